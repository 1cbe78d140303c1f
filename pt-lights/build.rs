//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/images.rs"]
mod images;
#[path = "src/records.rs"]
mod records;

fn main() {
    let header = [
        records::RayCounts::glsl(),
        records::RestirWeights::glsl(),
        records::RestirVisibility::glsl(),
        records::DirectPush::glsl(),
    ];
    pt_shaders::compiler::Kernels::new()
        .header("lights_records.glsl", header.concat())
        .header("lights_images.glsl", images::glsl())
        .compile("shaders");
}
