//! Faults that denoisers are known for, each as a small sequence with a bar. What shows that a case can fail is beside it: the same sequence
//! with the test of history, or the guide of the filter, switched off by its knob.

mod reflections;

use crate::common::*;
use pt_denoise::oracle::{Guided, Light};
use pt_denoise::{AtrousKernel, DenoiseParams, Denoiser};
use pt_shaders::records::FLAG_PRIMARY;

const FILTERS: [Denoiser; 5] =
    [Denoiser::Accumulate, Denoiser::Svgf, Denoiser::Asvgf, Denoiser::Atrous, Denoiser::Recurrent];

fn params(denoiser: Denoiser, change: impl FnOnce(&mut DenoiseParams)) -> DenoiseParams {
    let mut params = DenoiseParams { variant: denoiser, ..DenoiseParams::default() };
    change(&mut params);
    params
}

fn largest_error(values: &[f32], want: f32) -> f32 {
    values.iter().map(|v| (v - want).abs()).fold(0.0, f32::max)
}

#[test]
fn constant_light_stays_as_it_is() {
    let size = [33, 18];
    for denoiser in FILTERS {
        let mut bench = Bench::of(size, denoiser);
        for frame in 0..6 {
            let out = bench.next(&wall(size), &constant(size, 0.7));
            // A running mean in fp32: a rounding of 6e-8 a frame. Between the a-trous levels a root in a half float: 2^-11 of it, 2^-10 of the light.
            let is_rounded = matches!(denoiser, Denoiser::Svgf | Denoiser::Asvgf | Denoiser::Atrous);
            let tolerance = if is_rounded { 0.7 * 2f32.powi(-10) } else { 1e-6 };
            let error = largest_error(&hf(&out), 0.7).max(largest_error(&spec(&out), 0.7));
            assert!(error < tolerance, "{}, frame {frame}: {error}", pt_shaders::NamedEnum::name(denoiser));
        }
    }
}

/// Energy within 0.98 to 1.02, and a fifteenth of the variance at most.
#[test]
fn noise_falls_and_energy_stays() {
    let size = [64, 48];
    let mut random = Random(1);
    for (what, sparse, feedback) in [
        ("exponential", false, false),
        ("one sample in sixteen", true, false),
        ("one in sixteen, fed back", true, true),
    ] {
        let mut bench = Bench::new(size, params(Denoiser::Svgf, |p| p.atrous.feedback = feedback));
        let mut alone = Bench::of(size, Denoiser::Accumulate);
        let mut out = [Vec::new(), Vec::new()];
        let mut input = [0.0, 0.0];
        for _ in 0..32 {
            let light = noise(size, || if sparse { random.sparse(16) } else { random.exponential() });
            input = statistics(hf(&light));
            out = [bench.next(&wall(size), &light), alone.next(&wall(size), &light)];
        }
        for channel in [hf, spec] {
            let [filtered, accumulated] = out.each_ref().map(|light| statistics(channel(light)));
            // The mean of what history holds, which is what the filter in space may not change.
            let energy = filtered[0] / accumulated[0];
            let fall = input[1] / filtered[1];
            println!(
                "{what}: energy {energy:.4}, variance falls {fall:.0} times, {:.0} in time alone",
                input[1] / accumulated[1]
            );
            assert!((energy - 1.0).abs() < 0.02, "{what}: {energy}");
            assert!((filtered[0] - 1.0).abs() < 0.04, "{what}: mean {}", filtered[0]);
            assert!(fall > 15.0, "{what}: {fall}");
        }
    }
}

/// The recurrent blur under noise: means over disks keep the energy of a flat wall, and a shadow whose light comes from near by stays sharp.
#[test]
fn the_recurrent_blur_smooths_and_keeps_edges() {
    let size = [64, 48];
    let mut random = Random(21);
    let mut bench = Bench::of(size, Denoiser::Recurrent);
    let (mut out, mut input) = (Vec::new(), [0.0; 2]);
    for _ in 0..16 {
        let light = noise(size, || random.exponential());
        input = statistics(hf(&light));
        out = bench.next(&wall(size), &light);
    }
    let [mean, variance] = statistics(hf(&out));
    println!("recurrent: energy {mean:.4}, variance falls {:.0} times", input[1] / variance);
    assert!((mean - 1.0).abs() < 0.02 && input[1] / variance > 100.0, "{mean}, {variance}");

    let edge = |hit: f32| {
        // The wide means of short histories are the same for both.
        let mut bench = Bench::new(size, params(Denoiser::Recurrent, |p| p.recurrent.fix_frames = 1));
        bench.hits = vec![[hit; 2]; count(size)];
        let light: Vec<_> = (0..count(size)).map(|i| grey(if i % 64 < 32 { 1.0 } else { 0.0 })).collect();
        let mut out = Vec::new();
        for _ in 0..8 {
            out = hf(&bench.next(&wall(size), &light));
        }
        (0..48).map(|y| f64::from(out[y * 64 + 34])).sum::<f64>() / 48.0
    };
    let [near, far] = [0.05, 30.0].map(edge);
    println!(
        "recurrent: light two pixels beyond an edge: {near:.3} where it comes from near by, {far:.3} from far away"
    );
    assert!(near < 0.02 && far > 0.1, "{near}, {far}");
}

/// R7: what the filter in space alone does to the energy of single bright pixels.
#[test]
fn bright_pixels_beside_dark_ones_lose_no_energy() {
    let size = [64, 48];
    let mut random = Random(2);
    for n in [4, 16, 64] {
        let light = noise(size, || random.sparse(n));
        let mut bench = Bench::of(size, Denoiser::Atrous);
        let out = bench.next(&wall(size), &light);
        let energy = statistics(hf(&out))[0] / statistics(hf(&light))[0];
        println!("R7, one sample in {n}: energy {energy:.4}");
        // At the border of the frame a bright pixel weighs more or less than one.
        assert!((energy - 1.0).abs() < 0.02, "one sample in {n}: {energy}");
    }
}

/// R4: samples that are no light, in some pixels for three frames.
#[test]
fn broken_samples_leave_nothing_behind() {
    let size = [33, 18];
    for denoiser in FILTERS {
        let mut bench = Bench::of(size, denoiser);
        for frame in 0..8 {
            let mut light = constant(size, 1.0);
            if (2..5).contains(&frame) {
                for (i, v) in
                    [(40, f32::NAN), (41, f32::INFINITY), (42, f32::NEG_INFINITY), (200, -1e30), (300, 1e30)]
                {
                    light[i] = Light { hf: [v; 3], spec: [1.0; 3] };
                    light[i + 100].spec = [1.0, v, 1.0];
                }
            }
            let out = bench.next(&wall(size), &light);
            assert!(out.iter().all(|l| l.hf.iter().chain(&l.spec).all(|v| v.is_finite())), "frame {frame}");
            // With a history, or with neighbours, nothing of it is to be seen at any time.
            let error = largest_error(&hf(&out), 1.0).max(largest_error(&spec(&out), 1.0));
            assert!(error < 1e-5, "{}, frame {frame}: {error}", pt_shaders::NamedEnum::name(denoiser));
        }
    }
}

/// Everything is broken from the start, for two frames.
#[test]
fn a_broken_start_is_forgotten() {
    let size = [17, 9];
    for denoiser in FILTERS {
        let mut bench = Bench::of(size, denoiser);
        for v in [f32::NAN, 1e30] {
            let out = bench.next(&wall(size), &constant(size, v));
            assert!(hf(&out).iter().all(|v| *v == 0.0), "nothing is known");
        }
        let out = bench.next(&wall(size), &constant(size, 1.0));
        assert!(largest_error(&hf(&out), 1.0) < 1e-6);
    }
}

/// R8: a dark floor meets a bright wall at one distance; the camera moves by fractions of a pixel.
fn strafed(params: DenoiseParams) -> f32 {
    let size = [32, 24];
    let mut bench = Bench::new(size, params);
    let mut worst = 0.0f32;
    for frame in 0..24 {
        // The border comes down the picture by a quarter of a pixel a frame.
        let border = 8.1 + 0.25 * frame as f32;
        let floor = |i: usize| (i / 32) as f32 + 0.5 > border;
        let pixels: Vec<Guided> = (0..count(size))
            .map(|i| {
                let facing = if floor(i) { normal(0.0, 1.0, 0.02) } else { normal(0.0, 0.0, 1.0) };
                let motion = [0.0, -0.25 / 24.0, 0.0, if floor(i) { 2.0 } else { 100.0 }];
                Guided { normal: facing, vertex_normal: facing, motion, ..wall_pixel() }
            })
            .collect();
        let light: Vec<_> = (0..count(size)).map(|i| grey(if floor(i) { 0.1 } else { 1.0 })).collect();
        let out = hf(&bench.next(&pixels, &light));
        let errors = (0..count(size)).map(|i| (out[i] - light[i].hf[0]).abs());
        worst = worst.max(errors.fold(0.0, f32::max));
    }
    worst
}

#[test]
fn a_floor_seen_edge_on_keeps_its_light() {
    for denoiser in [Denoiser::Accumulate, Denoiser::Svgf] {
        let kept = strafed(params(denoiser, |_| {}));
        let blind = strafed(params(denoiser, |p| p.temporal.normal = 180.0));
        println!("R8: error {kept:.5}; without the test of normals {blind:.3}");
        assert!(kept < 0.001 && blind > 0.1, "{kept}, {blind}");
    }
}

/// R11: a picture in a glossy floor whose lobe is narrower than a pixel stays sharp; on a rough one it may blur.
#[test]
fn reflections_are_not_wider_than_the_lobe() {
    let size = [40, 20];
    let mut random = Random(3);
    let sharp = |roughness: f32, random: &mut Random| {
        let mut bench = Bench::of(size, Denoiser::Atrous);
        let pixels = vec![Guided { roughness, pixel_angle: 1.0 / 64.0, ..wall_pixel() }; count(size)];
        // A line among noise, which widens the tolerance.
        let light: Vec<_> = (0..count(size))
            .map(|i| grey(random.exponential() + if i % 40 == 20 { 4.0 } else { 0.0 }))
            .collect();
        let out = spec(&bench.next(&pixels, &light));
        let mean = |column: usize, of: &dyn Fn(usize) -> f32| {
            (0..20).map(|y| of(y * 40 + column)).sum::<f32>() / 20.0
        };
        let contrast = |of: &dyn Fn(usize) -> f32| mean(20, of) - 0.5 * (mean(17, of) + mean(23, of));
        contrast(&|i| out[i]) / contrast(&|i| light[i].spec[0])
    };
    let [glossy, rough] = [3277.0 / 65535.0, 1.0].map(|roughness| sharp(roughness, &mut random));
    println!("R11: contrast of a line kept: roughness 0.05 {glossy:.3}, 1 {rough:.3}");
    assert!(glossy > 0.99 && rough < 0.8, "{glossy}, {rough}");
}

/// R14 and R15: history grows by one in each frame while the picture moves by fractions of a pixel, at its borders too.
#[test]
fn histories_are_whole_and_reach_the_border() {
    let size = [25, 14];
    for motion in [[0.0, 0.0], [-0.3, 0.0], [0.4, -0.27], [0.0, 0.45]] {
        let mut bench = Bench::of(size, Denoiser::Svgf);
        let pixel = Guided { motion: [motion[0] / 25.0, motion[1] / 14.0, 0.0, 100.0], ..wall_pixel() };
        for frame in 1..=12 {
            bench.next(&vec![pixel; count(size)], &constant(size, 1.0));
            let lengths = bench.lengths();
            assert!(lengths.iter().all(|n| *n == frame), "{motion:?}, frame {frame}: {lengths:?}");
        }
    }
}

/// What moved in from outside has no history, and the rest keeps its own.
#[test]
fn what_comes_into_the_picture_starts_over() {
    let size = [24, 8];
    let mut bench = Bench::of(size, Denoiser::Accumulate);
    let pixel = Guided { motion: [-2.0 / 24.0, 0.0, 0.0, 100.0], ..wall_pixel() };
    for _ in 0..3 {
        bench.next(&vec![pixel; count(size)], &constant(size, 1.0));
    }
    let row: Vec<u32> = bench.lengths()[..7].to_vec();
    assert_eq!(row, [1, 1, 2, 2, 3, 3, 3]);
}

/// One bright pixel at the border of the two fields of the split frame, whose neighbour in the image is at the other side of the picture.
#[test]
fn nothing_leaks_from_field_to_field() {
    // Farthest pixels that a kernel reaches, and how many of one field it reaches from a corner.
    for (size, kernel, radius, least) in
        [([32, 12], AtrousKernel::Three, 1, 3), ([33, 13], AtrousKernel::Five, 2, 5)]
    {
        for flags in [FLAG_PRIMARY, 6] {
            let pixels = vec![Guided { flags, ..wall_pixel() }; count(size)];
            // Rows of both parities: the last column of one field, the first of the other.
            for hot in [5 * size[0] + size[0] - 1, 6 * size[0], 5 * size[0]].map(|i| i as usize) {
                let loose = |p: &mut DenoiseParams| {
                    (p.atrous.luminance_hf, p.atrous.iterations) = (1000.0, 1);
                    p.atrous.kernel = kernel;
                    p.temporal.firefly = None;
                };
                for denoiser in [Denoiser::Svgf, Denoiser::Atrous] {
                    let mut bench = Bench::new(size, params(denoiser, loose));
                    let mut light = constant(size, 0.0);
                    light[hot] = grey(1000.0);
                    let out = hf(&bench.next(&pixels, &light));
                    let at = |i: usize| [i % size[0] as usize, i / size[0] as usize];
                    let [x, y] = at(hot);
                    let mut reached = 0;
                    for (i, v) in out.iter().enumerate() {
                        let [dx, dy] = [at(i)[0].abs_diff(x), at(i)[1].abs_diff(y)];
                        let same_field = (dx + dy).is_multiple_of(2);
                        let may = dx <= radius && dy <= radius && (flags == FLAG_PRIMARY || same_field);
                        assert!(
                            may || *v == 0.0,
                            "{size:?}, flags {flags}: {v} at {:?} from {:?}",
                            at(i),
                            at(hot)
                        );
                        reached += usize::from(*v > 0.0);
                    }
                    assert!(reached >= least, "the filter does something: {reached}");
                }
            }
        }
    }
}

/// R22: of white noise, no checkerboard pattern is left.
#[test]
fn no_checkerboard_pattern_is_left() {
    let size = [64, 48];
    let mut random = Random(4);
    let mut bench = Bench::of(size, Denoiser::Svgf);
    let mut out = Vec::new();
    for _ in 0..8 {
        // Half of the fields' rays have gone elsewhere.
        let light: Vec<_> = (0..count(size))
            .map(|i| {
                if (i % 64 + i / 64).is_multiple_of(2) {
                    grey(random.exponential())
                } else {
                    grey(random.sparse(2))
                }
            })
            .collect();
        out = hf(&bench.next(&wall(size), &light));
    }
    // Over blocks of 4 x 4: the part of the variance that is at the checkerboard's frequency, for white noise 1/16.
    let mut pattern = 0.0;
    let mut all = 0.0;
    for block in 0..16 * 12 {
        let value = |k: usize| f64::from(out[(block / 16 * 4 + k / 4) * 64 + block % 16 * 4 + k % 4]);
        let mean = (0..16).map(value).sum::<f64>() / 16.0;
        let sign = |k: usize| if (k % 4 + k / 4).is_multiple_of(2) { 1.0 } else { -1.0 };
        pattern += ((0..16).map(|k| sign(k) * value(k)).sum::<f64>() / 16.0).powi(2);
        all += (0..16).map(|k| (value(k) - mean).powi(2)).sum::<f64>() / 16.0;
    }
    let amplitude = (pattern / 192.0).sqrt();
    let all = (all / 192.0).sqrt();
    println!("R22: amplitude of the checkerboard {amplitude:.5}, of all within a block {all:.5}");
    // Noise that has no pattern has a quarter of its amplitude there; what comes in has 0.35 / 4.
    assert!(amplitude < 0.02 && amplitude < 0.4 * all, "{amplitude}, {all}");
}

/// The frame after a reset has the bits of a first frame.
#[test]
fn a_reset_starts_over() {
    let size = [19, 11];
    for denoiser in FILTERS {
        let mut random = Random(5);
        let frames: Vec<_> = (0..4).map(|_| noise(size, || random.exponential())).collect();
        let mut fresh = Bench::of(size, denoiser);
        let first = fresh.next(&wall(size), &frames[3]);
        let mut bench = Bench::of(size, denoiser);
        frames.iter().take(3).for_each(|light| {
            bench.next(&wall(size), light);
        });
        bench.images.reset_history();
        assert_eq!(bench.next(&wall(size), &frames[3]), first);
    }
}

/// Sky beside a wall: no light, no history, and nothing of it in the wall.
#[test]
fn sky_stays_empty() {
    let size = [20, 10];
    for denoiser in FILTERS {
        let mut bench = Bench::of(size, denoiser);
        let sky = |i: usize| i % 20 < 9;
        let pixels: Vec<_> = (0..count(size))
            .map(|i| if sky(i) { Guided { depth: 1e18, ..Guided::default() } } else { wall_pixel() })
            .collect();
        for _ in 0..3 {
            let light: Vec<_> = (0..count(size)).map(|i| grey(if sky(i) { f32::NAN } else { 1.0 })).collect();
            let out = hf(&bench.next(&pixels, &light));
            for (i, v) in out.iter().enumerate() {
                let want = if sky(i) { 0.0 } else { 1.0 };
                assert!((v - want).abs() < 1e-6, "{i}: {v}");
            }
        }
    }
}
