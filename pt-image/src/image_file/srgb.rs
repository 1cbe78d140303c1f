//! The sRGB transfer function (IEC 61966-2-1).

/// Linear value to sRGB code value, both nominally 0 to 1. Negative values give 0; values above 1 continue the curve.
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear.max(0.0) * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB code value to linear value, both nominally 0 to 1.
pub fn srgb_decode(code: f32) -> f32 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Linear value to the nearest 8-bit sRGB code; values outside 0 to 1 are clamped, NaN gives 0.
pub fn srgb_encode_8bit(linear: f32) -> u8 {
    (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_survive_decoding_and_encoding() {
        for code in 0..=255u8 {
            assert_eq!(srgb_encode_8bit(srgb_decode(f32::from(code) / 255.0)), code);
        }
    }

    #[test]
    fn known_points() {
        assert!((srgb_decode(0.5) - 0.214_041).abs() < 1e-6);
        assert!((srgb_encode(0.18) - 0.461_356).abs() < 1e-5);
        assert_eq!(srgb_encode_8bit(f32::NAN), 0);
        assert_eq!(srgb_encode_8bit(-1.0), 0);
        assert_eq!(srgb_encode_8bit(f32::INFINITY), 255);
    }
}
