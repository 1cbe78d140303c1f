//! Separable convolution of one channel, borders replicated.

use std::ops::{AddAssign, Mul};

use rayon::prelude::*;

/// What a [`Plane`] holds: `f32` or `f64`.
pub(super) trait Real: Copy + Default + Send + Sync + AddAssign + Mul<Output = Self> {}

impl<T: Copy + Default + Send + Sync + AddAssign + Mul<Output = T>> Real for T {}

/// One channel of an image, rows from the top.
pub(super) struct Plane<T> {
    pub width: usize,
    pub values: Vec<T>,
}

impl<T: Real> Plane<T> {
    /// The channel that `value` makes of each pixel.
    pub fn from_pixels<P: Sync>(width: usize, pixels: &[P], value: impl Fn(&P) -> T + Sync + Send) -> Self {
        Self { width, values: pixels.par_iter().map(value).collect() }
    }

    /// Convolution with the outer product of two kernels of odd length: `across` along rows, `down` along columns.
    /// Beyond the border the nearest pixel repeats. Weights run from left to right and from top to bottom (no mirroring).
    pub fn convolve(&self, across: &[T], down: &[T]) -> Self {
        self.convolve_rows(across).convolve_columns(down)
    }

    fn convolve_rows(&self, kernel: &[T]) -> Self {
        let (width, radius) = (self.width, kernel.len() / 2);
        let mut values = vec![T::default(); self.values.len()];
        let rows = values.par_chunks_exact_mut(width).zip(self.values.par_chunks_exact(width));
        rows.for_each_init(
            || vec![T::default(); width + 2 * radius],
            |padded, (sums, row)| {
                padded[..radius].fill(row[0]);
                padded[radius..radius + width].copy_from_slice(row);
                padded[radius + width..].fill(row[width - 1]);
                for (tap, &weight) in kernel.iter().enumerate() {
                    add_scaled(sums, &padded[tap..tap + width], weight);
                }
            },
        );
        Self { width, values }
    }

    fn convolve_columns(&self, kernel: &[T]) -> Self {
        let (width, radius) = (self.width, kernel.len() / 2);
        let last = self.values.len() / width - 1;
        let mut values = vec![T::default(); self.values.len()];
        values.par_chunks_exact_mut(width).enumerate().for_each(|(y, sums)| {
            for (tap, &weight) in kernel.iter().enumerate() {
                let source = (y + tap).saturating_sub(radius).min(last) * width;
                add_scaled(sums, &self.values[source..source + width], weight);
            }
        });
        Self { width, values }
    }
}

fn add_scaled<T: Real>(sums: &mut [T], values: &[T], weight: T) {
    for (sum, &value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}
