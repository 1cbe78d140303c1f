//! How the histories are kept from frame to frame.

use crate::images::{HISTORY_HF, HISTORY_LF_COCG, HISTORY_LF_SH, HISTORY_SPEC, MOMENTS};
use crate::records::HistoryFormat;
use pt_core::Image;
use pt_shaders::channels::{Format, HalfCode, OtherFormats};

/// The histories with `denoise.histories=half`. The layers of an EXR hold what the codes stand for: variances where there are means of squares
/// in the full form.
static HALF_HISTORIES: OtherFormats = OtherFormats {
    constant: "half_histories",
    images: &[
        (MOMENTS, Format::Half(HalfCode::Moments)),
        (HISTORY_HF, Format::Half(HalfCode::Light)),
        (HISTORY_SPEC, Format::Half(HalfCode::Light)),
        (HISTORY_LF_SH, Format::Half(HalfCode::Roots)),
        (HISTORY_LF_COCG, Format::Half(HalfCode::Chroma)),
    ],
};

/// Greatest length of a history, frames. Larger than the inverse of any sensible least weight; fp32 holds it exactly.
pub(crate) const MAX_LENGTH: u32 = 4096;
/// The same of histories in half floats, which hold whole numbers up to here.
const MAX_LENGTH_HALF: u32 = 2048;

impl HistoryFormat {
    /// The formats that are not those of the tables. Images and kernels of the denoiser must be made on a device that has them
    /// ([`pt_core::Device::with_formats`]).
    pub fn others(self) -> Option<&'static OtherFormats> {
        match self {
            Self::Full => None,
            Self::Half => Some(&HALF_HISTORIES),
        }
    }

    pub(crate) fn max_length(self) -> u32 {
        match self {
            Self::Full => MAX_LENGTH,
            Self::Half => MAX_LENGTH_HALF,
        }
    }
}

/// Whether an image of light holds roots: those in half floats do.
pub(crate) fn holds_roots(light: &Image) -> bool {
    matches!(light.format(), Format::Rgba16F | Format::Half(_))
}
