//! Runs of the samplers and what they are measured by.

use super::contestant::{Choice, Contestant};
use super::statistics::{BlockTest, Blocks, Interval, mean, neighbours_alike, ratio, relmse, texel_of};
use super::truth::Truth;
use super::view::View;
use anyhow::{Result, ensure};
use glam::DVec3;
use pt_core::Recorder;
use pt_core::split::split_size;
use pt_lights::images::RESTIR_POINT;
use pt_lights::{Counted, DirectLighting, DirectParams};
use pt_shaders::channels::{COLOR, METALLIC_ROUGHNESS, SHADING_POSITION, TRANSPARENT};

/// Frames that decide which pixels count.
const MASK_FRAMES: u32 = 32;
/// Perceptual roughness below which a surface is a mirror.
const MIRROR_ROUGHNESS: f32 = 0.08;

/// What a comparison does.
#[derive(Clone, Copy)]
pub struct Plan {
    pub runs: u32,
    /// Frames of a run.
    pub frames: u32,
    /// Frames before them in which samplers with a history learn; they do not count.
    pub warm_up: u32,
    pub budget_ms: Option<f64>,
    pub seed: u32,
    /// Million shadow rays a second that the device traces in the scene.
    pub ray_rate: f64,
}

/// Error of the mean of so many frames.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoint {
    pub frames: u32,
    pub relmse: Interval,
}

/// What is known of a sampler.
pub struct Measured {
    pub choice: Choice,
    /// Mean light over that of the reference.
    pub mean_ratio: Interval,
    /// relMSE of one frame: mean over the frames of a run. All errors leave out what the noise of the reference adds.
    pub one_frame: Interval,
    /// The same, if a frame took as many independent samples as fit into a frame of the slowest sampler.
    pub one_frame_equal_time: Interval,
    /// relMSE of the mean of a run's frames.
    pub equal_samples: Interval,
    /// relMSE of the mean of as many frames as fit into the budget.
    pub equal_time: Interval,
    pub frames_equal_time: u32,
    pub curve: Vec<CurvePoint>,
    /// Variance of a frame's pixel, mean over pixels and channels.
    pub variance: f64,
    /// Of direct lighting and what belongs to its sampler, for a frame.
    pub gpu_ms: f64,
    /// Of the passes among them that choose lights.
    pub choose_gpu_ms: f64,
    /// Of the sampler's tables on the device.
    pub bytes: u64,
    /// Until the tables were made.
    pub build_ms: f64,
    /// Shadow rays per pixel.
    pub rays_per_pixel: f64,
    /// Share of them that reach their light.
    pub arrived: f64,
    /// Million shadow rays a second of GPU time.
    pub mrays_per_s: f64,
    /// Of a pixel's 8 neighbours, how many have the same sample.
    pub duplicates: f64,
    pub blocks: BlockTest,
    /// Mean of all runs, and root of the mean square of their errors, for each pixel.
    pub picture: Vec<DVec3>,
    pub error: Vec<f64>,
}

impl Measured {
    /// How many independent frames the mean of a run is worth: fewer than its frames where frames are alike.
    pub fn effective_frames(&self) -> f64 {
        self.one_frame.mean / self.equal_samples.mean
    }
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
    let mut lights = pt_light_sampling::LightTables::new(&view.device, &view.scene)?;
    lights.prepare(&view.device, &view.scene, &mut view.gpu, params.sampler_choice())?;
    let mut recorder = Recorder::new(&view.device)?;
    let [width, height] = view.size();
    let mut keep = vec![true; (width * height) as usize];
    view.leave_out_lamps(&mut keep);
    for index in 0..MASK_FRAMES {
        let mut frame = recorder.begin()?;
        let record = view.frame_record(index, 1);
        view.record(&mut frame, &record, &mut lights, (&stage, &params), None)?;
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

/// Measures all samplers. `tell` gets a line for each step.
pub fn compare(
    view: &mut View,
    truth: &Truth,
    mask: &[bool],
    choices: &[Choice],
    plan: &Plan,
    mut tell: impl FnMut(&str),
) -> Result<Vec<Measured>> {
    let mut timed = Vec::new();
    for choice in choices {
        tell(&format!("{}: compiling and timing", choice.name));
        timed.push(Contestant::new(view, choice, plan.seed)?);
    }
    let slowest = timed.iter().map(|c| c.gpu_ms).fold(0.0, f64::max);
    let budget = plan.budget_ms.unwrap_or(slowest * f64::from(plan.frames));
    let mut results = Vec::new();
    for contestant in timed {
        let equal_time = ((budget / contestant.gpu_ms).floor() as u32).max(1);
        let frames = equal_time.max(plan.frames);
        tell(&format!("{}: {} runs of {frames} frames", contestant.choice.name, plan.runs));
        let mut measured = contestant.measure(view, truth, mask, plan, equal_time)?;
        measured.one_frame_equal_time = measured.one_frame.scaled(measured.gpu_ms / slowest);
        results.push(measured);
    }
    Ok(results)
}

/// Frames of which the mean is compared with the reference: powers of two, and the last.
fn checkpoints(last: u32) -> Vec<u32> {
    let mut all: Vec<u32> = (0..32).map(|k| 1 << k).take_while(|frames| *frames < last).collect();
    all.push(last);
    all
}

/// Sums over the runs of a sampler.
struct Sums {
    one_frame: Vec<f64>,
    equal_samples: Vec<f64>,
    equal_time: Vec<f64>,
    ratios: Vec<f64>,
    /// For each checkpoint the errors of the runs.
    curve: Vec<(u32, Vec<f64>)>,
    /// Of every frame.
    squares: Vec<DVec3>,
    whole: Vec<DVec3>,
    picture: Vec<DVec3>,
    error: Vec<f64>,
    blocks: Blocks,
    duplicates: f64,
    traced: f64,
    arrived: f64,
}

impl Contestant {
    /// The light of the next frame, of the pixels in scan-line order.
    pub fn frame(
        &mut self,
        view: &mut View,
        recorder: &mut Recorder,
        (index, seed): (u32, u32),
        counted: Option<&Counted>,
    ) -> Result<Vec<DVec3>> {
        let mut frame = recorder.begin()?;
        let record = view.frame_record(index, seed);
        view.record(&mut frame, &record, &mut self.lights, (&self.stage, &self.choice.params), counted)?;
        frame.submit()?;
        recorder.finish()?;
        let color = view.images.current(COLOR).read_f32()?;
        let [width, height] = view.size();
        let light = (0..(width * height) as usize).map(|pixel| {
            let texel = 4 * texel_of(pixel, width);
            DVec3::from_slice(&[color[texel], color[texel + 1], color[texel + 2]].map(f64::from))
        });
        let light: Vec<DVec3> = light.collect();
        ensure!(light.iter().all(|value| value.is_finite()), "{}: a pixel is not finite", self.choice.name);
        Ok(light)
    }

    /// The samples of the texels of the last frame. Reservoirs name them as neighbours share them: each makes a point of its own of one.
    fn samples(&self, view: &View, counted: &Counted) -> Result<Vec<[u32; 2]>> {
        if !self.choice.is_restir() {
            return Ok(counted.choices()?);
        }
        let words = view.images.current(RESTIR_POINT).read_u32()?;
        Ok(words.chunks_exact(2).map(|sample| [sample[0], sample[1]]).collect())
    }

    fn measure(
        mut self,
        view: &mut View,
        truth: &Truth,
        mask: &[bool],
        plan: &Plan,
        equal_time: u32,
    ) -> Result<Measured> {
        let [width, height] = view.size();
        let pixels = (width * height) as usize;
        let texels = (split_size([width, height])[0] * height) as usize;
        let last = plan.frames.max(equal_time);
        let warm_up = if self.choice.has_history() { plan.warm_up } else { 0 };
        let runs = f64::from(plan.runs);
        let mut recorder = Recorder::new(&view.device)?;
        let mut sums = Sums {
            one_frame: Vec::new(),
            equal_samples: Vec::new(),
            equal_time: Vec::new(),
            ratios: Vec::new(),
            curve: checkpoints(last).into_iter().map(|frames| (frames, Vec::new())).collect(),
            squares: vec![DVec3::ZERO; pixels],
            whole: vec![DVec3::ZERO; pixels],
            picture: vec![DVec3::ZERO; pixels],
            error: vec![0.0; pixels],
            blocks: Blocks::default(),
            duplicates: 0.0,
            traced: 0.0,
            arrived: 0.0,
        };
        for run in 0..plan.runs {
            self.restart(view)?;
            // Counts of 32 bits are enough for a run.
            let counted = Counted::new(&view.device, texels)?;
            let mut sum = vec![DVec3::ZERO; pixels];
            let mut one_frame = Vec::new();
            for index in 0..warm_up + last {
                let seeds = (index, plan.seed.wrapping_add(1 + run));
                let counts = (index >= warm_up).then_some(&counted);
                let light = self.frame(view, &mut recorder, seeds, counts)?;
                let Some(seen) = (index + 1).checked_sub(warm_up).filter(|seen| *seen > 0) else { continue };
                for (pixel, value) in light.iter().enumerate() {
                    sum[pixel] += *value;
                    sums.whole[pixel] += *value;
                    sums.squares[pixel] += *value * *value;
                }
                if seen <= plan.frames {
                    one_frame.push(relmse(&light, 1.0, truth, mask));
                }
                let share = 1.0 / f64::from(seen);
                if let Some((_, errors)) = sums.curve.iter_mut().find(|(frames, _)| *frames == seen) {
                    errors.push(relmse(&sum, share, truth, mask));
                }
                if seen == equal_time {
                    sums.equal_time.push(relmse(&sum, share, truth, mask));
                }
                if seen == plan.frames {
                    let picture: Vec<DVec3> = sum.iter().map(|s| *s * share).collect();
                    sums.equal_samples.push(relmse(&picture, 1.0, truth, mask));
                    sums.ratios.push(ratio(&picture, 1.0, truth, mask));
                    sums.blocks.add(&picture, width, mask);
                    for (i, value) in picture.iter().enumerate() {
                        sums.picture[i] += *value / runs;
                        sums.error[i] += (*value - truth.mean[i]).length_squared() / 3.0 / runs;
                    }
                    let samples = self.samples(view, &counted)?;
                    sums.duplicates += neighbours_alike(&samples, [width, height], mask) / runs;
                }
            }
            sums.one_frame.push(mean(one_frame.into_iter()));
            let rays = counted.rays()?;
            sums.traced += f64::from(rays.traced);
            sums.arrived += f64::from(rays.arrived);
        }
        Ok(self.finish(sums, truth, (width, mask), runs * f64::from(last), equal_time))
    }

    fn finish(
        self,
        sums: Sums,
        truth: &Truth,
        (width, mask): (u32, &[bool]),
        frames: f64,
        equal_time: u32,
    ) -> Measured {
        let variance = |i: usize| {
            let mean = sums.whole[i] / frames;
            (sums.squares[i] / frames - mean * mean).max(DVec3::ZERO).element_sum() / 3.0
        };
        let one_frame = Interval::of(&sums.one_frame);
        let rays = sums.traced / frames;
        Measured {
            mean_ratio: Interval::of(&sums.ratios),
            one_frame,
            one_frame_equal_time: one_frame,
            equal_samples: Interval::of(&sums.equal_samples),
            equal_time: Interval::of(&sums.equal_time),
            frames_equal_time: equal_time,
            curve: sums
                .curve
                .iter()
                .map(|(frames, errors)| CurvePoint { frames: *frames, relmse: Interval::of(errors) })
                .collect(),
            variance: mean((0..mask.len()).filter(|i| mask[*i]).map(variance)),
            gpu_ms: self.gpu_ms,
            choose_gpu_ms: self.choose_gpu_ms,
            bytes: self.bytes,
            build_ms: self.build_ms,
            rays_per_pixel: rays / mask.len() as f64,
            arrived: sums.arrived / sums.traced.max(1.0),
            mrays_per_s: rays / self.gpu_ms * 1e-3,
            duplicates: sums.duplicates,
            blocks: sums.blocks.test(truth, width, mask),
            picture: sums.picture,
            error: sums.error.into_iter().map(f64::sqrt).collect(),
            choice: self.choice,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_are_powers_of_two_and_the_last() {
        assert_eq!(checkpoints(1), [1]);
        assert_eq!(checkpoints(8), [1, 2, 4, 8]);
        assert_eq!(checkpoints(11), [1, 2, 4, 8, 11]);
    }
}
