//! Sums on the host, and the estimate that follows from them.

use crate::records::{FilmPixel, FirstHitPixel};
use bytemuck::Zeroable;
use glam::{DVec3, Vec2, Vec3};

/// The sums of [`crate::PathTracer`], bit by bit, from which a render can be resumed.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmState {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rows from the top.
    pub film: Vec<FilmPixel>,
    /// Rows from the top.
    pub first_hit: Vec<FirstHitPixel>,
    /// Samples that were not finite and count as black.
    pub dropped: u32,
}

impl FilmState {
    /// Nothing yet.
    pub fn zero(size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        Self {
            size,
            film: vec![FilmPixel::zeroed(); pixels],
            first_hit: vec![FirstHitPixel::zeroed(); pixels],
            dropped: 0,
        }
    }

    /// Rays traced for the nearest hit, and shadow rays.
    pub fn rays(&self) -> [u64; 2] {
        let sum = |count: fn(&FilmPixel) -> u32| self.film.iter().map(|p| u64::from(count(p))).sum();
        [sum(|p| p.rays), sum(|p| p.shadow_rays)]
    }

    /// The estimate from `samples` samples a pixel.
    pub fn estimate(&self, samples: u32) -> Estimate {
        let n = f64::from(samples);
        let pixels = self.film.iter().zip(&self.first_hit);
        let pixels = pixels.map(|(film, first)| {
            let mean = (film.sum.as_dvec3() + film.sum_rest.as_dvec3()) / n;
            let square = film.square.as_dvec3() + film.square_rest.as_dvec3();
            // Of the mean, from the unbiased variance of the samples. Rounding can leave a constant pixel just below 0.
            let variance = ((square - mean * mean * n) / (n * (n - 1.0).max(1.0))).max(DVec3::ZERO);
            let variance = if samples > 1 { variance } else { DVec3::ZERO };
            let hits = first.hits.max(1.0);
            EstimatePixel {
                mean: mean.as_vec3(),
                variance: variance.as_vec3(),
                albedo: first.albedo / hits,
                normal: first.normal / hits,
                depth: first.depth / hits,
                motion: first.motion / hits,
                coverage: first.hits / samples.max(1) as f32,
            }
        });
        Estimate {
            size: self.size,
            samples: u64::from(samples),
            dropped: u64::from(self.dropped),
            pixels: pixels.collect(),
        }
    }
}

/// A pixel of an [`Estimate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatePixel {
    /// Radiance.
    pub mean: Vec3,
    /// Variance of `mean`, radiance squared; 0 after a single sample.
    pub variance: Vec3,
    /// Base colour of what camera rays see first; means over the rays that see a surface.
    pub albedo: Vec3,
    /// Its shading normal on the viewer's side, world space: a mean, so shorter than 1 at edges; 0 where nothing is seen.
    pub normal: Vec3,
    /// Its distance along the ray, metres.
    pub depth: f32,
    /// Where it was in the last frame minus where it is, UV.
    pub motion: Vec2,
    /// Share of the rays that see a surface, 0 to 1.
    pub coverage: f32,
}

/// An image with its variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples of each pixel.
    pub samples: u64,
    /// Samples that were not finite and count as black.
    pub dropped: u64,
    /// Rows from the top.
    pub pixels: Vec<EstimatePixel>,
}

/// Why estimates cannot be merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// There are none.
    #[error("nothing to merge")]
    Empty,
    /// They differ in size.
    #[error("sizes differ: {}x{} and {}x{}", a[0], a[1], b[0], b[1])]
    Size {
        /// Of the first one.
        a: [u32; 2],
        /// Of another one.
        b: [u32; 2],
    },
}

impl Estimate {
    /// Root of the expected relative squared error, sqrt(mean(variance / (mean^2 + epsilon))) over pixels and channels, with
    /// the epsilon of relMSE ([`pt_image::metrics::RELMSE_EPSILON`]); 0 after a single sample.
    pub fn relative_error(&self) -> f64 {
        let terms = self.pixels.iter().map(|p| {
            let (mean, variance) = (p.mean.as_dvec3(), p.variance.as_dvec3());
            (variance / (mean * mean + pt_image::metrics::RELMSE_EPSILON)).element_sum() / 3.0
        });
        (terms.sum::<f64>() / self.pixels.len() as f64).sqrt()
    }

    /// Joins independent estimates of one image, weighted by their samples: mean and variance are those of all samples
    /// together (Chan, Golub, LeVeque 1983, eq. 2.1), but for the rounding to f32.
    ///
    /// # Errors
    /// [`MergeError`].
    pub fn merge(parts: &[Self]) -> Result<Self, MergeError> {
        let first = parts.first().ok_or(MergeError::Empty)?;
        if let Some(other) = parts.iter().find(|part| part.size != first.size) {
            return Err(MergeError::Size { a: first.size, b: other.size });
        }
        let samples: u64 = parts.iter().map(|part| part.samples).sum();
        let pixels = (0..first.pixels.len())
            .map(|i| {
                merge_pixel(samples as f64, parts.iter().map(|part| (part.samples as f64, &part.pixels[i])))
            })
            .collect();
        let dropped = parts.iter().map(|part| part.dropped).sum();
        Ok(Self { size: first.size, samples, dropped, pixels })
    }
}

fn merge_pixel<'a>(
    samples: f64,
    parts: impl Iterator<Item = (f64, &'a EstimatePixel)> + Clone,
) -> EstimatePixel {
    let sum = |value: &dyn Fn(f64, &EstimatePixel) -> DVec3| {
        parts.clone().fold(DVec3::ZERO, |sum, (n, pixel)| sum + value(n, pixel))
    };
    let mean = sum(&|n, p| n * p.mean.as_dvec3()) / samples;
    let deviations = sum(&|n, p| {
        let shift = p.mean.as_dvec3() - mean;
        p.variance.as_dvec3() * n * (n - 1.0) + n * shift * shift
    });
    let hits_of = |n: f64, p: &EstimatePixel| (n * f64::from(p.coverage)).round();
    let hits = sum(&|n, p| DVec3::splat(hits_of(n, p))).x;
    let over_hits = |value: &dyn Fn(&EstimatePixel) -> Vec3| {
        let total = sum(&|n, p| hits_of(n, p) * value(p).as_dvec3());
        if hits > 0.0 { total / hits } else { DVec3::ZERO }
    };
    EstimatePixel {
        mean: mean.as_vec3(),
        variance: if samples > 1.0 {
            (deviations / (samples * (samples - 1.0))).as_vec3()
        } else {
            Vec3::ZERO
        },
        albedo: over_hits(&|p| p.albedo).as_vec3(),
        normal: over_hits(&|p| p.normal).as_vec3(),
        depth: over_hits(&|p| Vec3::splat(p.depth)).x as f32,
        motion: over_hits(&|p| p.motion.extend(0.0)).as_vec3().truncate(),
        coverage: hits as f32 / samples as f32,
    }
}
