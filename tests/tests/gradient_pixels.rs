//! Gradient pixels in whole frames: they repeat the light of the last frame where nothing changes, and show what has changed.

use pt_app::params::{FrameParams, resolve};
use pt_core::split::to_flat;
use pt_core::trace::TraceBackend;
use pt_denoise::images::SURFACE;
use pt_denoise::oracle::{
    self, Forward, GradientSample, Guided, Seen, brightest_candidates, forward_candidates,
};
use pt_denoise::{DenoiseParams, Denoiser, GradientPixel, Projection};
use pt_scene::glam::{Affine3A, Vec3};
use pt_scene::gpu::camera_record;
use pt_scene::{Blink, Camera, Light, LightMotion, Motion, Scene};
use pt_shaders::channels::{
    COLOR_HF, COLOR_SPEC, ChannelId, GRADIENT_SAMPLE, MOTION, RNG_SEED, SHADING_POSITION, VERTEX_NORMAL,
    VIEW_DEPTH, VIEW_DIRECTION,
};
use pt_tests::{Frames, builtin};

const SIZE: [u32; 2] = [47, 26];

/// Pixels with a shorter history are no gradient pixels, frames.
const LEAST_HISTORY: u32 = 4;

fn params(bounces: f32) -> FrameParams {
    let mut params = FrameParams::default();
    params.denoise.variant = Denoiser::Asvgf;
    params.indirect.bounces = bounces;
    params
}

fn frames(scene: Scene, params: FrameParams) -> Frames {
    let camera = scene.cameras[0].clone();
    Frames::with_params(scene, &camera, TraceBackend::Compute, SIZE, 3, false, params)
}

/// Luminances of a light channel, flat pixels.
fn luminances(frames: &Frames, id: ChannelId) -> Vec<f32> {
    let light: Vec<f32> =
        (frames.floats(id).chunks_exact(4)).map(|c| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]).collect();
    to_flat(&light, SIZE)
}

/// A gradient pixel: index of the flat pixel, luminances before, luminances now.
struct Gradient {
    pixel: usize,
    before: [f32; 2],
    now: [f32; 2],
}

fn gradients(frames: &Frames) -> Vec<Gradient> {
    let light = [COLOR_HF, COLOR_SPEC].map(|id| luminances(frames, id));
    let texels = frames.floats(GRADIENT_SAMPLE);
    // The extent of a third of the split frame.
    let across = SIZE[0].div_ceil(2) as usize * 2;
    let row = across.div_ceil(3);
    let mut found = Vec::new();
    let side = side();
    let [strata_across, strata_down] = strata_of_axes();
    for y in 0..strata_down {
        for x in 0..strata_across {
            let texel = &texels[4 * (y * row + x)..][..3];
            let Some(number) = (texel[0] as usize).checked_sub(1) else { continue };
            let pixel = (side * y + number / side) * SIZE[0] as usize + side * x + number % side;
            found.push(Gradient {
                pixel,
                before: [texel[1], texel[2]],
                now: [light[0][pixel], light[1][pixel]],
            });
        }
    }
    found
}

/// Pixels along a side of a stratum.
fn side() -> usize {
    DenoiseParams::default().antilag.stratum.side() as usize
}

fn strata_of_axes() -> [usize; 2] {
    SIZE.map(|pixels| (pixels as usize).div_ceil(side()))
}

fn strata() -> usize {
    strata_of_axes().iter().product()
}

/// Sum of changes over sum of luminances, diffuse light.
fn relative_change(gradients: &[Gradient]) -> f32 {
    let change: f32 = gradients.iter().map(|g| (g.now[0] - g.before[0]).abs()).sum();
    let top: f32 = gradients.iter().map(|g| g.now[0].max(g.before[0])).sum();
    // Without gradient pixels nothing seems to change.
    change / top.max(1e-6)
}

/// Camera, lights and objects stand still; every frame has another place in the pixels and other random numbers. The gradient pixels have last frame's
/// light to a rounding, of direct light and of bounces, and their seeds are one frame old.
#[test]
fn still_frames_are_repeated() {
    for (scene, bounces, projection) in [
        ("cornell", 0.0, Projection::Backward),
        ("cornell", 0.0, Projection::Forward),
        ("cornell", 1.0, Projection::Backward),
    ] {
        let mut params = params(bounces);
        params.denoise.antilag.projection = projection;
        params.denoise.antilag.pixel =
            if bounces > 0.0 { GradientPixel::Random } else { GradientPixel::Brightest };
        let mut frames = frames(builtin(scene), params);
        for frame in 0..LEAST_HISTORY + 4 {
            frames.render(0.0);
            let found = gradients(&frames);
            if frame < LEAST_HISTORY {
                assert!(found.is_empty(), "histories are short");
                continue;
            }
            // Forward projection takes a pixel of the last frame, which may have landed in the stratum beside this one, or have been a gradient pixel.
            let least = if projection == Projection::Forward { 5 } else { 3 };
            assert!(
                least * found.len() > strata(),
                "{scene}, frame {frame}: {} of {}",
                found.len(),
                strata()
            );
            let seeds: Vec<u32> = frames.integers(RNG_SEED).chunks_exact(2).map(|c| c[1]).collect();
            let seeds = to_flat(&seeds, SIZE);
            let mut lit = 0;
            for g in &found {
                assert_eq!(seeds[g.pixel] + 1, seeds.iter().copied().max().unwrap(), "frame {frame}");
                for c in 0..2 {
                    let near = (g.now[c] - g.before[c]).abs() <= 1e-4 * g.now[c].max(g.before[c]);
                    assert!(
                        near,
                        "{scene}, {bounces}, frame {frame}, {}: {:?} {:?}",
                        g.pixel, g.before, g.now
                    );
                }
                lit += usize::from(g.now[0] > 0.0);
            }
            // A pixel is none twice on end.
            let old = seeds.iter().filter(|s| **s + 1 == *seeds.iter().max().unwrap()).count();
            assert_eq!(old, found.len());
            assert!(3 * lit > found.len(), "{lit} of {} are lit", found.len());
        }
        frames.finish();
    }
}

/// R2: a still room of detail below a pixel, with jitter. Shading anew where a surface of the last frame is projected to would compare two points of a texture;
/// a gradient pixel has the very surface of the last frame: nothing seems to change, and hardly a history is cut short.
#[test]
fn detail_below_a_pixel_is_no_change() {
    for projection in [Projection::Backward, Projection::Forward] {
        repeats_detail(projection);
    }
}

fn repeats_detail(projection: Projection) {
    let mut params = params(0.0);
    params.denoise.antilag.gate = 0.0;
    params.denoise.antilag.projection = projection;
    let mut taken = Vec::new();
    let mut frames = frames(builtin("gallery"), params);
    let mut worst = [0.0f32; 2];
    for frame in 0..LEAST_HISTORY + 8 {
        frames.render(0.0);
        // Some pixels near edges have short histories for longer.
        if frame > LEAST_HISTORY {
            let found = gradients(&frames);
            assert!(8 * found.len() > strata(), "frame {frame}: {} of {}", found.len(), strata());
            taken.push(found.len() as f32 / strata() as f32);
            for (c, worst) in worst.iter_mut().enumerate() {
                let change: f32 = found.iter().map(|g| (g.now[c] - g.before[c]).abs()).sum();
                let top: f32 = found.iter().map(|g| g.now[c].max(g.before[c])).sum();
                *worst = worst.max(change / top);
            }
        }
    }
    let mean = taken.iter().sum::<f32>() / taken.len() as f32;
    println!(
        "R2: {}: relative change {worst:?}, part of the strata with a gradient pixel {mean:.3}",
        projection.name()
    );
    frames.finish();
    assert!(worst.iter().all(|w| *w < 1e-3), "{worst:?}");
}

/// Part of the pixels with a surface whose history has at most two frames.
fn short_histories(frames: &Frames) -> f32 {
    let words = frames.integers(SURFACE);
    let lengths: Vec<u32> = words.chunks_exact(2).filter(|w| w[0] != 0).map(|w| w[1]).collect();
    lengths.iter().filter(|n| **n <= 2).count() as f32 / lengths.len() as f32
}

/// Gradient pixels show that a light goes out in the frame in which it does, and nothing before and after. A light that goes on was no choice of the
/// last frame; the picture shows it. The histories begin again in both cases, and else not.
#[test]
fn a_switch_is_seen_at_once() {
    let mut scene = builtin("cornell");
    // In front of the blocks, on for 0.4 s, then off as long.
    let path = Motion::rest(Affine3A::from_translation(Vec3::new(-0.28, 0.4, -0.1)));
    let blink = Blink::Square { period_s: 0.8, share: 0.5, phase: 0.0 };
    let peak = Vec3::splat(0.5);
    scene.lights.push(Light::point("alarm", Vec3::ZERO, peak).moving(LightMotion { path, peak, blink }));
    let mut frames = frames(scene, params(0.0));
    let (mut changes, mut short) = (Vec::new(), Vec::new());
    for frame in 0..12 {
        frames.render(f64::from(frame) * 0.1 + 0.05);
        changes.push(relative_change(&gradients(&frames)));
        short.push(short_histories(&frames));
    }
    println!("{changes:?}, {short:?}");
    frames.finish();
    for (frame, (&change, &part)) in changes.iter().zip(&short).enumerate().skip(3) {
        assert!(if frame == 4 { change > 0.2 } else { change < 1e-4 }, "frame {frame}: {changes:?}");
        match frame {
            4 | 8 => assert!(part > 0.9, "frame {frame}: {short:?}"),
            // Some lie on edges, where pixels show one surface or the other.
            3 | 7 | 11 => assert!(part < 0.5, "frame {frame}: {short:?}"),
            _ => {}
        }
    }
}

/// A light that lights nothing goes on and off: where lights are chosen, also for the surfaces that bounce rays meet, that is another choice. Gradient
/// pixels make that of the last frame.
#[test]
fn bounced_light_is_chosen_as_in_the_last_frame() {
    let mut scene = builtin("cornell");
    for material in &mut scene.materials {
        (material.specular, material.roughness) = (1.0, 0.3);
    }
    // Outside of the box, which is closed but for the side of the camera.
    let path = Motion::rest(Affine3A::from_translation(Vec3::new(0.0, -3.0, -3.0)));
    let (blink, peak) = (Blink::Square { period_s: 0.2, share: 0.5, phase: 0.0 }, Vec3::splat(50.0));
    scene.lights.push(Light::point("hidden", Vec3::ZERO, peak).moving(LightMotion { path, peak, blink }));
    let mut frames = frames(scene, params(1.0));
    let mut lit = 0;
    for frame in 0..LEAST_HISTORY + 6 {
        frames.render(f64::from(frame) * 0.1 + 0.05);
        for g in gradients(&frames) {
            for c in 0..2 {
                let near = (g.now[c] - g.before[c]).abs() <= 1e-4 * g.now[c].max(g.before[c]);
                assert!(near, "frame {frame}, {}: {:?} {:?}", g.pixel, g.before, g.now);
            }
            lit += usize::from(g.now[1] > 0.0);
        }
    }
    frames.finish();
    assert!(lit > 100, "{lit} gradient pixels have specular light");
}

/// Glossy surfaces under a moving camera, lit directly: a gradient pixel is seen from where it was seen in the last frame. For the new view every lobe would have
/// turned, and the specular light of all pixels would seem to change.
#[test]
fn the_view_of_the_last_frame_is_kept() {
    let mut scene = builtin("cornell");
    for material in &mut scene.materials {
        (material.specular, material.roughness) = (1.0, 0.2);
    }
    let rest = scene.cameras[0].clone();
    let mut frames = frames(scene, params(0.0));
    let (mut change, mut light, mut count) = (0.0, 0.0, 0);
    for frame in 0..LEAST_HISTORY + 6 {
        let step = Affine3A::from_translation(Vec3::new(0.03 * frame as f32, 0.0, 0.0));
        frames.set_camera(Camera { world_from_camera: step * rest.world_from_camera, ..rest.clone() });
        frames.render(0.0);
        for g in gradients(&frames) {
            change += (g.now[1] - g.before[1]).abs();
            light += g.now[1].max(g.before[1]);
            count += usize::from(g.now[1] > 0.0);
        }
    }
    println!("relative change of specular light {}, {count} gradient pixels", change / light);
    frames.finish();
    assert!(count > strata(), "{count} gradient pixels have specular light");
    // Roundings of the position, which follows from the triangle again.
    assert!(change < 1e-4 * light, "{change} of {light}");
}

/// A sampler that reuses the samples of other pixels cannot take one again: there are no gradient pixels.
#[test]
fn samplers_that_cannot_repeat_have_no_gradient_pixels() {
    let sets =
        ["denoise.variant=asvgf", "indirect.bounces=0", "lights.rays=merged", "lights.sampler=restir-di"];
    let params = resolve(None, &sets.map(String::from), false).unwrap();
    let mut frames = frames(builtin("cornell"), params);
    for _ in 0..LEAST_HISTORY + 2 {
        frames.render(0.0);
        assert!(gradients(&frames).is_empty());
    }
    frames.finish();
}

/// Flat pixels as the denoiser's oracles see them.
fn guided(frames: &Frames) -> Vec<Guided> {
    let floats = |id: ChannelId| frames.floats(id);
    let (position, depth, motion) = (floats(SHADING_POSITION), floats(VIEW_DEPTH), floats(MOTION));
    let (vertex, direction) = (frames.integers(VERTEX_NORMAL), frames.integers(VIEW_DIRECTION));
    let texel = |i: usize| Guided {
        material: position[4 * i + 3].to_bits(),
        flags: direction[2 * i + 1],
        depth: depth[i],
        motion: [0, 1, 2, 3].map(|k| motion[4 * i + k]),
        vertex_normal: vertex[i],
        ..Guided::default()
    };
    to_flat(&(0..depth.len()).map(texel).collect::<Vec<_>>(), SIZE)
}

/// Colours of a light channel, flat pixels.
fn rgb(frames: &Frames, id: ChannelId) -> Vec<[f32; 3]> {
    let light: Vec<[f32; 3]> = frames.floats(id).chunks_exact(4).map(|c| [c[0], c[1], c[2]]).collect();
    to_flat(&light, SIZE)
}

fn all_samples(frames: &Frames) -> Vec<GradientSample> {
    let mut all = vec![GradientSample::default(); strata()];
    let texels = frames.floats(GRADIENT_SAMPLE);
    let row = (SIZE[0].div_ceil(2) as usize * 2).div_ceil(3);
    let [across, _] = strata_of_axes();
    for (s, sample) in all.iter_mut().enumerate() {
        let texel = &texels[4 * (s / across * row + s % across)..][..3];
        *sample = GradientSample { number: texel[0] as u32, luminance: [texel[1], texel[2]] };
    }
    all
}

/// What the next frame's gradient pixels are chosen from.
struct LastFrame {
    pixels: Vec<Guided>,
    light: Vec<oracle::Light>,
    samples: Vec<GradientSample>,
    positions: Vec<Vec3>,
    lengths: Vec<u32>,
}

impl LastFrame {
    fn of(frames: &Frames) -> Self {
        let [hf, spec] = [COLOR_HF, COLOR_SPEC].map(|id| rgb(frames, id));
        let light = hf.into_iter().zip(spec).map(|(hf, spec)| oracle::Light { hf, spec }).collect();
        let positions: Vec<Vec3> =
            (frames.floats(SHADING_POSITION).chunks_exact(4)).map(|p| Vec3::new(p[0], p[1], p[2])).collect();
        let positions = to_flat(&positions, SIZE);
        let lengths: Vec<u32> =
            frames.integers(SURFACE).chunks_exact(2).map(|word| word[1] & 0xffff).collect();
        let lengths = to_flat(&lengths, SIZE);
        Self { pixels: guided(frames), light, samples: all_samples(frames), positions, lengths }
    }

    fn seen(&self) -> Seen<'_> {
        Seen { pixels: &self.pixels, light: &self.light, samples: &self.samples, lengths: &self.lengths }
    }
}

/// The kernel's choice against the oracle's, while the camera moves, with detail below a pixel: the brightest pixel of a stratum whose surface was seen before.
#[test]
fn the_choice_agrees_with_the_oracle() {
    let mut params = params(0.0);
    params.denoise.antilag.pixel = GradientPixel::Brightest;
    let mut frames = frames(builtin("gallery"), params.clone());
    let mut before: Option<LastFrame> = None;
    let mut compared = 0;
    for frame in 0..LEAST_HISTORY + 4 {
        frames.render(0.2 * f64::from(frame));
        let (pixels, samples) = (guided(&frames), all_samples(&frames));
        if let Some(before) = &before {
            let wanted = brightest_candidates(SIZE, &pixels, before.seen(), &params.denoise);
            for (s, (want, lead)) in wanted.iter().enumerate() {
                let sum = want.luminance[0] + want.luminance[1];
                // Of two that are alike either may be taken.
                if want.number > 0 && *lead < 1e-4 * f64::from(sum.max(1e-6)) {
                    continue;
                }
                let got = &samples[s];
                assert_eq!(got.number, want.number, "frame {frame}, stratum {s}: {got:?}, oracle {want:?}");
                let near = |c: usize| (got.luminance[c] - want.luminance[c]).abs() <= 1e-5 * sum;
                assert!(near(0) && near(1), "frame {frame}, stratum {s}: {got:?}, oracle {want:?}");
                compared += usize::from(want.number > 0);
            }
        }
        before = Some(LastFrame::of(&frames));
    }
    frames.finish();
    assert!(compared > strata(), "{compared} gradient pixels were compared");
}

/// The same of forward projection, in a scene whose objects stand still: which pixel is sought, where it is now, and whether it is hidden.
#[test]
fn forward_projection_agrees_with_the_oracle() {
    let mut params = params(0.0);
    params.denoise.antilag.projection = Projection::Forward;
    let scene = builtin("gallery");
    let camera = scene.cameras[0].clone();
    let mut frames = frames(scene, params.clone());
    let mut before: Option<LastFrame> = None;
    let (mut compared, mut others) = (0, 0);
    for frame in 0..LEAST_HISTORY + 4 {
        let time = 0.2 * f64::from(frame);
        frames.render(time);
        if let Some(before) = &before {
            let camera = camera_record(&camera.at(time), SIZE);
            let forward = Forward { camera: &camera, positions: &before.positions, frame: [frame, 3] };
            let wanted = forward_candidates(SIZE, &guided(&frames), before.seen(), &forward, &params.denoise);
            for (got, want) in all_samples(&frames).iter().zip(&wanted) {
                let sum = want.luminance[0] + want.luminance[1];
                let near = |c: usize| (got.luminance[c] - want.luminance[c]).abs() <= 1e-5 * sum;
                compared += usize::from(want.number > 0);
                others += usize::from(got.number != want.number || !near(0) || !near(1));
            }
        }
        before = Some(LastFrame::of(&frames));
    }
    frames.finish();
    println!("forward projection: {others} of {compared} gradient pixels differ");
    // Places on the border of two pixels, in fp32 and in f64.
    assert!(compared > strata() && 200 * others <= compared, "{others} of {compared} differ");
}
