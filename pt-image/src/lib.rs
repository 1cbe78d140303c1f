//! Image files, image metrics and atomic file writes. Nothing here needs a device.
//!
//! * [`image_file`]: EXR and PNG out, EXR, PNG, JPEG and HDR in;
//! * [`metrics`]: relMSE, MSE, PSNR, SSIM, FLIP, HDR FLIP, energy, the Z-test, each with its formula;
//! * [`atomic_file`]: a file with the final name is always complete.
#![forbid(unsafe_code)]

pub mod atomic_file;
pub mod image_file;
pub mod metrics;
