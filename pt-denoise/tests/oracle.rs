//! The kernels of the denoiser against their oracles.

mod common;

use common::{Bench, Random, count, guide};
use pt_denoise::images::{HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC};
use pt_denoise::oracle::{
    Accumulated, History, Light, accumulate, atrous, spatial_variance, temporal_variance,
};
use pt_denoise::{DenoiseParams, Denoiser};

const SIZES: [[u32; 2]; 4] = [[1, 1], [3, 2], [17, 5], [29, 17]];

/// Noise with gaps, fireflies and samples that are no light.
fn samples(size: [u32; 2], random: &mut Random) -> Vec<Light> {
    let colour = |random: &mut Random| {
        let v = random.exponential();
        let v = if random.unit() < 0.02 { v * 1e4 } else { v };
        [v, v * random.unit(), v * random.unit()]
    };
    (0..count(size))
        .map(|i| {
            let mut light = Light { hf: colour(random), spec: colour(random) };
            match i % 97 {
                13 => light.hf[1] = f32::NAN,
                29 => light.spec[0] = f32::INFINITY,
                31 => light.hf = [-1.0; 3],
                53 => light.spec[2] = 1e30,
                _ => {}
            }
            light
        })
        .collect()
}

fn near(got: f64, want: f64, tolerance: f64) -> bool {
    (got - want).abs() <= tolerance
}

/// `scale`: what the error is relative to.
fn compare(what: &str, got: &[Accumulated], want: &[Accumulated], tolerance: impl Fn(usize) -> [f64; 2]) {
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let [light, variance] = tolerance(i);
        for k in 0..3 {
            assert!(near(got.hf[k], want.hf[k], light), "{what}, pixel {i}: {got:?}, oracle {want:?}");
            assert!(near(got.spec[k], want.spec[k], light), "{what}, pixel {i}: {got:?}, oracle {want:?}");
        }
        for c in 0..2 {
            assert!(
                near(got.variance[c], want.variance[c], variance),
                "{what}, {i}: {got:?}, oracle {want:?}"
            );
        }
    }
}

/// Largest luminance and largest square that a frame has: what errors of fp32 are relative to.
fn largest(light: &[Accumulated]) -> f64 {
    light.iter().flat_map(|l| l.hf.iter().chain(&l.spec)).copied().fold(1e-6, f64::max)
}

#[test]
fn svgf_agrees_with_the_oracle() {
    for size in SIZES {
        let mut random = Random(size[0].into());
        let mut params = DenoiseParams { variant: Denoiser::Svgf, ..DenoiseParams::default() };
        // All of its branches within a few frames.
        (params.temporal.alpha_hf, params.temporal.alpha_spec) = (0.2, 0.3);
        params.atrous.min_length = 3;
        params.atrous.feedback = true;
        let mut bench = Bench::new(size, params);
        let mut previous: Option<Vec<History>> = None;
        for frame in 0..8u32 {
            bench.params.atrous.iterations = [1, 1, 1, 2, 1, 3, 4, 5][frame as usize];
            let (pixels, light) = (guide(size, &mut random, frame), samples(size, &mut random));
            bench.next(&pixels, &light);
            let mut now =
                accumulate(size, &pixels, &light, previous.as_deref(), &bench.params.temporal, None);
            let lengths: Vec<u32> = now.iter().map(|h| h.length).collect();
            assert_eq!(bench.lengths(), lengths, "{size:?}, frame {frame}");
            let iterations = bench.params.atrous.iterations;
            let history = bench.light(HISTORY_HF, HISTORY_SPEC);
            let [ping, pong] = [bench.light(PING_HF, PING_SPEC), bench.light(PONG_HF, PONG_SPEC)];
            if iterations == 1 {
                let want: Vec<_> =
                    now.iter().map(|h| Accumulated { hf: h.hf, spec: h.spec, variance: [0.0; 2] }).collect();
                // Sums of positive numbers: a dozen roundings of 6e-8.
                compare("temporal", &ping, &want, |i| [1e-6 * largest(&want[i..=i]), 0.0]);
                for (got, want) in bench.moments().iter().zip(&now) {
                    for k in 0..4 {
                        assert!(near(got[k], want.moments[k], 2e-6 * want.moments[k]), "{got:?} {want:?}");
                    }
                }
                for (i, history) in now.iter_mut().enumerate() {
                    (history.hf, history.spec) = (ping[i].hf, ping[i].spec);
                    history.moments = bench.moments()[i];
                }
                let want = temporal_variance(size, &now, &bench.params);
                // Differences of squares.
                compare("variance", &pong, &want, |i| {
                    let square = now[i].moments[1].max(now[i].moments[3]).max(largest(&ping).powi(2));
                    [0.0, 2e-5 * square]
                });
            }
            // The last level's source is still there.
            let (source, target) = match iterations {
                1 => (&pong, &history),
                2 => (&history, &ping),
                n if n % 2 == 1 => (&ping, &pong),
                _ => (&pong, &ping),
            };
            let want = atrous(size, &pixels, source, iterations - 1, &bench.params.atrous);
            let top = largest(source);
            let variance = source.iter().flat_map(|l| l.variance).fold(0.0, f64::max);
            // Powers of cosines up to the 10000th: 6e-8 of the cosine is 1e-3 of the weight.
            compare(&format!("level {}", iterations - 1), target, &want, |_| [1e-3 * top, 2e-3 * variance]);
            previous = Some(
                now.into_iter()
                    .zip(&history)
                    .zip(bench.moments())
                    .map(|((h, light), moments)| History { hf: light.hf, spec: light.spec, moments, ..h })
                    .collect(),
            );
        }
    }
}

#[test]
fn frames_by_themselves_agree_with_the_oracle() {
    for size in SIZES {
        let mut random = Random(7);
        let params = DenoiseParams { variant: Denoiser::Atrous, ..DenoiseParams::default() };
        let mut bench = Bench::new(size, params);
        for iterations in 1..=3 {
            bench.params.atrous.iterations = iterations;
            let (pixels, light) = (guide(size, &mut random, 0), samples(size, &mut random));
            bench.next(&pixels, &light);
            let [ping, pong] = [bench.light(PING_HF, PING_SPEC), bench.light(PONG_HF, PONG_SPEC)];
            if iterations == 1 {
                let want = spatial_variance(size, &pixels, &light, &bench.params);
                let top =
                    light.iter().map(|l| l.hf[0].max(l.spec[0])).filter(|v| *v < 1e10).fold(0.0, f32::max);
                compare("variance", &ping, &want, |i| {
                    [2e-6 * largest(&want[i..=i]), 2e-5 * f64::from(top).powi(2)]
                });
            }
            let (source, target) = if iterations % 2 == 1 { (&ping, &pong) } else { (&pong, &ping) };
            let want = atrous(size, &pixels, source, iterations - 1, &bench.params.atrous);
            let (top, variance) =
                (largest(source), source.iter().flat_map(|l| l.variance).fold(0.0, f64::max));
            compare("level", target, &want, |_| [1e-3 * top, 2e-3 * variance]);
        }
    }
}
