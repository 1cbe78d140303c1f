use crate::LightTables;
use crate::records::DirectPush;
use pt_core::channels::field_width;
use pt_core::frame::{Pass, Uniforms};
use pt_core::settings::{InvalidValue, Validate};
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, Frame, Kernel, Result};
use pt_scene::gpu::GpuScene;
use pt_shaders::channels::{self, ChannelId};
use pt_shaders::records::{
    FrameRecord, KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_POSITIONAL, KIND_SUN, MASK_OPAQUE,
};
use serde::{Deserialize, Serialize};

/// Knobs of direct lighting. A kind of light that is off is not sampled, its light is missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DirectParams {
    /// Light of directional lights. Default true.
    pub sun: bool,
    /// Light of point and spot lights. Default true.
    pub positional: bool,
    /// Light of emissive triangles. Default true.
    pub emissive: bool,
    /// Light of the environment. Default true.
    pub environment: bool,
}

impl Default for DirectParams {
    fn default() -> Self {
        Self { sun: true, positional: true, emissive: true, environment: true }
    }
}

impl Validate for DirectParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        Ok(())
    }
}

impl DirectParams {
    /// The kernel's push constants.
    pub fn push(&self) -> DirectPush {
        let bit = |on: bool, kind: u32| if on { kind } else { 0 };
        DirectPush {
            kinds: bit(self.sun, KIND_SUN)
                | bit(self.positional, KIND_POSITIONAL)
                | bit(self.emissive, KIND_EMISSIVE)
                | bit(self.environment, KIND_ENVIRONMENT),
            mask: MASK_OPAQUE,
        }
    }
}

/// The direct lighting stage: one candidate and one shadow ray per pixel for each kind of light.
pub struct DirectLighting {
    kernel: Kernel,
}

impl DirectLighting {
    /// Channels that the stage reads.
    pub const READS: &[ChannelId] = &[
        channels::RNG_SEED,
        channels::BASE_COLOR,
        channels::METALLIC_ROUGHNESS,
        channels::NORMAL,
        channels::VERTEX_NORMAL,
        channels::SHADING_POSITION,
        channels::VIEW_DIRECTION,
    ];
    /// Channels that the stage writes.
    pub const WRITES: &[ChannelId] = &[channels::COLOR_HF, channels::COLOR_SPEC];

    /// Compiles the kernel for a trace backend.
    pub fn new(device: &Device, backend: TraceBackend) -> Result<Self> {
        Ok(Self { kernel: Kernel::trace::<DirectPush>(device, &crate::kernels::DIRECT, backend, &[])? })
    }

    /// Records the pass. `scene` is the scene that `lights` were listed from.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        lights: &LightTables,
        uniforms: &Uniforms<FrameRecord>,
        images: &ChannelImages,
        params: &DirectParams,
    ) -> Result<()> {
        let pass = frame.pass("direct lighting", &self.kernel).read("frame_uniforms", uniforms.buffer());
        Self::declare(scene.bind(pass), lights, images, params)
    }

    /// Declares what the pass touches besides scene and frame uniforms, and dispatches.
    fn declare(
        pass: Pass<'_, '_>,
        lights: &LightTables,
        images: &ChannelImages,
        params: &DirectParams,
    ) -> Result<()> {
        let [width, height] = images.size();
        lights
            .buffers()
            .into_iter()
            .fold(pass, Pass::addresses)
            .reads(images, Self::READS)
            .writes(images, Self::WRITES)
            .push(&params.push())
            .dispatch([2 * field_width(width), height, 1])
    }
}
