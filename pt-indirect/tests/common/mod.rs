//! Frames of primary rays and indirect lighting.

use glam::{DVec3, Vec3};
use pt_core::frame::Uniforms;
use pt_core::pack::unpack_unit_vector;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::{GbufferParams, PrimaryRays};
use pt_indirect::oracle::ShLight;
use pt_indirect::{BounceLights, IndirectLighting, IndirectParams};
use pt_light_sampling::{LightTables, SamplerChoice};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, Scene};
use pt_shaders::channels::*;
use pt_shaders::records::{FrameRecord, LightSampler};

/// What a frame says of a texel of the split frame.
#[derive(Clone, Copy)]
pub struct Texel {
    /// `None`: no surface.
    pub position: Option<DVec3>,
    /// Diffuse light at its shading normal.
    pub irradiance: DVec3,
    /// Demodulated.
    pub specular: DVec3,
}

/// The stages with their scene and images.
pub struct Rig {
    scene: Scene,
    /// Of frames in turn. Frames take their camera for that of the last frame as well: motion is 0, and the past of a pixel is another place.
    pub cameras: Vec<Camera>,
    gpu: GpuScene,
    lights: LightTables,
    primary: PrimaryRays,
    stage: IndirectLighting,
    params: IndirectParams,
    pub images: ChannelImages,
    uniforms: Uniforms<FrameRecord>,
    recorder: Recorder,
    size: [u32; 2],
}

impl Rig {
    pub fn new(
        device: &TestDevice,
        scene: Scene,
        camera: Camera,
        size: [u32; 2],
        params: &IndirectParams,
    ) -> Self {
        let sampler = LightSampler::Power;
        let mut gpu = GpuScene::new(device, &scene, TraceBackend::Compute).unwrap();
        let mut lights = LightTables::new(device, &scene).unwrap();
        lights.prepare(device, &scene, &mut gpu, Some(SamplerChoice::from(sampler))).unwrap();
        let bounce_lights = BounceLights::all(sampler);
        let stages = [vec![PrimaryRays::IO], IndirectLighting::io(params)].concat();
        Self {
            primary: PrimaryRays::new(device, gpu.variant()).unwrap(),
            stage: IndirectLighting::new(device, gpu.variant(), bounce_lights, params, 4).unwrap(),
            images: ChannelImages::alone(device, FrameSizes::same(size), &stages).unwrap(),
            uniforms: Uniforms::new(device, "frame_uniforms").unwrap(),
            recorder: Recorder::new(device).unwrap(),
            params: params.clone(),
            scene,
            cameras: vec![camera],
            gpu,
            lights,
            size,
        }
    }

    pub fn frame(&mut self, index: u32, seed: u32) -> Vec<Texel> {
        self.images.begin_frame();
        let specular = self.images.current(COLOR_SPEC);
        specular.write(&vec![0u8; specular.bytes() as usize]).unwrap();
        let mut frame = self.recorder.begin().unwrap();
        self.lights.update(&mut frame, &self.scene, &mut self.gpu).unwrap();
        let camera = camera_record(&self.cameras[index as usize % self.cameras.len()], self.size);
        self.uniforms.upload(&mut frame, &FrameRecord::new(camera, camera, self.size, index, seed)).unwrap();
        let inputs =
            StageInputs { scene: Some(&self.gpu), uniforms: Some(&self.uniforms), images: &self.images };
        self.primary.record(&mut frame, &inputs, &GbufferParams::default()).unwrap();
        self.stage.record(&mut frame, &inputs, &self.params, 0.0).unwrap();
        frame.submit().unwrap();
        self.recorder.finish().unwrap();
        self.texels()
    }

    fn texels(&self) -> Vec<Texel> {
        let floats = |id| self.images.current(id).read_f32().unwrap();
        let [sh, cocg, spec, positions] =
            [COLOR_LF_SH, COLOR_LF_COCG, COLOR_SPEC, SHADING_POSITION].map(floats);
        let normals = self.images.current(NORMAL).read_u32().unwrap();
        let vector = |values: &[f32], i: usize| Vec3::from_slice(&values[4 * i..]).as_dvec3();
        let texel = |i: usize| {
            let chroma = [cocg[2 * i], cocg[2 * i + 1]].map(f64::from);
            let light = ShLight { luma1: vector(&sh, i), luma0: sh[4 * i + 3].into(), chroma };
            let is_surface = positions[4 * i + 3].to_bits() != 0;
            Texel {
                position: is_surface.then(|| vector(&positions, i)),
                irradiance: light.irradiance(unpack_unit_vector(normals[i]).as_dvec3()),
                specular: vector(&spec, i),
            }
        };
        (0..normals.len()).map(texel).collect()
    }
}
