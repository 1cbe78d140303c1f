use crate::records::PrimaryPush;
use crate::{GbufferParams, Jitter, frame_jitter, kernels};
use pt_core::frame::Uniforms;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, Frame, Kernel};
use pt_scene::gpu::GpuScene;
use pt_shaders::channels::{self, ChannelId};
use pt_shaders::records::{FrameRecord, MASK_OPAQUE, MASK_TRANSMISSIVE};

/// The primary ray stage.
pub struct PrimaryRays {
    kernel: Kernel,
}

impl PrimaryRays {
    /// Channels that the stage writes.
    pub const WRITES: &[ChannelId] = &[
        channels::RNG_SEED,
        channels::VISIBILITY,
        channels::BARYCENTRICS,
        channels::CLUSTER,
        channels::BASE_COLOR,
        channels::METALLIC_ROUGHNESS,
        channels::NORMAL,
        channels::VERTEX_NORMAL,
        channels::VIEW_DEPTH,
        channels::MOTION,
        channels::SHADING_POSITION,
        channels::VIEW_DIRECTION,
        channels::THROUGHPUT,
        channels::BOUNCE_THROUGHPUT,
        channels::TRANSPARENT,
    ];

    /// Compiles the kernel for a trace backend.
    pub fn new(device: &Device, backend: TraceBackend) -> pt_core::Result<Self> {
        Ok(Self { kernel: Kernel::trace::<PrimaryPush>(device, &kernels::PRIMARY_RAYS, backend, &[])? })
    }

    /// Records the pass.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        uniforms: &Uniforms<FrameRecord>,
        images: &ChannelImages,
        params: &GbufferParams,
    ) -> pt_core::Result<()> {
        let [width, height] = images.size();
        let push = PrimaryPush {
            jitter: frame_jitter(params.jitter, frame.index()).into(),
            jitter_per_pixel: u32::from(params.jitter == Jitter::Pixel),
            lod_scale: params.texture_lod_bias.exp2(),
            mask: MASK_OPAQUE | MASK_TRANSMISSIVE,
        };
        let pass = frame.pass("primary rays", &self.kernel).read("frame_uniforms", uniforms.buffer());
        scene.bind(pass).writes(images, Self::WRITES).push(&push).dispatch([
            2 * pt_core::channels::field_width(width),
            height,
            1,
        ])
    }
}
