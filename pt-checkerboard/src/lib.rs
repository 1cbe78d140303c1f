//! The seam between the checkerboarded frame and the flat one: both fields interleaved, split surfaces blended.
//!
//! The pass is [`Interleave`]; the coordinate mapping is part of the frame contract ([`pt_core::split`]).

#![forbid(unsafe_code)]

pub mod oracle;
mod records;
pub mod study;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

use pt_core::settings::{InvalidValue, Validate};
use pt_core::{ChannelImages, Device, Frame, Kernel, Result};
use pt_shaders::channels::{COLOR, ChannelId, FLAT_COLOR, FLAT_MOTION, MOTION};
use records::InterleavePush;

/// Knobs of the interleave.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CheckerboardParams {
    /// Whether split surfaces (glass: one field reflects, the other refracts) are blended over both fields. Without, their
    /// checker pattern stays visible, as is right for unfiltered frames that alternate the fields.
    pub blend_split: bool,
}

impl Default for CheckerboardParams {
    fn default() -> Self {
        Self { blend_split: true }
    }
}

impl Validate for CheckerboardParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        Ok(())
    }
}

/// Split colour and motion to flat colour and motion.
///
/// Pixels of regular surfaces pass through bit by bit. `flat_color.a` keeps the pixel's checkerboard flags.
pub struct Interleave {
    kernel: Kernel,
}

impl Interleave {
    /// Channels that it reads.
    pub const READS: &[ChannelId] = &[COLOR, MOTION];
    /// Channels that it writes, on every pixel.
    pub const WRITES: &[ChannelId] = &[FLAT_COLOR, FLAT_MOTION];

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self { kernel: Kernel::compute::<InterleavePush>(device, &kernels::INTERLEAVE, &[])? })
    }

    /// Adds its pass to the frame.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        images: &ChannelImages,
        params: &CheckerboardParams,
    ) -> Result<()> {
        let [width, height] = images.size();
        frame
            .pass("interleave", &self.kernel)
            .reads(images, Self::READS)
            .writes(images, Self::WRITES)
            .push(&InterleavePush { blend_split: u32::from(params.blend_split) })
            .dispatch([width, height, 1])
    }
}
