//! Compiles the kernels of `shaders/` and of the tests.

#[path = "src/gpu/deform_records.rs"]
mod deform_records;

fn main() {
    let kernels = pt_shaders::compiler::Kernels::new();
    kernels.compile_as("tests/shaders", "test_kernels.rs");
    kernels.header("deform_records.glsl", deform_records::glsl()).compile("shaders");
}
