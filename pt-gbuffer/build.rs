//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/images.rs"]
mod images;
#[path = "src/records.rs"]
mod records;

fn main() {
    pt_test_data::declare();
    let header = [
        records::CameraInteriorPush::glsl(),
        records::EffectsPush::glsl(),
        records::GodraysPush::glsl(),
        records::PrimaryPush::glsl(),
        records::ReflectRefractPush::glsl(),
        records::ReplacedMotionPush::glsl(),
    ]
    .concat();
    pt_shaders::compiler::Kernels::new()
        .header("gbuffer_records.glsl", header)
        .header("gbuffer_images.glsl", images::glsl())
        .compile("shaders");
}
