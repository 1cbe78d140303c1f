//! Metering, adaptation and the noise-aware curve: kernels against oracle and closed forms.

use crate::common::gpu::{random_hdr, run, upload};
use proptest::test_runner::TestRunner;
use pt_core::test_support::TestDevice;
use pt_post::{CurveParams, Exposure, ExposureMode, ExposureRecord, PostParams, Tonemap, oracle};

type Rgb = [f32; 3];

struct Bench {
    device: TestDevice,
}

impl Bench {
    fn open() -> Self {
        Self { device: TestDevice::open() }
    }

    /// Meters one image after the other; returns what the last one was exposed with.
    fn expose(
        &self,
        exposure: &mut Exposure,
        size: [u32; 2],
        pixels: &[Rgb],
        dt: Option<f32>,
        params: &PostParams,
    ) -> ExposureRecord {
        let pixels = pixels.iter().map(|c| c.map(f64::from)).collect();
        // Alpha is no radiance: it must not show anywhere.
        let image = upload(&self.device, &oracle::Image { size, pixels }, f32::NAN);
        run(&self.device, |frame| exposure.record(frame, &image, dt, params).unwrap());
        exposure.read().unwrap()
    }

    fn meter(&self, size: [u32; 2], pixels: &[Rgb], params: &PostParams) -> ExposureRecord {
        self.expose(&mut Exposure::new(&self.device).unwrap(), size, pixels, None, params)
    }

    fn ev100(&self, size: [u32; 2], pixels: &[Rgb], params: &PostParams) -> f64 {
        f64::from(self.meter(size, pixels, params).ev100)
    }
}

/// What the closed forms are for: the metered luminance is the average.
fn unbiased() -> PostParams {
    PostParams { meter_bias: 0.0, ..PostParams::default() }
}

/// EV100 of a meter that reads this luminance.
fn ev_of(luminance: f64) -> f64 {
    (luminance * 8.0).log2()
}

/// Mean log2 luminance between the two percentiles by sorting: what the histogram approximates.
fn exact_ev(pixels: &[Rgb], params: &PostParams) -> f64 {
    let mut logs: Vec<f64> = pixels
        .iter()
        .map(|c| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]))
        .filter(|&y| y > 0.0)
        .map(f64::log2)
        .collect();
    logs.sort_by(f64::total_cmp);
    let n = logs.len() as f64;
    let (low, high) = (f64::from(params.meter_low) * n, f64::from(params.meter_high) * n);
    let weight = |i: usize| (high.min(i as f64 + 1.0) - low.max(i as f64)).max(0.0);
    let sum: f64 = logs.iter().enumerate().map(|(i, y)| y * weight(i)).sum();
    sum / (0..logs.len()).map(weight).sum::<f64>() + 3.0
}

fn random_pixels(runner: &mut TestRunner, size: [u32; 2]) -> Vec<Rgb> {
    random_hdr(runner, size).pixels.iter().map(|c| c.map(|v| v as f32)).collect()
}

#[test]
fn meter_agrees_with_oracle_and_exact_percentiles() {
    let bench = Bench::open();
    let mut runner = TestRunner::deterministic();
    for size in [[1, 1], [2, 1], [17, 5], [33, 31], [160, 90]] {
        let pixels = random_pixels(&mut runner, size);
        for (meter_low, meter_high, centre_weight) in
            [(0.7, 0.9, 0.0), (0.0, 1.0, 0.0), (0.25, 0.3, 0.0), (0.7, 0.9, 1.0), (0.1, 0.5, 0.4)]
        {
            let params = PostParams { meter_low, meter_high, centre_weight, ..unbiased() };
            let exposure = bench.meter(size, &pixels, &params);
            if centre_weight == 0.0 {
                assert_eq!(exposure.metered_pixels as usize, pixels.len());
            }
            assert_eq!(exposure.metered_ev100, exposure.ev100);
            let got = f64::from(exposure.ev100);
            let want = oracle::meter(size, &pixels, &params);
            // fp32 luminance may round a pixel to the next step of 1/128 octave, a weight to the next of 64.
            let steps = if centre_weight > 0.0 { 4e-2 } else { 8e-3 };
            assert!(
                (got - want).abs() < 2e-3 + steps / pixels.len() as f64,
                "{size:?}: {got}, oracle {want}"
            );
            if centre_weight == 0.0 {
                // Half a step everywhere, and a bin of 1/8 octave at either end where the pixels are few.
                let exact = exact_ev(&pixels, &params);
                let tolerance = if pixels.len() > 10_000 { 0.01 } else { 0.2 };
                assert!((got - exact).abs() < tolerance, "{size:?}: {got}, sorted {exact}");
            }
        }
    }
}

#[test]
fn constant_image_is_metered_at_its_luminance() {
    let bench = Bench::open();
    for luminance in [1.6e-5f32, 0.001, 0.18, 0.9999, 1.0, 1.0001, 37.0, 6e4] {
        let got = bench.ev100([19, 7], &[[luminance; 3]; 19 * 7], &unbiased());
        // Half a step of 1/128 octave at the lower end of an octave: log2(1 + 1/256).
        let want = ev_of(luminance.into());
        assert!((got - want).abs() < 0.0058, "{luminance}: {got}, expected {want}");
    }
    // Beyond the histogram: its last bin.
    for bright in [1e9f32, 1e30] {
        let got = bench.ev100([2, 2], &[[bright; 3]; 4], &unbiased());
        assert!((got - ev_of(65536.0)).abs() < 0.01, "{got}");
    }
}

#[test]
fn mixture_follows_the_percentiles() {
    let bench = Bench::open();
    // 80 % at 1, 20 % at 16: the metered fifth between 70 and 90 % is half one, half the other.
    let pixels: Vec<Rgb> = (0..1000).map(|i| if i % 5 == 0 { [16.0; 3] } else { [1.0; 3] }).collect();
    for (low, high, mean_log) in [(0.7, 0.9, 2.0), (0.0, 1.0, 0.8), (0.1, 0.8, 0.0), (0.85, 0.95, 4.0)] {
        let params = PostParams { meter_low: low, meter_high: high, ..unbiased() };
        let got = bench.ev100([100, 10], &pixels, &params);
        assert!((got - (mean_log + 3.0)).abs() < 0.006, "{low}..{high}: {got}, expected {}", mean_log + 3.0);
    }
}

/// A bright frame round a dark middle: centre weighting sees the middle, where it counts three times as much.
#[test]
fn the_centre_weighs_more() {
    let bench = Bench::open();
    let pixels: Vec<Rgb> = (0..64 * 64)
        .map(|i| {
            let (x, y) = (i % 64 - 32, i / 64 - 32);
            [if x * x + y * y < 16 * 16 { 1.0 } else { 256.0 }; 3]
        })
        .collect();
    let ev = |centre_weight| {
        let params = PostParams { centre_weight, meter_low: 0.0, meter_high: 1.0, ..unbiased() };
        bench.ev100([64, 64], &pixels, &params)
    };
    let (even, weighted) = (ev(0.0), ev(1.0));
    assert!((even - 3.0 - 8.0 * 0.8037).abs() < 0.05, "{even}");
    // Share of the disk of radius 1/4 in the integral of max(1 - 1.5 r, 0.01) over the square: 0.3403.
    assert!((weighted - 3.0 - 8.0 * 0.6597).abs() < 0.1, "{weighted}");
}

#[test]
fn few_very_bright_pixels_do_not_move_the_exposure() {
    let bench = Bench::open();
    let size = [100, 20];
    let fireflies = |pixels: &[Rgb]| -> Vec<Rgb> {
        pixels.iter().enumerate().map(|(i, &c)| if i % 100 == 37 { [1e5; 3] } else { c }).collect()
    };
    let params = unbiased();
    let grey = vec![[0.2; 3]; 2000];
    assert_eq!(bench.ev100(size, &grey, &params), bench.ev100(size, &fireflies(&grey), &params));
    let noisy = random_pixels(&mut TestRunner::deterministic(), size);
    let moved = bench.ev100(size, &fireflies(&noisy), &params) - bench.ev100(size, &noisy, &params);
    // The percentiles move by one per cent of 26 octaves; a mean would move by several stops.
    assert!((0.0..0.4).contains(&moved), "{moved}");
}

#[test]
fn exposure_does_not_depend_on_the_size() {
    let bench = Bench::open();
    let tile = random_pixels(&mut TestRunner::deterministic(), [16, 16]);
    let tiled = |n: usize| -> Vec<Rgb> {
        (0..n * n * 256).map(|i| tile[(i / (16 * n) % 16) * 16 + i % 16]).collect()
    };
    let params = unbiased();
    let [one, four, sixteen] =
        [1, 2, 4].map(|n: u32| bench.ev100([16 * n, 16 * n], &tiled(n as usize), &params));
    assert_eq!((one, one), (four, sixteen));
    // Enlarged, with centre weighting: the pixels' centres lie elsewhere, by half a pixel of the smallest.
    let enlarged = |n: usize| -> Vec<Rgb> {
        (0..n * n * 256).map(|i| tile[(i / (16 * n) / n) * 16 + i % (16 * n) / n]).collect()
    };
    let centred = PostParams { centre_weight: 1.0, ..unbiased() };
    let [small, large] = [1, 8].map(|n: u32| bench.ev100([16 * n, 16 * n], &enlarged(n as usize), &centred));
    assert!((small - large).abs() < 0.05, "{small}, {large}");
}

#[test]
fn dark_and_broken_pixels_are_not_metered() {
    let bench = Bench::open();
    let nan = f32::NAN;
    let broken = [[nan, 1.0, 1.0], [1.0, f32::INFINITY, 1.0], [0.0; 3], [-1.0; 3], [f32::NEG_INFINITY; 3]];
    let mut pixels = vec![[0.5; 3]; 11];
    pixels.extend(broken);
    let exposure = bench.meter([16, 1], &pixels, &unbiased());
    assert_eq!(exposure.metered_pixels, 11.0);
    assert!((f64::from(exposure.ev100) - ev_of(0.5)).abs() < 0.006);

    // Nothing to meter, and the next frame is as if it had not been.
    let params = PostParams { ev100: 2.5, ..unbiased() };
    let mut stage = Exposure::new(&bench.device).unwrap();
    let exposure = bench.expose(&mut stage, [2, 2], &[[0.0; 3]; 4], None, &params);
    assert_eq!((exposure.ev100, exposure.metered_pixels), (2.5, 0.0));
    let exposure = bench.expose(&mut stage, [1, 1], &[[1.0; 3]], None, &params);
    assert!((exposure.ev100 - 3.0).abs() < 0.006);
}

#[test]
fn modes_bias_compensation_and_limits() {
    let bench = Bench::open();
    let one = [[1.0; 3]];
    let manual = PostParams { exposure: ExposureMode::Manual, ev100: 1.5, compensation: 0.5, ..unbiased() };
    let exposure = bench.meter([1, 1], &one, &manual);
    assert_eq!((exposure.ev100, exposure.scale), (1.5, pt_post::exposure_scale(1.5, 0.5)));
    let camera =
        PostParams { exposure: ExposureMode::Camera, aperture: 8.0, shutter: 1.0, iso: 200.0, ..unbiased() };
    assert_eq!(bench.meter([1, 1], &one, &camera).ev100, 5.0);
    let auto = PostParams { compensation: -2.0, ..unbiased() };
    let dark = bench.meter([1, 1], &one, &auto);
    assert!((f64::from(dark.scale) * 4.0 * 1.2 * f64::from(dark.ev100).exp2() - 1.0).abs() < 1e-5);
    let biased = bench.ev100([1, 1], &one, &PostParams { meter_bias: 1.5, ..unbiased() });
    assert_eq!(biased, bench.ev100([1, 1], &one, &unbiased()) - 1.5);
    let clamped = PostParams { min_ev100: 7.0, max_ev100: 9.0, ..unbiased() };
    assert_eq!(bench.ev100([1, 1], &one, &clamped), 7.0);
    assert_eq!(bench.ev100([1, 1], &[[1e4; 3]], &clamped), 9.0);
}

/// A step of 6 EV up and one down: as the oracle says, without overshoot, and 5 % after 3 / speed seconds.
#[test]
fn adaptation_settles_in_its_time() {
    let bench = Bench::open();
    let params = unbiased();
    for (from, to, speed) in [(0.125f32, 8.0f32, params.speed_up), (8.0, 0.125, params.speed_down)] {
        let mut stage = Exposure::new(&bench.device).unwrap();
        let start = f64::from(bench.expose(&mut stage, [4, 4], &[[from; 3]; 16], None, &params).ev100);
        let end = bench.ev100([4, 4], &[[to; 3]; 16], &params);
        assert!(((end - start).abs() - 6.0).abs() < 0.01);
        let dt = 0.25;
        let mut expected = start;
        let mut settled = None;
        for frame in 1..=24 {
            let exposure = bench.expose(&mut stage, [4, 4], &[[to; 3]; 16], Some(dt), &params);
            assert!((f64::from(exposure.metered_ev100) - end).abs() < 1e-6);
            expected = oracle::adapt(expected, end, dt.into(), &params);
            let left = (end - f64::from(exposure.ev100)) / (end - start);
            assert!((f64::from(exposure.ev100) - expected).abs() < 1e-4, "frame {frame}");
            // One side all the time: no oscillation.
            assert!((-1e-6..1.0).contains(&left), "frame {frame}: {left}");
            if left < 0.05 && settled.is_none() {
                settled = Some(frame as f32 * dt);
            }
        }
        let seconds = settled.unwrap();
        // ln(20) / speed, and one frame.
        assert!((seconds - 20f32.ln() / speed).abs() <= dt + 1e-3, "{seconds} s at {speed}/s");
    }
}

#[test]
fn no_time_no_change() {
    let bench = Bench::open();
    let params = unbiased();
    let mut stage = Exposure::new(&bench.device).unwrap();
    let first = bench.expose(&mut stage, [2, 2], &[[1.0; 3]; 4], None, &params).ev100;
    assert!((first - 3.0).abs() < 0.006, "the first frame is exposed as metered");
    for dt in [0.0, -1.0, f32::NAN] {
        assert_eq!(bench.expose(&mut stage, [2, 2], &[[64.0; 3]; 4], Some(dt), &params).ev100, first);
    }
    let cut = bench.expose(&mut stage, [2, 2], &[[64.0; 3]; 4], None, &params).ev100;
    assert!((cut - 9.0).abs() < 0.006, "without a time step nothing is left of what was before");
    let later = bench.expose(&mut stage, [2, 2], &[[1.0; 3]; 4], Some(1e9), &params).ev100;
    assert!((later - first).abs() < 1e-5, "a long time is all the way");
}

/// Shares of the curve's bins, from the luminances themselves.
fn shares(pixels: &[Rgb]) -> Vec<f64> {
    let (counts, _) = oracle::histogram([pixels.len() as u32, 1], pixels, 0.0);
    let total: u64 = counts.iter().sum();
    counts.chunks(2).map(|pair| (pair[0] + pair[1]) as f64 / total as f64).collect()
}

#[test]
fn noise_aware_curve_agrees_with_the_oracle_and_is_monotone() {
    let bench = Bench::open();
    let mut runner = TestRunner::deterministic();
    let narrow = vec![[0.5; 3]; 64];
    let two: Vec<Rgb> = (0..64).map(|i| [if i % 2 == 0 { 0.01 } else { 100.0 }; 3]).collect();
    for pixels in [
        random_pixels(&mut runner, [64, 1]),
        random_pixels(&mut runner, [700, 1]),
        narrow,
        two,
        vec![[1e30; 3]; 4],
        vec![[0.0; 3]; 4],
    ] {
        for curve in [
            CurveParams::default(),
            CurveParams {
                blur: 0.0,
                range: 12.0,
                noise_stops: 3.0,
                noise_slope: 1.0,
                ..CurveParams::default()
            },
        ] {
            let params = PostParams { tonemap: Tonemap::NoiseAware, curve, ..unbiased() };
            let mut stage = Exposure::new(&bench.device).unwrap();
            let exposure = bench.expose(&mut stage, [pixels.len() as u32, 1], &pixels, None, &params);
            let got = stage.read_curve().unwrap();
            assert!(got.windows(2).all(|pair| pair[1] >= pair[0] - 1e-6), "monotone");
            assert!(got[128].abs() < 1e-4, "the brightest is white: {}", got[128]);
            let black = pixels[0] == [0.0; 3];
            let shares = if black { vec![0.0; 128] } else { shares(&pixels) };
            let want = oracle::noise_aware_curve(&shares, exposure.ev100.into(), &params.curve);
            for (bin, (got, want)) in got.iter().zip(&want).enumerate() {
                // fp32 sums of up to 1e6 per empty bin.
                assert!((f64::from(*got) - want).abs() < 2e-3, "bin {bin}: {got}, oracle {want}");
            }
        }
    }
}

/// A scene with less range than the display keeps its contrast; one with more loses as little of it as can be where most
/// pixels are.
#[test]
fn noise_aware_curve_spends_the_range_where_the_pixels_are() {
    let curve = CurveParams { blur: 0.0, ..CurveParams::default() };
    let slope = |curve: &[f64], bin: usize| (curve[bin + 1] - curve[bin]) * 4.0;
    let mut few = vec![0.0; 128];
    few[60..76].fill(1.0 / 16.0);
    let c = oracle::noise_aware_curve(&few, 3.0, &curve);
    assert!((60..76).all(|bin| (slope(&c, bin) - 1.0).abs() < 1e-3));
    // 16 stops: half of the bins hold nine times as many pixels.
    let mut many = vec![0.0; 128];
    (50..114).for_each(|bin| many[bin] = if bin < 82 { 0.9 / 32.0 } else { 0.1 / 32.0 });
    let c = oracle::noise_aware_curve(&many, 3.0, &curve);
    assert!(slope(&c, 60) > 0.8 && slope(&c, 100) < 0.1, "{} {}", slope(&c, 60), slope(&c, 100));
}

/// The curve follows a change of the scene with the speed of the eye.
#[test]
fn noise_aware_curve_adapts() {
    let bench = Bench::open();
    let params = PostParams { tonemap: Tonemap::NoiseAware, ..unbiased() };
    let mut stage = Exposure::new(&bench.device).unwrap();
    let mut curve = |luminance: f32, dt| {
        bench.expose(&mut stage, [4, 4], &[[luminance; 3]; 16], dt, &params);
        stage.read_curve().unwrap()
    };
    let (before, unchanged) = (curve(0.1, None), curve(10.0, Some(0.0)));
    assert_eq!(before, unchanged);
    let after = curve(10.0, Some(1e6));
    let middle = {
        let start = curve(0.1, Some(1e6));
        assert!(start.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-4));
        curve(10.0, Some(0.25))
    };
    let share = (middle[60] - before[60]) / (after[60] - before[60]);
    // 1 - exp(-0.25 * 2) towards a target that has itself moved as far as the exposure.
    assert!((0.1..0.6).contains(&share), "{share}");
}
