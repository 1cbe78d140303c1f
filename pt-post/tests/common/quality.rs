//! How close a picture is to another, in display codes.

use pt_post::oracle::Image;
use std::fmt;

/// Three measures of one pair of pictures.
#[derive(Clone, Copy, Debug)]
pub struct Quality {
    /// Peak signal-to-noise ratio, dB.
    pub psnr: f64,
    /// Structural similarity (Wang et al. 2004), mean over pixels; 1 = equal.
    pub ssim: f64,
    /// LDR FLIP, mean over pixels; 0 = equal.
    pub flip: f64,
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PSNR {:.2} dB  SSIM {:.4}  FLIP {:.4}", self.psnr, self.ssim, self.flip)
    }
}

/// Of a picture against its reference, both display codes from 0 to 1.
pub fn quality(picture: &Image, reference: &Image) -> Quality {
    assert_eq!(picture.size, reference.size);
    Quality { psnr: psnr(picture, reference), ssim: ssim(picture, reference), flip: flip(picture, reference) }
}

/// Peak 1.
pub fn psnr(picture: &Image, reference: &Image) -> f64 {
    let values = |image: &Image| image.pixels.iter().flatten().copied().collect::<Vec<f64>>();
    let (a, b) = (values(picture), values(reference));
    let mse = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64;
    -10.0 * mse.log10()
}

/// LDR FLIP at the default 67 pixels per degree.
pub fn flip(picture: &Image, reference: &Image) -> f64 {
    let image = |image: &Image| {
        let bytes: Vec<u8> =
            image.pixels.iter().flatten().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
        nv_flip::FlipImageRgb8::with_data(image.size[0], image.size[1], &bytes)
    };
    let map = nv_flip::flip(image(reference), image(picture), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec();
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}

/// Gaussian windows of 11 x 11 pixels, standard deviation 1.5, on luma; windows that leave the picture are left out.
fn ssim(picture: &Image, reference: &Image) -> f64 {
    let [width, height] = picture.size.map(|side| side as usize);
    let luma = |image: &Image| -> Vec<f64> {
        image.pixels.iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect()
    };
    let (a, b) = (luma(picture), luma(reference));
    let products = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x * y).collect() };
    let kernel: Vec<f64> = (-5..=5).map(|i| (-f64::from(i * i) / 4.5).exp()).collect();
    let total: f64 = kernel.iter().sum();
    let blur = |values: &[f64]| -> Vec<f64> {
        let rows: Vec<f64> = (0..height)
            .flat_map(|y| (5..width - 5).map(move |x| (x, y)))
            .map(|(x, y)| (0..11).map(|i| kernel[i] * values[y * width + x + i - 5]).sum::<f64>() / total)
            .collect();
        let inner = width - 10;
        (5..height - 5)
            .flat_map(|y| (0..inner).map(move |x| (x, y)))
            .map(|(x, y)| (0..11).map(|i| kernel[i] * rows[(y + i - 5) * inner + x]).sum::<f64>() / total)
            .collect()
    };
    let (ma, mb) = (blur(&a), blur(&b));
    let (aa, bb, ab) = (blur(&products(&a, &a)), blur(&products(&b, &b)), blur(&products(&a, &b)));
    let (c1, c2) = (0.01f64.powi(2), 0.03f64.powi(2));
    let term = |i: usize| {
        let (va, vb, cov) = (aa[i] - ma[i] * ma[i], bb[i] - mb[i] * mb[i], ab[i] - ma[i] * mb[i]);
        (2.0 * ma[i] * mb[i] + c1) * (2.0 * cov + c2)
            / ((ma[i] * ma[i] + mb[i] * mb[i] + c1) * (va + vb + c2))
    };
    (0..ma.len()).map(term).sum::<f64>() / ma.len() as f64
}
