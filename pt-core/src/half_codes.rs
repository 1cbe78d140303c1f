//! Texels of histories that are kept as half floats: what kernels write with `history_code.glsl` of pt-denoise.

use half::f16;
use pt_shaders::channels::{HalfCode, HalfPart};

/// Of a root with a sign; -1 is that of -1.
fn square(root: f32) -> f32 {
    root * root.abs()
}

fn root(value: f32) -> f32 {
    value.abs().sqrt().copysign(value)
}

/// The numbers that texels of such a code stand for.
pub(crate) fn decode(code: HalfCode, bytes: &[u8]) -> Vec<f32> {
    let half = |b: &[u8]| f16::from_le_bytes([b[0], b[1]]).to_f32();
    let number = |(k, b): (usize, &[u8])| match code.part(k % 4) {
        HalfPart::Plain => half(b),
        HalfPart::Root => square(half(b)),
        HalfPart::FourthRoot => square(square(half(b))),
    };
    bytes.chunks_exact(2).enumerate().map(number).collect()
}

/// The reverse, to the nearest half floats.
pub(crate) fn encode(code: HalfCode, values: &[f32]) -> Vec<u8> {
    let number = |(k, &v): (usize, &f32)| match code.part(k % 4) {
        HalfPart::Plain => v,
        HalfPart::Root => root(v),
        HalfPart::FourthRoot => root(root(v)),
    };
    let greatest = f16::MAX.to_f32();
    let half = |v: f32| f16::from_f32(v.clamp(-greatest, greatest)).to_le_bytes();
    values.iter().enumerate().map(number).flat_map(half).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CODES: [HalfCode; 4] = [HalfCode::Light, HalfCode::Moments, HalfCode::Roots, HalfCode::Chroma];

    fn stored(code: HalfCode, values: [f32; 4]) -> Vec<f32> {
        decode(code, &encode(code, &values))
    }

    #[test]
    fn values_are_off_by_the_rounding_of_their_roots() {
        let close = |code, values: [f32; 4]| {
            let got = stored(code, values);
            for (got, value) in got.iter().zip(values) {
                // Half floats have 11 bits: 2^-11 of a root is 2^-10 of its square and 2^-9 of its fourth power.
                assert!((got - value).abs() <= 2.01e-3 * value.abs(), "{code:?} {values:?}: {got}");
            }
        };
        close(HalfCode::Light, [1e-6, 0.3, 3e9, 1e19]);
        close(HalfCode::Roots, [-2e9, -0.7, 1e-5, 5.0]);
        close(HalfCode::Chroma, [-0.3, 7.0, 2047.0, 1e-9]);
        close(HalfCode::Moments, [0.7, 0.9, 1e4, 1e-9]);
    }

    #[test]
    fn what_was_read_is_written_back_as_it_was() {
        for code in CODES {
            let codes: Vec<u8> =
                (1..=8).flat_map(|k| f16::from_f32(0.1237 * k as f32).to_le_bytes()).collect();
            assert_eq!(encode(code, &decode(code, &codes)), codes, "{code:?}");
        }
    }

    #[test]
    fn what_is_missing_stays_missing_and_zero_stays_zero() {
        assert_eq!(stored(HalfCode::Light, [0.0, 0.0, 0.0, -1.0]), [0.0, 0.0, 0.0, -1.0]);
        assert_eq!(stored(HalfCode::Chroma, [0.0, 0.0, 2048.0, -1.0]), [0.0, 0.0, 2048.0, -1.0]);
    }
}
