//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;

fn main() {
    pt_shaders::compiler::Kernels::new()
        .header("composite_push.glsl", records::CompositePush::glsl())
        .compile("shaders");
}
