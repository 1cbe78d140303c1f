//! The classical filters that upscalers are measured against.

use super::{Image, add, scaled};

/// A separable reconstruction filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Two taps.
    Bilinear,
    /// Keys' cubic, a = -1/2 (Catmull-Rom), four taps.
    Bicubic,
    /// Windowed sinc of radius 3.
    Lanczos,
}

impl Filter {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Bilinear, Self::Bicubic, Self::Lanczos];

    fn radius(self) -> f64 {
        match self {
            Self::Bilinear => 1.0,
            Self::Bicubic => 2.0,
            Self::Lanczos => 3.0,
        }
    }

    fn weight(self, x: f64) -> f64 {
        let x = x.abs();
        let sinc = |x: f64| {
            let x = std::f64::consts::PI * x;
            if x == 0.0 { 1.0 } else { x.sin() / x }
        };
        match self {
            _ if x >= self.radius() => 0.0,
            Self::Bilinear => 1.0 - x,
            Self::Bicubic if x < 1.0 => 1.0 + x * x * (1.5 * x - 2.5),
            Self::Bicubic => 2.0 + x * (-4.0 + x * (2.5 - 0.5 * x)),
            Self::Lanczos => sinc(x) * sinc(x / 3.0),
        }
    }
}

/// Interpolates an image to a larger `size`. Outside, the nearest pixels go on.
pub fn resample(source: &Image, size: [u32; 2], filter: Filter) -> Image {
    let ratio = [0, 1].map(|i| f64::from(source.size[i]) / f64::from(size[i]));
    let reach = filter.radius() as i64;
    Image::from_fn(size, |x, y| {
        let px = (f64::from(x) + 0.5) * ratio[0] - 0.5;
        let py = (f64::from(y) + 0.5) * ratio[1] - 0.5;
        let (left, top) = (px.floor() as i64, py.floor() as i64);
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for row in top + 1 - reach..=top + reach {
            for column in left + 1 - reach..=left + reach {
                let weight = filter.weight(column as f64 - px) * filter.weight(row as f64 - py);
                add(&mut sum, weight, source.at(column, row));
                weights += weight;
            }
        }
        scaled(sum, 1.0 / weights)
    })
}
