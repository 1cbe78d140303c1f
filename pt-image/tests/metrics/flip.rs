//! FLIP: the 8-bit library, our own floating-point LDR FLIP, HDR FLIP, and the oracle, against each other.

use proptest::prelude::*;
use pt_core::rng::random4;
use pt_image::image_file::{srgb_decode, srgb_encode_8bit};
use pt_image::metrics::Metric;
use pt_image::metrics::flip::{EXPOSURE_LUMINANCE_FLOOR, Exposures, LdrFlip, PIXELS_PER_DEGREE, hdr_flip};

use super::flip_oracle::{self as oracle, Image};
use super::{DISPLAY, flat, image, measure};

type Pixels = Vec<[f32; 3]>;

/// Rows of 31 pixels, 23 of them: neither a multiple of anything nor larger than two filters.
const SIZE: [usize; 2] = [31, 23];

fn pixels(of: impl Fn(f32, f32, [f32; 4]) -> [f32; 3], seed: u32) -> Pixels {
    let [width, height] = SIZE;
    let at = |index: usize| {
        let (x, y) = ((index % width) as u32, (index / width) as u32);
        of(x as f32 / width as f32, y as f32 / height as f32, random4([x, y], 0, 0, seed))
    };
    (0..width * height).map(at).collect()
}

/// A lit wall with texture, a dark hard-edged object and a coloured gradient: what renderers make. `noise` is relative.
fn natural(noise: f32, seed: u32) -> Pixels {
    let shade = |x: f32, y: f32, random: [f32; 4]| {
        let light = 0.2 + 0.6 * (1.0 - y) * (1.0 + 0.2 * (40.0 * x).sin());
        let inside = (x - 0.55).abs() + (y - 0.5).abs() < 0.3;
        let colour = if inside { [0.05, 0.3 * x, 0.4] } else { [light, 0.8 * light, 0.5 * light + 0.3 * x] };
        [0, 1, 2].map(|c| (colour[c] * (1.0 + noise * (random[c] - 0.5))).clamp(0.0, 1.0))
    };
    pixels(shade, seed)
}

/// Pairs of display-referred images, linear values 0 to 1, by name.
fn pairs() -> Vec<(&'static str, Pixels, Pixels)> {
    let noise = |seed| pixels(|_, _, random| [random[0], random[1], random[2]], seed);
    let checker = |phase: i32| {
        let cell = |v: f32, n: usize| (v * n as f32).round() as i32;
        pixels(move |x, y, _| [((cell(x, 31) + cell(y, 23) + phase) & 1) as f32; 3], 0)
    };
    let one = |colour: [f32; 3]| vec![colour; SIZE[0] * SIZE[1]];
    let mut dot = one([0.0; 3]);
    dot[11 * SIZE[0] + 15] = [1.0; 3];
    let stripes =
        pixels(|x, _, _| if (x * 6.0) as i32 % 2 == 0 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] }, 0);
    vec![
        ("noise", noise(1), noise(2)),
        ("natural, noisy", natural(0.0, 3), natural(0.5, 4)),
        ("natural, nearly equal", natural(0.0, 3), natural(0.02, 5)),
        ("checkers", checker(0), checker(1)),
        ("a dot", one([0.0; 3]), dot),
        ("black and white", one([0.0; 3]), one([1.0; 3])),
        ("saturated stripes", stripes, one([0.0, 1.0, 0.0])),
        ("noise on red", one([1.0, 0.0, 0.0]), noise(6)),
    ]
}

fn ldr(reference: &[[f32; 3]], test: &[[f32; 3]]) -> Vec<f32> {
    LdrFlip::new(PIXELS_PER_DEGREE).map(SIZE[0], reference, test)
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn to_f32(map: Vec<f64>) -> Vec<f32> {
    map.into_iter().map(|value| value as f32).collect()
}

/// The 8-bit library on sRGB codes.
fn library(reference: &[[f32; 3]], test: &[[f32; 3]]) -> Vec<f32> {
    let encode = |pixels: &[[f32; 3]]| {
        let codes: Vec<u8> = pixels.iter().flatten().map(|&value| srgb_encode_8bit(value)).collect();
        nv_flip::FlipImageRgb8::with_data(SIZE[0] as u32, SIZE[1] as u32, &codes)
    };
    nv_flip::flip(encode(reference), encode(test), PIXELS_PER_DEGREE).to_vec()
}

fn rounded(pixels: &[[f32; 3]]) -> Pixels {
    let round = |value: f32| srgb_decode(f32::from(srgb_encode_8bit(value)) / 255.0);
    pixels.iter().map(|pixel| pixel.map(round)).collect()
}

/// What single precision may cost a pixel. The magnitude of a feature is off by about 3e-7; where features are equal but
/// for that, the square root makes 5e-4 of it, and the power c^(1 - f) passes on up to |c ln c| < 0.37 of that.
const ROUNDING: f32 = 2e-4;

#[test]
fn ldr_flip_is_the_definition() {
    for (name, reference, test) in pairs() {
        let expected = oracle::ldr_flip(
            &Image::new(SIZE[0], &reference),
            &Image::new(SIZE[0], &test),
            PIXELS_PER_DEGREE.into(),
        );
        let difference = largest_difference(&ldr(&reference, &test), &to_f32(expected));
        println!("{name}: {difference:e}");
        assert!(difference < ROUNDING, "{name}: {difference}");
    }
}

#[test]
fn ldr_flip_of_narrow_images_and_other_distances_is_the_definition() {
    let pixel = |index: u32| random4([index, 0], 0, 0, 9);
    let row = |offset: u32| -> Pixels {
        (0..36).map(|index| pixel(index + offset)).map(|[r, g, b, _]| [r, g, b]).collect()
    };
    for width in [1, 2, 36] {
        for ppd in [20.0f32, 67.0, 90.0] {
            let found = LdrFlip::new(ppd).map(width, &row(0), &row(36));
            let (reference, test) = (Image::new(width, &row(0)), Image::new(width, &row(36)));
            let difference =
                largest_difference(&found, &to_f32(oracle::ldr_flip(&reference, &test, ppd.into())));
            assert!(difference < ROUNDING, "{width} {ppd}: {difference}");
        }
    }
}

/// On colours that 8 bits hold exactly the library and we see the same input; both compute in single precision.
#[test]
fn ldr_flip_is_the_librarys_on_8_bit_images() {
    for (name, reference, test) in pairs() {
        let difference =
            largest_difference(&ldr(&rounded(&reference), &rounded(&test)), &library(&reference, &test));
        println!("{name}: {difference:e}");
        assert!(difference < ROUNDING, "{name}: {difference}");
    }
}

/// Between colours that fall between codes only their rounding stands, half a code of each image.
#[test]
fn rounding_to_8_bits_is_all_that_the_library_adds() {
    for (name, reference, test) in pairs() {
        let floating = ldr(&reference, &test);
        let by_rounding = largest_difference(&floating, &ldr(&rounded(&reference), &rounded(&test)));
        let difference = largest_difference(&floating, &library(&reference, &test));
        println!("{name}: {difference:e}, by rounding {by_rounding:e}");
        assert!(
            (difference - by_rounding).abs() < ROUNDING && difference < 0.03,
            "{name}: {difference} {by_rounding}"
        );
    }
}

#[test]
fn flip_of_flat_images_is_the_published_colour_error() {
    for (a, b) in [
        ([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
        ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([1.0, 1.0, 0.0], [1.0, 1.0, 1.0]),
    ] {
        let expected = oracle::colour_error(a.map(f64::from), b.map(f64::from));
        let found = measure(Metric::Flip, &flat(DISPLAY, a), &flat(DISPLAY, b));
        assert!((found.value - expected).abs() < 2e-3, "{a:?} {b:?}: {} is not {expected}", found.value);
        let own = LdrFlip::new(PIXELS_PER_DEGREE).map(16, &[b; 256], &[a; 256]);
        assert!(own.iter().all(|&value| (f64::from(value) - expected).abs() < 1e-5), "{a:?} {b:?}");
    }
}

#[test]
fn flip_sees_one_bright_pixel_where_it_is() {
    let a = flat(DISPLAY, [0.2; 3]);
    let mut b = a.clone();
    b.pixels[5 * 16 + 9] = [1.0; 3];
    for metric in [Metric::Flip, Metric::HdrFlip] {
        let found = measure(metric, &a, &b);
        let brightest = (0..256).max_by(|&i, &j| found.map[i].total_cmp(&found.map[j])).unwrap();
        assert_eq!(brightest, 5 * 16 + 9, "{metric:?}");
        assert!(found.value > 0.0 && found.value < 0.2, "{metric:?}: {}", found.value);
    }
}

/// The ACES curve reaches 0.85 at 2.118872.
const EXPOSED: f64 = 2.118_872_323_987_316;

#[test]
fn exposures_by_hand() {
    let exposures = |levels: &[f32]| {
        let pixels: Vec<_> = levels.iter().map(|&level| [level; 3]).collect();
        let Exposures { start, stop, count } = Exposures::of(&pixels);
        let found = oracle::exposures(&Image::new(1, &pixels));
        assert!(
            (start - found.0).abs() < 1e-12 && (stop - found.1).abs() < 1e-12 && count as usize == found.2
        );
        (start, stop, count)
    };
    let near = |found: (f64, f64, u32), start: f64, stop: f64, count: u32| {
        // The weights of red, green and blue add up to 1 only to single precision of the input.
        assert!((found.0 - start).abs() < 1e-6 && (found.1 - stop).abs() < 1e-6, "{found:?}");
        assert_eq!(found.2, count);
    };
    let zero = EXPOSED.log2();
    // Brightest 16, median 1: from 4 stops below zero to zero in 4 exposures; and by the seventeenth a stop more.
    near(exposures(&[1.0, 16.0, 0.0]), zero - 4.0, zero, 4);
    near(exposures(&[1.0, 17.0, 0.5]), zero - 17f64.log2(), zero, 5);
    // One level: two equal exposures. Of an even number the upper of the middle two is the median.
    near(exposures(&[4.0]), zero - 2.0, zero - 2.0, 2);
    near(exposures(&[1.0, 2.0, 8.0, 8.0]), zero - 3.0, zero - 3.0, 2);
    near(exposures(&[1.0, 2.0, 4.0, 8.0]), zero - 3.0, zero - 2.0, 2);
    // Luminance, not the mean of the channels.
    let green = Exposures::of(&[[0.0, 1.0, 0.0]]);
    assert!((green.start - (EXPOSED / 0.7152).log2()).abs() < 1e-9);
    // A reference that is mostly or all black; light below zero is no light.
    near(exposures(&[0.0, 0.0, 1.0]), zero, zero + 23.0, 23);
    near(exposures(&[0.0]), zero + 23.0, zero + 23.0, 2);
    assert_eq!(Exposures::of(&[[-1.0; 3]]), Exposures::of(&[[0.0; 3]]));
    assert_eq!(EXPOSURE_LUMINANCE_FLOOR, 2f64.powi(-23));
    // Equal steps, both ends included.
    let stops: Vec<_> = Exposures { start: -1.0, stop: 2.0, count: 4 }.stops().collect();
    assert_eq!(stops, [-1.0, 0.0, 1.0, 2.0]);
}

/// A dark room with a lamp: nine stops between median and brightest.
fn scene(noise: f32, seed: u32) -> Pixels {
    let mut pixels = natural(noise, seed);
    for (index, pixel) in pixels.iter_mut().enumerate() {
        let (x, y) = (index % SIZE[0], index / SIZE[0]);
        let lamp = if x.abs_diff(6) + y.abs_diff(5) < 4 { 600.0 } else { 1.0 };
        *pixel = pixel.map(|value| value * lamp);
    }
    pixels
}

#[test]
fn hdr_flip_is_the_definition() {
    let dark: Pixels = scene(0.5, 4).iter().map(|pixel| pixel.map(|value| value * 1e-3)).collect();
    for (name, reference, test) in [
        ("noise", scene(0.0, 3), scene(0.5, 4)),
        ("a thousandth of the light", scene(0.0, 3), dark),
        ("a black test", scene(0.0, 3), vec![[0.0; 3]; SIZE[0] * SIZE[1]]),
        ("a black reference", vec![[0.0; 3]; SIZE[0] * SIZE[1]], scene(0.0, 3)),
    ] {
        let found = hdr_flip(SIZE[0], &reference, &test);
        let expected = oracle::hdr_flip(
            &Image::new(SIZE[0], &reference),
            &Image::new(SIZE[0], &test),
            PIXELS_PER_DEGREE.into(),
        );
        let difference = largest_difference(&found.map, &to_f32(expected));
        println!("{name}: {difference:e}, {:?}", found.exposures);
        assert!(difference < ROUNDING, "{name}: {difference}");
    }
}

/// Values of the authors' own program (flip-evaluator 1.7 of PyPI, `flip.evaluate(reference, test, "HDR")`) for two
/// pairs of images that a formula makes: exposures, mean, and the pixels 0, 399, 540, 959 of the map.
#[test]
fn hdr_flip_is_that_of_the_authors() {
    let images = |noise: Option<f32>| -> Pixels {
        let value = |x: usize, y: usize, c: usize| {
            let level = (x / 5 + 2 * (y / 4) + c) % 14;
            let value = 2f32.powi(level as i32 - 8) * (1.0 + ((3 * x + 5 * y) % 7) as f32 / 8.0);
            noise.map_or(value, |noise| value * (1.0 + ((5 * x + 3 * y + c) % 4) as f32 / noise))
        };
        (0..960).map(|index| [0, 1, 2].map(|channel| value(index % 40, index / 40, channel))).collect()
    };
    for (noise, mean, expected) in [
        (16.0, 0.120_850_95, [0.044_938_426, 0.116_238_54, 0.119_995_99, 0.134_137_1]),
        (2.0, 0.426_315_76, [0.230_256_8, 0.362_371_5, 0.416_875_72, 0.488_133_4]),
    ] {
        let found = hdr_flip(40, &images(None), &images(Some(noise)));
        let Exposures { start, stop, count } = found.exposures;
        assert!((start + 4.440_405_8).abs() < 2e-6 && (stop - 0.673_919_86).abs() < 2e-6 && count == 6);
        let found_mean = found.map.iter().sum::<f32>() / 960.0;
        assert!((found_mean - mean).abs() < 1e-5, "{found_mean} {mean}");
        for (pixel, expected) in [0, 399, 540, 959].into_iter().zip(expected) {
            assert!((found.map[pixel] - expected).abs() < 2e-5, "{pixel}: {} {expected}", found.map[pixel]);
        }
    }
}

/// A lamp that is twice as bright looks equally white at the exposure of the room: only other exposures show it.
#[test]
fn hdr_flip_sees_what_one_exposure_hides() {
    let reference = scene(0.0, 3);
    let brighter: Pixels = reference
        .iter()
        .map(|pixel| if pixel[0] > 10.0 { pixel.map(|value| value * 2.0) } else { *pixel })
        .collect();
    let found = hdr_flip(SIZE[0], &reference, &brighter);
    let lamp = 5 * SIZE[0] + 6;
    assert!(found.map[lamp] > 0.1, "{}", found.map[lamp]);
    let white =
        |pixels: &[[f32; 3]]| -> Pixels { pixels.iter().map(|pixel| pixel.map(|v| v.min(1.0))).collect() };
    assert!(ldr(&white(&reference), &white(&brighter))[lamp] < 1e-6);
    // The room itself is the same in both, away from the lamp.
    assert_eq!(found.map[SIZE[0] * SIZE[1] - 1], 0.0);
}

/// Light in other units shifts the exposures and nothing else.
#[test]
fn hdr_flip_does_not_depend_on_the_unit_of_light() {
    let (reference, test) = (scene(0.0, 3), scene(0.5, 4));
    let base = hdr_flip(SIZE[0], &reference, &test);
    for scale in [683.0f32, 0.01] {
        let scaled = |pixels: &[[f32; 3]]| -> Pixels {
            pixels.iter().map(|pixel| pixel.map(|value| value * scale)).collect()
        };
        let found = hdr_flip(SIZE[0], &scaled(&reference), &scaled(&test));
        let shift = found.exposures.start - base.exposures.start + f64::from(scale).log2();
        assert!(shift.abs() < 1e-6 && found.exposures.count == base.exposures.count);
        assert!(largest_difference(&found.map, &base.map) < ROUNDING);
    }
}

#[test]
fn hdr_flip_as_a_metric_tells_its_exposures() {
    let (width, state) = (SIZE[0] as u32, super::SCENE);
    let (reference, test) = (image(width, state, scene(0.0, 3)), image(width, state, scene(0.5, 4)));
    let found = measure(Metric::HdrFlip, &test, &reference);
    let direct = hdr_flip(SIZE[0], &reference.pixels, &test.pixels);
    assert_eq!(found.map, direct.map);
    let exposures = direct.exposures;
    let expected = [
        ("start_exposure", exposures.start),
        ("stop_exposure", exposures.stop),
        ("exposures", exposures.count.into()),
    ];
    assert_eq!(found.details, expected);
    assert!(Metric::HdrFlip.formula().contains("T(2^c Y_b) = 0.85"));
}

fn any_pixels(top: f32) -> impl Strategy<Value = Pixels> {
    let value = prop_oneof![Just(0.0f32), Just(top), (0.0f32..1.0).prop_map(move |x| x * x * x * top)];
    prop::collection::vec(prop::array::uniform3(value), 7 * 9)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn ldr_flip_is_symmetric_and_in_range(a in any_pixels(1.0), b in any_pixels(1.0)) {
        let flip = LdrFlip::new(PIXELS_PER_DEGREE);
        let map = flip.map(7, &a, &b);
        prop_assert!(map.iter().all(|value| (0.0..=1.0).contains(value)));
        prop_assert_eq!(&map, &flip.map(7, &b, &a));
        prop_assert!(flip.map(7, &a, &a).iter().all(|&value| value == 0.0));
    }

    /// Mirrored images have mirrored differences, borders included.
    #[test]
    fn ldr_flip_has_no_preferred_direction(a in any_pixels(1.0), b in any_pixels(1.0)) {
        let flip = LdrFlip::new(PIXELS_PER_DEGREE);
        let map = flip.map(7, &a, &b);
        let mut turned = flip.map(7, &a.iter().rev().copied().collect::<Vec<_>>(), &b.iter().rev().copied().collect::<Vec<_>>());
        turned.reverse();
        prop_assert!(largest_difference(&map, &turned) < ROUNDING);
        let transposed = |pixels: &[[f32; 3]]| -> Pixels {
            (0..7 * 9).map(|index| pixels[index % 9 * 7 + index / 9]).collect()
        };
        let across = flip.map(9, &transposed(&a), &transposed(&b));
        let expected: Vec<f32> = (0..7 * 9).map(|index| map[index % 9 * 7 + index / 9]).collect();
        prop_assert!(largest_difference(&across, &expected) < ROUNDING);
    }

    #[test]
    fn hdr_flip_is_in_range(a in any_pixels(1e4), b in any_pixels(1e4)) {
        let found = hdr_flip(7, &a, &b);
        prop_assert!(found.map.iter().all(|value| (0.0..=1.0).contains(value)));
        prop_assert!(hdr_flip(7, &a, &a).map.iter().all(|&value| value == 0.0));
    }

    /// With one exposure the HDR metric is the LDR metric of the tone-mapped image; more exposures only add.
    #[test]
    fn no_exposure_exceeds_hdr_flip(a in any_pixels(100.0), b in any_pixels(100.0)) {
        let found = hdr_flip(7, &a, &b);
        let stop = found.exposures.stop.exp2() as f32;
        let aces = |x: f32| ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0);
        let shown = |pixels: &[[f32; 3]]| -> Pixels {
            pixels.iter().map(|pixel| pixel.map(|value| aces(0.6 * value * stop))).collect()
        };
        let one = LdrFlip::new(PIXELS_PER_DEGREE).map(7, &shown(&a), &shown(&b));
        prop_assert!(one.iter().zip(&found.map).all(|(one, all)| *one <= all + ROUNDING));
    }
}
