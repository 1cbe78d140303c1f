//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/records.rs"]
mod records;
use records::*;

fn main() {
    let constants = [
        ("HISTOGRAM_BINS", HISTOGRAM_BINS),
        ("BIN_BITS", BIN_BITS),
        ("STEP_BITS", STEP_BITS),
        ("TONEMAP_NONE", TONEMAP_NONE),
        ("TONEMAP_REINHARD", TONEMAP_REINHARD),
        ("TONEMAP_ACES", TONEMAP_ACES),
    ];
    let mut header: String =
        constants.iter().map(|(name, value)| format!("const uint {name} = {value}u;\n")).collect();
    header.push_str(&format!("const int MIN_LOG_LUMINANCE = {MIN_LOG_LUMINANCE};\n"));
    for record in [ExposureRecord::glsl(), MeterPush::glsl(), TonemapPush::glsl(), AccumulatePush::glsl()] {
        header.push_str(&record);
    }
    pt_shaders::compiler::Kernels::new().header("post_records.glsl", header).compile("shaders");
}
