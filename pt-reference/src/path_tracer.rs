use crate::film::FilmState;
use crate::kernels;
use crate::oracle::interior::{CAPACITY, InteriorList};
use crate::params::ReferenceParams;
use crate::records::{self, FilmPixel, FirstHitPixel, PathPush, ProgressRecord};
use glam::{UVec2, UVec3, UVec4, Vec4};
use pt_core::frame::{FRAMES_IN_FLIGHT, Uniforms};
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, SceneResources};
use pt_light_sampling::LightTables;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::{
    BvhImportance, Culling, FEATURE_EFFECTS, FEATURE_TRANSMISSION, FEATURES_TEXTURE, FrameRecord,
    KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_LOCAL, KIND_POSITIONAL, KIND_SUN, LightSampler, RayListHead,
};
use std::mem::offset_of;
use std::ops::Range;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Top left pixel.
    pub origin: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// Pixels of a block of slots, as in path_slots.glsl.
const BLOCK: [u32; 2] = [8, 4];
/// Bytes of a slot: its place in three lists (and a gap that keeps rows aligned), ten rows, the length of a ray.
const SLOT_BYTES: u64 = 4 * 4 + 10 * 16 + 4;

/// Of its ray cone, if it has one.
const CONE_BYTES: u64 = 8;
/// And, in scenes with transmission, for shadow rays that go straight on through surfaces.
const STRAIGHT_BYTES: u64 = 3 * 16;
/// And what the light sampler knows of the last vertex, where it looks at it.
const LIGHT_BYTES: u64 = 2 * 16;
/// And, in scenes with effects, for the share of light that shows them.
const EFFECTS_BYTES: u64 = 16;

impl Tile {
    fn blocks(self) -> [u32; 2] {
        [0, 1].map(|axis| self.size[axis].div_ceil(BLOCK[axis]))
    }
}

/// Iterations of a tile's samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Iterations {
    /// Pixels that are worked on.
    pub tile: Tile,
    /// Their samples, less than 2^18.
    pub samples: Range<u32>,
    /// Numbers of the iterations; iteration 0 begins the first sample. See [`PathTracer::is_done`].
    pub iterations: Range<u32>,
}

/// The path tracer with the sums that it adds to: 64 bytes a pixel, and 40 for what camera rays see first; and 180 bytes for every
/// pixel of a tile, whose paths advance side by side.
///
/// Iterations (`path_advance`, `path_trace`, `path_shade`, `path_shadow`) move all the tile's paths on by a ray and a shadow ray. A
/// sample is a pure function of pixel, sample index and seed, and a pixel's samples are added in the order of their
/// indices: however they are cut into passes, iterations and tiles, the sums hold the same bits.
pub struct PathTracer {
    advance: Kernel,
    trace: Kernel,
    shade: Kernel,
    shadow: Kernel,
    params: ReferenceParams,
    camera_solids: [(u32, f32); CAPACITY],
    size: [u32; 2],
    film: Buffer,
    first_hit: Buffer,
    dropped: Buffer,
    progress: Buffer,
    /// Frames take turns: the host looks at one while the device writes the other.
    progress_read: [Buffer; FRAMES_IN_FLIGHT],
    paths: Buffer,
}

impl PathTracer {
    /// Compiles the kernels, for what the scene has, and allocates sums of zero for an image of `size` pixels; `tile`: size of the
    /// largest tile. `lights` are those of [`ReferenceParams::prepare_lights`].
    ///
    /// # Errors
    /// When the device refuses, or has not the memory.
    pub fn new(
        device: &Device,
        scene: &GpuScene,
        lights: &LightTables,
        params: ReferenceParams,
        size: [u32; 2],
        tile: [u32; 2],
    ) -> Result<Self> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let blocks = Tile { origin: [0; 2], size: tile }.blocks().map(u64::from);
        let slots = blocks[0] * blocks[1] * u64::from(BLOCK[0] * BLOCK[1]);
        let sampler = params.light_sampler(lights);
        let has = |feature: u32| scene.features() & feature != 0;
        let slot_bytes = SLOT_BYTES
            + if params.ray_cones { CONE_BYTES } else { 0 }
            + if has(FEATURE_TRANSMISSION) { STRAIGHT_BYTES } else { 0 }
            + if sampler.is_some() { LIGHT_BYTES } else { 0 }
            + if has(FEATURE_EFFECTS) { EFFECTS_BYTES } else { 0 };
        let constants = [
            ("scene_features", scene.features().into()),
            ("light_kinds", kinds(&params, lights).into()),
            ("sampler_kind", params.sampler.code().into()),
            ("energy_compensation", params.energy_compensation.into()),
            ("ray_cones", params.ray_cones.into()),
            ("background", params.background.code().into()),
            ("merged_lights", sampler.is_some().into()),
            ("sort_materials", sorts_by_material(device, scene).into()),
        ];
        let mut shading = constants.to_vec();
        shading.extend([
            ("light_sampler", sampler.unwrap_or(LightSampler::Power).code().into()),
            ("bvh_importance", BvhImportance::SphericalGaussian.code().into()),
            ("environment_listed", false.into()),
            ("medium_density", params.medium.density.into()),
            ("medium_albedo", params.medium.albedo.into()),
            ("medium_anisotropy", params.medium.anisotropy.into()),
            ("medium_max_distance", params.medium.max_distance.into()),
            // The most: rays that meet no more effects have them in their order.
            ("effect_layers", 16u32.into()),
        ]);
        let compute = |code, constants: &[_]| Kernel::compute::<PathPush>(device, code, constants);
        let trace = |code, culling: Culling| {
            let mut constants = constants.to_vec();
            constants.push(("culling", culling.code().into()));
            Kernel::trace::<PathPush>(device, code, scene.backend(), &constants)
        };
        let buffer = |name, bytes| Buffer::new(device, name, bytes, Location::Device);
        let progress_read = || {
            let bytes = size_of::<ProgressRecord>() as u64;
            Buffer::new(device, "progress read-back", bytes, Location::Readback)
        };
        let tracer = Self {
            advance: compute(&kernels::PATH_ADVANCE, &constants)?,
            trace: trace(&kernels::PATH_TRACE, params.culling)?,
            shade: compute(&kernels::PATH_SHADE, &shading)?,
            shadow: trace(&kernels::PATH_SHADOW, params.culling.unseen())?,
            params,
            camera_solids: [(0, 1.0); CAPACITY],
            size,
            film: buffer("film", pixels * size_of::<FilmPixel>() as u64)?,
            first_hit: buffer("first hits", pixels * size_of::<FirstHitPixel>() as u64)?,
            dropped: buffer("dropped samples", 4)?,
            progress: Buffer::from_slice(device, "progress", &[no_progress(device)])?,
            progress_read: [progress_read()?, progress_read()?],
            paths: buffer("paths", slots * slot_bytes)?,
        };
        tracer.set(&FilmState::zero(size))?;
        Ok(tracer)
    }

    /// Sets the solids that the camera is inside of; none by default.
    pub(crate) fn set_camera_interior(&mut self, interior: &InteriorList) {
        self.camera_solids = [(0, 1.0); CAPACITY];
        for (place, solid) in self.camera_solids.iter_mut().zip(interior.solids()) {
            // As make_solid() of interior.glsl.
            *place = ((solid.material + 1) << 8 | solid.priority.min(255), solid.ior);
        }
    }

    /// Replaces the sums, to resume a render; waits for the device.
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

    /// Whether the samples of all pixels of the tile are complete after the iterations of the frame with this index. Known when that frame is
    /// finished, until the next but one is submitted.
    pub fn is_done(&self, frame: u32) -> bool {
        let progress = &self.progress_read[frame as usize % FRAMES_IN_FLIGHT];
        progress.mapped::<ProgressRecord>().iter().all(|progress| progress.done != 0)
    }

    /// Records the passes of some iterations: four each.
    ///
    /// # Errors
    /// When a pass does not fit into the frame.
    ///
    /// # Panics
    /// When there are too many samples: a slot has 18 bits for the number of its own.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        uniforms: &Uniforms<FrameRecord>,
        Iterations { tile, samples, iterations }: Iterations,
    ) -> Result<()> {
        assert!(samples.len() < 1 << 18, "too many samples");
        let [across, down] = tile.blocks();
        let blocks = [across * BLOCK[0], down * BLOCK[1], 1];
        let slots = [blocks[0] * blocks[1], 1, 1];
        for iteration in iterations {
            let push = PathPush { iteration, ..self.push(tile, &samples) };
            let [read, shadow] = [iteration & 1, records::LIST_SHADOW];

            let pass = frame.pass("path advance", &self.advance).read("frame_uniforms", uniforms.buffer());
            let pass = pass.addresses_updated(&self.paths).addresses_updated(&self.progress);
            let pass = pass.addresses_updated(&self.film).addresses_updated(&self.dropped).push(&push);
            // The last iteration of another tile said nothing about this one.
            if iteration == 0 {
                pass.dispatch(slots)?;
            } else {
                let groups = offset_of!(ProgressRecord, advance_groups) as u64;
                pass.dispatch_indirect(slots, &self.progress, groups)?;
            }

            let pass = frame.pass("path trace", &self.trace).read("frame_uniforms", uniforms.buffer());
            let pass = scene.bind(pass).addresses_updated(&self.paths).addresses_updated(&self.progress);
            let groups = groups_of(read, offset_of!(RayListHead, groups));
            pass.push(&push).dispatch_indirect(blocks, &self.progress, groups)?;

            let pass = frame.pass("path shade", &self.shade).read("frame_uniforms", uniforms.buffer());
            let pass = scene.bind(pass);
            let pass = pass.addresses_updated(&self.paths).addresses_updated(&self.progress);
            let pass = pass.addresses_updated(&self.first_hit).push(&push);
            let groups = groups_of(read, offset_of!(RayListHead, shading_groups));
            pass.dispatch_indirect(slots, &self.progress, groups)?;

            let pass = scene.bind(frame.pass("path shadow", &self.shadow));
            let pass = pass.addresses_updated(&self.paths).addresses_updated(&self.progress).push(&push);
            let groups = groups_of(shadow, offset_of!(RayListHead, groups));
            pass.dispatch_indirect(blocks, &self.progress, groups)?;
        }
        let progress_read = &self.progress_read[frame.index() as usize % FRAMES_IN_FLIGHT];
        frame.download(&self.progress, progress_read)
    }

    fn push(&self, tile: Tile, samples: &Range<u32>) -> PathPush {
        let params = &self.params;
        PathPush {
            film: self.film.address(),
            first_hit: self.first_hit.address(),
            dropped: self.dropped.address(),
            progress: self.progress.address(),
            paths: self.paths.address(),
            tile_origin: UVec2::from_array(tile.origin),
            tile_size: UVec2::from_array(tile.size),
            first_sample: samples.start,
            sample_count: samples.end - samples.start,
            max_bounces: params.max_bounces.unwrap_or(u32::MAX),
            roulette_start: params.roulette_start,
            emission: u32::from(params.light_types.emissive),
            heuristic: params.heuristic.code(),
            strategy: params.strategy.code(),
            clamp: params.clamp,
            camera_solids: UVec4::from_array(self.camera_solids.map(|(word, _)| word)),
            camera_iors: Vec4::from_array(self.camera_solids.map(|(_, ior)| ior)),
            log2_spp: params.spp.max(1).next_power_of_two().trailing_zeros(),
            iteration: 0,
        }
    }
}

/// Whether threads are sorted by material before they shade. A CPU samples a texture for all its lanes at once or for one lane after
/// the other: sorting saves a sixth of shading. On a GPU (NVIDIA H200) it costs as much.
fn sorts_by_material(device: &Device, scene: &GpuScene) -> bool {
    device.info().is_cpu() && scene.features() & FEATURES_TEXTURE != 0
}

/// About what a GPU has threads for at a time.
const WIDE_DEVICE: u32 = 65536;

/// Where in the progress record the workgroups of a launch over a list stand.
fn groups_of(list: u32, member: usize) -> u64 {
    (offset_of!(ProgressRecord, lists) + list as usize * size_of::<RayListHead>() + member) as u64
}

/// Nothing listed.
fn no_progress(device: &Device) -> ProgressRecord {
    let none = RayListHead { count: 0, groups: UVec3::ONE, shading_groups: UVec3::ONE, taken: 0 };
    let few_paths = if device.info().is_cpu() { 0 } else { WIDE_DEVICE };
    ProgressRecord { lists: [none; 3], advance_groups: UVec3::ONE, sweep: 0, done: 0, few_paths }
}

/// The kinds of light that count and that the scene has.
fn kinds(params: &ReferenceParams, lights: &LightTables) -> u32 {
    let (lists, types) = (lights.lists(), params.light_types);
    let bit = |on: bool, kind: u32| if on { kind } else { 0 };
    bit(types.sun && lists.sun_count > 0, KIND_SUN)
        | bit(types.positional && lists.lights.len() > lists.sun_count as usize, KIND_POSITIONAL)
        | bit(types.emissive && !lists.emissives.is_empty(), KIND_EMISSIVE)
        | bit((types.positional || types.emissive) && !lists.local.is_empty(), KIND_LOCAL)
        | bit(types.environment && lists.environment_alias.is_some(), KIND_ENVIRONMENT)
}
