//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

mod test_records {
    include!("tests/common/records.rs");
}

fn main() {
    let kernels = pt_shaders::compiler::Kernels::new();
    kernels
        .header("test_records.glsl", test_records::TestPush::glsl())
        .compile_as("tests/shaders", "test_kernels.rs");
}
