//! Every kernel on the CPU, plain and slow: what the kernels are tested against.
//!
//! Images are rows of pixels from the top. Arithmetic is f64 except where the kernel's fp32 matters to the result.

mod accumulate;
mod bloom;
mod exposure;
mod fsr;
mod resample;
mod taa;
mod tone_map;

pub use accumulate::RunningMean;
pub use bloom::bloom;
pub use exposure::{adapt, histogram, meter, noise_aware_curve};
pub use fsr::{easu, rcas};
pub use resample::{Filter, resample};
pub use taa::{TaaFrame, TaaOracle};
pub use tone_map::{Exposed, codes, pq_decode, pq_encode, quantize, srgb_encode, tone_curve};

/// A pixel: red, green, blue.
pub type Rgb = [f64; 3];

/// An image in rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row and rows.
    pub size: [u32; 2],
    /// The pixels.
    pub pixels: Vec<Rgb>,
}

impl Image {
    /// An image whose pixels are a function of column and row.
    pub fn from_fn(size: [u32; 2], mut pixel: impl FnMut(u32, u32) -> Rgb) -> Self {
        let rows = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Self { size, pixels: rows.map(|(x, y)| pixel(x, y)).collect() }
    }

    /// The pixel at a place; outside, the nearest one.
    pub fn at(&self, x: i64, y: i64) -> Rgb {
        let [width, height] = self.size.map(i64::from);
        self.pixels[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
    }

    /// Bilinear sample; pixel centres lie at halves. Outside, the nearest pixels.
    pub fn bilinear(&self, x: f64, y: f64) -> Rgb {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (fx, fy) = (x - 0.5 - left, y - 0.5 - top);
        let mut sum = [0.0; 3];
        for (dx, dy, weight) in [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ] {
            if weight != 0.0 {
                add(&mut sum, weight, self.at(left as i64 + dx, top as i64 + dy));
            }
        }
        sum
    }
}

pub(crate) fn add(sum: &mut Rgb, weight: f64, c: Rgb) {
    for (s, v) in sum.iter_mut().zip(c) {
        *s += weight * v;
    }
}

pub(crate) fn scaled(c: Rgb, factor: f64) -> Rgb {
    c.map(|v| v * factor)
}

pub(crate) fn zip(a: Rgb, b: Rgb, f: impl Fn(f64, f64) -> f64) -> Rgb {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

pub(crate) fn mix(a: Rgb, b: Rgb, share: f64) -> Rgb {
    zip(a, b, |a, b| a + (b - a) * share)
}

/// Rec. 709 luminance of linear RGB.
pub(crate) fn luminance([r, g, b]: Rgb) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

pub(crate) fn is_finite(c: Rgb) -> bool {
    c.iter().all(|v| v.is_finite())
}
