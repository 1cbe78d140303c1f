//! Histories in half floats: roots that are rounded at random keep the mean of the light, and follow its small changes.

use crate::common::{Bench, Random, constant, count, guide, hf, noise, spec, statistics, wall};
use pt_denoise::images::{HISTORY_HF, HISTORY_LF_COCG, HISTORY_LF_SH, HISTORY_SPEC};
use pt_denoise::oracle::{History, LfHistory, Light, accumulate, accumulate_lf};
use pt_denoise::{DenoiseParams, Denoiser, HistoryFormat};

/// A unit in the last place of a root is at most 2^-10 of it, so 2^-9 of its square.
const ROUNDING: f64 = 2.0e-3;
/// Of the fourth power.
const ROUNDING_OF_VARIANCE: f64 = 4.0e-3;
/// Light that the greatest half float is the root of.
const GREATEST: f64 = 65504.0 * 65504.0;

fn of(variant: Denoiser, histories: HistoryFormat) -> DenoiseParams {
    DenoiseParams { variant, histories, ..DenoiseParams::default() }
}

/// The light changes by 1 %. A step of the mean is at most a twentieth of that: less than half a unit in the last place of the root of 1.
#[test]
fn small_changes_are_followed() {
    let size = [48, 36];
    let mut fed = of(Denoiser::Svgf, HistoryFormat::Half);
    fed.atrous.feedback = true;
    let variants = [Denoiser::Accumulate, Denoiser::Svgf, Denoiser::Recurrent];
    for params in variants.map(|variant| of(variant, HistoryFormat::Half)).into_iter().chain([fed]) {
        let what = format!("{}, feedback {}", params.variant.name(), params.atrous.feedback);
        let mut bench = Bench::indirect(size, params);
        let (mut level, mut wanted, mut worst) = (1.0f32, 1.0f64, 0.0f64);
        for frame in 0..80 {
            if frame >= 30 {
                level = 1.01;
                wanted += 0.05 * (f64::from(level) - wanted);
            }
            bench.lf = vec![[0.2, -0.4, 0.1, 1.0, -0.3, 0.1].map(|c| c * level); count(size)];
            let out = bench.next(&wall(size), &constant(size, level));
            if frame % 10 != 9 {
                continue;
            }
            let coefficient = |k: usize, unit: f32| bench.filtered_lf.iter().map(|l| l[k] / unit).collect();
            let all: [Vec<f32>; 5] =
                [hf(&out), spec(&out), coefficient(3, 1.0), coefficient(1, -0.4), coefficient(4, -0.3)];
            for (channel, values) in all.into_iter().enumerate() {
                // Two thousand pixels are off by up to 2e-3 each, in both directions; the recurrent blur rounds twice in a frame.
                let [mean, _] = statistics(values);
                worst = worst.max((mean - wanted).abs());
                assert!(
                    (mean - wanted).abs() < 3e-4,
                    "{what}, frame {frame}, channel {channel}: {mean}, not {wanted}"
                );
            }
        }
        println!("{what}: off by up to {worst:.1e}");
    }
}

/// Each pixel has a light of its own that does not change. The mean over frames is that light, and no rounding passes for noise.
#[test]
fn still_light_keeps_its_mean() {
    let size = [48, 32];
    let mut random = Random(3);
    let mut bench = Bench::new(size, of(Denoiser::Accumulate, HistoryFormat::Half));
    let light = noise(size, || 10f32.powf(6.0 * random.unit() - 3.0));
    let frames = 600;
    let mut sums = vec![0.0; count(size)];
    for frame in 0..frames + 40 {
        let out = bench.next(&wall(size), &light);
        if frame >= 40 {
            sums.iter_mut().zip(hf(&out)).for_each(|(sum, v)| *sum += f64::from(v));
        }
    }
    let errors =
        sums.iter().zip(hf(&light)).map(|(sum, v)| (sum / f64::from(frames) / f64::from(v) - 1.0) as f32);
    let [mean, variance] = statistics(errors);
    println!("mean {mean:.2e}, deviation {:.2e}", variance.sqrt());
    // A rounding is off by 5e-4, and every 40 frames are independent: 1.4e-4. Rounded to the nearest, each pixel would stay off by 3.5e-4.
    assert!(mean.abs() < 2e-5, "{mean}");
    assert!(variance.sqrt() < 2.2e-4, "{}", variance.sqrt());
    for [mean, second, ..] in bench.moments() {
        assert!(second - mean * mean < 1e-5 * mean * mean, "{mean}, {second}");
    }
}

/// Of independent noise.
#[test]
fn noise_keeps_its_energy_and_its_variance() {
    let size = [40, 30];
    for variant in [Denoiser::Asvgf, Denoiser::Recurrent] {
        let mut random = Random(7);
        let mut benches = [HistoryFormat::Full, HistoryFormat::Half]
            .map(|histories| Bench::indirect(size, of(variant, histories)));
        let mut sums = [[0.0; 6]; 2];
        for frame in 0..45 {
            let light = noise(size, || random.exponential());
            let lf: Vec<_> = (0..count(size)).map(|_| [0.1, 0.0, -0.1, random.sparse(4), 0.2, 0.0]).collect();
            for (bench, sums) in benches.iter_mut().zip(&mut sums) {
                bench.lf.clone_from(&lf);
                let out = bench.next(&wall(size), &light);
                if frame >= 15 {
                    let indirect = bench.filtered_lf.iter().map(|l| l[3]).collect();
                    let all = [hf(&out), spec(&out), indirect].map(statistics).concat();
                    sums.iter_mut().zip(all).for_each(|(sum, v)| *sum += v);
                }
            }
        }
        let ratios: Vec<f64> = (0..6).map(|k| sums[1][k] / sums[0][k]).collect();
        println!("{}: {ratios:?}", variant.name());
        for k in [0, 2, 4] {
            assert!((ratios[k] - 1.0).abs() < 1e-3, "{}, energy: {ratios:?}", variant.name());
            assert!((ratios[k + 1] - 1.0).abs() < 0.02, "{}, variance: {ratios:?}", variant.name());
        }
    }
}

/// Numbers below the least half float are rounded to it or to 0.
fn check(what: &str, got: f64, want: f64, rounding: f64, top: f64) {
    let greatest = if rounding == ROUNDING { GREATEST } else { GREATEST * GREATEST };
    let (size, want) = (want.abs().min(greatest), want.clamp(-greatest, greatest));
    let tolerance = rounding * size + 2e-6 * top + 4e-9;
    assert!((got - want).abs() <= tolerance, "{what}: {got}, oracle {want}");
}

/// Over surfaces that move; of each frame by itself, so that errors do not add up.
#[test]
fn accumulation_agrees_with_the_oracle() {
    let size = [29, 17];
    let mut random = Random(19);
    let mut bench = Bench::indirect(size, of(Denoiser::Accumulate, HistoryFormat::Half));
    let mut previous: Option<(Vec<History>, Vec<LfHistory>)> = None;
    for frame in 0..8 {
        let pixels = guide(size, &mut random, frame);
        let mut light: Vec<Light> = noise(size, || random.exponential());
        // More than the format holds, and next to nothing.
        (light[40].hf, light[50].spec) = ([1e14; 3], [1e-9; 3]);
        let signed = |random: &mut Random| random.unit() - 0.5;
        bench.lf = (0..count(size))
            .map(|_| {
                [0, 1, 2, 3, 4, 5].map(|k| if k == 3 { random.exponential() } else { signed(&mut random) })
            })
            .collect();
        bench.next(&pixels, &light);
        let params = bench.params.temporal.clone();
        let before = previous.as_ref();
        let direct = accumulate(size, &pixels, &light, before.map(|(all, _)| &all[..]), &params, None, None);
        let wide: Vec<_> = bench.lf.iter().map(|l| l.map(f64::from)).collect();
        let indirect = accumulate_lf(size, &pixels, &wide, before.map(|(_, all)| &all[..]), &params, None);

        let what = format!("frame {frame}");
        let (stored, moments) = (bench.light(HISTORY_HF, HISTORY_SPEC), bench.moments());
        assert_eq!(bench.lengths(), direct.iter().map(|h| h.length).collect::<Vec<_>>(), "{what}");
        for ((got, moments), want) in stored.iter().zip(&moments).zip(&direct) {
            let (light, wanted) = ([got.hf, got.spec].concat(), [want.hf, want.spec].concat());
            let top = wanted.iter().copied().fold(0.0, f64::max);
            light.iter().zip(&wanted).for_each(|(got, want)| check(&what, *got, *want, ROUNDING, top));
            for c in [0, 2] {
                let ([mean, second], wanted) = ([moments[c], moments[c + 1]], want.moments);
                check(&what, mean, wanted[c], ROUNDING, top);
                let variance = |mean: f64, second: f64| second - mean * mean;
                if mean < 1e9 {
                    let wanted = variance(wanted[c], wanted[c + 1]).max(0.0);
                    check(&what, variance(mean, second), wanted, ROUNDING_OF_VARIANCE, top * top);
                }
            }
        }
        let [sh, cocg] = [HISTORY_LF_SH, HISTORY_LF_COCG].map(|id| bench.images.current(id));
        let (kept, chroma) = (bench.coefficients(sh, cocg), bench.flat(cocg));
        for ((got, chroma), want) in kept.iter().zip(&chroma).zip(&indirect) {
            assert_eq!(chroma[2] as u32, want.length, "{what}");
            assert_eq!(chroma[3] < 0.0, want.length == 0, "{what}");
            for (got, want) in got.iter().zip(want.light) {
                check(&what, f64::from(*got), want, ROUNDING, 10.0);
            }
            if want.length > 0 {
                let variance = (want.second - want.light[3] * want.light[3]).max(0.0);
                check(&what, f64::from(chroma[3]), variance, ROUNDING_OF_VARIANCE, 10.0);
            }
        }
        let direct = direct.into_iter().zip(&stored).zip(moments);
        let direct = direct.map(|((h, l), moments)| History { hf: l.hf, spec: l.spec, moments, ..h });
        let indirect = indirect.into_iter().zip(kept).zip(chroma).map(|((h, l), chroma)| {
            let light = l.map(f64::from);
            LfHistory { light, second: f64::from(chroma[3]) + light[3] * light[3], ..h }
        });
        previous = Some((direct.collect(), indirect.collect()));
    }
}

/// The same command, the same bits; another seed, other roundings.
#[test]
fn roundings_follow_frame_and_seed() {
    let size = [16, 16];
    let run = |seed: u32| {
        let mut bench = Bench::new(size, of(Denoiser::Accumulate, HistoryFormat::Half));
        bench.frame.seed = seed;
        (0..6).map(|_| hf(&bench.next(&wall(size), &constant(size, 0.7)))).collect::<Vec<_>>()
    };
    let first = run(1);
    assert_eq!(first, run(1));
    assert_ne!(first, run(2));
    assert_ne!(first[4], first[5]);
}
