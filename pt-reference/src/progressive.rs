use crate::camera_interior::interior_at;
use crate::film::FilmState;
use crate::params::ReferenceParams;
use crate::path_tracer::{Iterations, PathTracer, Tile};
use pt_core::frame::{FrameTiming, Uniforms};
use pt_core::{Device, Recorder, Result};
use pt_light_sampling::LightTables;
use pt_scene::Scene;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::FrameRecord;
use std::time::{Duration, Instant};

/// How long a submission is to take: long enough to hide its cost, short enough to be interrupted.
const SUBMISSION: Duration = Duration::from_millis(100);
/// Most iterations of a submission. The device goes through up to twice as many that have no paths left, before the host knows.
const MAX_ITERATIONS: u32 = 8;
/// How long a step is to take unless the caller says otherwise: the last paths of a step leave a wide device idle.
const STEP: Duration = Duration::from_millis(500);
/// Most samples a pixel gets in one step.
const MAX_BATCH: u32 = 256;
/// Most pixels of a tile: some 360 MB of paths.
const MAX_TILE_PIXELS: u32 = 1 << 21;

/// A render that gains samples step by step and can be stopped and resumed at every step.
pub struct Progressive {
    recorder: Recorder,
    tracer: PathTracer,
    uniforms: Uniforms<FrameRecord>,
    /// What `uniforms` is still to be filled with.
    view: Option<FrameRecord>,
    tiles: Vec<Tile>,
    next_sample: u32,
    /// Samples of the next step and iterations of the next submission, adapted to the device's speed.
    batch: u32,
    iterations: u32,
    step_time: Duration,
}

impl Progressive {
    /// A render of the view and size that `frame` states, with sums of zero, whose first sample has the index `first_sample`.
    /// `lights`: see [`PathTracer::new`]. `tile`: part of the image that is worked on at a time; `None`: whole rows, as many as fit into some 360 MB.
    ///
    /// # Errors
    /// When the device refuses, or has not the memory.
    pub fn new(
        device: &Device,
        gpu: &GpuScene,
        lights: &LightTables,
        frame: FrameRecord,
        params: ReferenceParams,
        tile: Option<[u32; 2]>,
        first_sample: u32,
    ) -> Result<Self> {
        let size = frame.size.to_array();
        let rows = (MAX_TILE_PIXELS / size[0].max(1)).max(1);
        let tile = tile.unwrap_or([size[0], rows]);
        let tile = [0, 1].map(|axis| tile[axis].clamp(1, size[axis].max(1)));
        Ok(Self {
            recorder: Recorder::new(device)?,
            tracer: PathTracer::new(device, gpu, lights, params, size, tile)?,
            uniforms: Uniforms::new(device, "frame_uniforms")?,
            view: Some(frame),
            tiles: tiles(size, tile),
            next_sample: first_sample,
            batch: 1,
            iterations: 1,
            step_time: STEP,
        })
    }

    /// How long a step is to take; at least one sample is traced.
    #[must_use]
    pub fn with_step_time(self, step_time: Duration) -> Self {
        Self { step_time, ..self }
    }

    /// Goes on from earlier sums; `next_sample` is the index of the first sample that they lack.
    ///
    /// # Errors
    /// When the device fails.
    pub fn resume(&mut self, state: &FilmState, next_sample: u32) -> Result<()> {
        self.next_sample = next_sample;
        self.tracer.set(state)
    }

    /// Index of the next sample.
    pub fn next_sample(&self) -> u32 {
        self.next_sample
    }

    /// Traces some more samples, up to the index `end`; returns their timings, submission by submission.
    ///
    /// # Errors
    /// When the device fails.
    pub fn step(
        &mut self,
        scene: &Scene,
        gpu: &mut GpuScene,
        lights: &mut LightTables,
        end: u32,
    ) -> Result<Vec<FrameTiming>> {
        let samples = self.next_sample..end.min(self.next_sample.saturating_add(self.batch));
        let mut timings = Vec::new();
        if samples.is_empty() {
            return Ok(timings);
        }
        let started = Instant::now();
        for tile in self.tiles.clone() {
            let mut iteration = 0;
            let mut finished = Instant::now();
            loop {
                // The first one is short, so that the device begins soon.
                let count = if iteration == 0 { 1 } else { self.iterations };
                let iterations = iteration..iteration + count;
                let work = Iterations { tile, samples: samples.clone(), iterations: iterations.clone() };
                let submitted = self.submit(scene, gpu, lights, work)?;
                // The device has this submission to work on while the host asks about the one before and records the next.
                self.recorder.wait_for_room()?;
                if iteration > 0 && self.tracer.is_done(submitted - 1) {
                    break;
                }
                // The submission before was not the short first one.
                if iteration > 1 {
                    let aim = SUBMISSION.min(self.step_time);
                    self.iterations = adapt(self.iterations, MAX_ITERATIONS, finished.elapsed(), aim);
                }
                finished = Instant::now();
                iteration = iterations.end;
            }
        }
        timings.extend(self.recorder.finish()?);
        self.batch = adapt(self.batch, MAX_BATCH, started.elapsed(), self.step_time);
        self.next_sample = samples.end;
        Ok(timings)
    }

    /// Hands iterations to the device; the index of their frame.
    fn submit(
        &mut self,
        scene: &Scene,
        gpu: &mut GpuScene,
        lights: &mut LightTables,
        work: Iterations,
    ) -> Result<u32> {
        let mut frame = self.recorder.begin()?;
        let index = frame.index();
        lights.update(&mut frame, scene, gpu)?;
        if let Some(view) = self.view.take() {
            self.uniforms.upload(&mut frame, &view)?;
            let position = view.camera.world_from_view.w_axis.truncate();
            self.tracer.set_camera_interior(&interior_at(scene, position));
        }
        self.tracer.record(&mut frame, gpu, &self.uniforms, work)?;
        frame.submit()?;
        Ok(index)
    }

    /// The sums.
    ///
    /// # Errors
    /// When the device fails.
    pub fn state(&self) -> Result<FilmState> {
        self.tracer.state()
    }
}

/// The next amount of work, 1 to `most`, after `amount` of it took `time`.
fn adapt(amount: u32, most: u32, time: Duration, aim: Duration) -> u32 {
    if time * 2 < aim {
        (amount * 2).min(most)
    } else if time > aim * 2 {
        (amount / 2).max(1)
    } else {
        amount
    }
}

fn tiles(size: [u32; 2], tile: [u32; 2]) -> Vec<Tile> {
    let steps = |axis: usize| (0..size[axis]).step_by(tile[axis].max(1) as usize);
    steps(1)
        .flat_map(|y| steps(0).map(move |x| [x, y]))
        .map(|origin| Tile {
            origin,
            size: [0, 1].map(|axis| tile[axis].max(1).min(size[axis] - origin[axis])),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_image_once() {
        for (size, tile) in [([7, 5], [3, 2]), ([4, 4], [4, 4]), ([5, 3], [100, 1]), ([1, 1], [0, 0])] {
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for t in tiles(size, tile) {
                for y in t.origin[1]..t.origin[1] + t.size[1] {
                    for x in t.origin[0]..t.origin[0] + t.size[0] {
                        seen[(y * size[0] + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{size:?} in tiles of {tile:?}");
        }
    }
}
