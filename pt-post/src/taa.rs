//! Temporal anti-aliasing and upscaling.

use crate::images::{RESOLVED, TAA_HISTORY};
use crate::kernels;
use crate::records::*;
use pt_core::{Device, Frame, Image, Kernel, Result, StageInputs, StageIo, knobs};

knobs! {
    /// Knobs of temporal anti-aliasing.
    pub struct TaaParams {
        /// Whether temporal anti-aliasing also runs without upscaling; it needs one sub-pixel offset per frame (`gbuffer.jitter`).
        pub enabled: bool = false, source "Karis 2014" => structural;
        /// The space in which history is compared with the neighbourhood and blended.
        pub space: ClipSpace = ClipSpace::Pq;
        /// Whether the new frame and the history are blended as linear radiance, which keeps the mean over frames; otherwise PQ codes are
        /// blended, as Quake II RTX does, which is smoother but darker at edges of high contrast.
        pub blend_linear: bool = true;
        /// What happens to history that lies outside the box of the neighbourhood's colours.
        pub rectify: Rectify = Rectify::Clamp, source "Karis 2014";
        /// Half width of the neighbourhood's box.
        pub sigma: f32 = 1.0, in 0.0..=8.0, unit "standard deviations", source "Salvi 2016";
        /// How much the variation of a pixel over the frames widens its box, which keeps lines thinner than a pixel; space `rgb` ignores
        /// it, and Quake II RTX has 0.
        pub temporal: f32 = 2.5, in 0.0..=8.0, unit "mean absolute deviations";
        /// Factor on `sigma` where reflection and refraction share the pixel.
        pub split_sigma: f32 = 2.0, in 1.0..=8.0;
        /// Suppression of bright single pixels: a pixel is limited to x^-0.25 times the mean of its neighbours, in the blended space; 0
        /// is no limit, and Quake II RTX has 0.25.
        pub anti_sparkle: f32 = 0.0, in 0.0..=1.0;
        /// Weight of the new frame where something moves by a pixel or more, once the history is full; before, history is a running mean.
        pub blend: f32 = 0.1, in 0.01..=1.0, source "Karis 2014";
        /// Weight of the new frame where nothing moves, once the history is full; Quake II RTX has the value of `blend`.
        pub blend_still: f32 = 0.03, in 0.01..=1.0;
        /// Luminance that radiance 1 stands for on the PQ scale, which ends at 10000.
        pub pq_scale: f32 = 1.0, in 1e-3..=1e5, unit "cd/m2", source "SMPTE ST 2084";
    }
}

impl TaaParams {
    /// Most that a pixel may exceed the mean of its neighbours; 0 = no limit.
    pub(crate) fn sparkle_limit(&self) -> f32 {
        if self.anti_sparkle > 0.0 { self.anti_sparkle.powf(-0.25) } else { 0.0 }
    }

    fn push(&self, jitter: [f32; 2], reset: bool) -> TaaPush {
        TaaPush {
            jitter: jitter.into(),
            space: self.space.code(),
            blend_linear: self.blend_linear.into(),
            rectify: self.rectify.code(),
            sigma: self.sigma,
            split_sigma: self.split_sigma,
            temporal: self.temporal,
            sparkle_limit: self.sparkle_limit(),
            blend: self.blend,
            blend_still: self.blend_still,
            pq_scale: self.pq_scale,
            reset: reset.into(),
        }
    }
}

/// Blends this frame into the reprojected history; with an output larger than the input it upscales. History counts where the
/// images have one ([`ChannelImages::has_history`](pt_core::ChannelImages::has_history)), else the frame starts over.
pub struct Taa {
    kernel: Kernel,
    /// For [`ClipSpace::Pq`].
    pq_kernel: Kernel,
}

impl Taa {
    /// The images that it accesses besides colour and motion.
    pub const IO: StageIo =
        StageIo { reads_previous: &[TAA_HISTORY], writes: &[TAA_HISTORY, RESOLVED], ..StageIo::of("taa") };

    /// Creates the kernels.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<TaaPush>(device, &kernels::TAA, &[])?;
        let pq_kernel = Kernel::compute::<TaaPush>(device, &kernels::TAA_PQ, &[])?;
        Self::IO.check([&kernel])?;
        Self::IO.check([&pq_kernel])?;
        Ok(Self { kernel, pq_kernel })
    }

    /// Adds its pass to the frame and returns the anti-aliased frame. `color`: linear radiance, a = checkerboard flags; `motion`:
    /// previous minus current screen position in UV; `jitter`: where in its pixels the frame was sampled, from the centre, pixels.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        color: &Image,
        motion: &Image,
        jitter: [f32; 2],
        params: &TaaParams,
    ) -> Result<&'a Image> {
        let resolved = inputs.images.current(RESOLVED);
        let [width, height] = resolved.extent();
        let groups = [width.div_ceil(TAA_COLUMNS), height.div_ceil(TAA_ROWS)];
        let kernel = if params.space == ClipSpace::Pq { &self.pq_kernel } else { &self.kernel };
        inputs
            .pass(frame, "taa", kernel, &Self::IO)
            .sample("color", color)
            .sample("motion", motion)
            .push(&params.push(jitter, !inputs.images.has_history()))
            .dispatch([groups[0] * (TAA_COLUMNS + 2), groups[1], 1])?;
        Ok(resolved)
    }
}
