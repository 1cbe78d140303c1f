//! Changes of the light: kernels against their oracles, and how fast histories follow.

use crate::common::renderer::Renderer;
use crate::common::{
    Bench, Random, constant, count, grey, guide, hf, noise, spec, statistics, wall, wall_pixel,
};
use pt_denoise::images::{
    GRADIENTS, GRADIENTS2, HISTORY_HF, HISTORY_LF_COCG, HISTORY_LF_SH, HISTORY_SPEC, SUMS_HF, SUMS_LF,
    SUMS_SPEC, SUMS2_HF, SUMS2_LF, SUMS2_SPEC,
};
use pt_denoise::oracle::{
    Adaptive, GradientSample, History, LfHistory, Light, accumulate, accumulate_lf, filter_gradients,
    gradients, strata, sums_direct, sums_lf,
};
use pt_denoise::{DenoiseParams, Denoiser, GradientFilter, Stratum};
use pt_shaders::channels::ChannelId;

fn adaptive(change: impl FnOnce(&mut DenoiseParams)) -> DenoiseParams {
    let mut params = DenoiseParams { variant: Denoiser::Asvgf, ..DenoiseParams::default() };
    change(&mut params);
    params
}

fn random_light(size: [u32; 2], random: &mut Random) -> Vec<Light> {
    (0..count(size))
        .map(|i| {
            let colour = |random: &mut Random| [random.exponential(), random.unit(), random.unit()];
            let mut light = Light { hf: colour(random), spec: colour(random) };
            match i % 61 {
                17 => light.hf[0] = f32::NAN,
                40 => light.spec[1] = -2.0,
                _ => {}
            }
            light
        })
        .collect()
}

/// Some strata have a gradient pixel, some of which have kept their light.
fn random_samples(size: [u32; 2], side: usize, light: &[Light], random: &mut Random) -> Vec<GradientSample> {
    let [across, down] = strata(size, side as u32);
    (0..across * down)
        .map(|s| {
            let number = (random.bits() % (side * side) as u64) as usize;
            let at = [side * (s % across) + number % side, side * (s / across) + number / side];
            if random.unit() < 0.2 || at[0] >= size[0] as usize || at[1] >= size[1] as usize {
                return GradientSample::default();
            }
            let own = &light[at[1] * size[0] as usize + at[0]];
            let luminance = |c: [f32; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
            let scale = if random.unit() < 0.5 { 1.0 } else { 0.5 + random.unit() };
            let kept =
                [luminance(own.hf), luminance(own.spec)].map(|l| if l.is_finite() { l * scale } else { 1.0 });
            GradientSample { number: number as u32 + 1, luminance: kept }
        })
        .collect()
}

fn compare<const N: usize>(what: &str, got: &[[f32; N]], want: &[[f64; N]], relative: f64) {
    assert_eq!(got.len(), want.len(), "{what}");
    let tops: Vec<f64> = (0..N).map(|k| want.iter().map(|w| w[k].abs()).fold(1e-6, f64::max)).collect();
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let near = (0..N).all(|k| (f64::from(got[k]) - want[k]).abs() <= relative * tops[k]);
        assert!(near, "{what}, {i}: {got:?}, oracle {want:?}");
    }
}

#[test]
fn passes_agree_with_the_oracle() {
    let forms = [(Stratum::Three, GradientFilter::Atrous), (Stratum::Five, GradientFilter::Strided)];
    let cases = [([1, 1], 0), ([4, 5], 0), ([17, 8], 0), ([17, 8], 1), ([31, 16], 0), ([31, 16], 1)];
    for (size, form) in cases {
        let (stratum, filter) = forms[form];
        let mut random = Random(u64::from(size[0]) + 5);
        let mut bench = Bench::indirect(
            size,
            adaptive(|p| {
                p.antilag.gate_noise = 0.5;
                (p.antilag.stratum, p.antilag.filter) = (stratum, filter);
            }),
        );
        let mut previous: Option<(Vec<History>, Vec<LfHistory>)> = None;
        for frame in 0..6u32 {
            bench.params.antilag.iterations = frame % 4;
            let params = bench.params.clone();
            let (pixels, light) = (guide(size, &mut random, frame), random_light(size, &mut random));
            bench.samples = random_samples(size, stratum.side() as usize, &light, &mut random);
            let y = if frame == 3 { 4.0 } else { 1.0 };
            let lf =
                |random: &mut Random| [0.1, 0.2, -0.3, 1.0, 0.3, -0.2].map(|v| y * v * random.exponential());
            bench.lf = (0..count(size)).map(|_| lf(&mut random)).collect();
            bench.next(&pixels, &light);
            let what = format!("{size:?}, {}, {}, frame {frame}", stratum.name(), filter.name());

            let filtered = |mut now: Vec<[f64; 4]>, of_lf: bool| {
                for level in 0..params.antilag.iterations {
                    now = filter_gradients(size, &now, level, of_lf, &params.antilag);
                }
                now
            };
            let other = params.antilag.iterations % 2 == 1;
            let last = |ids: [ChannelId; 2]| bench.strata(ids[usize::from(other)]);
            let pixel_gradients = last([GRADIENTS, GRADIENTS2]);
            let want = gradients(size, &pixels, &light, &bench.samples, &params.antilag);
            compare(&format!("{what}, gradients"), &pixel_gradients, &filtered(want, false), 1e-5);
            let lf: Vec<_> = bench.lf.iter().map(|l| l.map(f64::from)).collect();
            let sums = [[SUMS_HF, SUMS2_HF], [SUMS_SPEC, SUMS2_SPEC], [SUMS_LF, SUMS2_LF]].map(last);
            for (channel, got) in sums.iter().enumerate() {
                let before = previous.as_ref();
                let want = match channel {
                    2 => sums_lf(size, &pixels, &lf, before.map(|(_, lf)| &lf[..]), &params),
                    _ => {
                        let before = before.map(|(direct, _)| &direct[..]);
                        sums_direct(size, &pixels, &light, &bench.samples, before, channel, &params)
                    }
                };
                let want = filtered(want, true);
                let part = |of: &[f64; 4]| [of[0], of[1], of[2]];
                let (of_frame, wanted): (Vec<_>, Vec<_>) = (got.iter().zip(&want))
                    .map(|(got, want)| (part(&got.map(f64::from)).map(|v| v as f32), part(want)))
                    .unzip();
                compare(&format!("{what}, sums {channel}"), &of_frame, &wanted, 1e-5);
                // Differences of squares, the same to a rounding where histories are short.
                let top = want.iter().map(|w| w[2].max(w[3])).fold(1e-6, f64::max);
                for (got, want) in got.iter().zip(&want) {
                    let near = (f64::from(got[3]) - want[3]).abs() < 1e-5 * top;
                    assert!(near, "{what}, sums {channel}: {got:?}, oracle {want:?}");
                }
            }

            let adaptive = Some(Adaptive {
                gradients: &pixel_gradients,
                sums: [&sums[0], &sums[1], &sums[2]],
                samples: &bench.samples,
                params: &params.antilag,
            });
            let before = previous.as_ref().map(|(direct, _)| &direct[..]);
            let direct = accumulate(size, &pixels, &light, before, &params.temporal, adaptive, None);
            assert_eq!(bench.lengths(), direct.iter().map(|h| h.length).collect::<Vec<_>>(), "{what}");
            let stored = bench.light(HISTORY_HF, HISTORY_SPEC);
            let rgb = |l: &[f64; 3]| l.map(|v| v as f32);
            for (name, got, want) in [
                (
                    "hf",
                    stored.iter().map(|l| rgb(&l.hf)).collect::<Vec<_>>(),
                    direct.iter().map(|h| h.hf).collect::<Vec<_>>(),
                ),
                (
                    "spec",
                    stored.iter().map(|l| rgb(&l.spec)).collect(),
                    direct.iter().map(|h| h.spec).collect(),
                ),
            ] {
                compare(&format!("{what}, {name}"), &got, &want, 5e-6);
            }
            let before = previous.as_ref().map(|(_, lf)| &lf[..]);
            let indirect = accumulate_lf(size, &pixels, &lf, before, &params.temporal, adaptive);
            let [sh, cocg] = [HISTORY_LF_SH, HISTORY_LF_COCG].map(|id| bench.images.current(id));
            let lengths: Vec<u32> = bench.flat(cocg).iter().map(|c| c[2] as u32).collect();
            assert_eq!(lengths, indirect.iter().map(|h| h.length).collect::<Vec<_>>(), "{what}");
            let kept = bench.coefficients(sh, cocg);
            compare(
                &format!("{what}, lf"),
                &kept,
                &indirect.iter().map(|h| h.light).collect::<Vec<_>>(),
                5e-6,
            );
            // What the device holds, so that errors do not add up.
            let direct = direct.into_iter().zip(&stored).zip(bench.moments());
            let direct = direct.map(|((h, l), moments)| History { hf: l.hf, spec: l.spec, moments, ..h });
            let indirect =
                indirect.iter().zip(&kept).map(|(h, l)| LfHistory { light: l.map(f64::from), ..*h });
            previous = Some((direct.collect(), indirect.collect()));
        }
    }
}

/// Frame in which the light jumps.
const SWITCH: usize = 20;

/// Frames from a jump of the light from 1 to `to` on until the mean of the picture is within 15 % of the new light; and mean and variance of the
/// still picture before it.
fn recovery(variant: Denoiser, to: f32, has_gradient_pixels: bool) -> (usize, [f64; 2]) {
    let size = [36, 27];
    let brightness = |frame: usize, _: usize| if frame < SWITCH { 1.0 } else { to };
    let mut renderer = Renderer::new(size, brightness);
    let mut bench = Bench::new(size, DenoiseParams { variant, ..DenoiseParams::default() });
    let mut before = [0.0; 2];
    let mut random = Random(12);
    for frame in 0..SWITCH + 25 {
        let light = if has_gradient_pixels {
            let (light, samples) = renderer.frame(frame);
            bench.samples = samples;
            light
        } else {
            noise(size, || random.sparse(4) * brightness(frame, 0))
        };
        let out = bench.next(&wall(size), &light);
        let [mean, variance] = statistics(hf(&out));
        let [mean_spec, _] = statistics(spec(&out));
        if frame == SWITCH - 1 {
            before = [mean, variance];
        }
        let wanted = f64::from(brightness(frame, 0));
        let near = |mean: f64| (mean - wanted).abs() < 0.15 * wanted.max(1.0);
        if frame >= SWITCH && near(mean) && near(mean_spec) {
            return (frame - SWITCH, before);
        }
    }
    (25, before)
}

/// A light that switches: histories follow within a few frames; without gradients they take dozens. Gradient pixels, which are the brightest of the last frame,
/// do not make the picture brighter.
#[test]
fn histories_follow_a_switch() {
    for to in [0.0, 3.0] {
        let (adaptive, [mean, _]) = recovery(Denoiser::Asvgf, to, true);
        let (plain, _) = recovery(Denoiser::Svgf, to, false);
        // Light samples that cannot find the light in the last frame, or cannot be taken again.
        let (unseen, _) = recovery(Denoiser::Asvgf, to, false);
        println!(
            "to {to}: asvgf {adaptive} frames, {unseen} without gradient pixels, svgf {plain}; still picture of asvgf {mean:.4}"
        );
        assert!(adaptive <= 5 && unseen <= 5 && plain >= 15, "{to}: {adaptive}, {unseen}, {plain}");
        assert!((mean - 1.0).abs() < 0.05, "{to}: {mean}");
    }
}

/// R3: a light goes out over several frames: the picture follows, and the strata are not to be seen in it.
#[test]
fn a_light_that_fades_leaves_no_boxes() {
    let size = [48, 36];
    let brightness = |frame: usize, _: usize| (1.0 - (frame as f32 - 20.0) / 8.0).clamp(0.0, 1.0);
    let mut renderer = Renderer::new(size, brightness);
    let mut bench = Bench::new(size, adaptive(|_| {}));
    let side = bench.params.antilag.stratum.side() as usize;
    let (mut late, mut pattern) = (0.0f64, 0.0f64);
    for frame in 0..34 {
        let (light, samples) = renderer.frame(frame);
        bench.samples = samples;
        let out = hf(&bench.next(&wall(size), &light));
        let [mean, _] = statistics(out.iter().copied());
        if frame >= 20 {
            late = late.max((mean - f64::from(brightness(frame, 0))).abs());
            for place in 0..side * side {
                let alike = (0..count(size)).filter(|i| i % 48 % side + i / 48 % side * side == place);
                pattern = pattern.max((statistics(alike.map(|i| out[i]))[0] - mean).abs());
            }
        }
    }
    println!("R3: late by {late:.3}, pattern of the strata {pattern:.4}");
    assert!(late < 0.3 && pattern < 0.05, "{late}, {pattern}");
}

/// R18: a spot of light moves over a dark wall. What it leaves behind it, of its own light.
#[test]
fn a_moving_light_leaves_no_trail() {
    let size = [96, 24];
    let trail = |variant: Denoiser| {
        let centre = |frame: usize| 10.0 + 2.0 * frame as f32;
        let away =
            move |frame: usize, i: usize| ((i % 96) as f32 - centre(frame)).hypot((i / 96) as f32 - 12.0);
        let mut renderer =
            Renderer::new(size, move |frame: usize, i: usize| if away(frame, i) < 8.0 { 1.0 } else { 0.0 });
        let mut bench = Bench::new(size, DenoiseParams { variant, ..DenoiseParams::default() });
        let mut out = Vec::new();
        for frame in 0..32 {
            let (light, samples) = renderer.frame(frame);
            bench.samples = samples;
            out = hf(&bench.next(&wall(size), &light));
        }
        let sum = |of: &dyn Fn(usize) -> bool| {
            (0..count(size)).filter(|i| of(*i)).map(|i| f64::from(out[i])).sum::<f64>()
        };
        // The a-trous filter itself blurs the edge of the spot.
        let behind = |i: usize| (i % 96) as f32 + 14.0 < centre(31);
        sum(&behind) / sum(&|i| away(31, i) < 8.0)
    };
    let [adaptive, plain] = [Denoiser::Asvgf, Denoiser::Svgf].map(trail);
    println!("R18: light behind the spot over that in it: asvgf {adaptive:.3}, svgf {plain:.3}");
    assert!(adaptive < 0.2 && plain > 2.0 * adaptive, "{adaptive}, {plain}");
}

/// A change of indirect light alone: its samples are not repeated, and are told from noise by their variance. A great change, and one of few standard deviations.
#[test]
fn indirect_light_follows_a_switch() {
    let size = [36, 27];
    let frames = |params: DenoiseParams, after: f32| {
        let mut random = Random(6);
        let mut bench = Bench::indirect(size, params);
        for frame in 0..SWITCH + 25 {
            let wanted = if frame < SWITCH { 1.0 } else { after };
            bench.lf =
                (0..count(size)).map(|_| [0.0, 0.0, 0.0, wanted * random.exponential(), 0.0, 0.0]).collect();
            bench.next(&wall(size), &constant(size, 0.0));
            let [mean, _] = statistics(bench.filtered_lf.iter().map(|l| l[3]));
            if frame >= SWITCH && (mean - f64::from(wanted)).abs() < 0.1 * f64::from(wanted) {
                return frame - SWITCH;
            }
        }
        25
    };
    for after in [3.0, 0.75] {
        let [adaptive, plain] =
            [adaptive(|_| {}), adaptive(|p| p.antilag.lf = 0.0)].map(|params| frames(params, after));
        println!("indirect light, {after} times as bright: {adaptive} frames, {plain} without antilag");
        assert!(adaptive <= 5 && plain >= 15, "{after}: {adaptive}, {plain}");
    }
}

/// A change in one half of the picture leaves the history of the other half alone, beyond the reach of the filter.
#[test]
fn changes_stay_where_they_are() {
    let size = [96, 12];
    let mut bench = Bench::new(size, adaptive(|p| p.antilag.iterations = 2));
    let side = bench.params.antilag.stratum.side() as usize;
    let [across, down] = strata(size, side as u32);
    let middle = side * (side / 2) + side / 2;
    for frame in 0..10 {
        let changed = frame == 9;
        let left = |i: usize| i % 96 < 48;
        let light: Vec<_> =
            (0..count(size)).map(|i| grey(if changed && left(i) { 5.0 } else { 1.0 })).collect();
        let sample = GradientSample { number: 1 + middle as u32, luminance: [1.0; 2] };
        bench.samples = if frame > 0 { vec![sample; across * down] } else { Vec::new() };
        bench.next(&vec![wall_pixel(); count(size)], &light);
    }
    let lengths = bench.lengths();
    // Two levels reach three strata; the border may lie within one.
    let reach = 4 * side;
    let far: Vec<usize> = (0..count(size)).filter(|i| i % 96 >= 48 + reach).collect();
    let repeated = |i: usize| i / 96 % side * side + i % 96 % side == middle;
    assert!(far.iter().filter(|i| !repeated(**i)).all(|i| lengths[*i] == 10), "{lengths:?}");
    assert!((0..count(size)).filter(|i| i % 96 < 48 - reach).all(|i| lengths[i] <= 2), "{lengths:?}");
}

/// Strata and filters of gradients beside each other: error in the first frames after a light in one half of the picture has gone out, and part of the history that is left where
/// nothing changes.
#[test]
fn filters_and_strata_compared() {
    let size = [60, 30];
    for (stratum, filter, iterations) in [
        (Stratum::Three, GradientFilter::Atrous, 3),
        (Stratum::Three, GradientFilter::Strided, 2),
        (Stratum::Five, GradientFilter::Atrous, 2),
        (Stratum::Five, GradientFilter::Strided, 1),
    ] {
        let brightness = |frame: usize, i: usize| if frame < SWITCH || i % 60 >= 30 { 1.0 } else { 0.2 };
        let mut renderer = Renderer::new(size, brightness).with_strata(stratum.side());
        let mut bench = Bench::new(
            size,
            adaptive(|p| {
                (p.antilag.stratum, p.antilag.filter, p.antilag.iterations) = (stratum, filter, iterations);
            }),
        );
        let (mut error, mut kept, mut still) = (0.0, 0.0, 0.0);
        for frame in 0..SWITCH + 4 {
            let (light, samples) = renderer.frame(frame);
            bench.samples = samples;
            let out = hf(&bench.next(&wall(size), &light));
            let part = |of: &dyn Fn(usize) -> bool, value: &dyn Fn(usize) -> f64| {
                let inside: Vec<usize> = (0..count(size)).filter(|i| of(*i)).collect();
                inside.iter().map(|i| value(*i)).sum::<f64>() / inside.len() as f64
            };
            let lengths = bench.lengths();
            if frame + 1 == SWITCH {
                still = part(&|_| true, &|i| f64::from(lengths[i])) / frame as f64;
            } else if frame >= SWITCH {
                error += part(&|i| i % 60 < 24, &|i| f64::from((out[i] - 0.2).abs()) / 0.2) / 4.0;
                kept += part(&|i| i % 60 >= 48, &|i| f64::from(lengths[i])) / (4.0 * frame as f64);
            }
        }
        println!(
            "strata {}, {} filter of {iterations}: error after the change {error:.3}; history kept: before it {still:.3}, far from it {kept:.3}",
            stratum.name(),
            filter.name()
        );
        assert!(error < 0.6 && still > 0.8 && kept > 0.5, "{error} {still} {kept}");
    }
}
