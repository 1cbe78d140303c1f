//! The `bloom_*.comp` kernels.

use super::{Image, add, is_finite, mix, scaled};
use crate::bloom::{BloomMode, BloomParams, chain_sizes, quarter_sigma, radius};

const MAX_HALF: f64 = 65504.0;

fn held(c: super::Rgb) -> super::Rgb {
    c.map(|v| v.clamp(0.0, MAX_HALF))
}

/// A frame with its bloom.
pub fn bloom(source: &Image, params: &BloomParams) -> Image {
    let blurred = match params.mode {
        _ if params.intensity == 0.0 => return source.clone(),
        BloomMode::Off => return source.clone(),
        BloomMode::Gaussian => gaussian(source, params),
        BloomMode::Chain => chain(source, params),
    };
    let ratio = [0, 1].map(|i| f64::from(blurred.size[i]) / f64::from(source.size[i]));
    Image::from_fn(source.size, |x, y| {
        let c = source.at(x.into(), y.into());
        let glow = blurred.bilinear((f64::from(x) + 0.5) * ratio[0], (f64::from(y) + 0.5) * ratio[1]);
        if is_finite(c) { mix(held(c), glow, params.intensity.into()) } else { c }
    })
}

fn gaussian(source: &Image, params: &BloomParams) -> Image {
    let [width, height] = source.size;
    let quarter = Image::from_fn([width.div_ceil(4), height.div_ceil(4)], |x, y| {
        let (mut sum, mut count) = ([0.0; 3], 0.0f64);
        for (column, row) in (0..16).map(|i| (4 * x + i % 4, 4 * y + i / 4)) {
            if column < width && row < height {
                let c = source.at(column.into(), row.into());
                if is_finite(c) {
                    add(&mut sum, 1.0, held(c));
                    count += 1.0;
                }
            }
        }
        scaled(sum, 1.0 / count.max(1.0))
    });
    let sigma = quarter_sigma(params.sigma, height);
    let blur = |image: &Image, dx: i64, dy: i64| {
        let reach = i64::from(radius(sigma));
        Image::from_fn(image.size, |x, y| {
            let (mut sum, mut weights) = ([0.0; 3], 0.0);
            for i in -reach..=reach {
                let weight = (-0.5 * (i * i) as f64 / f64::from(sigma).powi(2)).exp();
                add(&mut sum, weight, image.at(i64::from(x) + i * dx, i64::from(y) + i * dy));
                weights += weight;
            }
            scaled(sum, 1.0 / weights)
        })
    };
    blur(&blur(&quarter, 1, 0), 0, 1)
}

fn chain(source: &Image, params: &BloomParams) -> Image {
    let mut levels: Vec<Image> = Vec::new();
    for size in chain_sizes(source.size, params.levels) {
        let from = levels.last().unwrap_or(source);
        let box_at = |x: i64, y: i64| {
            let mut sum = [0.0; 3];
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let c = from.at(x + dx, y + dy);
                if is_finite(c) {
                    add(&mut sum, 0.25, held(c));
                }
            }
            sum
        };
        levels.push(Image::from_fn(size, |x, y| {
            let (x, y) = (2 * i64::from(x), 2 * i64::from(y));
            let mut sum = scaled(box_at(x, y), 0.5);
            for (dx, dy) in [(-1, -1), (1, -1), (-1, 1), (1, 1)] {
                add(&mut sum, 0.125, box_at(x + dx, y + dy));
            }
            sum
        }));
    }
    let mut lower = levels.pop().unwrap_or_else(|| source.clone());
    while let Some(level) = levels.pop() {
        let ratio = [0, 1].map(|i| f64::from(lower.size[i]) / f64::from(level.size[i]));
        lower = Image::from_fn(level.size, |x, y| {
            let (cx, cy) = ((f64::from(x) + 0.5) * ratio[0], (f64::from(y) + 0.5) * ratio[1]);
            let mut sum = [0.0; 3];
            for (dx, dy) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
                add(&mut sum, 1.0 / 12.0, lower.bilinear(cx + dx, cy + dy));
            }
            for (dx, dy) in [(0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)] {
                add(&mut sum, 1.0 / 6.0, lower.bilinear(cx + dx, cy + dy));
            }
            mix(level.at(x.into(), y.into()), sum, params.spread.into())
        });
    }
    lower
}
