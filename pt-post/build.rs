//! Compiles the kernels of `shaders/`.

use pt_shaders::GpuStruct;

#[path = "src/images.rs"]
mod images;
#[path = "src/records.rs"]
mod records;
use records::*;

macro_rules! glsl_constants {
    ($($name:ident),* $(,)?) => { [$(format!("const uint {} = {}u;\n", stringify!($name), $name)),*].concat() };
}

fn main() {
    pt_test_data::declare();
    let mut header = glsl_constants![
        HISTOGRAM_BINS,
        BIN_BITS,
        STEP_BITS,
        FULL_WEIGHT,
        CURVE_BINS,
        CURVE_BINS_PER_OCTAVE,
        TAA_COLUMNS,
        TAA_ROWS,
        TONEMAP_ROWS,
        EASU_ROWS,
        EASU_HALF_ROWS,
        RCAS_COLUMNS,
        RCAS_ROWS,
        HISTOGRAM_SPAN,
        BLUR_OUTPUTS,
        BLUR_MAX_RADIUS,
    ];
    header.push_str(&format!("const int MIN_LOG_LUMINANCE = {MIN_LOG_LUMINANCE};\n"));
    for text in [
        Tonemap::glsl(),
        Encoding::glsl(),
        ClipSpace::glsl(),
        Rectify::glsl(),
        ExposureRecord::glsl(),
        HistogramPush::glsl(),
        MeterPush::glsl(),
        CurvePush::glsl(),
        TonemapPush::glsl(),
        AccumulatePush::glsl(),
        MattePush::glsl(),
        TaaPush::glsl(),
        BlurPush::glsl(),
        MixPush::glsl(),
        RcasPush::glsl(),
        EasuPush::glsl(),
    ] {
        header.push_str(&text);
    }
    pt_shaders::compiler::Kernels::new()
        .header("post_records.glsl", header)
        .header("post_images.glsl", images::glsl())
        .compile("shaders");
}
