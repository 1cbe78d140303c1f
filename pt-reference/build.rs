//! Compiles the kernels of the tests.

use pt_shaders::GpuStruct;

#[path = "tests/common/records.rs"]
mod test_records;

fn main() {
    let test_header = [
        test_records::BsdfCase::glsl(),
        test_records::BsdfResult::glsl(),
        test_records::HistogramPush::glsl(),
        test_records::InteriorEvent::glsl(),
        test_records::InteriorResult::glsl(),
        test_records::SamplerCase::glsl(),
        test_records::ListPush::glsl(),
    ];
    pt_shaders::compiler::Kernels::new()
        .header("test_records.glsl", test_header.concat())
        .compile_as("tests/shaders", "test_kernels.rs");
}
