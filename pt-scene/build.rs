//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

#[path = "src/gpu/deform_records.rs"]
mod deform_records;
#[path = "tests/common/records.rs"]
mod test_records;

fn main() {
    pt_test_data::declare();
    let kernels = pt_shaders::compiler::Kernels::new();
    kernels.header("deform_records.glsl", deform_records::glsl()).compile("shaders");
    let header = [test_records::MaterialCase::glsl(), test_records::MaterialResult::glsl()].concat();
    pt_shaders::compiler::Kernels::new()
        .header("test_records.glsl", header)
        .compile_as("tests/shaders", "test_kernels.rs");
}
