//! How close a picture is to another, both as sRGB codes from 0 to 1.

use pt_image::image_file::{ImageState, LinearImage, srgb_decode};
use pt_image::metrics::{Metric, compare};
use pt_post::oracle::Image;
use std::fmt;

/// Three measures of one pair of pictures.
#[derive(Clone, Copy, Debug)]
pub struct Quality {
    /// Peak signal-to-noise ratio, dB.
    pub psnr: f64,
    /// Structural similarity; 1 = equal.
    pub ssim: f64,
    /// FLIP; 0 = equal.
    pub flip: f64,
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PSNR {:.2} dB  SSIM {:.4}  FLIP {:.4}", self.psnr, self.ssim, self.flip)
    }
}

/// Of a picture against its reference.
pub fn quality(picture: &Image, reference: &Image) -> Quality {
    let linear = |image: &Image| LinearImage {
        width: image.size[0],
        height: image.size[1],
        pixels: image.pixels.iter().map(|c| c.map(|v| srgb_decode(v as f32))).collect(),
        state: ImageState::DisplayReferred,
    };
    let metrics = [Metric::Psnr, Metric::Ssim, Metric::Flip];
    let found = compare(&linear(picture), &linear(reference), &metrics).unwrap();
    Quality { psnr: found[0].value, ssim: found[1].value, flip: found[2].value }
}
