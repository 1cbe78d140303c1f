//! A G-buffer that a test makes, and runs of frames of the direct lighting stage on it.

use glam::{UVec2, Vec2, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::pack::pack_unit_vector;
use pt_core::split::{split_size, split_to_flat, to_flat};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_light_sampling::test_support::Uploaded;
use pt_lights::{Counted, DirectLighting, DirectParams};
use pt_scene::Scene;
use pt_shaders::channels::*;
use pt_shaders::records::FrameRecord;

/// What the G-buffer holds at a pixel.
#[derive(Clone, Copy)]
pub struct Pixel {
    pub position: Vec3,
    pub normal: Vec3,
    /// Towards the viewer.
    pub view: Vec3,
    /// Distance from the viewer.
    pub depth: f32,
    pub base: [f32; 4],
    pub metallic: f32,
    pub roughness: f32,
    /// Previous minus current position on the screen, in UV.
    pub motion: Vec2,
}

impl Pixel {
    pub const LAMBERTIAN: Self = Self {
        position: Vec3::ZERO,
        normal: Vec3::Y,
        view: Vec3::Y,
        depth: 5.0,
        base: [0.5, 0.5, 0.5, 0.0],
        metallic: 0.0,
        roughness: 1.0,
        motion: Vec2::ZERO,
    };
}

fn unorm16(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(|v| ((v * 65535.0).round() as u16).to_le_bytes()).collect()
}

/// The stage with its scene and images.
pub struct Rig {
    pub uploaded: Uploaded,
    pub images: ChannelImages,
    pub params: DirectParams,
    /// Counts the rays of the frames from now on.
    pub counted: Option<Counted>,
    pub stage: DirectLighting,
    uniforms: Uniforms<FrameRecord>,
    recorder: Recorder,
    size: [u32; 2],
}

impl Rig {
    pub fn new(device: &TestDevice, scene: Scene, size: [u32; 2], params: &DirectParams) -> Self {
        Self::with_backend(device, scene, TraceBackend::Compute, size, params)
    }

    pub fn with_backend(
        device: &TestDevice,
        scene: Scene,
        backend: TraceBackend,
        size: [u32; 2],
        params: &DirectParams,
    ) -> Self {
        let mut uploaded = Uploaded::new(device, scene, backend);
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        lights.prepare(device, scene, gpu, params.sampler_choice()).unwrap();
        let stage = DirectLighting::new(device, gpu.variant(), params).unwrap();
        let io = DirectLighting::io(params);
        Self {
            images: ChannelImages::alone(device, FrameSizes::same(size), &io).unwrap(),
            uniforms: Uniforms::new(device, "frame_uniforms").unwrap(),
            recorder: Recorder::new(device).unwrap(),
            params: params.clone(),
            counted: None,
            uploaded,
            stage,
            size,
        }
    }

    /// The same images with another scene.
    pub fn replace_scene(&mut self, device: &TestDevice, scene: Scene) {
        self.uploaded = Uploaded::new(device, scene, TraceBackend::Compute);
        let Uploaded { scene, lights, gpu } = &mut self.uploaded;
        lights.prepare(device, scene, gpu, self.params.sampler_choice()).unwrap();
        self.stage = DirectLighting::new(device, gpu.variant(), &self.params).unwrap();
    }

    /// Records a frame without its surfaces, of which `updates` says whether the light tables are brought up to date, and gives it up: what the
    /// stage says of the tables.
    pub fn try_record(&mut self, updates: bool) -> pt_core::Result<()> {
        let mut frame = self.recorder.begin()?;
        let Uploaded { scene, lights, gpu } = &mut self.uploaded;
        if updates {
            lights.update(&mut frame, scene, gpu)?;
        }
        let inputs = StageInputs { scene: Some(&*gpu), uniforms: Some(&self.uniforms), images: &self.images };
        self.stage.record(&mut frame, &inputs, &self.params, 0.0)
    }

    fn flat_positions(&self) -> impl Iterator<Item = [u32; 2]> {
        let [width, height] = split_size(self.size);
        let field = field_width(self.size[0]);
        (0..height).flat_map(move |y| (0..width).map(move |x| split_to_flat([x, y], field)))
    }

    fn write(&self, id: ChannelId, bytes: &[u8]) {
        // A sampler without reuse has no use for some of them.
        if self.images.ids().any(|known| known == id) {
            self.images.current(id).write(bytes).unwrap();
        }
    }

    fn fill(&self, pixel: &dyn Fn([u32; 2]) -> Option<Pixel>) {
        let pixels: Vec<Option<Pixel>> = self.flat_positions().map(pixel).collect();
        let words = |f: &dyn Fn(&Pixel) -> Vec<u32>, none: &[u32]| -> Vec<u8> {
            let texel = |p: &Option<Pixel>| p.as_ref().map_or(none.to_vec(), f);
            pixels.iter().flat_map(texel).flat_map(u32::to_le_bytes).collect()
        };
        let solid = || pixels.iter().map(|p| p.unwrap_or(Pixel::LAMBERTIAN));
        self.write(BASE_COLOR, &unorm16(solid().flat_map(|p| p.base)));
        self.write(METALLIC_ROUGHNESS, &unorm16(solid().flat_map(|p| [p.metallic, p.roughness])));
        self.write(NORMAL, &words(&|p| vec![pack_unit_vector(p.normal)], &[0]));
        self.write(VERTEX_NORMAL, &words(&|p| vec![pack_unit_vector(p.normal)], &[0]));
        self.write(VIEW_DIRECTION, &words(&|p| vec![pack_unit_vector(-p.view), 1], &[0, 0]));
        self.write(VIEW_DEPTH, &words(&|p| vec![p.depth.to_bits()], &[1e18_f32.to_bits()]));
        let motion = |p: &Pixel| [p.motion.x, p.motion.y, 0.0, 0.0].map(f32::to_bits).to_vec();
        self.write(MOTION, &words(&motion, &[0; 4]));
        let position =
            |p: &Pixel| [p.position.x.to_bits(), p.position.y.to_bits(), p.position.z.to_bits(), 1].to_vec();
        self.write(SHADING_POSITION, &words(&position, &[0; 4]));
        let clusters = self.uploaded.gpu.clusters();
        let cluster: Vec<u8> =
            solid().flat_map(|p| (clusters.find(p.position) as u16).to_le_bytes()).collect();
        self.write(CLUSTER, &cluster);
    }

    /// One frame; `index` and `seed` are the arguments of its random numbers.
    pub fn frame(&mut self, index: u32, seed: u32, pixel: &dyn Fn([u32; 2]) -> Option<Pixel>) {
        self.images.begin_frame();
        self.fill(pixel);
        let keys: Vec<u8> = self
            .flat_positions()
            .flat_map(|[x, y]| [x | y << 16, index])
            .flat_map(u32::to_le_bytes)
            .collect();
        self.write(RNG_SEED, &keys);
        let mut frame = self.recorder.begin().unwrap();
        let mut record: FrameRecord = bytemuck::Zeroable::zeroed();
        record.size = UVec2::from_array(self.size);
        record.field_width = field_width(self.size[0]);
        record.seed = seed;
        self.uniforms.upload(&mut frame, &record).unwrap();
        let Uploaded { scene, lights, gpu } = &mut self.uploaded;
        lights.update(&mut frame, scene, gpu).unwrap();
        let inputs = StageInputs { scene: Some(&*gpu), uniforms: Some(&self.uniforms), images: &self.images };
        let counted = self.counted.as_ref();
        self.stage.record_counted(&mut frame, &inputs, &self.params, 0.0, counted).unwrap();
        frame.submit().unwrap();
        self.recorder.finish().unwrap();
    }

    /// The texels of a light channel, of the pixels in scan-line order.
    pub fn texels(&self, id: ChannelId) -> Vec<[f32; 4]> {
        let split: Vec<[f32; 4]> = self
            .images
            .current(id)
            .read_f32()
            .unwrap()
            .chunks_exact(4)
            .map(|t| [t[0], t[1], t[2], t[3]])
            .collect();
        to_flat(&split, self.size)
    }

    /// The light of a surface of albedo and F0 of a half, of the pixels in scan-line order.
    pub fn light(&self) -> Vec<f64> {
        let [hf, spec] = [COLOR_HF, COLOR_SPEC].map(|id| self.images.current(id).read_f32().unwrap());
        let [width, height] = self.size;
        let mut flat = vec![0.0; (width * height) as usize];
        let sums = hf.chunks_exact(4).zip(spec.chunks_exact(4)).map(|(a, b)| 0.5 * f64::from(a[1] + b[1]));
        for ([x, y], light) in self.flat_positions().zip(sums) {
            if x < width {
                flat[(y * width + x) as usize] = light;
            }
        }
        flat
    }
}
