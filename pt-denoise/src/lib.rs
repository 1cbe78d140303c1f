//! From the light channels of the split frame to its radiance.
//!
//! There is no filter here yet: [`Composite`] puts the noisy channels together, with the reflectance that they were
//! divided by, the path throughput and the transparent layer.

#![forbid(unsafe_code)]

pub mod oracle;
mod records;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

use pt_core::settings::{InvalidValue, Validate, check_range};
use pt_core::{ChannelImages, Device, Frame, Kernel, Result};
use pt_shaders::channels::{
    BASE_COLOR, COLOR, COLOR_HF, COLOR_SPEC, ChannelId, METALLIC_ROUGHNESS, SHADING_POSITION, THROUGHPUT,
    TRANSPARENT, VIEW_DIRECTION,
};
use records::CompositePush;

/// Knobs of the composite. They show parts of the light by themselves; every value but the default changes energy.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DenoiseParams {
    /// Factor on the diffuse channel, 0 to 10.
    pub scale_hf: f32,
    /// Factor on the specular channel, 0 to 10.
    pub scale_spec: f32,
    /// Factor on the radiance of the transparent layer (its coverage stays), 0 to 10.
    pub scale_overlay: f32,
    /// Diffuse albedo that stands for every surface's own, 0 to 1; none: their own.
    pub fixed_albedo: Option<f32>,
}

impl Default for DenoiseParams {
    fn default() -> Self {
        Self { scale_hf: 1.0, scale_spec: 1.0, scale_overlay: 1.0, fixed_albedo: None }
    }
}

impl Validate for DenoiseParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        check_range("scale_hf", self.scale_hf, 0.0..=10.0, "")?;
        check_range("scale_spec", self.scale_spec, 0.0..=10.0, "")?;
        check_range("scale_overlay", self.scale_overlay, 0.0..=10.0, "")?;
        self.fixed_albedo.map_or(Ok(()), |albedo| check_range("fixed_albedo", albedo, 0.0..=1.0, ""))
    }
}

/// Light channels, material and transparent layer to `color`.
///
/// A non-finite input makes its own pixel non-finite and no other.
pub struct Composite {
    kernel: Kernel,
}

impl Composite {
    /// Channels that it reads.
    pub const READS: &[ChannelId] = &[
        BASE_COLOR,
        METALLIC_ROUGHNESS,
        SHADING_POSITION,
        VIEW_DIRECTION,
        THROUGHPUT,
        TRANSPARENT,
        COLOR_HF,
        COLOR_SPEC,
    ];
    /// Channels that it writes, on every pixel.
    pub const WRITES: &[ChannelId] = &[COLOR];

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self { kernel: Kernel::compute::<CompositePush>(device, &kernels::COMPOSITE, &[])? })
    }

    /// Adds its pass to the frame.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        images: &ChannelImages,
        params: &DenoiseParams,
    ) -> Result<()> {
        let [width, height] = images.current(COLOR).extent();
        frame
            .pass("composite", &self.kernel)
            .reads(images, Self::READS)
            .writes(images, Self::WRITES)
            .push(&CompositePush {
                scale_hf: params.scale_hf,
                scale_spec: params.scale_spec,
                scale_overlay: params.scale_overlay,
                use_albedo: u32::from(params.fixed_albedo.is_some()),
                albedo: params.fixed_albedo.unwrap_or(0.0),
            })
            .dispatch([width, height, 1])
    }
}
