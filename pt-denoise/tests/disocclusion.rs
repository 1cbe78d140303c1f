//! What comes into view when an object moves away: R5, R6 and R12 of the faults that denoisers are known for.

use crate::common::*;
use pt_denoise::oracle::{Guided, Light};
use pt_denoise::{DenoiseParams, Denoiser};

fn params(denoiser: Denoiser, change: impl FnOnce(&mut DenoiseParams)) -> DenoiseParams {
    let mut params = DenoiseParams { variant: denoiser, ..DenoiseParams::default() };
    change(&mut params);
    params
}

fn largest_error(values: &[f32], want: f32) -> f32 {
    values.iter().map(|v| (v - want).abs()).fold(0.0, f32::max)
}

/// A dark box moves over a bright wall; both have one material, so that only the distance tells them apart.
fn uncovered(params: DenoiseParams) -> f32 {
    let size = [48, 16];
    let mut bench = Bench::new(size, params);
    let mut worst = 0.0f32;
    for frame in 0..6 {
        let left = 4 + 5 * frame;
        let covered = |i: usize| (left..left + 16).contains(&(i % 48));
        let pixels: Vec<Guided> = (0..count(size))
            .map(|i| {
                let wall = wall_pixel();
                let moving = Guided { depth: 1.5, motion: [-5.0 / 48.0, 0.0, 0.0, 100.0], ..wall };
                if covered(i) { moving } else { wall }
            })
            .collect();
        let light: Vec<_> = (0..count(size)).map(|i| grey(if covered(i) { 0.01 } else { 1.0 })).collect();
        let out = hf(&bench.next(&pixels, &light));
        let seen: Vec<f32> = (0..count(size)).filter(|i| !covered(*i)).map(|i| out[i]).collect();
        worst = worst.max(largest_error(&seen, 1.0));
    }
    worst
}

/// R5
#[test]
fn an_uncovered_wall_has_no_dark_smear() {
    for denoiser in [Denoiser::Accumulate, Denoiser::Svgf] {
        let kept = uncovered(params(denoiser, |_| {}));
        let blind = uncovered(params(denoiser, |p| p.temporal.depth = 1.0));
        println!("R5: error {kept:.5}; without the test of distances {blind:.3}");
        assert!(kept < 0.01 && blind > 0.3, "{kept}, {blind}");
    }
}

/// R6: the wall is uncovered while its samples are missing: it takes the light of what is known around it, not black.
#[test]
fn missing_history_is_not_black() {
    let size = [24, 12];
    let mut bench = Bench::of(size, Denoiser::Svgf);
    let block = |i: usize| (10..13).contains(&(i % 24)) && (4..7).contains(&(i / 24));
    for frame in 0..4 {
        let mut pixels = wall(size);
        let mut light = constant(size, 1.0);
        for i in (0..count(size)).filter(|i| block(*i)) {
            if frame < 2 {
                pixels[i] = Guided { material: 2, depth: 1.0, ..wall_pixel() };
                light[i] = grey(0.0);
            } else if frame == 2 {
                light[i] = grey(f32::NAN);
            }
        }
        let out = hf(&bench.next(&pixels, &light));
        let seen: Vec<f32> = (0..count(size)).filter(|i| frame >= 2 || !block(*i)).map(|i| out[i]).collect();
        let error = largest_error(&seen, 1.0);
        // The steep exponent of the normals and the depth leave the wall's own light.
        assert!(error < 1e-4, "R6, frame {frame}: {error}");
    }
}

/// R12: a box that covered the wall is gone. The wall behind it has the bits of a first frame: it is filtered once, and by nothing of the box. Largest
/// difference from a first frame, beyond the reach of the filters from the border of the box.
fn first_frame_difference(denoiser: Denoiser, depth: f32) -> f32 {
    let size = [48, 36];
    let reach = |p: &mut DenoiseParams| (p.atrous.iterations, p.temporal.depth) = (2, depth);
    let mut random = Random(9);
    let covered = |i: usize| (6..42).contains(&(i % 48)) && (4..32).contains(&(i / 48));
    let mut bench = Bench::new(size, params(denoiser, reach));
    for _ in 0..6 {
        let with_box =
            |(i, pixel): (usize, Guided)| Guided { depth: if covered(i) { 1.5 } else { 3.0 }, ..pixel };
        let pixels: Vec<_> = wall(size).into_iter().enumerate().map(with_box).collect();
        bench.next(&pixels, &noise(size, || random.exponential()));
    }
    let light = noise(size, || random.exponential());
    let out = bench.next(&wall(size), &light);
    let first = Bench::new(size, params(denoiser, reach)).next(&wall(size), &light);
    // Two levels reach 2 + 4 pixels, smoothed variances 1 + 2 more, their estimate 3 more: 12.
    let inner = |i: &usize| (20..28).contains(&(i % 48)) && (17..19).contains(&(i / 48));
    let difference = |of: &dyn Fn(&Light) -> f32| {
        (0..count(size)).filter(inner).map(|i| (of(&out[i]) - of(&first[i])).abs()).fold(0.0, f32::max)
    };
    difference(&|l| l.hf[0]).max(difference(&|l| l.spec[0]))
}

#[test]
fn an_uncovered_wall_is_filtered_as_a_first_frame() {
    for denoiser in [Denoiser::Accumulate, Denoiser::Svgf, Denoiser::Asvgf] {
        let kept = first_frame_difference(denoiser, DenoiseParams::default().temporal.depth);
        let blind = first_frame_difference(denoiser, 1.0);
        println!("R12: difference {kept}; without the test of distances {blind:.3}");
        assert!(kept == 0.0 && blind > 0.05, "{kept}, {blind}");
    }
}
