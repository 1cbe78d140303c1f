//! The scene on the device, seen by one camera: what all samplers light.

use super::{Args, lamps};
use anyhow::{Context, Result, ensure};
use glam::{UVec2, Vec2, Vec3};
use pt_core::capture::folder::CaptureFolder;
use pt_core::frame::Uniforms;
use pt_core::trace::bench::{BenchOptions, default_size, rate};
use pt_core::trace::{RayKind, TraceBackend};
use pt_core::{ChannelImages, Device, DeviceOptions, FrameSizes, SplitLight, StageInputs, console};
use pt_core::{Frame, FramePlan};
use pt_denoise::{Composite, DenoiseParams};
use pt_gbuffer::{GbufferParams, PrimaryRays};
use pt_import::LoadOptions;
use pt_light_sampling::LightTables;
use pt_lights::{Counted, DirectLighting, DirectParams};
use pt_scene::gpu::{GpuScene, camera_record, mesh_geometry, placements};
use pt_scene::{BadTexels, Scene};
use pt_shaders::records::{CameraRecord, FrameRecord};
use std::path::Path;

/// Timed windows of the rate of shadow rays.
const RATE_WINDOWS: u32 = 5;

/// A scene and a camera.
pub struct View {
    pub device: Device,
    pub scene: Scene,
    pub gpu: GpuScene,
    pub lights: LightTables,
    pub images: ChannelImages,
    size: [u32; 2],
    camera: CameraRecord,
    uniforms: Uniforms<FrameRecord>,
    surface_uniforms: Uniforms<FrameRecord>,
    primary: PrimaryRays,
    composite: Composite,
    gbuffer: GbufferParams,
    /// Corners of the lamps that the program has hung into the scene.
    hung: Vec<[Vec3; 3]>,
}

impl View {
    /// Loads the scene, and the camera of the capture if there is one. `stages`: the direct lighting that is to be recorded.
    pub fn open(args: &Args, stages: &[DirectParams]) -> Result<Self> {
        let scene = args.scene.as_deref().unwrap_or_default();
        let folder = Path::new(scene);
        let recorded = folder.is_dir().then(|| recorded_view(folder)).transpose()?;
        let name = match (&recorded, &args.scene_file) {
            (Some(_), Some(file)) => file,
            (Some(capture), None) => &capture.scene,
            (None, _) => scene,
        };
        let options = LoadOptions {
            environment: args.env.clone(),
            bad_texels: BadTexels::clamp_if(args.env_clamp),
            ..LoadOptions::default()
        };
        let scene = pt_import::open(name, &options).with_context(|| {
            if recorded.is_some() { "the capture's scene; --scene-file names it" } else { "the scene" }
        })?;
        scene.notices.iter().for_each(|notice| console::print_warning(notice));
        let mut scene = scene;
        let hung = args.lamps.map(|count| lamps::hang(&mut scene, count)).transpose()?;
        let gbuffer = GbufferParams::default();
        let (camera, size) = match recorded {
            Some(Recorded { camera, size, .. }) => (camera, size),
            None => {
                let size = [args.width, (args.width * 9 / 16).max(1)];
                let camera = match args.camera {
                    Some(index) => {
                        let count = scene.cameras.len();
                        scene
                            .cameras
                            .get(index)
                            .cloned()
                            .with_context(|| format!("--camera {index}: the scene has {count} cameras"))?
                    }
                    None => scene.default_camera(),
                };
                (gbuffer.with_lens(camera_record(&camera, size)), size)
            }
        };
        let device = open_device(args)?;
        let view = Self::of_scene(device, scene, camera, size, args.backend, stages)?;
        Ok(Self { hung: hung.unwrap_or_default(), ..view })
    }

    /// Takes the pixels out of a mask, rows from the top, that may show a lamp which the program has hung up: so small that a pixel shows it now and then,
    /// and then it is bright.
    pub fn leave_out_lamps(&self, keep: &mut [bool]) {
        let is_perspective = self.camera.projection == 0;
        let size = UVec2::from_array(self.size).as_vec2();
        for corners in &self.hung {
            let seen = corners.map(|corner| self.camera.view_from_world.transform_point3(corner));
            if seen.iter().all(|corner| corner.z >= 0.0) {
                continue;
            }
            let pixel = seen.map(|corner| {
                let depth = if is_perspective { (-corner.z).max(1e-3) } else { 1.0 };
                let plane = Vec2::new(corner.x, corner.y) / depth / self.camera.half_extent;
                (Vec2::new(0.5 + 0.5 * plane.x, 0.5 - 0.5 * plane.y) * size)
                    .clamp(Vec2::splat(-2.0), size + 2.0)
            });
            // A pixel more on each side: samples of a pixel may lie beside it.
            let first = pixel[0].min(pixel[1]).min(pixel[2]).floor() - 1.0;
            let last = pixel[0].max(pixel[1]).max(pixel[2]).floor() + 1.0;
            let [first, last] = [first, last].map(|at| at.clamp(Vec2::ZERO, size - 1.0).as_uvec2());
            for y in first.y..=last.y {
                let row = (y * self.size[0]) as usize;
                keep[row + first.x as usize..=row + last.x as usize].fill(false);
            }
        }
    }

    /// A scene from a camera.
    pub fn of_scene(
        device: Device,
        scene: Scene,
        camera: CameraRecord,
        size: [u32; 2],
        backend: TraceBackend,
        stages: &[DirectParams],
    ) -> Result<Self> {
        let gbuffer = GbufferParams::default();
        let mut gpu = GpuScene::new(&device, &scene, backend)?;
        let lights = LightTables::new(&device, &scene)?;
        lights.attach(&mut gpu);
        let mut plan = FramePlan::new(FrameSizes::same(size));
        plan.stage(&PrimaryRays::IO)?;
        for io in stages.iter().flat_map(DirectLighting::io) {
            plan.stage(&io)?;
        }
        plan.stage(&SplitLight::UNFILTERED)?;
        plan.stage(&Composite::IO)?;
        Ok(Self {
            images: plan.allocate(&device)?,
            uniforms: Uniforms::new(&device, "frame_uniforms")?,
            surface_uniforms: Uniforms::new(&device, "frame_uniforms of surfaces")?,
            primary: PrimaryRays::new(&device, gbuffer.variant(gpu.variant()))?,
            composite: Composite::new(&device)?,
            device,
            scene,
            gpu,
            lights,
            size,
            camera,
            gbuffer,
            hung: Vec::new(),
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// A line for people.
    pub fn describe(&self) -> String {
        let lists = self.lights.lists();
        let info = self.device.info();
        format!(
            "{}, {}x{}: {} directional lights, {} positional lights, {} emissive triangles, {}; {}, {}, {}",
            self.scene.name,
            self.size[0],
            self.size[1],
            lists.sun_count,
            lists.lights.len() - lists.sun_count as usize,
            lists.emissives.len(),
            if lists.environment_alias.is_some() { "an environment" } else { "no environment" },
            info.name,
            info.driver_line(),
            self.gpu.backend(),
        )
    }

    /// The uniforms of a frame of a run.
    pub fn frame_record(&self, index: u32, seed: u32) -> FrameRecord {
        FrameRecord::new(self.camera, self.camera, self.size, index, seed)
    }

    /// Million shadow rays a second that the backend traces in this scene, as `pt bench trace` measures them.
    pub fn shadow_rate(&self) -> Result<f64> {
        let size = default_size(&self.device).map(|side| side / 2);
        let options = BenchOptions { size, windows: RATE_WINDOWS, seed: 0 };
        let (meshes, instances) = (mesh_geometry(&self.scene), placements(&self.scene));
        let rays = (self.gpu.backend(), RayKind::Shadow);
        Ok(rate(&self.device, (&meshes, &instances), &self.camera, rays, options)?)
    }

    /// Moves the scene to a time, from where it was at another (seconds); the camera stays.
    pub fn set_time(&mut self, now: f64, previous: f64) {
        self.scene.set_time(now, previous);
    }

    /// Records a frame up to its radiance, with these lights of the scene.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        record: &FrameRecord,
        lights: &mut LightTables,
        (stage, params): (&DirectLighting, &DirectParams),
        counted: Option<&Counted>,
    ) -> Result<()> {
        self.record_lit(frame, [record, record], lights, (stage, params), counted)
    }

    /// As [`View::record`], of surfaces that may be those of another frame, with its seeds: the first record.
    pub fn record_lit(
        &mut self,
        frame: &mut Frame<'_>,
        [surfaces, record]: [&FrameRecord; 2],
        lights: &mut LightTables,
        (stage, params): (&DirectLighting, &DirectParams),
        counted: Option<&Counted>,
    ) -> Result<()> {
        self.images.begin_frame();
        lights.update(frame, &self.scene, &mut self.gpu)?;
        self.surface_uniforms.upload(frame, surfaces)?;
        self.uniforms.upload(frame, record)?;
        let (scene, images) = (Some(&self.gpu as _), &self.images);
        let inputs = StageInputs { scene, uniforms: Some(&self.surface_uniforms), images };
        self.primary.record(frame, &inputs, &self.gbuffer)?;
        let inputs = StageInputs { uniforms: Some(&self.uniforms), ..inputs };
        stage.record_counted(frame, &inputs, params, 0.0, counted)?;
        let light = SplitLight::unfiltered(&self.images);
        Ok(self.composite.record(frame, &inputs, light, &DenoiseParams::default())?)
    }
}

/// The device that the arguments name.
pub fn open_device(args: &Args) -> Result<Device> {
    Ok(Device::open(&DeviceOptions { device: args.device.clone(), ..DeviceOptions::default() })?)
}

struct Recorded {
    scene: String,
    camera: CameraRecord,
    size: [u32; 2],
}

fn recorded_view(folder: &Path) -> Result<Recorded> {
    let reader = CaptureFolder::open(folder)?;
    let range = reader.range();
    ensure!(!range.is_empty(), "{}: the capture has no frame", folder.display());
    let record = reader.frame(range.start)?.sidecar.record();
    Ok(Recorded { scene: reader.index.scene.clone(), camera: record.camera, size: record.size.into() })
}
