//! Compiles the kernels of the tests.

fn main() {
    pt_shaders::compiler::Kernels::new().compile_as("tests/shaders", "test_kernels.rs");
}
