//! `tonemap.comp`, `tonemap_codes.comp` and the curves.

use super::{Rgb, is_finite, luminance, mix, scaled};
use crate::params::PostParams;
use crate::records::{CURVE_BINS_PER_OCTAVE, MIN_LOG_LUMINANCE};
use crate::records::{Encoding, Tonemap};

/// How a frame is exposed.
#[derive(Clone, Debug, Default)]
pub struct Exposed {
    /// Factor that takes radiance to exposed values.
    pub scale: f64,
    /// Metered minus used EV100: by how much a manual exposure moves the noise-aware curve.
    pub shift: f64,
    /// The noise-aware curve; empty without.
    pub curve: Vec<f64>,
}

/// Linear display value to sRGB code value, both 0 to 1 (IEC 61966-2-1).
pub fn srgb_encode(x: f64) -> f64 {
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

const M1: f64 = 2610.0 / 16384.0;
const M2: f64 = 2523.0 / 32.0;
const C1: f64 = 3424.0 / 4096.0;
const C2: f64 = 2413.0 / 128.0;
const C3: f64 = 2392.0 / 128.0;

/// Luminance over 10000 cd/m2 to PQ code (SMPTE ST 2084), both 0 to 1.
pub fn pq_encode(luminance: f64) -> f64 {
    let p = luminance.powf(M1);
    ((C1 + C2 * p) / (1.0 + C3 * p)).powf(M2)
}

/// PQ code to luminance over 10000 cd/m2, both 0 to 1.
pub fn pq_decode(code: f64) -> f64 {
    let p = code.powf(1.0 / M2);
    ((p - C1).max(0.0) / (C2 - C3 * p)).powf(1.0 / M1)
}

fn rows(matrix: [[f64; 3]; 3], c: Rgb) -> Rgb {
    matrix.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2])
}

fn aces_hill(c: Rgb) -> Rgb {
    let v = rows([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]], c);
    let v = v.map(|v| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
    rows([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]], v)
}

/// AgX's contrast curve on its log2 code, both 0 to 1.
fn agx_contrast(x: f64) -> f64 {
    let pivot = 10.0 / 16.5;
    let branch = |x: f64, run: f64, power: f64| {
        let scale = (0.5f64.powf(-power) - (2.0 * run).powf(-power)).powf(-1.0 / power);
        let t = 2.0 * x / scale;
        scale * t / (1.0 + t.powf(power)).powf(1.0 / power)
    };
    if x < pivot { 0.5 - branch(pivot - x, pivot, 3.0) } else { 0.5 + branch(x - pivot, 1.0 - pivot, 3.25) }
}

fn agx(c: Rgb) -> Rgb {
    let inset = [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ];
    let outset = [
        [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
        [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
        [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
    ];
    let log = rows(inset, c).map(|v| (((v.max(1e-10) / 0.18).log2() + 10.0) / 16.5).clamp(0.0, 1.0));
    rows(outset, log.map(agx_contrast)).map(|v| v.max(0.0).powf(2.2))
}

fn pbr_neutral(c: Rgb) -> Rgb {
    let least = c[0].min(c[1]).min(c[2]);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let c = c.map(|v| v - offset);
    let peak = c[0].max(c[1]).max(c[2]);
    if peak <= 0.76 {
        return c;
    }
    let compressed = 1.0 - 0.24 * 0.24 / (peak - 0.52);
    let to_white = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    mix(scaled(c, compressed / peak), [compressed; 3], to_white)
}

fn noise_aware(c: Rgb, exposed: &Exposed, params: &PostParams, hdr: bool) -> Rgb {
    let y = luminance(c);
    if y <= 0.0 {
        return [0.0; 3];
    }
    let per_octave = f64::from(CURVE_BINS_PER_OCTAVE);
    let x = ((y / exposed.scale).log2() - f64::from(MIN_LOG_LUMINANCE)) * per_octave;
    let at = x.clamp(0.0, exposed.curve.len() as f64 - 1.0 - 1e-3);
    let (below, above) = (exposed.curve[at as usize], exposed.curve[at as usize + 1]);
    let value = below + (above - below) * at.fract() + x.min(0.0) / per_octave;
    let knobs = &params.curve;
    let shift = f64::from(knobs.bias) + f64::from(params.compensation) + exposed.shift;
    let (knee, white) = (f64::from(knobs.knee), f64::from(knobs.white_point));
    let bend = |x: f64| {
        let w = (knee * (knee - 2.0) + white) / (white - 1.0);
        if hdr || x <= knee { x } else { (w * x - knee * knee) / (x + w - 2.0 * knee) }
    };
    let curved = scaled(c, (value + shift).exp2() / y).map(bend);
    let reinhard = (1.0 + y / (white * white)) / (1.0 + y);
    mix(curved, scaled(c, reinhard), knobs.reinhard.into())
}

/// Exposed values (0 and more) to linear display values; not clamped.
pub fn tone_curve(c: Rgb, exposed: &Exposed, params: &PostParams, hdr: bool) -> Rgb {
    match params.tonemap {
        Tonemap::Aces => c.map(|x| x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)),
        Tonemap::AcesHill => aces_hill(c),
        Tonemap::Agx => agx(c),
        Tonemap::Neutral => pbr_neutral(c),
        Tonemap::NoiseAware => noise_aware(c, exposed, params, hdr),
        Tonemap::Reinhard => c.map(|x| x / (1.0 + x)),
        Tonemap::None => c,
    }
}

/// Scene radiance to codes before rounding: sRGB and PQ 0 to 1, scRGB in units of 80 cd/m2.
pub fn codes(radiance: [f32; 3], exposed: &Exposed, encoding: Encoding, params: &PostParams) -> Rgb {
    let c = radiance.map(f64::from);
    let c = c.map(|v| if v.is_nan() { 0.0 } else { (v * exposed.scale).clamp(0.0, 65504.0) });
    let shown = tone_curve(c, exposed, params, encoding.is_hdr()).map(|v| v.max(0.0));
    debug_assert!(is_finite(shown));
    let luminances = shown.map(|v| (v * f64::from(params.paper_white)).min(params.peak.into()) / 10_000.0);
    match encoding {
        Encoding::Srgb => shown.map(|v| srgb_encode(v.min(1.0))),
        Encoding::Scrgb => scaled(luminances, 125.0),
        Encoding::Pq => {
            rows([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]], luminances)
                .map(pq_encode)
        }
    }
}

/// 8-bit code of an sRGB code value with dither noise `uniform` (0 to 1; 0.5: none), before rounding.
pub fn quantize(code: f64, uniform: f64) -> f64 {
    let t = 2.0 * uniform - 1.0;
    let triangular = t.signum() * (1.0 - (1.0 - t.abs()).sqrt());
    let steps = 255.0 * code.clamp(0.0, 1.0);
    steps + if (1.0..=254.0).contains(&steps) { triangular } else { uniform - 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(tonemap: Tonemap, c: Rgb) -> Rgb {
        tone_curve(c, &Exposed::default(), &PostParams { tonemap, ..PostParams::default() }, false)
    }

    fn close(a: Rgb, b: Rgb, tolerance: f64) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
    }

    /// IEC 61966-2-1 in both branches, at their seam and at its worked values.
    #[test]
    fn srgb_at_known_values() {
        for (linear, code) in [(0.0, 0.0), (0.001, 0.01292), (0.18, 0.461_356), (0.214_041, 0.5), (1.0, 1.0)]
        {
            assert!((srgb_encode(linear) - code).abs() < 1e-6, "{linear}");
        }
        assert!((srgb_encode(0.0031308) - srgb_encode(0.003_130_801)).abs() < 1e-6);
    }

    /// Points of the standard's table (ITU-R BT.2100): 0, 100, 1000 and 10000 cd/m2.
    #[test]
    fn pq_at_known_values() {
        for (luminance, code) in [(0.0, 7.3e-7), (0.01, 0.508_078), (0.1, 0.751_827), (1.0, 1.0)] {
            assert!((pq_encode(luminance) - code).abs() < 1e-6, "{luminance}: {}", pq_encode(luminance));
        }
        for luminance in [1e-7, 1e-4, 0.02, 0.7] {
            assert!((pq_decode(pq_encode(luminance)) / luminance - 1.0).abs() < 1e-9);
        }
    }

    /// Values of the fitted curve worked out by hand from its five published coefficients.
    #[test]
    fn aces_at_known_values() {
        let known = [
            (0.0, 0.0),
            (0.18, 0.086724 / 0.324932),
            (0.5, 0.6425 / 1.0425),
            (1.0, 2.54 / 3.16),
            (2.0, 10.1 / 11.04),
        ];
        for (x, y) in known {
            assert!(close(shown(Tonemap::Aces, [x; 3]), [y; 3], 1e-12), "{x}");
        }
        assert_eq!(shown(Tonemap::Reinhard, [1.0; 3]), [0.5; 3]);
    }

    /// A grey goes through the fit alone: the published matrices have rows that sum to 1 (to the printed digits).
    #[test]
    fn aces_hill_at_known_values() {
        for x in [0.18, 1.0, 4.0] {
            let y = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
            assert!(close(shown(Tonemap::AcesHill, [x; 3]), [y; 3], 2e-5), "{x}");
        }
        assert!((shown(Tonemap::AcesHill, [1.0; 3])[0] - 1.024_488_063 / 1.654_761).abs() < 2e-5);
        // A bright saturated red turns towards white.
        let red = shown(Tonemap::AcesHill, [50.0, 0.0, 0.0]);
        assert!(red[1] > 0.05 && red[0] > 0.9, "{red:?}");
    }

    /// The ends and the pivot of the definition: 10 stops below middle grey, middle grey, 6.5 stops above; slope 2 at the
    /// pivot; and the published sixth-order fit (Wrensch 2023), whose coefficients have four digits.
    #[test]
    fn agx_at_known_values() {
        assert!(agx_contrast(0.0).abs() < 1e-12);
        assert!((agx_contrast(10.0 / 16.5) - 0.5).abs() < 1e-12);
        assert!((agx_contrast(1.0) - 1.0).abs() < 1e-12);
        let pivot = 10.0 / 16.5;
        let slope = (agx_contrast(pivot + 1e-6) - agx_contrast(pivot - 1e-6)) / 2e-6;
        assert!((slope - 2.0).abs() < 1e-4, "{slope}");
        let mut squares = 0.0;
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            let fit = 15.5 * x.powi(6) - 40.14 * x.powi(5) + 31.96 * x.powi(4) - 6.868 * x.powi(3)
                + 0.4298 * x * x
                + 0.1191 * x
                - 0.00232;
            squares += (agx_contrast(x) - fit).powi(2) / 1001.0;
        }
        assert!(squares < 1e-5, "{squares:e}");
        // The matrices' rows sum to 1 within 2e-4: greys stay grey, middle grey is half the code of a 2.2 display.
        assert!(close(shown(Tonemap::Agx, [0.18; 3]), [0.5f64.powf(2.2); 3], 2e-4));
    }

    /// The three pieces of the specification: quadratic toe, offset, compression; and its guarantee that base colours from
    /// 0.08 to 0.8 come out as they are under white light, 4 % of specular reflection added.
    #[test]
    fn pbr_neutral_at_known_values() {
        assert!(close(shown(Tonemap::Neutral, [0.04; 3]), [0.01; 3], 1e-12));
        for base in [[0.08, 0.3, 0.76], [0.5; 3], [0.1, 0.1, 0.7]] {
            let lit = base.map(|v| v + 0.04);
            assert!(close(shown(Tonemap::Neutral, lit), base, 1e-12), "{base:?}");
        }
        // 1 - 0.24^2 / (0.96 - 0.52)
        assert!(close(shown(Tonemap::Neutral, [1.0; 3]), [1.0 - 0.0576 / 0.44; 3], 1e-12));
        // Hue stays: the order of the channels and their differences' ratio.
        let c = shown(Tonemap::Neutral, [8.0, 4.0, 2.0]);
        assert!(((c[0] - c[1]) / (c[1] - c[2]) - 2.0).abs() < 1e-9, "{c:?}");
    }

    #[test]
    fn curves_rise_and_stay_in_range() {
        for tonemap in Tonemap::ALL.into_iter().filter(|&t| t != Tonemap::NoiseAware) {
            let mut last = 0.0;
            for step in 0..20_000 {
                let x = 10f64.powf(f64::from(step) / 2000.0 - 5.0);
                let [r, g, b] = shown(tonemap, [x; 3]).map(|v| v.clamp(0.0, 1.0));
                // To the rounding of the curve, whose terms are of the order of 1.
                assert!(r >= last - 1e-12, "{tonemap:?} at step {step}: {r} after {last}");
                assert!((r - g).abs() < 1e-3 && (r - b).abs() < 1e-3, "{tonemap:?}: grey at {x}");
                last = r;
            }
            assert!(last > 0.97, "{tonemap:?} ends at {last}");
        }
    }

    /// The knee meets the line with the same slope and reaches 1 at the white point; no operator gives more than white.
    #[test]
    fn noise_aware_curve_bends_into_white() {
        let curve: Vec<f64> = (0..=128).map(|i| f64::from(i) / 4.0 - 16.0).collect();
        let exposed = Exposed { scale: 1.0, shift: 0.0, curve };
        let mut params = PostParams { tonemap: Tonemap::NoiseAware, ..PostParams::default() };
        (params.curve.bias, params.curve.reinhard) = (0.0, 0.0);
        // The curve is the identity: only the knee is left.
        let y = |x: f64| tone_curve([x; 3], &exposed, &params, false)[0];
        assert!((y(0.3) - 0.3).abs() < 1e-9 && (y(0.6) - 0.6).abs() < 1e-9);
        assert!(((y(0.6 + 1e-6) - y(0.6)) / 1e-6 - 1.0).abs() < 1e-4);
        assert!((y(10.0) - 1.0).abs() < 1e-9);
        params.curve.reinhard = 1.0;
        let y = tone_curve([10.0; 3], &exposed, &params, false)[0];
        assert!((y - 1.0).abs() < 1e-9, "{y}");
    }
}
