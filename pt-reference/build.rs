//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;
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
    let kernels = pt_shaders::compiler::Kernels::new()
        .header("reference_records.glsl", records::glsl())
        .header("test_records.glsl", test_header.concat());
    kernels.compile("shaders");
    kernels.compile_as("tests/shaders", "test_kernels.rs");
}
