//! Compiles the kernels of `shaders/`.

#[path = "src/records.rs"]
mod records;

fn main() {
    pt_shaders::compiler::Kernels::new()
        .header("reference_records.glsl", records::glsl())
        .header("lights_records.glsl", pt_lights_records::glsl())
        .compile("shaders");
}

#[path = "../pt-lights/src/records.rs"]
mod pt_lights_records;
