//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;
#[path = "tests/common/records.rs"]
mod test_records;

fn main() {
    let tables = [records::LocalLightsPush::glsl(), records::ShadowStatisticsPush::glsl()];
    let kernels = pt_shaders::compiler::Kernels::new()
        .header("lights_records.glsl", records::DirectPush::glsl())
        .header("nee_at_records.glsl", records::NeeAtPush::glsl())
        .header("local_lights_records.glsl", tables.concat());
    let test_header = [
        test_records::SamplerPush::glsl(),
        test_records::SampleRecord::glsl(),
        test_records::BrdfCase::glsl(),
        test_records::NeeAtPicksPush::glsl(),
    ];
    kernels.compile("shaders");
    kernels.header("test_records.glsl", test_header.concat()).compile_as("tests/shaders", "test_kernels.rs");
}
