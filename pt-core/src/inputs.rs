//! What every stage of a frame needs, as one value.

use crate::channels::ChannelImages;
use crate::frame::{Frame, Pass, Uniforms};
use crate::image::Image;
use crate::kernel::Kernel;
use crate::plan::StageIo;
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};
use pt_shaders::records::FrameRecord;

/// A scene on the device, with its lights: all that kernels find through `scene.glsl` and `trace.glsl`.
pub trait SceneResources {
    /// Binds it to a pass.
    fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r>;
}

/// Light of the split frame, divided by the reflectance of the surface: what the lighting stages make, a denoiser filters,
/// and the composite puts together. Who made it does not matter to who takes it.
#[derive(Clone, Copy)]
pub struct SplitLight<'a> {
    /// High-frequency diffuse light: irradiance / pi, linear radiance.
    pub hf: &'a Image,
    /// Specular light divided by `max(0.01, F0)`, linear radiance.
    pub spec: &'a Image,
}

impl<'a> SplitLight<'a> {
    /// What the lighting stages wrote, not filtered.
    pub fn unfiltered(images: &'a ChannelImages) -> Self {
        Self { hf: images.current(COLOR_HF), spec: images.current(COLOR_SPEC) }
    }

    /// The images that [`SplitLight::unfiltered`] hands on.
    pub const UNFILTERED: StageIo =
        StageIo { reads: &[COLOR_HF, COLOR_SPEC], ..StageIo::of("denoiser: off") };
}

/// What every stage of a frame needs: the scene with its lights, the frame's uniforms, its images.
#[derive(Clone, Copy)]
pub struct StageInputs<'a> {
    /// `None` in a replay, which has no scene.
    pub scene: Option<&'a dyn SceneResources>,
    /// Camera, size, frame index and seed; `None` where no kernel asks for them.
    pub uniforms: Option<&'a Uniforms<FrameRecord>>,
    /// Channels and private images.
    pub images: &'a ChannelImages,
}

impl<'a> StageInputs<'a> {
    /// For stages that work from images alone.
    pub fn new(images: &'a ChannelImages) -> Self {
        Self { scene: None, uniforms: None, images }
    }

    /// Declares a pass of a stage: binds what the stage's declaration names, and scene and frame uniforms where the kernel
    /// asks for them.
    pub fn pass<'f, 'r>(
        &self,
        frame: &'f mut Frame<'r>,
        name: &str,
        kernel: &'f Kernel,
        io: &StageIo,
    ) -> Pass<'f, 'r> {
        let mut pass = frame.pass(name, kernel).touches(self.images, io);
        if let (true, Some(uniforms)) = (kernel.has_binding("frame_uniforms"), self.uniforms) {
            pass = pass.read("frame_uniforms", uniforms.buffer());
        }
        match (kernel.has_binding("scene_uniforms"), self.scene) {
            (true, Some(scene)) => scene.bind(pass),
            _ => pass,
        }
    }

    /// Threads for one each of the split frame's texels.
    pub fn split_threads(&self) -> [u32; 3] {
        let [width, height] = crate::split::split_size(self.images.size());
        [width, height, 1]
    }

    /// Threads for one each of the flat frame's pixels.
    pub fn flat_threads(&self) -> [u32; 3] {
        let [width, height] = self.images.size();
        [width, height, 1]
    }
}
