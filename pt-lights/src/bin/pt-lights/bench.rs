//! Runs of the samplers and what they are measured by.

use super::truth::Truth;
use super::view::View;
use anyhow::{Result, ensure};
use glam::DVec3;
use pt_core::split::{flat_to_split, split_size};
use pt_core::{Recorder, harness::Spread};
use pt_image::metrics::RELMSE_EPSILON;
use pt_lights::{Counted, DirectLighting, DirectParams};
use pt_shaders::channels::{COLOR, METALLIC_ROUGHNESS, SHADING_POSITION, TRANSPARENT};
use pt_shaders::records::LightSampler;
use std::time::Instant;

/// Frames that decide which pixels count.
const MASK_FRAMES: u32 = 32;
/// Perceptual roughness below which a surface is a mirror.
const MIRROR_ROUGHNESS: f32 = 0.08;
/// Frames that are timed before anything else, after as many to warm up.
const TIMED_FRAMES: u32 = 6;
/// Passes that are the same for all samplers.
const COMMON_PASSES: [&str; 2] = ["primary rays", "composite"];

/// What a comparison does.
pub struct Plan<'a> {
    pub runs: u32,
    pub frames: u32,
    pub budget_ms: Option<f64>,
    pub seed: u32,
    pub params: &'a DirectParams,
}

/// Mean over independent runs with its 95 % interval (Student's t).
#[derive(Clone, Copy, Debug, Default)]
pub struct Interval {
    pub mean: f64,
    pub low: f64,
    pub high: f64,
}

/// What is known of a sampler.
pub struct Measured {
    pub sampler: LightSampler,
    /// Mean light over that of the reference.
    pub mean_ratio: Interval,
    /// relMSE of a run, without what the noise of the reference adds.
    pub relmse_equal_samples: Interval,
    pub relmse_equal_time: Interval,
    /// Frames of a run at equal time.
    pub frames_equal_time: u32,
    /// Variance of a frame's pixel, mean over pixels and channels.
    pub variance: f64,
    /// Of direct lighting and what belongs to its sampler, for a frame.
    pub gpu_ms: f64,
    /// Of the sampler's tables on the device.
    pub bytes: u64,
    /// Until the tables were made.
    pub build_ms: f64,
    /// Shadow rays per pixel with a surface.
    pub rays_per_pixel: f64,
    /// Share of them that reach their light.
    pub arrived: f64,
    /// Of a pixel's 8 neighbours, how many have the same point on the same light.
    pub duplicates: f64,
    /// Mean of all runs, and root of the mean square of their errors, for each pixel.
    pub picture: Vec<DVec3>,
    pub error: Vec<f64>,
}

/// Which pixels count: those that show a surface that does not shine in any of some frames, no mirror and no glass.
pub fn mask(view: &mut View) -> Result<Vec<bool>> {
    let params = DirectParams {
        sun: false,
        positional: false,
        emissive: false,
        environment: false,
        ..DirectParams::default()
    };
    let stage = DirectLighting::new(&view.device, view.gpu.variant(), &params)?;
    let mut recorder = Recorder::new(&view.device)?;
    let [width, height] = view.size();
    let mut keep = vec![true; (width * height) as usize];
    for index in 0..MASK_FRAMES {
        let mut frame = recorder.begin()?;
        let record = view.frame_record(index, 1);
        view.record(&mut frame, &record, &stage, &params, None)?;
        frame.submit()?;
        recorder.finish()?;
        let overlay = view.images.current(TRANSPARENT).read_f32()?;
        let position = view.images.current(SHADING_POSITION).read_f32()?;
        let roughness = view.images.current(METALLIC_ROUGHNESS).read_f32()?;
        for (pixel, keep) in keep.iter_mut().enumerate() {
            let texel = texel_of(pixel, width);
            let material = position[4 * texel + 3].to_bits();
            let dark = overlay[4 * texel..4 * texel + 3].iter().all(|c| *c == 0.0);
            let diffuse = material > 0 && !view.scene.materials[material as usize - 1].transmits();
            *keep &= dark && diffuse && roughness[2 * texel + 1] >= MIRROR_ROUGHNESS;
        }
    }
    Ok(keep)
}

/// Index in the split frame of a pixel of the flat frame.
fn texel_of(pixel: usize, width: u32) -> usize {
    let pixel = pixel as u32;
    let [x, y] = flat_to_split([pixel % width, pixel / width], pt_shaders::records::field_width(width));
    (y * split_size([width, 1])[0] + x) as usize
}

/// Measures all samplers. `tell` gets a line for each step.
pub fn compare(
    view: &mut View,
    truth: &Truth,
    mask: &[bool],
    samplers: &[LightSampler],
    plan: &Plan<'_>,
    mut tell: impl FnMut(&str),
) -> Result<Vec<Measured>> {
    let mut timed = Vec::new();
    for &sampler in samplers {
        tell(&format!("{}: compiling and timing", sampler.name()));
        timed.push(Contestant::new(view, sampler, plan)?);
    }
    let slowest = timed.iter().map(|c| c.gpu_ms).fold(0.0, f64::max);
    let budget = plan.budget_ms.unwrap_or(slowest * f64::from(plan.frames));
    let mut results = Vec::new();
    for contestant in timed {
        let equal_time = ((budget / contestant.gpu_ms).floor() as u32).max(1);
        tell(&format!(
            "{}: {} runs of {} frames",
            contestant.sampler.name(),
            plan.runs,
            equal_time.max(plan.frames)
        ));
        results.push(contestant.measure(view, truth, mask, plan, equal_time)?);
    }
    Ok(results)
}

/// A sampler with its kernels.
struct Contestant {
    sampler: LightSampler,
    params: DirectParams,
    stage: DirectLighting,
    gpu_ms: f64,
    build_ms: f64,
    bytes: u64,
}

impl Contestant {
    fn new(view: &mut View, sampler: LightSampler, plan: &Plan<'_>) -> Result<Self> {
        let params = DirectParams { sampler, ..plan.params.clone() };
        let stage = DirectLighting::new(&view.device, view.gpu.variant(), &params)?;
        let mut contestant = Self { sampler, params, stage, gpu_ms: 0.0, build_ms: 0.0, bytes: 0 };
        let started = Instant::now();
        contestant.restart(view)?;
        contestant.build_ms = started.elapsed().as_secs_f64() * 1e3;
        contestant.bytes = view.lights.sampler().map_or(0, |tables| tables.bytes());
        let mut recorder = Recorder::new(&view.device)?;
        let mut times = Vec::new();
        for index in 0..2 * TIMED_FRAMES {
            let mut frame = recorder.begin()?;
            let record = view.frame_record(index, plan.seed);
            view.record(&mut frame, &record, &contestant.stage, &contestant.params, None)?;
            frame.submit()?;
            for timing in recorder.finish()? {
                let own = timing.passes.iter().filter(|pass| !COMMON_PASSES.contains(&pass.pass.as_str()));
                times.push(own.map(|pass| pass.ms).sum());
            }
        }
        contestant.gpu_ms = Spread::of(times.split_off(TIMED_FRAMES as usize)).median_ms;
        ensure!(contestant.gpu_ms > 0.0, "the device has no timestamps");
        Ok(contestant)
    }

    /// Forgets what the sampler has learnt.
    fn restart(&self, view: &mut View) -> Result<()> {
        let View { device, scene, gpu, lights, images, .. } = view;
        images.reset_history();
        lights.keep_last_frame(self.params.replays());
        Ok(lights.prepare(device, scene, gpu, self.params.sampler_choice())?)
    }

    fn measure(
        self,
        view: &mut View,
        truth: &Truth,
        mask: &[bool],
        plan: &Plan<'_>,
        equal_time: u32,
    ) -> Result<Measured> {
        let [width, height] = view.size();
        let pixels = (width * height) as usize;
        let texels = (split_size([width, height])[0] * height) as usize;
        let counted = Counted::new(&view.device, texels)?;
        let mut recorder = Recorder::new(&view.device)?;
        let (mut at_samples, mut at_time, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        let (mut picture, mut error) = (vec![DVec3::ZERO; pixels], vec![0.0; pixels]);
        let (mut squares, mut frames_seen) = (vec![DVec3::ZERO; pixels], 0u64);
        let mut duplicates = 0.0;
        for run in 0..plan.runs {
            self.restart(view)?;
            let mut sum = vec![DVec3::ZERO; pixels];
            for index in 0..plan.frames.max(equal_time) {
                let mut frame = recorder.begin()?;
                let record = view.frame_record(index, plan.seed.wrapping_add(1 + run));
                view.record(&mut frame, &record, &self.stage, &self.params, Some(&counted))?;
                frame.submit()?;
                recorder.finish()?;
                let color = view.images.current(COLOR).read_f32()?;
                frames_seen += 1;
                for (pixel, sum) in sum.iter_mut().enumerate() {
                    let texel = 4 * texel_of(pixel, width);
                    let value =
                        DVec3::from_slice(&[color[texel], color[texel + 1], color[texel + 2]].map(f64::from));
                    ensure!(value.is_finite(), "{}: a pixel is not finite", self.sampler.name());
                    *sum += value;
                    squares[pixel] += value * value;
                }
                let mean = |sum: &[DVec3]| sum.iter().map(|s| *s / f64::from(index + 1)).collect::<Vec<_>>();
                if index + 1 == plan.frames {
                    let mean = mean(&sum);
                    at_samples.push(relmse(&mean, truth, mask));
                    ratios.push(ratio(&mean, truth, mask));
                    for (i, value) in mean.iter().enumerate() {
                        picture[i] += *value / f64::from(plan.runs);
                        error[i] += (*value - truth.mean[i]).length_squared() / 3.0 / f64::from(plan.runs);
                    }
                    duplicates +=
                        neighbours_alike(&counted.choices()?, [width, height], mask) / f64::from(plan.runs);
                }
                if index + 1 == equal_time {
                    at_time.push(relmse(&mean(&sum), truth, mask));
                }
            }
        }
        let rays = counted.rays()?;
        let surfaces = frames_seen as f64 * pixels as f64;
        let n = frames_seen as f64;
        let variance = (0..pixels).filter(|i| mask[*i]).map(|i| {
            let mean = picture[i];
            (squares[i] / n - mean * mean).max(DVec3::ZERO).element_sum() / 3.0
        });
        let kept = mask.iter().filter(|keep| **keep).count() as f64;
        Ok(Measured {
            sampler: self.sampler,
            mean_ratio: interval(&ratios),
            relmse_equal_samples: interval(&at_samples),
            relmse_equal_time: interval(&at_time),
            frames_equal_time: equal_time,
            variance: variance.sum::<f64>() / kept,
            gpu_ms: self.gpu_ms,
            bytes: self.bytes,
            build_ms: self.build_ms,
            rays_per_pixel: f64::from(rays.traced) / surfaces,
            arrived: f64::from(rays.arrived) / f64::from(rays.traced.max(1)),
            duplicates,
            picture,
            error: error.into_iter().map(f64::sqrt).collect(),
        })
    }
}

/// Mean of (x - t)^2 / (t^2 + epsilon) over the pixels that count, less what the variance of t adds.
fn relmse(picture: &[DVec3], truth: &Truth, mask: &[bool]) -> f64 {
    let term = |i: usize| {
        let (x, t) = (picture[i], truth.mean[i]);
        (((x - t) * (x - t) - truth.variance[i]) / (t * t + RELMSE_EPSILON)).element_sum() / 3.0
    };
    mean((0..picture.len()).filter(|i| mask[*i]).map(term))
}

fn ratio(picture: &[DVec3], truth: &Truth, mask: &[bool]) -> f64 {
    let sum = |of: &[DVec3]| (0..of.len()).filter(|i| mask[*i]).map(|i| of[i].element_sum()).sum::<f64>();
    let truth = sum(&truth.mean);
    if truth > 0.0 { sum(picture) / truth } else { 1.0 }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u64), |(sum, count), v| (sum + v, count + 1));
    sum / count.max(1) as f64
}

/// Of the 8 neighbours of a pixel, how many have the same choice; mean over the pixels that have one and count.
fn neighbours_alike(choices: &[[u32; 2]], [width, height]: [u32; 2], mask: &[bool]) -> f64 {
    let at = |x: u32, y: u32| choices[texel_of((y * width + x) as usize, width)];
    let inner = (1..height.saturating_sub(1)).flat_map(|y| (1..width.saturating_sub(1)).map(move |x| (x, y)));
    mean(inner.filter(|&(x, y)| mask[(y * width + x) as usize] && at(x, y)[0] != u32::MAX).map(|(x, y)| {
        let own = at(x, y);
        let near = (0..9u32).filter(|i| *i != 4).map(|i| at(x + i % 3 - 1, y + i / 3 - 1));
        near.filter(|other| *other == own).count() as f64
    }))
}

/// 97.5 % quantile of Student's t for n - 1 degrees of freedom, n from 2 on: Cornish-Fisher expansion (Abramowitz and Stegun 26.7.5), exact
/// values for the first few.
fn student(n: usize) -> f64 {
    const FIRST: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    let degrees = n.saturating_sub(1).max(1);
    if let Some(exact) = FIRST.get(degrees - 1) {
        return *exact;
    }
    let (z, v) = (1.959_964f64, degrees as f64);
    z + (z.powi(3) + z) / (4.0 * v) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * v * v)
}

fn interval(values: &[f64]) -> Interval {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    let reach = student(values.len()) * (variance / n).sqrt();
    Interval { mean, low: mean - reach, high: mean + reach }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_students() {
        assert!((student(7) - 2.447).abs() < 1e-3 && (student(12) - 2.201).abs() < 3e-3);
        assert!((student(31) - 2.042).abs() < 1e-3);
        let i = interval(&[1.0, 2.0, 3.0]);
        assert!((i.mean - 2.0).abs() < 1e-12 && (i.high - 2.0 - 4.303 / 3f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn duplicates_are_counted_among_neighbours() {
        let size = [4, 3];
        let mut choices = vec![[u32::MAX, 0]; (split_size(size)[0] * size[1]) as usize];
        for (pixel, choice) in [(5, [7, 1]), (6, [7, 1]), (9, [7, 2]), (1, [7, 1])] {
            choices[texel_of(pixel, size[0])] = choice;
        }
        // Pixel 5 has 6 and 1 as its like, pixel 6 has 5 and 1.
        assert_eq!(neighbours_alike(&choices, size, &[true; 12]), 2.0);
    }
}
