use crate::film::FilmState;
use crate::params::ReferenceParams;
use crate::path_tracer::{PathTracer, Tile};
use pt_core::frame::Uniforms;
use pt_core::{Device, Recorder, Result};
use pt_lights::LightTables;
use pt_scene::Scene;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::FrameRecord;
use std::time::{Duration, Instant};

/// How long a submission is to take: long enough to hide its cost, short enough to be interrupted.
const SUBMISSION: Duration = Duration::from_millis(100);
/// Most samples a pixel gets in one submission.
const MAX_BATCH: u32 = 64;

/// A render that gains samples step by step and can be stopped and resumed at every step.
pub struct Progressive {
    recorder: Recorder,
    tracer: PathTracer,
    uniforms: Uniforms<FrameRecord>,
    frame: FrameRecord,
    params: ReferenceParams,
    tiles: Vec<Tile>,
    next_sample: u32,
    /// Samples of the next submission, adapted to the device's speed.
    batch: u32,
}

impl Progressive {
    /// A render of the view and size that `frame` states, with sums of zero, whose first sample has the index `first_sample`.
    /// `tile`: largest part of the image that one submission works on; `None`: all of it.
    ///
    /// # Errors
    /// When the device refuses, or has not the memory.
    pub fn new(
        device: &Device,
        gpu: &GpuScene,
        frame: FrameRecord,
        params: ReferenceParams,
        tile: Option<[u32; 2]>,
        first_sample: u32,
    ) -> Result<Self> {
        let size = frame.size.to_array();
        Ok(Self {
            recorder: Recorder::new(device)?,
            tracer: PathTracer::new(device, gpu.backend(), size)?,
            uniforms: Uniforms::new(device, "frame_uniforms")?,
            frame,
            params,
            tiles: tiles(size, tile.unwrap_or(size)),
            next_sample: first_sample,
            batch: 1,
        })
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

    /// Submits some more samples, up to the index `end`; returns before they are done.
    ///
    /// # Errors
    /// When the device fails.
    pub fn step(&mut self, scene: &Scene, gpu: &mut GpuScene, lights: &LightTables, end: u32) -> Result<()> {
        let samples = self.next_sample..end.min(self.next_sample.saturating_add(self.batch));
        if samples.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        for &tile in &self.tiles {
            let mut frame = self.recorder.begin()?;
            gpu.update(&mut frame, scene)?;
            self.uniforms.upload(&mut frame, &self.frame)?;
            self.tracer.record(
                &mut frame,
                gpu,
                lights,
                &self.uniforms,
                &self.params,
                (tile, samples.clone()),
            )?;
            frame.submit()?;
        }
        // Two submissions are in flight: once there are more, the time between them is the device's.
        let per_tile = started.elapsed() / self.tiles.len() as u32;
        if per_tile * 2 < SUBMISSION {
            self.batch = (self.batch * 2).min(MAX_BATCH);
        } else if per_tile > SUBMISSION * 2 {
            self.batch = (self.batch / 2).max(1);
        }
        self.next_sample = samples.end;
        Ok(())
    }

    /// Waits, and returns the sums.
    ///
    /// # Errors
    /// When the device fails.
    pub fn state(&mut self) -> Result<FilmState> {
        self.recorder.finish()?;
        self.tracer.state()
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
