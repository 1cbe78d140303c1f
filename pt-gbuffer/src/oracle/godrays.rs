//! Light that a homogeneous medium scatters once, by brute force: what `godrays.trace` and `godrays_filter.comp` are tested against.

use crate::GodraysParams;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Share of the scattered light per steradian (Henyey and Greenstein 1941). `cos_theta`: between the way of the light before and after.
pub fn henyey_greenstein(cos_theta: f64, g: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5))
}

/// Radiance that `irradiance`, which comes from `towards_light`, gives to a camera that looks along `direction` through `way` metres of the
/// medium. `lit`: whether the point that many metres away gets it. The integral of exp(-s t) s a p E over the lit part of the way, by `cells`
/// midpoints.
pub fn scattered(
    params: &GodraysParams,
    irradiance: DVec3,
    towards_light: DVec3,
    direction: DVec3,
    way: f64,
    cells: u32,
    lit: impl Fn(f64) -> bool,
) -> DVec3 {
    let [density, albedo, g] = [params.density, params.albedo, params.anisotropy].map(f64::from);
    let width = way / f64::from(cells);
    let midpoints = (0..cells).map(|i| (f64::from(i) + 0.5) * width);
    let attenuation: f64 = midpoints.filter(|&t| lit(t)).map(|t| (-density * t).exp()).sum();
    let phase = henyey_greenstein(direction.dot(towards_light), g);
    irradiance * (density * albedo * phase * attenuation * width)
}

/// A marched pixel.
#[derive(Clone, Copy, Debug)]
pub struct Marched {
    /// Its place in the flat frame.
    pub pixel: DVec2,
    /// Mean over the march.
    pub mean: DVec3,
    /// Length of the march, metres.
    pub way: f64,
}

/// The marched pixel of block `q` of the frame with this index; `size`: of the flat frame.
pub fn marched_pixel(q: [u32; 2], frame: u32, size: [u32; 2]) -> [u32; 2] {
    let place = [[0, 0], [1, 1], [0, 1], [1, 0]][frame as usize % 4];
    std::array::from_fn(|axis| (2 * q[axis] + place[axis]).min(size[axis] - 1))
}

/// What the bilateral filter makes of the marched pixels of the 5 x 5 blocks around a pixel whose way is `way` metres; zero without any.
pub fn filtered(around: &[Marched], pixel: DVec2, way: f64) -> DVec3 {
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for marched in around.iter().filter(|marched| marched.way > 0.0) {
        let distance2 = marched.pixel.distance_squared(pixel);
        let difference = (marched.way - way).abs() / marched.way.min(way);
        let weight = (-distance2 / 12.5).exp() * ((-10.0 * difference).exp() + 1e-4);
        sum += weight * marched.mean;
        weights += weight;
    }
    if weights > 0.0 { sum / weights } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All light that is scattered goes somewhere, at the mean cosine g.
    #[test]
    fn the_phase_function_is_a_density() {
        const CELLS: u32 = 200_000;
        for g in [-0.95, -0.3, 0.0, 0.6, 0.95] {
            let (mut sum, mut mean) = (0.0, 0.0);
            for i in 0..CELLS {
                let cos_theta = (f64::from(i) + 0.5) / f64::from(CELLS) * 2.0 - 1.0;
                let share = 2.0 * PI * henyey_greenstein(cos_theta, g) * 2.0 / f64::from(CELLS);
                sum += share;
                mean += share * cos_theta;
            }
            assert!((sum - 1.0).abs() < 1e-5 && (mean - g).abs() < 1e-5, "{g}: {sum} {mean}");
        }
    }

    /// Constant light without occluders: a p E (1 - exp(-s d)).
    #[test]
    fn light_without_occluders_has_a_closed_form() {
        let params = GodraysParams { density: 0.3, albedo: 0.8, anisotropy: 0.5, ..Default::default() };
        let light = scattered(&params, DVec3::ONE, DVec3::Y, DVec3::X, 7.0, 10_000, |_| true);
        let albedo = f64::from(params.albedo);
        let exact = albedo * henyey_greenstein(0.0, 0.5) * (1.0 - (-f64::from(params.density) * 7.0).exp());
        assert!((light.x / exact - 1.0).abs() < 1e-6, "{light} {exact}");
    }
}
