//! Indirect diffuse light: kernels against their oracles, energy, direction, borders.

use crate::common::{Bench, Random, constant, count, guide, noise, normal, wall, wall_pixel};
use pt_core::pack::unpack_unit_vector;
use pt_denoise::images::{HISTORY_LF_COCG, HISTORY_LF_SH};
use pt_denoise::oracle::{
    Guided, LfHistory, LowFrequency, accumulate_lf, atrous_lf, deflicker, downsample, upsample,
};
use pt_denoise::{DenoiseParams, Denoiser};

/// Light without a direction.
fn plain(v: f32) -> [f32; 6] {
    [0.0, 0.0, 0.0, v, 0.25 * v, -0.5 * v]
}

fn bench(size: [u32; 2], variant: Denoiser) -> Bench {
    Bench::indirect(size, DenoiseParams { variant, ..DenoiseParams::default() })
}

/// The next frame, whose other channels are black.
fn next(bench: &mut Bench, pixels: &[Guided], lf: Vec<[f32; 6]>) -> Vec<[f32; 6]> {
    bench.lf = lf;
    bench.next(pixels, &constant(bench.size, 0.0));
    bench.filtered_lf.clone()
}

/// Directed noise with gaps and samples that are no light.
fn samples(size: [u32; 2], random: &mut Random) -> Vec<[f32; 6]> {
    (0..count(size))
        .map(|i| {
            let y = random.exponential();
            let signed = |random: &mut Random| y * (2.0 * random.unit() - 1.0);
            let mut light =
                [signed(random), signed(random), signed(random), y, signed(random), signed(random)];
            match i % 83 {
                11 => light[1] = f32::NAN,
                23 => light[5] = f32::INFINITY,
                37 => light[3] = -1.0,
                51 => light[3] = 1e30,
                _ => {}
            }
            light
        })
        .collect()
}

/// Surfaces whose vertex normals differ from pixel to pixel.
fn curved(size: [u32; 2], random: &mut Random, frame: u32) -> Vec<Guided> {
    let mut pixels = guide(size, random, frame);
    for pixel in pixels.iter_mut().filter(|p| p.material != 0) {
        let n = unpack_unit_vector(pixel.vertex_normal);
        let bend = |random: &mut Random| 0.2 * (random.unit() - 0.5);
        pixel.vertex_normal = normal(n.x + bend(random), n.y + bend(random), n.z);
    }
    pixels
}

fn wide(light: &[[f32; 6]]) -> Vec<LowFrequency> {
    light.iter().map(|l| l.map(f64::from)).collect()
}

/// `relative`: to the largest that there is.
fn compare(what: &str, got: &[LowFrequency], want: &[LowFrequency], relative: f64) {
    let top = want.iter().flatten().fold(1e-6f64, |top, v| top.max(v.abs()));
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let near = got.iter().zip(want).all(|(a, b)| (a - b).abs() <= relative * top);
        assert!(near, "{what}, pixel {i}: {got:?}, oracle {want:?}");
    }
}

#[test]
fn passes_agree_with_the_oracle() {
    for size in [[1, 1], [4, 3], [17, 5], [29, 17]] {
        let mut random = Random(u64::from(size[0]) + 11);
        let mut bench = bench(size, Denoiser::Svgf);
        bench.params.temporal.alpha_lf = 0.3;
        if size[0] > 10 {
            (bench.params.lf.deflicker, bench.params.lf.leak_guard) = (Some(1.2), true);
            bench.params.temporal.firefly_lf = Some(1.5);
        }
        let mut previous: Option<Vec<LfHistory>> = None;
        for frame in 0..6u32 {
            bench.params.lf.iterations = frame % 5;
            let pixels = curved(size, &mut random, frame);
            let lf = samples(size, &mut random);
            let filtered = wide(&next(&mut bench, &pixels, lf.clone()));
            let params = bench.params.clone();
            let now = accumulate_lf(size, &pixels, &wide(&lf), previous.as_deref(), &params.temporal, None);
            let [sh, cocg] = [HISTORY_LF_SH, HISTORY_LF_COCG].map(|id| bench.images.current(id));
            let lengths: Vec<u32> = bench.flat(cocg).iter().map(|c| c[2] as u32).collect();
            assert_eq!(lengths, now.iter().map(|h| h.length).collect::<Vec<_>>(), "{size:?}, {frame}");
            let history = wide(&bench.coefficients(sh, cocg));
            let want: Vec<_> = now.iter().map(|h| h.light).collect();
            // A dozen roundings of 6e-8.
            compare(&format!("{size:?}, {frame}, history"), &history, &want, 2e-6);
            let known: Vec<_> = history.iter().zip(&now).map(|(l, h)| (h.length > 0).then_some(*l)).collect();
            let mut tiles = downsample(size, &pixels, &known, &params.lf);
            if let Some(limit) = params.lf.deflicker {
                tiles = deflicker(size, &tiles, limit.into());
            }
            for level in 0..params.lf.iterations {
                tiles = atrous_lf(size, &pixels, &tiles, level, &params.lf);
            }
            let want = upsample(size, &pixels, &tiles, &known, &params.lf);
            // The exponentials of distances, which are differences of fp32.
            compare(&format!("{size:?}, {frame}, filtered"), &filtered, &want, 2e-5);
            let light = now.iter().zip(history).map(|(h, light)| LfHistory { light, ..*h });
            previous = Some(light.collect());
        }
    }
}

#[test]
fn frames_by_themselves_agree_with_the_oracle() {
    let size = [19, 13];
    let mut random = Random(3);
    let mut bench = bench(size, Denoiser::Atrous);
    let (pixels, lf) = (curved(size, &mut random, 0), samples(size, &mut random));
    let filtered = wide(&next(&mut bench, &pixels, lf.clone()));
    let known: Vec<_> = wide(&lf).into_iter().map(Some).collect();
    let params = &bench.params.lf;
    let mut tiles = downsample(size, &pixels, &known, params);
    for level in 0..params.iterations {
        tiles = atrous_lf(size, &pixels, &tiles, level, params);
    }
    compare("filtered", &filtered, &upsample(size, &pixels, &tiles, &known, params), 2e-5);
}

fn mean(light: &[[f32; 6]], k: usize) -> f64 {
    light.iter().map(|l| f64::from(l[k])).sum::<f64>() / light.len() as f64
}

fn variance(light: &[[f32; 6]], k: usize) -> f64 {
    let mean = mean(light, k);
    light.iter().map(|l| (f64::from(l[k]) - mean).powi(2)).sum::<f64>() / light.len() as f64
}

/// What comes out has the energy of what went in, per coefficient, and far less noise. Of half a bounce every other row is black.
#[test]
fn energy_is_kept_and_noise_falls() {
    let size = [66, 48];
    for half in [false, true] {
        let mut random = Random(9);
        let mut bench = bench(size, Denoiser::Svgf);
        let mut alone = self::bench(size, Denoiser::Accumulate);
        let mut input = Vec::new();
        let mut out = [Vec::new(), Vec::new()];
        for frame in 0..8 {
            let traced = |i: usize| !half || (i / 66 + frame).is_multiple_of(2);
            let scale = if half { 2.0 } else { 1.0 };
            let one = |random: &mut Random| {
                [0.3, 0.1, -0.2, 1.0, 0.2, -0.1].map(|v| v * scale * random.exponential())
            };
            let lf: Vec<_> =
                (0..count(size)).map(|i| if traced(i) { one(&mut random) } else { [0.0; 6] }).collect();
            input = lf.clone();
            out = [next(&mut bench, &wall(size), lf.clone()), next(&mut alone, &wall(size), lf)];
        }
        let [filtered, accumulated] = out;
        for k in 0..6 {
            let energy = mean(&filtered, k) / mean(&accumulated, k);
            let fall = variance(&input, k) / variance(&filtered, k);
            println!("half {half}, coefficient {k}: energy {energy:.4}, variance falls {fall:.0} times");
            assert!((energy - 1.0).abs() < 0.02, "{half}, {k}: {energy}");
            assert!(fall > 100.0, "{half}, {k}: {fall}");
        }
    }
}

/// Irradiance at a normal, as `sh.glsl` resolves luma.
fn irradiance(light: &[f32; 6], normal: u32) -> f64 {
    let n = unpack_unit_vector(normal);
    let directed = light[0] * n.x + light[1] * n.y + light[2] * n.z;
    f64::from(1.023_326_7 * directed + 0.886_226_9 * light[3]).max(0.0)
}

/// Sum of squared differences of neighbours.
fn gradient_energy(size: [u32; 2], values: &[f64]) -> f64 {
    let width = size[0] as usize;
    let pairs = (0..values.len()).flat_map(|i| {
        let right = (i % width + 1 < width).then_some(i + 1);
        let below = (i + width < values.len()).then_some(i + width);
        [right, below].into_iter().flatten().map(move |j| (i, j))
    });
    pairs.map(|(i, j)| (values[i] - values[j]).powi(2)).sum()
}

/// A wall with a normal map, lit from one side by noisy indirect light alone: with directions it keeps its relief, as plain colour it loses it.
#[test]
fn relief_of_a_normal_map_is_kept() {
    let size = [48, 36];
    let mut random = Random(21);
    let pixels: Vec<Guided> = (0..count(size))
        .map(|i| {
            let [x, y] = [i % 48, i / 48].map(|v| v as f32);
            Guided { normal: normal(0.4 * (1.9 * x).sin(), 0.4 * (2.3 * y).cos(), 1.0), ..wall_pixel() }
        })
        .collect();
    let light = |v: f32| [0.35 * v, 0.2 * v, 0.25 * v, v, 0.0, 0.0];
    let truth: Vec<f64> = pixels.iter().map(|p| irradiance(&light(1.0), p.normal)).collect();
    let detail = [true, false].map(|directed| {
        let mut bench = bench(size, Denoiser::Svgf);
        let mut out = Vec::new();
        for _ in 0..16 {
            let sample = |(_, p): (usize, &Guided)| {
                let v = random.exponential();
                // Without directions the light of the pixel's own normal is stored.
                let constant = (irradiance(&light(v), p.normal) / 0.886_226_9) as f32;
                if directed { light(v) } else { [0.0, 0.0, 0.0, constant, 0.0, 0.0] }
            };
            let lf = pixels.iter().enumerate().map(sample).collect();
            out = next(&mut bench, &pixels, lf);
        }
        let shown: Vec<f64> = out.iter().zip(&pixels).map(|(l, p)| irradiance(l, p.normal)).collect();
        gradient_energy(size, &shown) / gradient_energy(size, &truth)
    });
    println!("gradient energy over that of the truth: directed {:.3}, plain {:.3}", detail[0], detail[1]);
    assert!((0.9..1.1).contains(&detail[0]) && detail[1] < 0.1, "{detail:?}");
}

/// R17: under a normal map, light with directions has the energy of plain light.
#[test]
fn resolved_light_has_the_energy_of_plain_light() {
    let size = [36, 36];
    let mut random = Random(8);
    let mut bench = bench(size, Denoiser::Svgf);
    let pixels: Vec<Guided> = (0..count(size))
        .map(|_| {
            let bent = normal(0.6 * (random.unit() - 0.5), 0.6 * (random.unit() - 0.5), 1.0);
            Guided { normal: bent, ..wall_pixel() }
        })
        .collect();
    let (mut out, mut plain) = (Vec::new(), 0.0);
    for frame in 0..16 {
        let sample = |p: &Guided| {
            // One direction of the upper hemisphere, whose irradiance at the pixel's own normal is known.
            let (x, y) = (1.4 * (random.unit() - 0.5), 1.4 * (random.unit() - 0.5));
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            let v = random.exponential();
            let l =
                [0.488_602_5 * x * v, 0.488_602_5 * y * v, 0.488_602_5 * z * v, 0.282_094_8 * v, 0.0, 0.0];
            plain += irradiance(&l, p.normal);
            l
        };
        let lf = pixels.iter().map(sample).collect();
        out = next(&mut bench, &pixels, lf);
        // A history is a mean of all frames as long as it is short.
        assert!(frame < 20);
    }
    let resolved: f64 = out.iter().zip(&pixels).map(|(l, p)| irradiance(l, p.normal)).sum();
    let energy = 16.0 * resolved / plain;
    println!("R17: energy {energy:.4}");
    assert!((energy - 1.0).abs() < 0.02, "{energy}");
}

/// A curved surface whose vertex normals turn by a few degrees a pixel, under light from one direction of the sky over each pixel: between pixels
/// light keeps its angle with the vertex normal. Shown at the directions that neighbours stored, it would lose energy.
#[test]
fn curved_surfaces_keep_their_energy() {
    let size = [48, 36];
    let pixels: Vec<Guided> = (0..count(size))
        .map(|i| {
            let [x, y] = [i % 48, i / 48].map(|v| 0.12 * v as f32);
            let bent = normal(x.sin(), 0.6 * y.sin(), 1.0);
            Guided { normal: bent, vertex_normal: bent, ..wall_pixel() }
        })
        .collect();
    let mut random = Random(31);
    let mut bench = bench(size, Denoiser::Svgf);
    let (mut out, mut input) = (Vec::new(), 0.0);
    for _ in 0..16 {
        let sample = |p: &Guided| {
            let (n, v) = (unpack_unit_vector(p.vertex_normal), random.exponential());
            let l = [0.488_602_5 * n.x * v, 0.488_602_5 * n.y * v, 0.488_602_5 * n.z * v, 0.282_094_8 * v];
            let l = [l[0], l[1], l[2], l[3], 0.0, 0.0];
            input += irradiance(&l, p.normal);
            l
        };
        let lf = pixels.iter().map(sample).collect();
        out = next(&mut bench, &pixels, lf);
    }
    let shown: f64 = out.iter().zip(&pixels).map(|(l, p)| irradiance(l, p.normal)).sum();
    let energy = 16.0 * shown / input;
    println!("energy of a curved surface: {energy:.4}");
    assert!((energy - 1.0).abs() < 0.001, "{energy}");
}

/// R19: bright light behind a thin wall.
#[test]
fn light_does_not_leak_through_walls() {
    let size = [45, 24];
    // The border goes through tiles whose middle is on the bright side.
    let side = |i: usize| i % 45 < 23;
    // Walls that face the camera: their distance hardly changes within a pixel.
    let flat = Guided { motion: [0.0, 0.0, 0.0, 1000.0], ..wall_pixel() };
    let pixels: Vec<Guided> =
        (0..count(size)).map(|i| if side(i) { flat } else { Guided { depth: 3.3, ..flat } }).collect();
    let mut random = Random(2);
    for variant in [Denoiser::Svgf, Denoiser::Atrous] {
        let mut bench = bench(size, variant);
        let mut out = Vec::new();
        for _ in 0..4 {
            let lf =
                (0..count(size)).map(|i| plain(if side(i) { 100.0 * random.exponential() } else { 0.0 }));
            out = next(&mut bench, &pixels, lf.collect());
        }
        let leaked = (0..count(size)).filter(|i| !side(*i)).map(|i| out[i][3]).fold(0.0, f32::max);
        println!("{}: {leaked} of 100", variant.name());
        assert!(leaked < 0.1, "{}: {leaked}", variant.name());
    }
}

/// Where the fields show two paths, light stays in its field; elsewhere a bright pixel reaches no further than the filter.
#[test]
fn nothing_leaks_from_field_to_field() {
    let size = [33, 25];
    for flags in [1, 6] {
        let pixels = vec![Guided { flags, ..wall_pixel() }; count(size)];
        let hot = 12 * 33 + 32;
        let mut bench = bench(size, Denoiser::Atrous);
        bench.params.lf.iterations = 1;
        let mut lf = vec![[0.0; 6]; count(size)];
        lf[hot] = plain(1000.0);
        let out = next(&mut bench, &pixels, lf);
        let mut reached = 0;
        for (i, light) in out.iter().enumerate() {
            let [dx, dy] = [(i % 33).abs_diff(32), (i / 33).abs_diff(12)];
            let may = dx <= 8 && dy <= 8 && (flags == 1 || (dx + dy).is_multiple_of(2));
            assert!(may || light[3] == 0.0, "flags {flags}: {light:?} at {i}");
            reached += usize::from(light[3] > 0.0);
        }
        assert!(reached > 4, "the filter does something: {reached}");
    }
}

/// R4 for indirect light: what is no light, in some pixels for three frames, leaves nothing behind.
#[test]
fn broken_samples_leave_nothing_behind() {
    let size = [33, 18];
    for variant in [Denoiser::Accumulate, Denoiser::Svgf] {
        let mut bench = bench(size, variant);
        for frame in 0..7 {
            let mut lf = vec![plain(1.0); count(size)];
            if (2..5).contains(&frame) {
                for (k, v) in [f32::NAN, f32::INFINITY, -1e30, 1e30].into_iter().enumerate() {
                    (0..6).for_each(|c| lf[40 + 50 * k + c][c] = v);
                }
            }
            let out = next(&mut bench, &wall(size), lf);
            for (i, light) in out.iter().enumerate() {
                let near = light.iter().zip(plain(1.0)).all(|(a, b)| (a - b).abs() < 1e-5);
                assert!(near, "{}, frame {frame}, pixel {i}: {light:?}", variant.name());
            }
        }
    }
}

/// The length of this history is its own: samples of one channel that are missing do not shorten that of the other.
#[test]
fn lengths_are_apart() {
    let size = [12, 9];
    let mut bench = bench(size, Denoiser::Svgf);
    let mut random = Random(1);
    for frame in 0..4 {
        let v = if frame % 2 == 0 { 1.0 } else { f32::NAN };
        bench.lf = vec![plain(v); count(size)];
        bench.next(&wall(size), &noise(size, || random.unit()));
    }
    let lengths = bench.flat(bench.images.current(HISTORY_LF_COCG));
    assert!(lengths.iter().all(|c| c[2] == 2.0 && c[3] == 1.0), "{:?}", lengths[0]);
    assert!(bench.lengths().iter().all(|n| *n == 4));
}

/// Light of 1 with one tile in forty far brighter: what blinks from frame to frame is limited, its excess is lost, and the other light stays.
#[test]
fn deflicker_limits_single_bright_tiles() {
    let size = [66, 48];
    let spread = |deflicker: Option<f32>| {
        let mut random = Random(15);
        let mut bench = bench(size, Denoiser::Atrous);
        bench.params.lf.deflicker = deflicker;
        let sample = |_| plain(if random.unit() < 1.0 / 360.0 { 100.0 } else { 1.0 });
        let out = next(&mut bench, &wall(size), (0..count(size)).map(sample).collect());
        (mean(&out, 3), variance(&out, 3).sqrt())
    };
    let [(mean_without, without), (mean_with, with)] = [None, Some(2.0)].map(spread);
    println!("deflicker: deviation {without:.3} -> {with:.3}, mean {mean_without:.3} -> {mean_with:.3}");
    assert!(with < 0.5 * without, "{without} {with}");
    // The bright samples add 0.12. A bright tile is limited to twice the light around it, which adds 1/40, and more where that has a bright tile, too.
    assert!(mean_without > 1.08 && (1.0..1.1).contains(&mean_with), "{mean_without} {mean_with}");
}

/// One sample in 500 is a thousand times as bright as the others, as those of bounce light through a small opening: what is over the limit leaves the picture, and the other light stays.
#[test]
fn single_bright_samples_are_limited() {
    let size = [66, 48];
    let filtered = |firefly: Option<f32>| {
        let mut random = Random(33);
        let mut bench = bench(size, Denoiser::Svgf);
        bench.params.temporal.firefly_lf = firefly;
        let mut out = Vec::new();
        for _ in 0..8 {
            let sample = |_| plain(if random.unit() < 0.002 { 1000.0 } else { random.exponential() });
            out = next(&mut bench, &wall(size), (0..count(size)).map(sample).collect());
        }
        (mean(&out, 3), variance(&out, 3).sqrt())
    };
    let [(mean_without, without), (mean_with, with)] = [None, Some(20.0)].map(filtered);
    println!(
        "limit of single samples: deviation {without:.3} -> {with:.3}, mean {mean_without:.3} -> {mean_with:.3}"
    );
    // 1 without the bright samples, which add 2; at most 20 times 1 is left of each, 0.04.
    assert!(
        with < 0.1 * without && (0.95..1.1).contains(&mean_with) && mean_without > 2.0,
        "{mean_with} {with}"
    );
}

/// R19: a thin wall between a bright and a dark room, both with the same distance and normal in the picture: the guard keeps the light where it is, and its sum.
#[test]
fn light_leaks_less_with_the_guard() {
    let size = [66, 48];
    let leaked = |leak_guard: bool| {
        let mut bench = bench(size, Denoiser::Atrous);
        (bench.params.lf.leak_guard, bench.params.lf.iterations) = (leak_guard, 1);
        let lf: Vec<_> = (0..count(size)).map(|i| plain(if i % 66 < 33 { 10.0 } else { 0.1 })).collect();
        let out = next(&mut bench, &wall(size), lf);
        let dark: Vec<f64> =
            (0..count(size)).filter(|i| i % 66 >= 35).map(|i| f64::from(out[i][3])).collect();
        (dark.iter().sum::<f64>() / dark.len() as f64 / 0.1, mean(&out, 3) / 5.05)
    };
    let [(without, energy_without), (with, energy)] = [false, true].map(leaked);
    println!(
        "R19: light in the dark room {without:.3} -> {with:.3} of its own; energy {energy_without:.4}, {energy:.4}"
    );
    assert!(without > 1.5 && with < 1.1, "{without} {with}");
    assert!((energy - 1.0).abs() < 0.01, "{energy}");
}
