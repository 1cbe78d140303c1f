//! From the split frame to the flat frame: interleaves the two checkerboard fields and blends split surfaces.
//!
//! The pass is [`Interleave`]; [`AddPlane`] adds the flat frames of planes; the coordinate mapping is part of the frame contract ([`pt_core::split`]).

#![forbid(unsafe_code)]

mod add_plane;
pub mod oracle;
mod records;
pub mod study;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

pub use add_plane::AddPlane;

use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels::{COLOR, FLAT_COLOR, FLAT_MOTION, MOTION};
use records::InterleavePush;

knobs! {
    /// Knobs of the interleave.
    pub struct CheckerboardParams {
        /// Whether split surfaces (glass: one field reflects, the other refracts) are blended over both fields; without, their checker
        /// pattern stays visible, as is right for unfiltered frames that alternate the fields.
        pub blend_split: bool = true, source "Quake II RTX";
    }
}

/// Split colour and motion to flat colour and motion.
///
/// Pixels of regular surfaces pass through bit by bit. `flat_color.a` keeps the pixel's checkerboard flags.
pub struct Interleave {
    kernel: Kernel,
}

impl Interleave {
    /// The images that it accesses; it writes every pixel.
    pub const IO: StageIo =
        StageIo { reads: &[COLOR, MOTION], writes: &[FLAT_COLOR, FLAT_MOTION], ..StageIo::of("interleave") };

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<InterleavePush>(device, &kernels::INTERLEAVE, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Adds its pass to the frame.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &CheckerboardParams,
    ) -> Result<()> {
        inputs
            .pass(frame, "interleave", &self.kernel, &Self::IO)
            .push(&InterleavePush { blend_split: u32::from(params.blend_split) })
            .dispatch(inputs.flat_threads())
    }
}
