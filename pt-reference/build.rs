//! Compiles the kernels of `shaders/`.

#[path = "src/records.rs"]
mod records;

fn main() {
    pt_shaders::compiler::Kernels::new().header("reference_records.glsl", records::glsl()).compile("shaders");
}
