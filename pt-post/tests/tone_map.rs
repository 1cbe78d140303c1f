//! Tone curves and display codes: kernels against oracle, closed forms and published values.

use crate::common::gpu::{download, random_hdr, run, upload};
use proptest::test_runner::TestRunner;
use pt_core::Image;
use pt_core::blue_noise::blue_noise;
use pt_core::test_support::TestDevice;
use pt_post::oracle::{self, Exposed};
use pt_post::{Encoding, Exposure, ExposureMode, PostParams, ToneMap, Tonemap};
use pt_shaders::channels::Format;

struct Bench {
    device: TestDevice,
    exposure: Exposure,
    /// For the curves and encodings so far.
    stages: Vec<((Tonemap, Encoding), ToneMap)>,
}

impl Bench {
    fn open() -> Self {
        let device = TestDevice::open();
        let exposure = Exposure::new(&device).unwrap();
        Self { device, exposure, stages: Vec::new() }
    }

    fn show(
        &mut self,
        source: &oracle::Image,
        format: Format,
        encoding: Encoding,
        params: &PostParams,
    ) -> Image {
        let image = upload(&self.device, source, f32::NAN);
        let target = Image::new(&self.device, "target", format, source.size).unwrap();
        let key = (params.tonemap, encoding);
        let place = self.stages.iter().position(|(made_for, _)| *made_for == key).unwrap_or_else(|| {
            self.stages.push((key, ToneMap::new(&self.device, key.0, key.1, false).unwrap()));
            self.stages.len() - 1
        });
        run(&self.device, |frame| {
            self.exposure.record(frame, &image, None, params).unwrap();
            self.stages[place].1.record(frame, &image, &self.exposure, &target, params).unwrap();
        });
        target
    }

    /// 8-bit codes, RGBA.
    fn picture(&mut self, source: &oracle::Image, params: &PostParams) -> Vec<u8> {
        self.show(source, Format::Rgba8Unorm, Encoding::Srgb, params).read().unwrap()
    }

    fn exposed(&self, params: &PostParams) -> Exposed {
        let record = self.exposure.read().unwrap();
        let manual = params.exposure != ExposureMode::Auto;
        Exposed {
            scale: record.scale.into(),
            shift: if manual { f64::from(record.metered_ev100) - f64::from(record.ev100) } else { 0.0 },
            curve: self.exposure.read_curve().unwrap().into_iter().map(f64::from).collect(),
        }
    }
}

fn manual(ev100: f32, compensation: f32, tonemap: Tonemap) -> PostParams {
    PostParams {
        exposure: ExposureMode::Manual,
        ev100,
        compensation,
        tonemap,
        dither: false,
        ..PostParams::default()
    }
}

fn row(pixels: &[[f64; 3]]) -> oracle::Image {
    oracle::Image { size: [pixels.len() as u32, 1], pixels: pixels.to_vec() }
}

fn floats(c: [f64; 3]) -> [f32; 3] {
    c.map(|v| v as f32)
}

#[test]
fn exposure_is_arithmetic() {
    let mut bench = Bench::open();
    let source = row(&[[1.2; 3], [0.6; 3], [2.4; 3], [0.0; 3]]);
    let mut show = |ev100, compensation| {
        let codes = bench.picture(&source, &manual(ev100, compensation, Tonemap::None));
        [codes[0], codes[4], codes[8], codes[12]]
    };
    // 1.2 * 2^EV is exposed to 1; sRGB of one half is 188 (187.5).
    assert_eq!(show(0.0, 0.0), [255, 188, 255, 0]);
    assert_eq!(show(1.0, 0.0), [188, 137, 255, 0]);
    assert_eq!(show(1.0, 1.0), [255, 188, 255, 0]);
}

#[test]
fn curves_agree_with_the_oracle() {
    let mut bench = Bench::open();
    let mut runner = TestRunner::deterministic();
    for size in [[1, 1], [3, 5], [67, 33]] {
        let mut source = random_hdr(&mut runner, size);
        source.pixels[0] = [f64::from(f32::MAX), 1e30, f64::from(f32::MIN_POSITIVE)];
        for tonemap in Tonemap::ALL {
            for auto in [false, true] {
                let mut params = manual(1.0, 0.5, tonemap);
                if auto {
                    params.exposure = ExposureMode::Auto;
                }
                let codes = bench.picture(&source, &params);
                let exposed = bench.exposed(&params);
                for (code, &radiance) in codes.chunks_exact(4).zip(&source.pixels) {
                    assert_eq!(code[3], 255);
                    let want = oracle::codes(floats(radiance), &exposed, Encoding::Srgb, &params);
                    for (&code, want) in code.iter().zip(want) {
                        // The rounding to 8 bits, and 2e-4 of the range for fp32 and the driver's pow.
                        assert!(
                            (f64::from(code) - 255.0 * want).abs() <= 0.551,
                            "{radiance:?} {tonemap:?}: {code}, {}",
                            255.0 * want
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn hdr_codes_agree_with_the_oracle() {
    let mut bench = Bench::open();
    let source = random_hdr(&mut TestRunner::deterministic(), [31, 17]);
    for tonemap in [Tonemap::None, Tonemap::Agx, Tonemap::NoiseAware] {
        for encoding in [Encoding::Pq, Encoding::Scrgb, Encoding::Srgb] {
            let params = PostParams { exposure: ExposureMode::Auto, ..manual(0.0, 0.0, tonemap) };
            let image = bench.show(&source, Format::Rgba16F, encoding, &params);
            let exposed = bench.exposed(&params);
            for (got, &radiance) in download(&image).pixels.iter().zip(&source.pixels) {
                let want = oracle::codes(floats(radiance), &exposed, encoding, &params);
                for (got, want) in got.iter().zip(want) {
                    // Half floats are at most 2^-10 apart, relatively; and fp32.
                    let tolerance = 1.0 / 1024.0 * want + 1e-4;
                    assert!((got - want).abs() < tolerance, "{tonemap:?} {encoding:?}: {got}, {want}");
                }
            }
        }
    }
    // Paper white and the peak, in both units.
    let params = manual(0.0, 0.0, Tonemap::None);
    let source = row(&[[1.2; 3], [1e6; 3]]);
    let pq = download(&bench.show(&source, Format::Rgba16F, Encoding::Pq, &params));
    for (c, nits) in pq.pixels.iter().zip([203.0, 1000.0]) {
        assert!((c[0] - oracle::pq_encode(nits / 10_000.0)).abs() < 1e-3, "{nits} cd/m2: {c:?}");
    }
    let scrgb = download(&bench.show(&source, Format::Rgba16F, Encoding::Scrgb, &params));
    assert!((scrgb.pixels[0][1] - 203.0 / 80.0).abs() < 2e-3 && (scrgb.pixels[1][1] - 12.5).abs() < 1e-2);
}

#[test]
fn broken_pixels_do_not_spread() {
    let mut bench = Bench::open();
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let source = row(&[[0.5; 3], [nan, 0.5, 0.5], [0.5, inf, 0.5], [-1.0; 3], [-inf; 3], [0.5; 3]]);
    for tonemap in Tonemap::ALL {
        let codes = bench.picture(&source, &manual(0.0, 0.0, tonemap));
        let pixel = |i: usize| &codes[4 * i..4 * i + 4];
        assert_eq!(pixel(0), pixel(5), "{tonemap:?}");
        assert!(pixel(0)[0] > 60, "{tonemap:?}: {codes:?}");
        assert_eq!((pixel(3), pixel(4)), (&[0, 0, 0, 255][..], &[0, 0, 0, 255][..]), "{tonemap:?}");
        assert!(pixel(2)[1] > 240, "{tonemap:?}: {codes:?}");
        // NaN is black in its channel; curves that mix channels may take a little from the others.
        assert!(pixel(1)[0] < pixel(1)[1], "{tonemap:?}: {codes:?}");
    }
    for (value, code) in [(0.0, 0), (1e30, 255)] {
        for tonemap in [
            Tonemap::Aces,
            Tonemap::AcesHill,
            Tonemap::Agx,
            Tonemap::Neutral,
            Tonemap::Reinhard,
            Tonemap::None,
        ] {
            let codes = bench.picture(&row(&[[value; 3]; 3]), &manual(0.0, 0.0, tonemap));
            assert!(
                codes.chunks_exact(4).all(|c| c[0].abs_diff(code) <= 3),
                "{tonemap:?} {value}: {codes:?}"
            );
        }
    }
}

/// Dithered grey has the mean of the undithered one to a hundredth of a code; black, white and the range stay.
#[test]
fn dither_keeps_the_mean() {
    let mut bench = Bench::open();
    let params = PostParams { dither: true, ..manual(0.0, 0.0, Tonemap::None) };
    for radiance in [0.00003, 0.0003, 0.2, 0.6, 0.603, 1.1997] {
        let source = oracle::Image::from_fn([64, 64], |_, _| [radiance; 3]);
        let codes = bench.picture(&source, &params);
        let want = 255.0 * oracle::srgb_encode(radiance / 1.2);
        for channel in 0..3 {
            let values: Vec<f64> = codes.iter().skip(channel).step_by(4).map(|&c| c.into()).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            assert!((mean - want).abs() < 0.01, "{radiance}: mean {mean}, expected {want}");
            assert!(values.iter().all(|v| (v - want).abs() < 1.51));
        }
    }
    for (radiance, code) in [(0.0, 0), (1.3, 255)] {
        let source = oracle::Image::from_fn([64, 64], |_, _| [radiance; 3]);
        assert!(bench.picture(&source, &params).chunks_exact(4).all(|c| c == [code, code, code, 255]));
    }
}

/// The noise is that of the tile: the kernel's codes are the oracle's.
#[test]
fn dither_agrees_with_the_oracle() {
    let mut bench = Bench::open();
    let params = PostParams { dither: true, ..manual(0.0, 0.0, Tonemap::Reinhard) };
    let source = random_hdr(&mut TestRunner::deterministic(), [70, 66]);
    let codes = bench.picture(&source, &params);
    let exposed = bench.exposed(&params);
    let mask = blue_noise();
    let mut off_by_one = 0;
    for (i, (code, &radiance)) in codes.chunks_exact(4).zip(&source.pixels).enumerate() {
        let want = oracle::codes(floats(radiance), &exposed, Encoding::Srgb, &params);
        for (channel, (dx, dy)) in [(0, 0), (23, 41), (47, 11)].into_iter().enumerate() {
            let at = ((i / 70 + dy) % 64) * 64 + (i % 70 + dx) % 64;
            let want = oracle::quantize(want[channel], mask[at].into());
            let difference = (f64::from(code[channel]) - want).abs();
            assert!(difference < 0.6, "{difference}");
            off_by_one += u32::from(difference > 0.51);
        }
    }
    assert!(off_by_one < 20, "{off_by_one} codes on the wrong side of their rounding");
}

/// A manual exposure moves the noise-aware curve: a stop more light is about a stop brighter. Not quite: Reinhard's part bends,
/// and the noise is expected elsewhere.
#[test]
fn manual_exposure_moves_the_noise_aware_curve() {
    let mut bench = Bench::open();
    let source = oracle::Image::from_fn([32, 8], |x, _| [0.01 * 1.2f64.powi(x as i32); 3]);
    let mut green = |ev100| {
        let image = bench.show(
            &source,
            Format::Rgba16F,
            Encoding::Scrgb,
            &PostParams { peak: 1e4, ..manual(ev100, 0.0, Tonemap::NoiseAware) },
        );
        download(&image).pixels[8][1]
    };
    let ratio = green(2.0) / green(3.0);
    assert!((1.8..2.3).contains(&ratio), "{ratio}");
}
