//! Compiles the kernels of the tests.

use pt_shaders::GpuStruct;

#[path = "tests/common/records.rs"]
mod test_records;

fn main() {
    let header = [test_records::MaterialCase::glsl(), test_records::MaterialResult::glsl()].concat();
    pt_shaders::compiler::Kernels::new()
        .header("test_records.glsl", header)
        .compile_as("tests/shaders", "test_kernels.rs");
}
