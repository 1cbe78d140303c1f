//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

#[path = "src/images.rs"]
mod images;
#[path = "src/records.rs"]
mod records;
#[path = "tests/common/records.rs"]
mod test_records;

fn main() {
    let header = [records::glsl(), records::BounceTables::glsl(), records::IndirectPush::glsl()];
    pt_shaders::compiler::Kernels::new()
        .header("indirect_records.glsl", header.concat())
        .header("indirect_images.glsl", images::glsl())
        .compile("shaders");
    pt_shaders::compiler::Kernels::new()
        .header("test_records.glsl", test_records::ShRecord::glsl())
        .compile_as("tests/shaders", "test_kernels.rs");
}
