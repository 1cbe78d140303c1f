//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;

fn main() {
    pt_shaders::compiler::Kernels::new()
        .header("interleave_push.glsl", records::InterleavePush::glsl())
        .header("add_plane_push.glsl", records::AddPlanePush::glsl())
        .compile("shaders");
}
