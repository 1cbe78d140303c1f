//! Compiles the kernels of `shaders/`.

#[path = "src/gpu/deform_records.rs"]
mod deform_records;

fn main() {
    let kernels = pt_shaders::compiler::Kernels::new();
    kernels.header("deform_records.glsl", deform_records::glsl()).compile("shaders");
}
