//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/images.rs"]
mod images;
#[path = "src/records.rs"]
mod records;
use records::*;

fn main() {
    let records = [
        glsl(),
        TemporalPush::glsl(),
        VariancePush::glsl(),
        AtrousPush::glsl(),
        LfPush::glsl(),
        GradientPush::glsl(),
        GradientPixelsPush::glsl(),
        RecurrentPush::glsl(),
        SpecularMotion::glsl(),
    ];
    pt_shaders::compiler::Kernels::new()
        .header("composite_push.glsl", CompositePush::glsl())
        .header("denoise_records.glsl", records.concat())
        .header("denoise_images.glsl", images::glsl())
        .compile("shaders");
}
