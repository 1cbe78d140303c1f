//! R9, R10, R20: histories of what a glossy wall mirrors, while the camera moves along it. R21: two ways to look through glass.

use crate::common::*;
use pt_denoise::oracle::{Guided, Light};
use pt_denoise::{AtrousKernel, DenoiseParams, Denoiser, SpecularMotion, TemporalParams};
use pt_shaders::glam::Vec3;
use pt_shaders::records::FrameRecord;

const SIZE: [u32; 2] = [64, 24];
/// Distance of the wall from the camera.
const WALL: f32 = 3.0;

/// What is mirrored: distance behind the wall and brightness, by the ray that goes on straight through it.
type Mirrored = fn(eye: Vec3, direction: Vec3) -> (f32, f32);

/// Where a ray meets the plane z, and how far that is.
fn at_plane(eye: Vec3, direction: Vec3, z: f32) -> (Vec3, f32) {
    let length = (z - eye.z) / direction.z;
    (eye + direction * length, length)
}

/// Stripes far behind the wall.
fn stripes(eye: Vec3, direction: Vec3) -> (f32, f32) {
    let (place, length) = at_plane(eye, direction, -WALL - 9.0);
    let bright = (place.x / 3.0).floor().rem_euclid(2.0) == 0.0;
    (length, if bright { 1.0 } else { 0.1 })
}

/// A bright post near the wall, before the stripes.
fn post(eye: Vec3, direction: Vec3) -> (f32, f32) {
    let (place, length) = at_plane(eye, direction, -WALL - 0.5);
    if (-0.6..0.0).contains(&place.x) { (length, 5.0) } else { stripes(eye, direction) }
}

/// Narrow lamps near the wall, before darkness far away.
fn lamps(eye: Vec3, direction: Vec3) -> (f32, f32) {
    let (place, length) = at_plane(eye, direction, -WALL - 0.5);
    if (place.x / 0.3).floor().rem_euclid(2.0) == 0.0 {
        return (length, 5.0);
    }
    (at_plane(eye, direction, -WALL - 20.0).1, 0.2)
}

struct View {
    pixels: Vec<Guided>,
    positions: Vec<Vec3>,
    hits: Vec<[f32; 2]>,
    truth: Vec<f32>,
}

/// The wall as a camera at `x` sees it, which was at `before`.
fn view(mirrored: Mirrored, x: f32, before: f32, roughness: f32) -> View {
    let eye = Vec3::new(x, 0.0, 0.0);
    let mut out = View { pixels: Vec::new(), positions: Vec::new(), hits: Vec::new(), truth: Vec::new() };
    for i in 0..count(SIZE) {
        let uv = [(i as u32 % SIZE[0]) as f32 + 0.5, (i as u32 / SIZE[0]) as f32 + 0.5];
        let [u, v] = [uv[0] / SIZE[0] as f32, uv[1] / SIZE[1] as f32];
        let direction = Vec3::new(2.0 * u - 1.0, 1.0 - 2.0 * v, -1.0).normalize();
        let (place, distance) = at_plane(eye, direction, -WALL);
        let (to_image, brightness) = mirrored(eye, direction);
        let motion = [(x - before) / (2.0 * WALL), 0.0, 0.0, 10.0];
        let was = place.distance(Vec3::new(before, 0.0, 0.0));
        out.pixels.push(Guided {
            depth: distance,
            motion: [motion[0], 0.0, was - distance, motion[3]],
            roughness,
            pixel_angle: 2.0 / SIZE[0] as f32,
            ..wall_pixel()
        });
        out.positions.push(place);
        out.hits.push([to_image - distance; 2]);
        out.truth.push(brightness);
    }
    out
}

/// Ways to find the history.
fn follows(specular: SpecularMotion) -> TemporalParams {
    TemporalParams { specular, ..TemporalParams::default() }
}

/// Mean error of specular light over its mean, of the last frames of a walk along the wall, and the mean length of the histories. The samples have no noise: a history that is
/// dropped is no error, which is why its length counts. `change`: of the hit distances that the denoiser is told.
fn ghosts(mirrored: Mirrored, temporal: TemporalParams, change: impl Fn(&mut Vec<[f32; 2]>)) -> [f64; 2] {
    let params = DenoiseParams { variant: Denoiser::Accumulate, temporal, ..DenoiseParams::default() };
    let mut bench = Bench::new(SIZE, params);
    let (mut error, mut sum, mut length, mut pixels) = (0.0, 0.0, 0.0, 0.0);
    for frame in 0..20 {
        // Still at first, then two pixels of the wall a frame.
        let x = |frame: i32| 0.1875 * (frame - 6).max(0) as f32;
        let seen = view(mirrored, x(frame), x(frame - 1), 0.1);
        let at = |frame: i32| camera_at(Vec3::new(x(frame), 0.0, 0.0));
        bench.frame = FrameRecord::new(at(frame), at(frame - 1), SIZE, frame as u32, 0);
        bench.positions = seen.positions;
        bench.hits = seen.hits;
        change(&mut bench.hits);
        let light: Vec<_> = seen.truth.iter().map(|v| grey(*v)).collect();
        let out = spec(&bench.next(&seen.pixels, &light));
        if frame < 6 {
            let largest = out.iter().zip(&seen.truth).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(largest < 1e-5, "nothing moves: {largest}");
        } else if frame > 10 {
            let lengths = bench.specular_lengths();
            // At the sides there is no history.
            for (i, (got, want)) in out.iter().zip(&seen.truth).enumerate() {
                if (12..52).contains(&(i % 64)) {
                    error += f64::from((got - want).abs());
                    sum += f64::from(*want);
                    length += f64::from(lengths[i]);
                    pixels += 1.0;
                }
            }
        }
    }
    [error / sum, length / pixels]
}

/// R9: a bright post near the wall before stripes far behind it.
#[test]
fn a_post_in_a_mirror_leaves_no_ghosts() {
    let [surface, image, better] = [SpecularMotion::Surface, SpecularMotion::Virtual, SpecularMotion::Better]
        .map(|m| ghosts(post, follows(m), |_| ()));
    let cut = TemporalParams { parallax: Some(1.0), ..follows(SpecularMotion::Better) };
    let cut = ghosts(post, cut, |_| ());
    println!(
        "R9, ghosts and length: by surface motion {surface:.3?}, by virtual hit {image:.3?}, by the better of both {better:.3?}, with parallax=1 {cut:.3?}"
    );
    assert!(better[0] < 0.5 * surface[0] && better[0] < image[0], "{surface:?} {image:?} {better:?}");
    assert!(cut[0] < 0.7 * better[0] && cut[1] > 8.0, "{better:?} {cut:?}");
}

/// R10: hit distances of near lamps and of the dark between them. Where neighbours are averaged, images are sought where none was.
#[test]
fn hit_distances_of_two_paths_are_not_averaged() {
    let averaged = |hits: &mut Vec<[f32; 2]>| {
        let own = hits.clone();
        for (i, hit) in hits.iter_mut().enumerate() {
            let row = i / 64 * 64;
            let around = (i % 64).saturating_sub(2)..=(i % 64 + 2).min(63);
            let values: Vec<f32> = around.map(|x| own[row + x][1]).collect();
            hit[1] = values.iter().sum::<f32>() / values.len() as f32;
        }
    };
    let temporal = || TemporalParams { parallax: Some(1.0), ..follows(SpecularMotion::Better) };
    let own = ghosts(lamps, temporal(), |_| ());
    let mixed = ghosts(lamps, temporal(), averaged);
    println!("R10, ghosts and length: own hit distances {own:.3?}, means of neighbours {mixed:.3?}");
    assert!(own[0] < 0.3 * mixed[0] && own[1] > 3.0 * mixed[1], "{own:?} {mixed:?}");
}

/// R20: a planar mirror under noise, still and then moving: no pattern of the checkerboard while it is still, no ghosts while it moves.
#[test]
fn a_mirror_stands_still_and_moves() {
    let moving = [SpecularMotion::Surface, SpecularMotion::Better]
        .map(|motion| ghosts(stripes, follows(motion), |_| ()));
    let mut params = DenoiseParams { variant: Denoiser::Svgf, ..DenoiseParams::default() };
    params.temporal.specular = SpecularMotion::Better;
    let mut bench = Bench::new(SIZE, params);
    let mut random = Random(31);
    let seen = view(stripes, 0.0, 0.0, 0.1);
    let at = camera_at(Vec3::ZERO);
    bench.frame = FrameRecord::new(at, at, SIZE, 0, 0);
    (bench.positions, bench.hits) = (seen.positions, seen.hits);
    let mut out = Vec::new();
    for _ in 0..16 {
        let light: Vec<_> = seen.truth.iter().map(|v| grey(v * random.exponential())).collect();
        out = spec(&bench.next(&seen.pixels, &light));
    }
    let relative: Vec<f64> = out.iter().zip(&seen.truth).map(|(a, b)| f64::from(a / b)).collect();
    let sign = |i: usize| if (i % 64 + i / 64).is_multiple_of(2) { 1.0 } else { -1.0 };
    let pattern = relative.iter().enumerate().map(|(i, v)| sign(i) * v).sum::<f64>() / relative.len() as f64;
    // White noise of the mean of 16 samples has 1/4 / sqrt(1536).
    println!(
        "R20: checkerboard while still {pattern:.4}; ghosts and length while moving: by surface motion {:.3?}, by the better of both {:.3?}",
        moving[0], moving[1]
    );
    assert!(pattern.abs() < 0.02, "{pattern}");
    assert!(moving[1][0] < 0.4 * moving[0][0] && moving[1][1] > 8.0, "{moving:?}");
}

/// A history that follows the surface is cut short where the reflection has turned away, if that is asked for.
#[test]
fn parallax_cuts_histories_of_mirrors() {
    let lengths = |parallax: Option<f32>, roughness: f32| {
        let mut params = DenoiseParams { variant: Denoiser::Accumulate, ..DenoiseParams::default() };
        params.temporal.parallax = parallax;
        let mut bench = Bench::new(SIZE, params);
        for frame in 0..8 {
            let x = |frame: i32| 0.1875 * frame as f32;
            let seen = view(stripes, x(frame), x(frame - 1), roughness);
            let at = |frame: i32| camera_at(Vec3::new(x(frame), 0.0, 0.0));
            bench.frame = FrameRecord::new(at(frame), at(frame - 1), SIZE, frame as u32, 0);
            (bench.positions, bench.hits) = (seen.positions, seen.hits);
            let light: Vec<_> = seen.truth.iter().map(|v| grey(*v)).collect();
            bench.next(&seen.pixels, &light);
        }
        let middle = 12 * 64 + 32;
        (bench.lengths()[middle], bench.specular_lengths()[middle])
    };
    assert_eq!(lengths(None, 0.1), (8, 8));
    assert_eq!(lengths(Some(1.0), 0.1), (8, 1), "a mirror");
    assert_eq!(lengths(Some(1.0), 1.0), (8, 8), "a rough wall shows no image");
}

/// Independent runs of R21.
const SEEDS: u64 = 5;

/// Two pictures that glass shows at once, its reflectance, and how they are mixed.
fn glass_error(split: bool, period: usize, frames: usize) -> [f64; 2] {
    const REFLECTANCE: f32 = 0.3;
    let width = SIZE[0] as usize;
    let band =
        |i: usize, shift: usize| if ((i % width + shift) / period).is_multiple_of(2) { 2.0f32 } else { 0.5 };
    let reflected = |i: usize| band(i, 0);
    let refracted = |i: usize| band(i, period / 2);
    let is_reflecting = |i: usize| (i % width + i / width).is_multiple_of(2);
    let flags = if split { 6 } else { 1 };
    let pixels = vec![Guided { flags, ..wall_pixel() }; count(SIZE)];
    let mut params = DenoiseParams { variant: Denoiser::Svgf, ..DenoiseParams::default() };
    params.atrous.kernel = AtrousKernel::Five;
    let mut bench = Bench::new(SIZE, params);
    let mut errors = Vec::new();
    for seed in 0..SEEDS {
        let mut random = Random(1000 + seed);
        bench.images.reset_history();
        let mut out = Vec::new();
        for _ in 0..frames {
            let light: Vec<Light> = (0..count(SIZE))
                .map(|i| {
                    let reflects = if split { is_reflecting(i) } else { random.unit() < REFLECTANCE };
                    grey(random.exponential() * if reflects { reflected(i) } else { refracted(i) })
                })
                .collect();
            out = hf(&bench.next(&pixels, &light));
        }
        let mut error = 0.0;
        let inner: Vec<usize> = (0..count(SIZE))
            .filter(|i| (1..width - 1).contains(&(i % width)) && (1..23).contains(&(i / width)))
            .collect();
        for &i in &inner {
            let got = if split {
                // As the interleave blends the fields: the other path is that of the four pixels around.
                let around = (out[i - 1] + out[i + 1] + out[i - width] + out[i + width]) / 4.0;
                let (r, t) = if is_reflecting(i) { (out[i], around) } else { (around, out[i]) };
                REFLECTANCE * r + (1.0 - REFLECTANCE) * t
            } else {
                out[i]
            };
            let want = REFLECTANCE * reflected(i) + (1.0 - REFLECTANCE) * refracted(i);
            error += f64::from((got - want).powi(2) / (want * want));
        }
        errors.push(error / inner.len() as f64);
    }
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

/// R21: glass that reflects in one field and refracts in the other, against a choice by chance in each pixel; one ray a pixel in both.
#[test]
fn split_fields_against_a_choice_by_chance() {
    for (period, frames) in [(16, 1), (16, 8), (4, 8)] {
        let [split, chance] = [true, false].map(|split| glass_error(split, period, frames));
        println!(
            "R21: stripes of {period} pixels, {frames} frames: split {:.4} +- {:.4}, by chance {:.4} +- {:.4}",
            split[0], split[1], chance[0], chance[1]
        );
        let between = 3.0 * split[1].hypot(chance[1]);
        // Where the pictures are smooth, the fields have the noise of the light alone; detail below their distance costs what that gains.
        let wanted = if period == 16 && frames > 1 { chance[0] - between } else { chance[0] + between };
        assert!(split[0] < wanted, "{period}, {frames}: {split:?}, {chance:?}");
    }
}
