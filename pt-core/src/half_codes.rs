//! Texels of histories that are kept as half floats: what kernels write with `history_code.glsl` of pt-denoise.

use half::f16;
use pt_shaders::channels::HalfCode;

/// Of a root with a sign; -1 is that of -1.
fn square(root: f32) -> f32 {
    root * root.abs()
}

fn root(value: f32) -> f32 {
    value.abs().sqrt().copysign(value)
}

/// Of a mean and a mean of squares.
fn standard_deviation(mean: f32, second: f32) -> f32 {
    (second - mean * mean).max(0.0).sqrt()
}

/// The numbers that texels of such a code stand for.
pub(crate) fn decode(code: HalfCode, bytes: &[u8]) -> Vec<f32> {
    let texel: fn([f32; 4]) -> [f32; 4] = match code {
        HalfCode::Light => |[r, g, b, a]| [square(r), square(g), square(b), square(square(a))],
        HalfCode::Roots => |code| code.map(square),
        HalfCode::Chroma => |[x, y, z, w]| [square(x), square(y), z, square(square(w))],
        HalfCode::Moments => |code| {
            let [a, deviation_a, b, deviation_b] = code.map(square);
            [a, a * a + deviation_a * deviation_a, b, b * b + deviation_b * deviation_b]
        },
    };
    let half = |k: usize, b: &[u8]| f16::from_le_bytes([b[2 * k], b[2 * k + 1]]).to_f32();
    bytes.chunks_exact(8).flat_map(|b| texel([0, 1, 2, 3].map(|k| half(k, b)))).collect()
}

/// The reverse, to the nearest half floats.
pub(crate) fn encode(code: HalfCode, values: &[f32]) -> Vec<u8> {
    let texel: fn([f32; 4]) -> [f32; 4] = match code {
        HalfCode::Light => |[r, g, b, a]| [root(r), root(g), root(b), root(root(a))],
        HalfCode::Roots => |value| value.map(root),
        HalfCode::Chroma => |[x, y, z, w]| [root(x), root(y), z, root(root(w))],
        HalfCode::Moments => |[a, second_a, b, second_b]| {
            [a, standard_deviation(a, second_a), b, standard_deviation(b, second_b)].map(root)
        },
    };
    let bytes = |v: f32| f16::from_f32(v.clamp(-f16::MAX.to_f32(), f16::MAX.to_f32())).to_le_bytes();
    let texels = values.chunks_exact(4).map(|v| texel([v[0], v[1], v[2], v[3]]));
    texels.flat_map(|code| code.map(bytes)).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CODES: [HalfCode; 4] =
        [HalfCode::Light, HalfCode::Moments, HalfCode::Roots, HalfCode::Chroma];

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
        close(HalfCode::Moments, [0.7, 0.9, 1e4, 1e12]);
    }

    #[test]
    fn what_was_read_is_written_back_as_it_was() {
        for code in CODES {
            let codes: Vec<u8> = (1..=8).flat_map(|k| f16::from_f32(0.1237 * k as f32).to_le_bytes()).collect();
            assert_eq!(encode(code, &decode(code, &codes)), codes, "{code:?}");
        }
    }

    #[test]
    fn what_is_missing_stays_missing_and_zero_stays_zero() {
        assert_eq!(stored(HalfCode::Light, [0.0, 0.0, 0.0, -1.0]), [0.0, 0.0, 0.0, -1.0]);
        assert_eq!(stored(HalfCode::Chroma, [0.0, 0.0, 2048.0, -1.0]), [0.0, 0.0, 2048.0, -1.0]);
    }

    /// The roots of mean and second moment would be off by 2^-9 each, and their difference a false deviation of 4 % of the mean.
    #[test]
    fn light_without_noise_has_no_variance() {
        for mean in [0.1, 0.7, 3.1e4] {
            let [first, second, ..] = stored(HalfCode::Moments, [mean, mean * mean, 0.0, 0.0])[..] else {
                unreachable!("four components")
            };
            assert!(second - first * first <= 1e-6 * second, "{first}, {second}");
        }
    }
}
