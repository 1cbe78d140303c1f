use crate::film::FilmState;
use crate::kernels;
use crate::oracle::albedo;
use crate::params::{Heuristic, ReferenceParams, Strategy};
use crate::records::{self, FilmPixel, FirstHitPixel, PathPush};
use glam::UVec2;
use pt_core::frame::Uniforms;
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result};
use pt_lights::LightTables;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::{FrameRecord, KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_POSITIONAL, KIND_SUN};
use std::ops::Range;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Top left pixel.
    pub origin: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// The path tracer with the sums that it adds to: 48 bytes a pixel, and 40 for what camera rays see first.
///
/// A sample is a pure function of pixel, sample index and seed, and a pixel's samples are added in the order of their
/// indices: however they are cut into passes and tiles, the sums hold the same bits.
pub struct PathTracer {
    path: Kernel,
    first_hit_kernel: Kernel,
    size: [u32; 2],
    bsdf_tables: Buffer,
    film: Buffer,
    first_hit: Buffer,
    dropped: Buffer,
}

impl PathTracer {
    /// Compiles the kernels and allocates sums of zero for an image of `size` pixels.
    ///
    /// # Errors
    /// When the device refuses, or has not the memory.
    pub fn new(device: &Device, backend: TraceBackend, size: [u32; 2]) -> Result<Self> {
        let pixels = size[0] as usize * size[1] as usize;
        let tracer = Self {
            path: Kernel::trace::<PathPush>(device, &kernels::PATH, backend)?,
            first_hit_kernel: Kernel::trace::<PathPush>(device, &kernels::FIRST_HIT, backend)?,
            size,
            bsdf_tables: Buffer::from_slice(device, "bsdf_tables", &albedo::packed())?,
            film: Buffer::new(device, "film", (pixels * size_of::<FilmPixel>()) as u64, Location::Device)?,
            first_hit: Buffer::new(
                device,
                "first hits",
                (pixels * size_of::<FirstHitPixel>()) as u64,
                Location::Device,
            )?,
            dropped: Buffer::new(device, "dropped samples", 4, Location::Device)?,
        };
        tracer.set(&FilmState::zero(size))?;
        Ok(tracer)
    }

    /// Replaces the sums, for a render that goes on; waits.
    ///
    /// # Errors
    /// When the device fails.
    ///
    /// # Panics
    /// When `state` is of another size.
    pub fn set(&self, state: &FilmState) -> Result<()> {
        assert_eq!(state.size, self.size, "film of another size");
        self.film.write_through_staging(bytemuck::cast_slice(&state.film))?;
        self.first_hit.write_through_staging(bytemuck::cast_slice(&state.first_hit))?;
        self.dropped.write_through_staging(bytemuck::bytes_of(&state.dropped))
    }

    /// The sums, after everything submitted so far.
    ///
    /// # Errors
    /// When the device fails.
    pub fn state(&self) -> Result<FilmState> {
        Ok(FilmState {
            size: self.size,
            film: self.film.read()?,
            first_hit: self.first_hit.read()?,
            dropped: self.dropped.read::<u32>()?[0],
        })
    }

    /// Records the passes that add the samples to the pixels of the tile.
    ///
    /// # Errors
    /// When a pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        lights: &LightTables,
        uniforms: &Uniforms<FrameRecord>,
        params: &ReferenceParams,
        (tile, samples): (Tile, Range<u32>),
    ) -> Result<()> {
        let push = PathPush {
            film: self.film.address(),
            first_hit: self.first_hit.address(),
            dropped: self.dropped.address(),
            tile_origin: UVec2::from_array(tile.origin),
            tile_size: UVec2::from_array(tile.size),
            first_sample: samples.start,
            sample_count: samples.end - samples.start,
            max_bounces: params.max_bounces,
            roulette_start: params.roulette_start,
            kinds: kinds(params, lights),
            emission: u32::from(params.light_types.emissive),
            heuristic: match params.heuristic {
                Heuristic::Balance => records::HEURISTIC_BALANCE,
                Heuristic::Power => records::HEURISTIC_POWER,
            },
            strategy: match params.strategy {
                Strategy::Both => records::STRATEGY_BOTH,
                Strategy::Lights => records::STRATEGY_LIGHTS,
                Strategy::Bsdf => records::STRATEGY_BSDF,
            },
            sampler_kind: params.sampler as u32,
            energy_compensation: u32::from(params.energy_compensation),
            clamp: params.clamp,
            log2_spp: params.spp.max(1).next_power_of_two().trailing_zeros(),
        };
        let extent = [tile.size[0], tile.size[1], 1];
        let pass = frame.pass("path", &self.path).read("frame_uniforms", uniforms.buffer());
        let pass = pass.read("bsdf_tables", &self.bsdf_tables);
        let pass = lights.buffers().into_iter().fold(scene.bind(pass), pt_core::frame::Pass::addresses);
        pass.addresses_written(&self.film).addresses_written(&self.dropped).push(&push).dispatch(extent)?;
        let pass = frame.pass("first hit", &self.first_hit_kernel).read("frame_uniforms", uniforms.buffer());
        scene.bind(pass).addresses_written(&self.first_hit).push(&push).dispatch(extent)
    }
}

/// The kinds of light that count and that the scene has.
fn kinds(params: &ReferenceParams, lights: &LightTables) -> u32 {
    let (lists, types) = (lights.lists(), params.light_types);
    let bit = |on: bool, kind: u32| if on { kind } else { 0 };
    bit(types.sun && lists.sun_count > 0, KIND_SUN)
        | bit(types.punctual && lists.lights.len() > lists.sun_count as usize, KIND_POSITIONAL)
        | bit(types.emissive && !lists.emissives.is_empty(), KIND_EMISSIVE)
        | bit(types.environment && lists.environment_alias.is_some(), KIND_ENVIRONMENT)
}
