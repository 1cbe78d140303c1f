//! The inputs of every stage as one value: scene, frame uniforms, images.

use crate::channels::ChannelImages;
use crate::frame::{Frame, Pass, Uniforms};
use crate::image::Image;
use crate::kernel::Kernel;
use crate::plan::StageIo;
use pt_shaders::channels::{COLOR_HF, COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC};
use pt_shaders::records::FrameRecord;

/// A scene on the device with its lights: everything that kernels access through `scene.glsl` and `trace.glsl`.
pub trait SceneResources {
    /// Binds it to a pass.
    fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r>;
}

/// Demodulated light of the split frame (divided by the reflectance of the surface): the lighting stages compute it, a denoiser
/// filters it, and the composite turns it into radiance. Its consumer does not name the producer's channels.
#[derive(Clone, Copy)]
pub struct SplitLight<'a> {
    /// High-frequency diffuse light: irradiance / pi, linear radiance.
    pub hf: &'a Image,
    /// Specular light divided by `max(0.01, F0)`, linear radiance.
    pub spec: &'a Image,
    /// Indirect diffuse light, if there is any.
    pub lf: Option<LowFrequencyLight<'a>>,
}

/// Low-frequency diffuse light as `sh.glsl` stores it: irradiance, for any normal.
#[derive(Clone, Copy)]
pub struct LowFrequencyLight<'a> {
    /// Luma in spherical harmonics.
    pub sh: &'a Image,
    /// Chroma.
    pub cocg: &'a Image,
}

impl<'a> SplitLight<'a> {
    /// The output of the lighting stages, not denoised; indirect diffuse light where its channels are allocated.
    pub fn unfiltered(images: &'a ChannelImages) -> Self {
        let lf = match (images.get(COLOR_LF_SH), images.get(COLOR_LF_COCG)) {
            (Ok(sh), Ok(cocg)) => Some(LowFrequencyLight { sh, cocg }),
            _ => None,
        };
        Self { hf: images.current(COLOR_HF), spec: images.current(COLOR_SPEC), lf }
    }

    /// The images that [`SplitLight::unfiltered`] returns of direct light.
    pub const UNFILTERED: StageIo =
        StageIo { reads: &[COLOR_HF, COLOR_SPEC], ..StageIo::of("denoiser: off") };

    /// The images that [`SplitLight::unfiltered`] returns of direct and indirect light.
    pub const UNFILTERED_INDIRECT: StageIo = StageIo {
        reads: &[COLOR_HF, COLOR_SPEC, COLOR_LF_SH, COLOR_LF_COCG],
        ..StageIo::of("denoiser: off")
    };
}

/// The inputs of every stage: the scene with its lights, the frame uniforms, the images.
#[derive(Clone, Copy)]
pub struct StageInputs<'a> {
    /// `None` in a replay, which has no scene.
    pub scene: Option<&'a dyn SceneResources>,
    /// Camera, size, frame index and seed; `None` if no kernel uses them.
    pub uniforms: Option<&'a Uniforms<FrameRecord>>,
    /// Channels and private images.
    pub images: &'a ChannelImages,
}

impl<'a> StageInputs<'a> {
    /// For stages that need only images.
    pub fn new(images: &'a ChannelImages) -> Self {
        Self { scene: None, uniforms: None, images }
    }

    /// Begins a pass of a stage: binds the images of the stage's declaration, and scene and frame uniforms if the kernel uses
    /// them.
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

    /// One thread per texel of the split frame.
    pub fn split_threads(&self) -> [u32; 3] {
        let [width, height] = crate::split::split_size(self.images.size());
        [width, height, 1]
    }

    /// One thread per pixel of the flat frame.
    pub fn flat_threads(&self) -> [u32; 3] {
        let [width, height] = self.images.size();
        [width, height, 1]
    }
}
