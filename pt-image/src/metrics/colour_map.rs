//! False colours for error maps.

use crate::image_file::srgb_encode_8bit;

/// Colour of `t` (clamped to 0..1; NaN is 0) as 8-bit sRGB: near black over purple, red and orange to pale yellow.
///
/// Computed in Oklab (Ottosson 2020, "A perceptual color space for image processing"): lightness grows linearly with
/// `t`, so equal steps of error look like equal steps of brightness, also in grey print; the hue turns at a constant
/// rate and the chroma is largest in the middle.
pub fn colour_map(t: f32) -> [u8; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let lightness = 0.10 + 0.87 * t;
    let hue = (290.0 + 180.0 * t).to_radians();
    let chroma = 0.01 + 0.18 * (std::f32::consts::PI * t).sin();
    oklab_to_linear([lightness, chroma * hue.cos(), chroma * hue.sin()]).map(srgb_encode_8bit)
}

/// Maps errors from 0 to `top` through [`colour_map`] to RGB bytes. A `top` that is not positive maps all to black.
pub fn heatmap(errors: &[f32], top: f32) -> Vec<u8> {
    let scale = if top > 0.0 { 1.0 / top } else { 0.0 };
    errors.iter().flat_map(|error| colour_map(error * scale)).collect()
}

/// Oklab to linear Rec. 709 RGB, not clamped.
fn oklab_to_linear([lightness, a, b]: [f32; 3]) -> [f32; 3] {
    let long = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let medium = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let short = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    [
        4.076_741_7 * long - 3.307_711_6 * medium + 0.230_969_94 * short,
        -1.268_438 * long + 2.609_757_4 * medium - 0.341_319_38 * short,
        -0.004_196_086_3 * long - 0.703_418_6 * medium + 1.707_614_7 * short,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::srgb_decode;

    #[test]
    fn brightness_grows_along_the_map() {
        let luminance = |step: u32| {
            let [r, g, b] = colour_map(step as f32 / 64.0).map(|code| srgb_decode(f32::from(code) / 255.0));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for step in 0..64 {
            assert!(luminance(step + 1) > luminance(step), "step {step}");
        }
        assert!(luminance(0) < 0.01 && luminance(64) > 0.8);
    }

    #[test]
    fn oklab_white_is_white() {
        for value in oklab_to_linear([1.0, 0.0, 0.0]) {
            assert!((value - 1.0).abs() < 1e-4, "{value}");
        }
    }

    #[test]
    fn errors_are_scaled_and_clamped() {
        let map = heatmap(&[0.0, 1.0, 2.0, 9.0], 2.0);
        assert_eq!(map[..3], colour_map(0.0));
        assert_eq!(map[3..6], colour_map(0.5));
        assert_eq!(map[6..9], map[9..12]);
        assert_eq!(heatmap(&[0.0, 0.0], 0.0), [colour_map(0.0), colour_map(0.0)].concat());
    }
}
