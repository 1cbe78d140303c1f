//! The fixed transform from linear images to the display values that PSNR and FLIP look at.

use crate::image_file::{ImageState, LinearImage, srgb_encode};

/// What [`display_values`] does, in one line for reports.
pub const DISPLAY_TRANSFORM: &str = "display values: sRGB codes, 0 to 1, negative values as 0; scene-referred \
    input is first scaled by s = 0.18 / exp(mean(log Y_b)) over pixels of b with Y_b > 0 (of a, when b is \
    display-referred), then x / (1 + x) per channel (display-referred input is not)";

/// Grey to which the average of a scene is brought (the key of Reinhard et al. 2002).
const KEY: f64 = 0.18;

/// The pixels of `a` and of the reference `b` as sRGB codes, 0 to 1.
///
/// Display-referred images are clamped and encoded. Scene-referred ones are first exposed and compressed by the global
/// operator of Reinhard et al. 2002, "Photographic tone reproduction for digital images", eq. 1 to 3. The exposure comes
/// from the reference alone (from `a` when the reference is display-referred) and serves both, so that a difference in brightness stays one. Black pixels (background) do
/// not count towards it.
pub fn display_values(a: &LinearImage, b: &LinearImage) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let metered = if b.state == ImageState::SceneReferred { b } else { a };
    let exposure = exposure(metered);
    (encode(a, exposure), encode(b, exposure))
}

fn exposure(image: &LinearImage) -> f64 {
    let logs = image.pixels.iter().map(luminance).filter(|&y| y > 0.0).map(f64::ln);
    let (sum, count) = logs.fold((0.0, 0u32), |(sum, count), log| (sum + log, count + 1));
    if count == 0 { 1.0 } else { KEY / (sum / f64::from(count)).exp() }
}

/// Luma: the weights of [`luminance`] on display values.
pub(super) fn luma(code: &[f32; 3]) -> f64 {
    luminance(code)
}

/// Relative luminance of Rec. 709 primaries.
fn luminance(pixel: &[f32; 3]) -> f64 {
    let [r, g, b] = pixel.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn encode(image: &LinearImage, exposure: f64) -> Vec<[f32; 3]> {
    let compress = |value: f32| {
        let exposed = f64::from(value.max(0.0)) * exposure;
        (exposed / (1.0 + exposed)) as f32
    };
    let code = |value: f32| match image.state {
        ImageState::SceneReferred => srgb_encode(compress(value)),
        ImageState::DisplayReferred => srgb_encode(value.clamp(0.0, 1.0)),
    };
    image.pixels.iter().map(|pixel| pixel.map(code)).collect()
}
