//! Temporal anti-aliasing and upscaling.

use crate::kernels;
use crate::records::*;
use pt_core::settings::{InvalidValue, Validate, check_range};
use pt_core::{Device, Frame, History, Image, Kernel, Result};
use pt_shaders::channels::Format;
use serde::{Deserialize, Serialize};

/// In which space history is compared with the neighbourhood and blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClipSpace {
    /// PQ codes of R, G, B: steps look alike at all luminances.
    Pq,
    /// Compared in luma and chroma (YCoCg) of the PQ codes: a tighter box along grey; blended in PQ.
    Ycocg,
    /// Linear R, G, B: blends keep energy, bright pixels dominate.
    Rgb,
}

/// What happens to history outside of the neighbourhood's box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rectify {
    /// Nothing: no aliasing, but moving things leave trails.
    Off,
    /// Each channel is clamped.
    Clamp,
    /// The colour moves towards the mean until it is inside: keeps its hue.
    Clip,
}

/// Knobs of temporal anti-aliasing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TaaParams {
    /// Whether it runs without upscaling too. Wants one sub-pixel offset a frame (`gbuffer.jitter`). Default false.
    pub enabled: bool,
    /// `pq`, `ycocg` or `rgb`. Default `pq`.
    pub space: ClipSpace,
    /// Whether new and old are mixed as linear radiance: the mean over frames is then that of the light. Else they are mixed
    /// as PQ codes, which is darker at edges of high contrast, and smoother. Default true; Quake II RTX: false.
    pub blend_linear: bool,
    /// `off`, `clamp` or `clip`. Default `clamp`.
    pub rectify: Rectify,
    /// Half width of the neighbourhood's box in standard deviations, 0 to 8. Default 1.
    pub sigma: f32,
    /// How far what a pixel has shown from frame to frame widens its box, in mean absolute deviations, 0 to 8: keeps lines that
    /// are thinner than a pixel, which most frames miss. Not for space `rgb`. Default 2.5; Quake II RTX: 0.
    pub temporal: f32,
    /// Factor on `sigma` where reflection and refraction share the pixel, 1 to 8. Default 2.
    pub split_sigma: f32,
    /// How bright a pixel may be beside its neighbours: at most x^-0.25 times their mean, in the blended space. 0 (no
    /// limit) to 1. Default 0: thin bright lines keep their light; Quake II RTX: 0.25, that is 1.41 times.
    pub anti_sparkle: f32,
    /// Weight of a new frame once history is full, where something moves by a pixel or more, 0.01 to 1; before, history is a
    /// running mean. Default 0.1.
    pub blend: f32,
    /// The same where nothing moves, 0.01 to 1. Default 0.03; Quake II RTX: as `blend`.
    pub blend_still: f32,
    /// Luminance of radiance 1 on the PQ scale, which ends at 10000, 1e-3 to 1e5 cd/m2. Default 1.
    pub pq_scale: f32,
}

impl Default for TaaParams {
    fn default() -> Self {
        Self {
            enabled: false,
            space: ClipSpace::Pq,
            blend_linear: true,
            rectify: Rectify::Clamp,
            sigma: 1.0,
            temporal: 2.5,
            split_sigma: 2.0,
            anti_sparkle: 0.0,
            blend: 0.1,
            blend_still: 0.03,
            pq_scale: 1.0,
        }
    }
}

impl Validate for TaaParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        check_range("sigma", self.sigma, 0.0..=8.0, "")?;
        check_range("split_sigma", self.split_sigma, 1.0..=8.0, "")?;
        check_range("anti_sparkle", self.anti_sparkle, 0.0..=1.0, "")?;
        check_range("temporal", self.temporal, 0.0..=8.0, "")?;
        check_range("blend", self.blend, 0.01..=1.0, "")?;
        check_range("blend_still", self.blend_still, 0.01..=1.0, "")?;
        check_range("pq_scale", self.pq_scale, 1e-3..=1e5, "cd/m2")
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
            space: match self.space {
                ClipSpace::Pq => SPACE_PQ,
                ClipSpace::Ycocg => SPACE_YCOCG,
                ClipSpace::Rgb => SPACE_RGB,
            },
            blend_linear: self.blend_linear.into(),
            rectify: match self.rectify {
                Rectify::Off => RECTIFY_OFF,
                Rectify::Clamp => RECTIFY_CLAMP,
                Rectify::Clip => RECTIFY_CLIP,
            },
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

/// Blends this frame into the reprojected history; with an output larger than the input it upscales.
pub struct Taa {
    kernel: Kernel,
    /// For [`ClipSpace::Pq`].
    pq_kernel: Kernel,
    history: History<Image>,
    resolved: Image,
    empty: bool,
}

impl Taa {
    /// Creates the kernels and the images of `output_size`.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, output_size: [u32; 2]) -> Result<Self> {
        let image = |name, format| Image::new(device, name, format, output_size);
        Ok(Self {
            kernel: Kernel::compute::<TaaPush>(device, &kernels::TAA, &[])?,
            pq_kernel: Kernel::compute::<TaaPush>(device, &kernels::TAA_PQ, &[])?,
            history: History::new(
                image("taa_history", Format::Rgba16Unorm)?,
                image("taa_history_prev", Format::Rgba16Unorm)?,
            ),
            resolved: image("resolved", Format::Rgba16F)?,
            empty: true,
        })
    }

    /// Forgets history, as after a cut: the next frame starts over.
    pub fn reset(&mut self) {
        self.empty = true;
    }

    /// Adds its pass to the frame. `color`: linear radiance, a = checkerboard flags; `motion`: previous minus current screen
    /// position in UV; `jitter`: where in its pixels the frame was sampled, from the centre, pixels.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        color: &Image,
        motion: &Image,
        jitter: [f32; 2],
        params: &TaaParams,
    ) -> Result<()> {
        self.history.swap();
        let [width, height] = self.resolved.extent();
        let groups = [width.div_ceil(TAA_COLUMNS), height.div_ceil(TAA_ROWS)];
        let kernel = if params.space == ClipSpace::Pq { &self.pq_kernel } else { &self.kernel };
        frame
            .pass("taa", kernel)
            .sample("color", color)
            .sample("motion", motion)
            .sample("history", self.history.previous())
            .write("new_history", self.history.current())
            .write("resolved", &self.resolved)
            .push(&params.push(jitter, self.empty))
            .dispatch([groups[0] * (TAA_COLUMNS + 2), groups[1], 1])?;
        self.empty = false;
        Ok(())
    }

    /// The anti-aliased frame: linear radiance, at most 10000 / `pq_scale`; finite and not negative everywhere.
    pub fn resolved(&self) -> &Image {
        &self.resolved
    }

    /// What the last frame left for the next: PQ codes; a = weight of what they hold and deviation (see `taa.comp`).
    pub fn history(&self) -> &Image {
        self.history.current()
    }
}
