//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;

fn main() {
    let header = [records::RayCounts::glsl(), records::DirectPush::glsl()];
    pt_shaders::compiler::Kernels::new().header("lights_records.glsl", header.concat()).compile("shaders");
}
