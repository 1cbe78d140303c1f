//! Renders for the tests.

use pt_core::channels::field_width;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_lights::LightTables;
use pt_reference::{Estimate, FilmState, Progressive, ReferenceParams};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, Scene};
use pt_shaders::glam::UVec2;
use pt_shaders::records::FrameRecord;
use std::ops::Range;

/// A scene on the device, to be rendered several times.
pub struct Stage<'a> {
    pub device: &'a TestDevice,
    pub scene: Scene,
    gpu: GpuScene,
    lights: LightTables,
}

impl<'a> Stage<'a> {
    pub fn new(device: &'a TestDevice, scene: Scene) -> Self {
        Self::on(device, scene, TraceBackend::Compute)
    }

    pub fn on(device: &'a TestDevice, scene: Scene, backend: TraceBackend) -> Self {
        let mut gpu = GpuScene::new(device, &scene, backend).unwrap();
        let lights = LightTables::new(device, &scene).unwrap();
        lights.fill(gpu.record_mut());
        Self { device, scene, gpu, lights }
    }

    /// The sums over `samples`.
    pub fn state(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        params: &ReferenceParams,
        seed: u32,
        samples: Range<u32>,
    ) -> FilmState {
        let record = camera_record(camera, size);
        let frame = FrameRecord {
            camera: record,
            camera_prev: record,
            size: UVec2::from_array(size),
            field_width: field_width(size[0]),
            frame_index: 0,
            seed,
            pad: [0; 3],
        };
        let mut render =
            Progressive::new(self.device, &self.gpu, frame, params.clone(), None, samples.start).unwrap();
        while render.next_sample() < samples.end {
            render.step(&self.scene, &mut self.gpu, &self.lights, samples.end).unwrap();
        }
        render.state().unwrap()
    }

    /// The image from `spp` samples.
    pub fn render(&mut self, camera: &Camera, size: [u32; 2], params: &ReferenceParams, seed: u32, spp: u32) -> Estimate {
        self.state(camera, size, params, seed, 0..spp).estimate(spp)
    }
}
