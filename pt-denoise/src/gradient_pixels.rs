//! Gradient pixels: before the light is computed.

use crate::DenoiseParams;
use crate::images::SURFACE;
use crate::kernels;
use crate::records::{GradientPixel, GradientPixelsPush, Projection};
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::{
    BARYCENTRICS, BASE_COLOR, CLUSTER, COLOR_HF, COLOR_SPEC, GRADIENT_SAMPLE, METALLIC_ROUGHNESS, MOTION,
    NORMAL, RNG_SEED, SHADING_POSITION, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION, VISIBILITY,
};

/// Gives one pixel of each stratum the surface and the random seed of the last frame, so that the lighting stages after it compute the same sample
/// with this frame's lights. It needs the scene, and the history of [`crate::Denoiser::Asvgf`].
pub struct GradientPixels {
    kernel: Kernel,
}

impl GradientPixels {
    /// The images that it accesses. It changes the pixels that it chooses and no others.
    pub const IO: StageIo = StageIo {
        reads: &[MOTION, VIEW_DEPTH],
        reads_previous: &[
            RNG_SEED,
            VISIBILITY,
            BARYCENTRICS,
            CLUSTER,
            BASE_COLOR,
            METALLIC_ROUGHNESS,
            NORMAL,
            VERTEX_NORMAL,
            VIEW_DEPTH,
            SHADING_POSITION,
            VIEW_DIRECTION,
            COLOR_HF,
            COLOR_SPEC,
            GRADIENT_SAMPLE,
            SURFACE,
        ],
        writes: &[
            RNG_SEED,
            VISIBILITY,
            BARYCENTRICS,
            CLUSTER,
            BASE_COLOR,
            METALLIC_ROUGHNESS,
            NORMAL,
            GRADIENT_SAMPLE,
        ],
        updates: &[VERTEX_NORMAL, SHADING_POSITION, VIEW_DIRECTION],
        ..StageIo::of("gradient pixels")
    };

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device, variant: TraceVariant, params: &DenoiseParams) -> Result<Self> {
        let constants =
            [("scene_features", variant.scene_features.into()), params.antilag.stratum_constant()];
        let kernel = Kernel::compute::<GradientPixelsPush>(device, &kernels::GRADIENT_PIXELS, &constants)?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Adds its pass to the frame, between the G-buffer and the light. `replays`: the lighting stages take the light samples of gradient pixels
    /// again; otherwise there are none, because what differs would be noise.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DenoiseParams,
        replays: bool,
    ) -> Result<()> {
        let images = inputs.images;
        let size = images.size();
        let push = GradientPixelsPush {
            size: size.into(),
            depth: params.temporal.depth,
            normal: params.temporal.normal_cosine(),
            reset: (!images.has_history() || !replays).into(),
            brightest: u32::from(params.antilag.pixel == GradientPixel::Brightest),
            forward: u32::from(params.antilag.projection == Projection::Forward),
        };
        let side = params.antilag.stratum.side();
        inputs.pass(frame, "gradient pixels", &self.kernel, &Self::IO).push(&push).dispatch([
            size[0].div_ceil(side),
            size[1].div_ceil(side),
            1,
        ])
    }
}
