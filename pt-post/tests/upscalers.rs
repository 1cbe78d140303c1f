//! EASU and RCAS beside bilinear, bicubic and Lanczos, against the native picture: PSNR, SSIM and FLIP of display codes.

use crate::common::pictures::{natural, text, to_codes, zone_plate};
use crate::common::quality::quality;
use pt_post::FsrParams;
use pt_post::oracle::{Filter, Image, easu, rcas, resample};

/// Mean over each lower-resolution pixel's area: what a renderer with a box filter gives there.
fn render_at_lower_resolution(native: &Image, size: [u32; 2]) -> Image {
    let ratio = [0, 1].map(|i| f64::from(native.size[i]) / f64::from(size[i]));
    // How much of pixel `i` lies between two places.
    let cover = |from: f64, to: f64| {
        (from as i64..to.ceil() as i64)
            .map(move |i| (i, (to.min(i as f64 + 1.0) - from.max(i as f64)).max(0.0)))
    };
    Image::from_fn(size, |x, y| {
        let mut sum = [0.0; 3];
        for (row, high) in cover(f64::from(y) * ratio[1], f64::from(y + 1) * ratio[1]) {
            for (column, wide) in cover(f64::from(x) * ratio[0], f64::from(x + 1) * ratio[0]) {
                let weight = high * wide / (ratio[0] * ratio[1]);
                sum.iter_mut().zip(native.at(column, row)).for_each(|(s, v)| *s += weight * v);
            }
        }
        sum
    })
}

fn fsr_is_better_than_bicubic(pictures: &[(&str, Image)]) {
    let sharpness = f64::from(FsrParams::default().sharpness);
    for factor in [1.5, 2.0] {
        for (name, native) in pictures {
            let low_size = native.size.map(|side| (f64::from(side) / factor).round() as u32);
            let reference = to_codes(native);
            let low = to_codes(&render_at_lower_resolution(native, low_size));
            let measure = |image: &Image| quality(image, &reference);
            let [bilinear, bicubic, lanczos] =
                Filter::ALL.map(|filter| measure(&resample(&low, native.size, filter)));
            let upscaled = easu(&low, native.size);
            let easu = measure(&upscaled);
            let fsr = measure(&rcas(&upscaled, (-sharpness).exp2(), false));
            println!("{name}, x{factor}");
            println!("  bilinear     {bilinear}\n  bicubic      {bicubic}\n  Lanczos      {lanczos}");
            println!("  EASU         {easu}\n  EASU + RCAS  {fsr}");
            assert!(fsr.ssim > bicubic.ssim && fsr.flip < bicubic.flip, "{name}, x{factor}");
            // Text ends at its paper's white, where EASU's limit to the nearest texels takes the overshoot that PSNR likes.
            let margin = if *name == "text" { 0.2 } else { 0.0 };
            assert!(fsr.psnr > bicubic.psnr - margin, "{name}, x{factor}");
        }
    }
}

#[test]
fn on_drawn_pictures() {
    fsr_is_better_than_bicubic(&[("zone plate", zone_plate([192, 192])), ("text", text([192, 128]))]);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn on_a_photograph() {
    fsr_is_better_than_bicubic(&[("natural", natural())]);
}
