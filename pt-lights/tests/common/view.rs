//! Direct lighting of what a camera sees, without the stages before it: primary visibility by brute force on the CPU.

use glam::{UVec2, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::pack::pack_unit_vector;
use pt_core::random::RandomSource;
use pt_core::split::{to_flat, to_split};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::trace::TraceVariant;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_light_sampling::LightTables;
use pt_light_sampling::test_support::Uploaded;
use pt_lights::{Counted, DirectLighting, DirectParams};
use pt_scene::gpu::camera_record;
use pt_scene::{Camera, Scene};
use pt_shaders::channels::{
    BASE_COLOR, CLUSTER, COLOR_HF, COLOR_SPEC, METALLIC_ROUGHNESS, MOTION, NORMAL, RNG_SEED,
    SHADING_POSITION, VERTEX_NORMAL, VIEW_DIRECTION,
};
use pt_shaders::records::FrameRecord;

/// F0 of a dielectric of index 1.5.
const F0: f32 = 0.04;

/// What a pixel shows.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub position: Vec3,
    pub normal: Vec3,
    pub to_viewer: Vec3,
    pub material: u32,
}

/// The surfaces that a camera sees, in scan-line order.
pub fn look(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Vec<Option<Surface>> {
    let mut triangles = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        triangles.extend((0..mesh.triangle_count()).map(|t| {
            let corners = mesh.triangle(t).map(|p| instance.world_from_object.transform_point3(p));
            (corners, mesh.triangle_materials[t])
        }));
    }
    let record = camera_record(camera, size);
    let eye = record.world_from_view.transform_point3(Vec3::ZERO);
    let pixel = |i: u32| {
        let at = glam::Vec2::new((i % size[0]) as f32 + 0.5, (i / size[0]) as f32 + 0.5);
        let uv = at / UVec2::from_array(size).as_vec2();
        let plane = glam::Vec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y) * record.half_extent;
        let d = record.world_from_view.transform_vector3(Vec3::new(plane.x, plane.y, -1.0)).normalize();
        let hits = triangles.iter().filter_map(|([a, b, c], material)| {
            let (e1, e2) = (b - a, c - a);
            let p = d.cross(e2);
            let determinant = e1.dot(p);
            let s = eye - a;
            let u = s.dot(p) / determinant;
            let q = s.cross(e1);
            let v = d.dot(q) / determinant;
            let t = e2.dot(q) / determinant;
            let normal = e1.cross(e2).normalize_or_zero();
            let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-3;
            inside.then_some((t, normal * -normal.dot(d).signum(), *material))
        });
        let (t, normal, material) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Surface { position: eye + t * d, normal, to_viewer: -d, material })
    };
    (0..size[0] * size[1]).map(pixel).collect()
}

/// Frames of direct lighting, one after another.
pub struct View<'d> {
    pub uploaded: Uploaded,
    pub stage: DirectLighting,
    pub params: DirectParams,
    pub images: ChannelImages,
    pub seed: u32,
    size: [u32; 2],
    index: u32,
    uniforms: Uniforms<FrameRecord>,
    recorder: Recorder,
    albedo: Vec<Vec3>,
    counted: Counted,
    device: &'d TestDevice,
}

fn unorm16(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(|v| ((v * 65535.0).round() as u16).to_le_bytes()).collect()
}

impl<'d> View<'d> {
    pub fn new(device: &'d TestDevice, scene: Scene, params: DirectParams, size: [u32; 2]) -> Self {
        let room = scene.lights.len();
        Self::with(device, scene, params, size, RandomSource::White, room)
    }

    /// With that source of random numbers, and room for that many punctual lights.
    pub fn with(
        device: &'d TestDevice,
        scene: Scene,
        params: DirectParams,
        size: [u32; 2],
        random: RandomSource,
        room: usize,
    ) -> Self {
        let mut uploaded = Uploaded::new(device, scene, TraceBackend::Compute);
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        *lights = LightTables::with_room(device, scene, room).unwrap();
        lights.keep_last_frame(params.replays());
        lights.prepare(device, scene, gpu, params.sampler_choice()).unwrap();
        let variant = TraceVariant { random, ..uploaded.gpu.variant() };
        let stage = DirectLighting::new(device, variant, &params).unwrap();
        let io = DirectLighting::io(&params);
        let images = ChannelImages::alone(device, FrameSizes::same(size), &io).unwrap();
        let mut view = Self {
            images,
            stage,
            params,
            seed: 1,
            size,
            index: 0,
            uniforms: Uniforms::new(device, "frame_uniforms").unwrap(),
            recorder: Recorder::new(device).unwrap(),
            albedo: Vec::new(),
            counted: Counted::new(device, (2 * field_width(size[0]) * size[1]) as usize).unwrap(),
            device,
            uploaded,
        };
        if io.iter().any(|io| io.reads.contains(&MOTION)) {
            view.set_motion(|_, _| [0.0; 2]);
        }
        view
    }

    /// Shows these surfaces, in scan-line order.
    pub fn show(&mut self, flat: &[Option<Surface>]) {
        let Uploaded { scene, gpu, .. } = &self.uploaded;
        let surfaces = to_split(flat, self.size, None);
        let material = |s: &Surface| &scene.materials[s.material as usize];
        let write = |id, bytes: Vec<u8>| self.images.current(id).write(&bytes).unwrap();
        let words = |f: &dyn Fn(&Surface) -> Vec<u32>| -> Vec<u8> {
            let nothing = vec![0; f(&NOTHING).len()];
            let all = surfaces.iter().flat_map(|s| s.as_ref().map_or(nothing.clone(), f));
            all.flat_map(u32::to_le_bytes).collect()
        };
        const NOTHING: Surface =
            Surface { position: Vec3::ZERO, normal: Vec3::ZERO, to_viewer: Vec3::ZERO, material: 0 };
        write(
            SHADING_POSITION,
            words(&|s| {
                let p = s.position;
                vec![p.x.to_bits(), p.y.to_bits(), p.z.to_bits(), s.material + 1]
            }),
        );
        write(NORMAL, words(&|s| vec![pack_unit_vector(s.normal)]));
        write(VERTEX_NORMAL, words(&|s| vec![pack_unit_vector(s.normal)]));
        write(VIEW_DIRECTION, words(&|s| vec![pack_unit_vector(-s.to_viewer), 1]));
        let clusters =
            surfaces.iter().map(|s| s.map_or(u16::MAX, |s| gpu.clusters().find(s.position) as u16));
        write(CLUSTER, clusters.flat_map(u16::to_le_bytes).collect());
        let base = |s: &Option<Surface>| s.as_ref().map_or(Vec3::ZERO, |s| material(s).base_color.truncate());
        write(BASE_COLOR, unorm16(surfaces.iter().flat_map(|s| base(s).extend(F0).to_array())));
        let rough =
            surfaces.iter().flat_map(|s| s.as_ref().map_or([0.0; 2], |s| [0.0, material(s).roughness]));
        write(METALLIC_ROUGHNESS, unorm16(rough));
        self.albedo = flat.iter().map(base).collect();
    }

    /// Motion of every flat pixel, in pixels: previous minus current position.
    pub fn set_motion(&mut self, motion: impl Fn(u32, u32) -> [f32; 2]) {
        let [width, height] = self.size;
        let flat: Vec<[f32; 4]> = (0..width * height)
            .map(|i| {
                let [x, y] = motion(i % width, i / width);
                [x / width as f32, y / height as f32, 0.0, 0.0]
            })
            .collect();
        let split = to_split(&flat, self.size, [0.0; 4]);
        self.images.current(MOTION).write(bytemuck::cast_slice(&split)).unwrap();
    }

    /// The next frame has no history.
    pub fn reset(&mut self) {
        self.images.reset_history();
        self.index = 0;
    }

    /// The same, and light tables are new.
    pub fn restart(&mut self) {
        let Uploaded { scene, lights, gpu } = &mut self.uploaded;
        lights.prepare(self.device, scene, gpu, self.params.sampler_choice()).unwrap();
        self.reset();
    }

    /// Radiance of every flat pixel of the next frame, luminance.
    pub fn frame(&mut self) -> Vec<f64> {
        self.frame_with(|_| false)
    }

    /// The same; the pixels (numbers in scan-line order) for which `is_gradient` holds have the random seed of the last frame.
    pub fn frame_with(&mut self, is_gradient: impl Fn(u32) -> bool) -> Vec<f64> {
        let [width, height] = self.size;
        let seed = |i: u32| [(i % width) | ((i / width) << 16), self.index - u32::from(is_gradient(i))];
        let keys: Vec<[u32; 2]> = (0..width * height).map(seed).collect();
        let split = to_split(&keys, self.size, [0; 2]);
        self.images.current(RNG_SEED).write(bytemuck::cast_slice(&split)).unwrap();
        self.images.begin_frame();
        let mut frame = self.recorder.begin().unwrap();
        let record = FrameRecord {
            size: self.size.into(),
            field_width: field_width(width),
            frame_index: self.index,
            seed: self.seed,
            ..bytemuck::Zeroable::zeroed()
        };
        self.uniforms.upload(&mut frame, &record).unwrap();
        let Uploaded { scene, lights, gpu } = &mut self.uploaded;
        lights.update(&mut frame, scene, gpu).unwrap();
        let inputs = StageInputs { scene: Some(&*gpu), uniforms: Some(&self.uniforms), images: &self.images };
        self.stage.record_counted(&mut frame, &inputs, &self.params, 0.0, Some(&self.counted)).unwrap();
        frame.submit().unwrap();
        self.recorder.finish().unwrap();
        self.index += 1;
        let read = |id| {
            let texels = self.images.current(id).read_f32().unwrap();
            let rgb: Vec<Vec3> = texels.chunks_exact(4).map(Vec3::from_slice).collect();
            to_flat(&rgb, self.size)
        };
        let light = read(COLOR_HF).into_iter().zip(read(COLOR_SPEC)).zip(&self.albedo);
        light.map(|((hf, spec), albedo)| pt_light_sampling::luminance(hf * *albedo + spec * F0)).collect()
    }

    /// The local light that each flat pixel of the last frame chose, and a hash of the point on it.
    pub fn choices(&self) -> Vec<[u32; 2]> {
        to_flat(&self.counted.choices().unwrap(), self.size)
    }

    pub fn device(&self) -> &'d TestDevice {
        self.device
    }
}
