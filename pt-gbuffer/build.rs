//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;

fn main() {
    pt_test_data::declare();
    let header = [
        records::CameraInteriorPush::glsl(),
        records::PrimaryPush::glsl(),
        records::ReflectRefractPush::glsl(),
        records::ReplacedMotionPush::glsl(),
    ]
    .concat();
    pt_shaders::compiler::Kernels::new().header("gbuffer_records.glsl", header).compile("shaders");
}
