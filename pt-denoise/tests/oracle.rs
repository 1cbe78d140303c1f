//! The kernels of the denoiser against their oracles.

use crate::common::{Bench, Random, camera_at, count, guide};
use pt_denoise::images::{
    HISTORY_HF, HISTORY_SPEC, LEVELS_HF, LEVELS_SPEC, LEVELS2_HF, LEVELS2_SPEC, PING_HF, PING_SPEC, PONG_HF,
    PONG_SPEC,
};
use pt_denoise::oracle::{
    Accumulated, Guided, History, Light, Lit, Reflections, accumulate, atrous, blur, fix_history,
    spatial_variance, temporal_variance,
};
use pt_denoise::{AtrousKernel, DenoiseParams, Denoiser, Schedule, SpecularMotion};
use pt_shaders::glam::Vec3;
use pt_shaders::records::FrameRecord;

/// The last one is higher than a group of any kernel.
const SIZES: [[u32; 2]; 5] = [[1, 1], [3, 2], [17, 5], [29, 17], [5, 41]];

/// Noise with gaps, this share of fireflies, and samples that are no light.
fn samples_with(fireflies: f32, size: [u32; 2], random: &mut Random) -> Vec<Light> {
    let colour = |random: &mut Random| {
        let v = random.exponential();
        let v = if random.unit() < fireflies { v * 1e4 } else { v };
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

/// Noise with gaps, fireflies and samples that are no light.
fn samples(size: [u32; 2], random: &mut Random) -> Vec<Light> {
    samples_with(0.02, size, random)
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
    let permuted = SIZES.map(|size| (size, AtrousKernel::Three, Schedule::Permuted));
    let others = [
        ([29, 17], AtrousKernel::Five, Schedule::Permuted),
        ([29, 17], AtrousKernel::Three, Schedule::Dilated),
        ([17, 5], AtrousKernel::Five, Schedule::Dilated),
    ];
    for (size, kernel, schedule) in permuted.into_iter().chain(others) {
        let mut random = Random(size[0].into());
        let mut params = DenoiseParams { variant: Denoiser::Svgf, ..DenoiseParams::default() };
        (params.atrous.kernel, params.atrous.schedule) = (kernel, schedule);
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
                accumulate(size, &pixels, &light, previous.as_deref(), &bench.params.temporal, None, None);
            let lengths: Vec<u32> = now.iter().map(|h| h.length).collect();
            assert_eq!(bench.lengths(), lengths, "{size:?}, frame {frame}");
            let iterations = bench.params.atrous.iterations;
            let history = bench.light(HISTORY_HF, HISTORY_SPEC);
            let ping = bench.light(PING_HF, PING_SPEC);
            let levels = [bench.roots(LEVELS_HF, LEVELS_SPEC), bench.roots(LEVELS2_HF, LEVELS2_SPEC)];
            if iterations == 1 {
                let largest_of = |h: &History| h.hf.iter().chain(&h.spec).copied().fold(1e-6, f64::max);
                for (got, want) in ping.iter().zip(&now) {
                    // Sums of positive numbers: a dozen roundings of 6e-8.
                    let tolerance = 1e-6 * largest_of(want);
                    let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| near(a[k], b[k], tolerance));
                    assert!(close(got.hf, want.hf) && close(got.spec, want.spec), "{got:?} {want:?}");
                }
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
                compare("variance", &ping, &want, |i| {
                    let square = now[i].moments[1].max(now[i].moments[3]).max(largest(&ping).powi(2));
                    [1e-6 * largest(&ping[i..=i]), 2e-5 * square]
                });
            }
            // The last level's source is still there.
            let (source, target) = match iterations {
                1 => (&ping, &history),
                2 => (&history, &ping),
                n => (&levels[n as usize % 2], &ping),
            };
            let want = atrous(size, &pixels, source, iterations - 1, &bench.params.atrous);
            let top = largest(source);
            let variance = source.iter().flat_map(|l| l.variance).fold(0.0, f64::max);
            // 10000 times the cosine of which 6e-8 are rounded: 1e-3 of the weight.
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
            // Tolerances are relative to the brightest sample: where levels follow each other there are no fireflies, so that small errors are seen, too.
            let fireflies = if iterations == 1 { 0.02 } else { 0.0 };
            let (pixels, light) = (guide(size, &mut random, 0), samples_with(fireflies, size, &mut random));
            bench.next(&pixels, &light);
            let [ping, pong] = [bench.light(PING_HF, PING_SPEC), bench.light(PONG_HF, PONG_SPEC)];
            let levels = [bench.roots(LEVELS_HF, LEVELS_SPEC), bench.roots(LEVELS2_HF, LEVELS2_SPEC)];
            if iterations == 1 {
                let want = spatial_variance(size, &pixels, &light, &bench.params);
                let top =
                    light.iter().map(|l| l.hf[0].max(l.spec[0])).filter(|v| *v < 1e10).fold(0.0, f32::max);
                compare("variance", &ping, &want, |i| {
                    [2e-6 * largest(&want[i..=i]), 2e-5 * f64::from(top).powi(2)]
                });
            }
            if iterations > 1 {
                // Roots in half floats: 2^-11 of the root, 2^-10 of the light, four times that of a variance.
                let want = atrous(size, &pixels, &ping, 0, &bench.params.atrous);
                let (top, variance) =
                    (largest(&ping), ping.iter().flat_map(|l| l.variance).fold(0.0, f64::max));
                compare("first level", &levels[0], &want, |_| [2e-3 * top, 4e-3 * variance]);
            }
            let source = if iterations == 1 { &ping } else { &levels[iterations as usize % 2] };
            let want = atrous(size, &pixels, source, iterations - 1, &bench.params.atrous);
            let (top, variance) =
                (largest(source), source.iter().flat_map(|l| l.variance).fold(0.0, f64::max));
            compare("level", &pong, &want, |_| [1e-3 * top, 2e-3 * variance]);
        }
    }
}

/// Histories of specular light along the motion of mirror images.
#[test]
fn mirror_images_agree_with_the_oracle() {
    let size = [29, 17];
    for (specular, parallax) in [
        (SpecularMotion::Virtual, None),
        (SpecularMotion::Better, Some(3.0)),
        (SpecularMotion::Surface, Some(0.5)),
    ] {
        let mut random = Random(41);
        let mut params = DenoiseParams { variant: Denoiser::Svgf, ..DenoiseParams::default() };
        (params.temporal.specular, params.temporal.parallax) = (specular, parallax);
        params.atrous.iterations = 1;
        params.atrous.min_length = 3;
        params.atrous.feedback = true;
        let mut bench = Bench::new(size, params);
        let mut previous: Option<(Vec<History>, Vec<f32>)> = None;
        let mut apart = 0;
        for frame in 0..6u32 {
            let (pixels, light) = (guide(size, &mut random, frame), samples(size, &mut random));
            let eye = |frame: u32| Vec3::new(0.02 * frame as f32, 0.0, 0.0);
            bench.frame =
                FrameRecord::new(camera_at(eye(frame)), camera_at(eye(frame.max(1) - 1)), size, frame, 0);
            let place = |(i, pixel): (usize, &Guided)| {
                let [x, y] = [(i % 29) as f32 / 14.5 - 1.0, 1.0 - (i / 29) as f32 / 8.5];
                eye(frame) + Vec3::new(x, y, -1.0).normalize() * pixel.depth
            };
            bench.positions = pixels.iter().enumerate().map(place).collect();
            let hit = |random: &mut Random| if random.unit() < 0.2 { 0.0 } else { 2.0 + 0.2 * random.unit() };
            bench.hits = (0..count(size)).map(|_| [1.0, hit(&mut random)]).collect();
            let hits: Vec<f32> = bench.hits.iter().map(|hit| hit[1]).collect();
            // The kernel takes hit distances of known samples alone.
            let known = |(i, hit): (usize, &f32)| {
                let l = &light[i];
                let is_light = l.hf.iter().chain(&l.spec).all(|v| (0.0..=1e15).contains(v));
                if is_light && pixels[i].material != 0 { *hit } else { 0.0 }
            };
            let own: Vec<f32> = hits.iter().enumerate().map(known).collect();
            bench.next(&pixels, &light);
            let none = Vec::new();
            let before = previous.as_ref();
            let reflections = Reflections {
                frame: &bench.frame,
                positions: &bench.positions,
                hits: &own,
                hits_before: before.map_or(&none, |(_, hits)| hits),
            };
            let histories = before.map(|(histories, _)| &histories[..]);
            let now = accumulate(
                size,
                &pixels,
                &light,
                histories,
                &bench.params.temporal,
                None,
                before.map(|_| &reflections),
            );
            let what = format!("{}, frame {frame}", specular.name());
            assert_eq!(bench.lengths(), now.iter().map(|h| h.length).collect::<Vec<_>>(), "{what}");
            let lengths: Vec<u32> = now.iter().map(|h| h.spec_length).collect();
            assert_eq!(bench.specular_lengths(), lengths, "{what}");
            apart += now.iter().filter(|h| h.length != h.spec_length).count();
            let ping = bench.light(PING_HF, PING_SPEC);
            let want: Vec<_> = now
                .iter()
                .zip(&ping)
                .map(|(h, l)| Accumulated { hf: h.hf, spec: h.spec, variance: l.variance })
                .collect();
            // Places in fp32: 1e-6 of a weight of neighbours that differ by all that they are.
            let around = largest(&want);
            compare(&what, &ping, &want, |_| [2e-5 * around, 0.0]);
            let moments = bench.moments();
            let stored: Vec<_> = now
                .into_iter()
                .zip(&ping)
                .zip(moments)
                .map(|((h, l), moments)| History { hf: l.hf, spec: l.spec, moments, ..h })
                .collect();
            let want = temporal_variance(size, &stored, &bench.params);
            compare("variance", &ping, &want, |_| [0.0, 1e-4 * around.powi(2)]);
            // What the a-trous level made of it.
            let fed = bench.light(HISTORY_HF, HISTORY_SPEC);
            let stored = stored.into_iter().zip(&fed);
            previous = Some((stored.map(|(h, l)| History { hf: l.hf, spec: l.spec, ..h }).collect(), hits));
        }
        assert!(apart > 20, "{}: specular light has histories of its own: {apart}", specular.name());
    }
}

fn lit(light: &[Accumulated]) -> Vec<Lit> {
    let one = |colour, hit: f64| (hit >= 0.0).then_some((colour, hit));
    light.iter().map(|l| [one(l.hf, l.variance[0]), one(l.spec, l.variance[1])]).collect()
}

/// Few taps may be rounded to another pixel.
fn compare_lit(what: &str, got: &[Lit], want: &[Lit]) {
    let top = want.iter().flatten().flatten().flat_map(|(colour, _)| *colour).fold(1e-6, f64::max);
    let differs = |(a, b): (&Lit, &Lit)| {
        (0..2).any(|c| match (a[c], b[c]) {
            (Some((a, h)), Some((b, k))) => {
                (0..3).any(|k| (a[k] - b[k]).abs() > 1e-3 * top) || (h - k).abs() > 1e-4 * k.abs().max(1.0)
            }
            (a, b) => a.is_some() != b.is_some(),
        })
    };
    let others = got.iter().zip(want).filter(|pair| differs(*pair)).count();
    assert!(500 * others <= got.len().max(500), "{what}: {others} of {} differ", got.len());
}

#[test]
fn recurrent_blurs_agree_with_the_oracle() {
    for size in [[1, 1], [17, 5], [29, 17]] {
        let mut random = Random(size[0].into());
        let mut params = DenoiseParams { variant: Denoiser::Recurrent, ..DenoiseParams::default() };
        params.recurrent.fix_radius = 6.0;
        params.recurrent.fix_frames = 3;
        // What is limited in between is not seen here.
        params.temporal.firefly = None;
        let mut bench = Bench::new(size, params);
        for frame in 0..5u32 {
            let (pixels, light) = (guide(size, &mut random, frame), samples(size, &mut random));
            let hit = |random: &mut Random| if random.unit() < 0.2 { 0.0 } else { 3.0 * random.unit() };
            bench.hits = (0..count(size)).map(|_| [hit(&mut random), hit(&mut random)]).collect();
            bench.next(&pixels, &light);
            let frames: Vec<[u32; 2]> = bench.lengths().into_iter().map(|n| [n, n]).collect();
            let params = bench.params.clone();
            let what = format!("{size:?}, frame {frame}");
            let [fixed, history, out] = [
                bench.light(PING_HF, PING_SPEC),
                bench.light(HISTORY_HF, HISTORY_SPEC),
                bench.light(PONG_HF, PONG_SPEC),
            ]
            .map(|light| lit(&light));
            if frame == 0 {
                let raw = |(i, l): (usize, &Light)| -> Lit {
                    let known = l.hf.iter().chain(&l.spec).all(|v| (0.0..=1e15).contains(v));
                    let wide = |c: [f32; 3]| c.map(f64::from);
                    let [a, b] = bench.hits[i].map(f64::from);
                    match known && pixels[i].material != 0 {
                        true => [Some((wide(l.hf), a)), Some((wide(l.spec), b))],
                        false => [None, None],
                    }
                };
                let raw: Vec<Lit> = light.iter().enumerate().map(raw).collect();
                let before = blur(size, &pixels, &raw, None, params.recurrent.pre_radius, &params);
                compare_lit(&what, &fixed, &fix_history(size, &pixels, &before, &frames, &params));
            }
            let want = blur(size, &pixels, &fixed, Some(&frames), params.recurrent.radius, &params);
            compare_lit(&format!("{what}, blur"), &history, &want);
            let want = blur(size, &pixels, &history, Some(&frames), params.recurrent.post_radius, &params);
            compare_lit(&format!("{what}, post-blur"), &out, &want);
        }
    }
}
