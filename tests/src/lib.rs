//! Whole frames in the same process as the test, under the validation layers.

use pt_app::args::CameraArgs;
use pt_app::frame::FullFrame;
use pt_app::params::{FrameParams, resolve};
use pt_app::session::Session;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{Device, Kept, Recorder};
use pt_image::image_file::{ImageState, LinearImage};
use pt_import::LoadOptions;
use pt_scene::{Camera, Scene};
use pt_shaders::channels::ChannelId;

/// A built-in scene as `pt render` sees it.
///
/// # Panics
/// When there is none of this name.
pub fn builtin(name: &str) -> Scene {
    pt_import::open(name, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The default parameters without the denoiser.
pub fn without_denoiser() -> FrameParams {
    resolve(None, &["denoise.variant=off".into()], false).unwrap_or_else(|e| panic!("{e:#}"))
}

/// The same without bounces.
pub fn direct_light_only() -> FrameParams {
    let mut params = without_denoiser();
    params.indirect.bounces = 0.0;
    params
}

/// A scene that is rendered frame by frame. Its methods panic where a test has to fail.
pub struct Frames {
    session: Session,
    full: FullFrame,
    recorder: Recorder,
    camera: Camera,
    seed: u32,
    time: f64,
    params: FrameParams,
    // Dropped last: checks what the validation layers said.
    device: TestDevice,
}

impl Frames {
    /// On a [`TestDevice`], without the denoiser. With `accumulate` the frame has
    /// the pass that averages all frames.
    pub fn new(
        scene: Scene,
        camera: &Camera,
        backend: TraceBackend,
        size: [u32; 2],
        seed: u32,
        accumulate: bool,
    ) -> Self {
        Self::with_params(scene, camera, backend, size, seed, accumulate, without_denoiser())
    }

    /// As [`Frames::new`], with parameters of one's own.
    pub fn with_params(
        scene: Scene,
        camera: &Camera,
        backend: TraceBackend,
        size: [u32; 2],
        seed: u32,
        accumulate: bool,
        params: FrameParams,
    ) -> Self {
        Self::open(None, Kept::All, scene, camera, backend, size, seed, accumulate, params)
    }

    /// With the compute backend, whose kernels traverse as on a GPU or as on a CPU device ([`Device::with_gpu_traversal`]).
    pub fn with_gpu_traversal(
        gpu_traversal: bool,
        scene: Scene,
        camera: &Camera,
        size: [u32; 2],
        seed: u32,
        params: FrameParams,
    ) -> Self {
        let (traversal, backend) = (Some(gpu_traversal), TraceBackend::Compute);
        Self::open(traversal, Kept::All, scene, camera, backend, size, seed, false, params)
    }

    /// As [`Frames::with_params`], without the pass that averages frames. With [`Kept::Outputs`] images share memory.
    pub fn keeping(
        kept: Kept,
        scene: Scene,
        camera: &Camera,
        backend: TraceBackend,
        size: [u32; 2],
        seed: u32,
        params: FrameParams,
    ) -> Self {
        Self::open(None, kept, scene, camera, backend, size, seed, false, params)
    }

    #[expect(clippy::too_many_arguments, reason = "what its callers differ in")]
    fn open(
        gpu_traversal: Option<bool>,
        kept: Kept,
        scene: Scene,
        camera: &Camera,
        backend: TraceBackend,
        size: [u32; 2],
        seed: u32,
        accumulate: bool,
        params: FrameParams,
    ) -> Self {
        let device = TestDevice::open();
        let told = gpu_traversal.map(|gpu| device.with_gpu_traversal(gpu));
        let on: &Device = told.as_ref().unwrap_or(&device);
        let mut session =
            Session::on(on, backend, &CameraArgs::default(), scene).unwrap_or_else(|e| panic!("{e:#}"));
        let full = FullFrame::keeping(kept, &mut session, size, accumulate, &params)
            .unwrap_or_else(|e| panic!("{e}"));
        let recorder = Recorder::new(&session.device).unwrap_or_else(|e| panic!("{e}"));
        Self { session, full, recorder, camera: camera.clone(), seed, time: 0.0, params, device }
    }

    /// Starts over with another seed.
    pub fn restart(&mut self, seed: u32) {
        self.full.reset_history();
        self.seed = seed;
    }

    /// Of each plane: whether the last frame had a history.
    pub fn have_history(&self) -> Vec<bool> {
        self.full.planes().iter().map(|images| images.has_history()).collect()
    }

    /// Renders the next frame, at `time` seconds.
    pub fn render(&mut self, time: f64) {
        let mut frame = self.recorder.begin().unwrap();
        self.session.update(&mut frame, time, self.time).unwrap();
        self.time = time;
        let camera = self.camera.at(time);
        self.full.record(&mut frame, &self.session.gpu, &camera, self.seed, None, &self.params).unwrap();
        frame.submit().unwrap();
    }

    /// Bytes of the images of all planes.
    pub fn image_bytes(&self) -> u64 {
        self.full.planes().iter().map(|images| images.bytes()).sum()
    }

    /// Names of the allocations of device memory.
    pub fn allocations(&self) -> Vec<String> {
        self.session.device.memory_in_use().into_iter().map(|(name, _)| name).collect()
    }

    /// A channel of floats as the last frame left it.
    pub fn floats(&self, channel: ChannelId) -> Vec<f32> {
        self.full.images().current(channel).read_f32().unwrap()
    }

    /// A channel of integers.
    pub fn integers(&self, channel: ChannelId) -> Vec<u32> {
        self.full.images().current(channel).read_u32().unwrap()
    }

    /// All images of the frame.
    pub fn channels(&self) -> Vec<ChannelId> {
        self.full.images().ids().collect()
    }

    /// Red, green and blue of a channel of the flat frame.
    pub fn image(&self, channel: ChannelId) -> LinearImage {
        let [width, height] = self.full.images().size();
        let pixels = self.floats(channel).chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
        LinearImage { width, height, pixels, state: ImageState::SceneReferred }
    }

    /// Other values of knobs that are not structural, for the next frames.
    pub fn set_params(&mut self, params: FrameParams) {
        self.params = params;
    }

    /// Another camera for the next frames.
    pub fn set_camera(&mut self, camera: Camera) {
        self.camera = camera;
    }

    /// How rays are traced.
    pub fn backend(&self) -> TraceBackend {
        self.session.gpu.backend()
    }

    /// Names of the passes of the last frame; waits for it.
    pub fn passes(&mut self) -> Vec<String> {
        self.recorder.finish().unwrap();
        self.recorder.pass_table().iter().map(|pass| pass.name.clone()).collect()
    }

    /// The backends that the device has.
    pub fn backends(&self) -> Vec<TraceBackend> {
        TraceBackend::available(&self.session.device)
    }

    /// Waits for the last frame and fails if the validation layers said anything.
    pub fn finish(mut self) {
        self.recorder.finish().unwrap();
        drop(self.device);
    }
}
