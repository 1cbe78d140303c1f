//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

#[path = "src/images.rs"]
mod images;
#[path = "src/records.rs"]
mod records;
#[path = "tests/common/records.rs"]
mod test_records;

fn main() {
    let header = [
        records::RayCounts::glsl(),
        records::ShadowRayTables::glsl(),
        records::LightStorage::glsl(),
        records::NeeAtPdf::glsl(),
        records::RestirWeights::glsl(),
        records::RestirVisibility::glsl(),
        records::DirectPush::glsl(),
    ];
    let caustics = [
        records::CausticTarget::glsl(),
        records::CausticBox::glsl(),
        records::CausticHead::glsl(),
        records::CausticCell::glsl(),
        records::CausticsPush::glsl(),
    ];
    let kernels = pt_shaders::compiler::Kernels::new()
        .header("lights_records.glsl", header.concat())
        .header("caustics_records.glsl", caustics.concat())
        .header("nee_at_records.glsl", records::NeeAtPush::glsl())
        .header("lights_images.glsl", images::glsl());
    kernels.compile("shaders");
    let test_header = [
        test_records::SampleRecord::glsl(),
        test_records::PackedRecord::glsl(),
        test_records::NeeAtPicksPush::glsl(),
    ];
    kernels.header("test_records.glsl", test_header.concat()).compile_as("tests/shaders", "test_kernels.rs");
}
