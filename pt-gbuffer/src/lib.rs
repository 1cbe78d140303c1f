//! First visible surface: primary rays into the split G-buffer.
//!
//! One ray a pixel through a thin lens; at its hit the whole contract for regular surfaces is written: visibility, normals,
//! material, motion, inverse footprint depth, ray-cone texture gradients. Mirrors and glass are regular surfaces until the
//! reflect/refract pass is there.
#![forbid(unsafe_code)]

mod jitter;
pub mod oracle;
pub mod records;

pub use jitter::halton;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

use pt_core::frame::Uniforms;
use pt_core::settings::{InvalidValue, Validate, check_range};
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, Frame, Kernel};
use pt_scene::gpu::GpuScene;
use pt_shaders::channels::{self, ChannelId};
use pt_shaders::records::{FrameRecord, MASK_OPAQUE, MASK_TRANSMISSIVE};
use records::PrimaryPush;
use serde::{Deserialize, Serialize};

/// Where in the pixel its ray goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Jitter {
    /// The centre.
    None,
    /// One offset for the whole frame: Halton (2, 3), period 128. What temporal anti-aliasing wants.
    Halton,
    /// A random offset for every pixel: the box filter, when frames are averaged.
    #[default]
    Pixel,
}

/// Knobs of the primary rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PrimaryParams {
    /// `none`, `halton` or `pixel`. Default `pixel`.
    pub jitter: Jitter,
    /// Depth of field with the camera's thin lens. Default true; without effect while the lens radius is 0.
    pub depth_of_field: bool,
    /// Thin lens radius in metres, instead of the camera's own. Range 0..1. Default: not set.
    pub lens_radius: Option<f32>,
    /// Distance in focus in metres, instead of the camera's own. Range 1e-3..1e6. Default: not set.
    pub focus_distance: Option<f32>,
    /// Bias on the texture level of detail, in mip levels; negative is sharper. Range -8..8, default 0.
    pub texture_lod_bias: f32,
}

impl Default for PrimaryParams {
    fn default() -> Self {
        Self {
            jitter: Jitter::default(),
            depth_of_field: true,
            lens_radius: None,
            focus_distance: None,
            texture_lod_bias: 0.0,
        }
    }
}

impl Validate for PrimaryParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("texture_lod_bias", self.texture_lod_bias, -8.0..=8.0, "mip levels")?;
        if let Some(radius) = self.lens_radius {
            check_range("lens_radius", radius, 0.0..=1.0, "m")?;
        }
        if let Some(distance) = self.focus_distance {
            check_range("focus_distance", distance, 1e-3..=1e6, "m")?;
        }
        Ok(())
    }
}

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
        channels::GEO_NORMAL,
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
        Ok(Self { kernel: Kernel::trace::<PrimaryPush>(device, &kernels::PRIMARY_RAYS, backend)? })
    }

    /// Records the pass.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        uniforms: &Uniforms<FrameRecord>,
        images: &ChannelImages,
        params: &PrimaryParams,
    ) -> pt_core::Result<()> {
        let [width, height] = images.size();
        let push = PrimaryPush {
            jitter: match params.jitter {
                Jitter::Halton => halton(frame.index()).into(),
                Jitter::None | Jitter::Pixel => glam::Vec2::ZERO,
            },
            jitter_per_pixel: u32::from(params.jitter == Jitter::Pixel),
            lod_scale: params.texture_lod_bias.exp2(),
            mask: MASK_OPAQUE | MASK_TRANSMISSIVE,
        };
        let pass = frame.pass("primary rays", &self.kernel).read("frame_uniforms", uniforms.buffer());
        scene
            .bind(pass)
            .writes(images, Self::WRITES)
            .push(&push)
            .dispatch([2 * pt_core::channels::field_width(width), height, 1])
    }
}
