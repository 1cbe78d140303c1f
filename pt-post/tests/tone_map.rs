//! Metering, tone curves and display encoding: kernels against oracle, closed forms and published values.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, Recorder};
use pt_post::{ExposureMode, ExposureRecord, PostParams, Radiance, ToneMap, Tonemap, oracle};
use pt_shaders::channels::{ACCUMULATED, DISPLAY, FLAT_COLOR};

type Rgb = [f32; 3];

struct Bench {
    device: TestDevice,
    stage: ToneMap,
}

impl Bench {
    fn open() -> Self {
        let device = TestDevice::open();
        let stage = ToneMap::new(&device).unwrap();
        Self { device, stage }
    }

    /// Shows an image; returns display codes (RGBA) and exposure.
    fn show(&self, size: [u32; 2], pixels: &[Rgb], params: &PostParams) -> (Vec<u8>, ExposureRecord) {
        let images = ChannelImages::new(&self.device, size, [FLAT_COLOR, DISPLAY]).unwrap();
        // Alpha is no radiance: it must not show anywhere.
        let texels: Vec<[f32; 4]> = pixels.iter().map(|c| [c[0], c[1], c[2], f32::NAN]).collect();
        images.current(FLAT_COLOR).write(bytemuck::cast_slice(&texels)).unwrap();
        let mut recorder = Recorder::new(&self.device).unwrap();
        let mut frame = recorder.begin().unwrap();
        self.stage.record(&mut frame, &images, Radiance::Frame, params).unwrap();
        frame.submit().unwrap();
        (images.current(DISPLAY).read().unwrap(), self.stage.exposure().unwrap())
    }

    fn ev100(&self, size: [u32; 2], pixels: &[Rgb], params: &PostParams) -> f64 {
        f64::from(self.show(size, pixels, params).1.ev100)
    }
}

/// What the closed forms are for: the metered luminance is the average.
fn unbiased() -> PostParams {
    PostParams { meter_bias: 0.0, ..Default::default() }
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

/// Colours with luminance from 1e-4 to 1e4.
fn random_pixels(runner: &mut TestRunner, count: usize) -> Vec<Rgb> {
    let value = (-4.0f32..4.0).prop_map(|e| 10f32.powf(e));
    let rgb = (value, 0.5f32..1.0, 0.5f32..1.0).prop_map(|(r, g, b)| [r, g * r, b * r]);
    prop::collection::vec(rgb, count).new_tree(runner).unwrap().current()
}

#[test]
fn meter_agrees_with_oracle_and_exact_percentiles() {
    let bench = Bench::open();
    let mut runner = TestRunner::deterministic();
    for size in [[1, 1], [2, 1], [17, 5], [33, 31], [160, 90]] {
        let pixels = random_pixels(&mut runner, (size[0] * size[1]) as usize);
        for (meter_low, meter_high) in [(0.7, 0.9), (0.0, 1.0), (0.25, 0.3)] {
            let params = PostParams { meter_low, meter_high, ..unbiased() };
            let (_, exposure) = bench.show(size, &pixels, &params);
            assert_eq!(exposure.metered_pixels as usize, pixels.len());
            let got = f64::from(exposure.ev100);
            let want = oracle::meter(&pixels, &params);
            // fp32 luminance may round a pixel to the next step of 1/128 octave.
            assert!((got - want).abs() < 2e-3 + 8e-3 / pixels.len() as f64, "{size:?}: {got}, oracle {want}");
            // Half a step everywhere, and a bin of 1/8 octave at either end where the pixels are few.
            let exact = exact_ev(&pixels, &params);
            let tolerance = if pixels.len() > 10_000 { 0.01 } else { 0.2 };
            assert!((got - exact).abs() < tolerance, "{size:?}: {got}, sorted {exact}");
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
    let got = bench.ev100([2, 2], &[[1e9; 3]; 4], &unbiased());
    assert!((got - ev_of(65536.0)).abs() < 0.01, "{got}");
}

#[test]
fn mixture_follows_the_percentiles() {
    let bench = Bench::open();
    let size = [100, 10];
    // 80 % at 1, 20 % at 16: the metered fifth between 70 and 90 % is half one, half the other.
    let pixels: Vec<Rgb> = (0..1000).map(|i| if i % 5 == 0 { [16.0; 3] } else { [1.0; 3] }).collect();
    let ev = |low, high| {
        let params = PostParams { meter_low: low, meter_high: high, ..unbiased() };
        bench.ev100(size, &pixels, &params)
    };
    for (low, high, mean_log) in [(0.7, 0.9, 2.0), (0.0, 1.0, 0.8), (0.1, 0.8, 0.0), (0.85, 0.95, 4.0)] {
        let got = ev(low, high);
        assert!((got - (mean_log + 3.0)).abs() < 0.006, "{low}..{high}: {got}, expected {}", mean_log + 3.0);
    }
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
    let noisy = random_pixels(&mut TestRunner::deterministic(), 2000);
    let moved = bench.ev100(size, &fireflies(&noisy), &params) - bench.ev100(size, &noisy, &params);
    // The percentiles move by one per cent of 26 octaves; a mean would move by several stops.
    assert!((0.0..0.4).contains(&moved), "{moved}");
}

#[test]
fn exposure_does_not_depend_on_the_size() {
    let bench = Bench::open();
    let tile = random_pixels(&mut TestRunner::deterministic(), 16 * 16);
    let tiled = |n: usize| -> Vec<Rgb> {
        (0..n * n * 256).map(|i| tile[(i / (16 * n) % 16) * 16 + i % 16]).collect()
    };
    let params = unbiased();
    let [one, four, sixteen] =
        [1, 2, 4].map(|n: u32| bench.show([16 * n, 16 * n], &tiled(n as usize), &params).1.ev100);
    assert_eq!((one, one), (four, sixteen));
}

#[test]
fn dark_and_broken_pixels_are_not_metered() {
    let bench = Bench::open();
    let nan = f32::NAN;
    let broken = [[nan, 1.0, 1.0], [1.0, f32::INFINITY, 1.0], [0.0; 3], [-1.0; 3], [f32::NEG_INFINITY; 3]];
    let mut pixels = vec![[0.5; 3]; 11];
    pixels.extend(broken);
    let (codes, exposure) = bench.show([16, 1], &pixels, &unbiased());
    assert_eq!(exposure.metered_pixels, 11);
    assert!((f64::from(exposure.ev100) - ev_of(0.5)).abs() < 0.006);
    let grey = codes[0];
    assert!((90..=115).contains(&grey), "{grey}");
    assert!(codes[..44].chunks_exact(4).all(|c| c == [grey, grey, grey, 255]), "nothing spreads: {codes:?}");
    assert_eq!(codes[44..52], [0, codes[45], codes[46], 255, codes[48], 255, codes[50], 255]);
    assert!(codes[45] > grey && codes[48] > grey, "the finite channels are shown: {codes:?}");
    assert!(codes[52..].chunks_exact(4).all(|c| c == [0, 0, 0, 255]), "{codes:?}");

    // Nothing to meter, and the next frame is as if it had not been.
    let params = PostParams { ev100: 2.5, ..unbiased() };
    let (_, exposure) = bench.show([2, 2], &[[0.0; 3]; 4], &params);
    assert_eq!((exposure.ev100, exposure.metered_pixels), (2.5, 0));
    assert!((bench.ev100([1, 1], &[[1.0; 3]], &params) - 3.0).abs() < 0.006);
}

#[test]
fn manual_exposure_and_compensation() {
    let bench = Bench::open();
    let pixels = [[1.2; 3], [0.6; 3], [2.4; 3], [0.0; 3]];
    let params = PostParams { exposure: ExposureMode::Manual, tonemap: Tonemap::None, ..unbiased() };
    let show = |ev100, compensation| {
        let (codes, exposure) =
            bench.show([4, 1], &pixels, &PostParams { ev100, compensation, ..params.clone() });
        assert_eq!(exposure.ev100, ev100);
        [codes[0], codes[4], codes[8], codes[12]]
    };
    // 1.2 * 2^EV is exposed to 1; sRGB of one half is 188 (187.5).
    assert_eq!(show(0.0, 0.0), [255, 188, 255, 0]);
    assert_eq!(show(1.0, 0.0), [188, 137, 255, 0]);
    assert_eq!(show(1.0, 1.0), [255, 188, 255, 0]);
    let auto = PostParams { compensation: -2.0, ..unbiased() };
    let (_, dark) = bench.show([1, 1], &[[1.0; 3]], &auto);
    assert!((f64::from(dark.scale) * 4.0 * 1.2 * f64::from(dark.ev100).exp2() - 1.0).abs() < 1e-5);
    let biased = bench.ev100([1, 1], &[[1.0; 3]], &PostParams { meter_bias: 1.5, ..unbiased() });
    assert_eq!(biased, bench.ev100([1, 1], &[[1.0; 3]], &unbiased()) - 1.5);
    let clamped = PostParams { min_ev100: 7.0, max_ev100: 9.0, ..unbiased() };
    assert_eq!(bench.ev100([1, 1], &[[1.0; 3]], &clamped), 7.0);
    assert_eq!(bench.ev100([1, 1], &[[1e4; 3]], &clamped), 9.0);
}

#[test]
fn curves_agree_with_the_oracle() {
    let bench = Bench::open();
    let mut runner = TestRunner::deterministic();
    let scale = pt_post::exposure_scale(1.0, 0.5);
    for size in [[1, 1], [3, 5], [67, 33]] {
        let mut pixels = random_pixels(&mut runner, (size[0] * size[1]) as usize);
        pixels[0] = [f32::MAX, 1e30, f32::MIN_POSITIVE];
        for tonemap in [Tonemap::Aces, Tonemap::Reinhard, Tonemap::None] {
            let params = PostParams {
                exposure: ExposureMode::Manual,
                ev100: 1.0,
                compensation: 0.5,
                tonemap,
                ..unbiased()
            };
            let (codes, exposure) = bench.show(size, &pixels, &params);
            assert_eq!(exposure.scale, scale);
            for (code, pixel) in codes.chunks_exact(4).zip(&pixels) {
                assert_eq!(code[3], 255);
                for (&code, &radiance) in code.iter().zip(pixel) {
                    let want = oracle::display_code(radiance, scale, tonemap);
                    // The rounding to 8 bits, and 1e-4 of the range for fp32 and the driver's pow.
                    assert!(
                        (f64::from(code) - want).abs() <= 0.526,
                        "{radiance} {tonemap:?}: {code}, {want}"
                    );
                }
            }
        }
    }
}

#[test]
fn accumulated_radiance_is_shown_too() {
    let bench = Bench::open();
    let images = ChannelImages::new(&bench.device, [1, 1], [FLAT_COLOR, ACCUMULATED, DISPLAY]).unwrap();
    images.current(ACCUMULATED).write(bytemuck::cast_slice(&[0.6f32, 1.2, 0.0, 4.0])).unwrap();
    let mut recorder = Recorder::new(&bench.device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let params = PostParams { exposure: ExposureMode::Manual, tonemap: Tonemap::None, ..unbiased() };
    bench.stage.record(&mut frame, &images, Radiance::Accumulated, &params).unwrap();
    frame.submit().unwrap();
    assert_eq!(images.current(DISPLAY).read().unwrap(), [188, 255, 0, 255]);
}
