//! The weights by which the environment's texels are picked.

use crate::luminance;
use pt_scene::Environment;
use std::f64::consts::PI;

/// Per texel, row by row: solid angle x mean luminance of what a lookup inside it can return, at intensity 1.
///
/// Lookups are bilinear between texel centres, so the radiance inside a texel depends on its eight neighbours: its mean is
/// the separable kernel (1, 6, 1) / 8 over them. No direction with radiance is in a texel of weight zero, and only such
/// texels have it.
pub(crate) fn weights(environment: &Environment) -> Vec<f64> {
    let (width, height) = (environment.image.width as usize, environment.image.height as usize);
    let texel = |x: usize, y: usize| luminance(environment.image.texels[y * width + x]);
    let kernel = |before: f64, at: f64, after: f64| (before + 6.0 * at + after) / 8.0;
    let along_row: Vec<f64> = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            kernel(texel((x + width - 1) % width, y), texel(x, y), texel((x + 1) % width, y))
        })
        .collect();
    (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let at = |y: usize| along_row[y * width + x];
            let mean = kernel(at(y.saturating_sub(1)), at(y), at((y + 1).min(height - 1)));
            mean * texel_solid_angle(width, height, y)
        })
        .collect()
}

/// Solid angle of every texel of row `y`, in steradians.
pub(crate) fn texel_solid_angle(width: usize, height: usize, y: usize) -> f64 {
    let (step, middle) = (PI / height as f64, PI * (y as f64 + 0.5) / height as f64);
    4.0 * PI / width as f64 * middle.sin() * (0.5 * step).sin()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pt_scene::EnvironmentImage;

    #[test]
    fn solid_angles_fill_the_sphere() {
        let sum: f64 = (0..9).map(|y| 7.0 * texel_solid_angle(7, 9, y)).sum();
        assert!((sum - 4.0 * PI).abs() < 1e-12);
    }

    /// A single bright texel lights its neighbours' lookups, round the seam as well; the weights sum to the mean radiance.
    #[test]
    fn footprint_of_one_texel() {
        let (width, height) = (8, 6);
        let mut texels = vec![Vec3::ZERO; 48];
        texels[2 * 8] = Vec3::ONE;
        let weights = weights(&Environment::new(EnvironmentImage { width, height, texels }));
        let lit: Vec<usize> = (0..48).filter(|&i| weights[i] > 0.0).collect();
        assert_eq!(lit, [8, 9, 15, 16, 17, 23, 24, 25, 31]);
    }
}
