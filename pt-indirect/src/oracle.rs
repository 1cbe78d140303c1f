//! What `sh.glsl` is tested against, the same functions in f64; and the light of a surface that a bounce ray meets.
//!
//! Real spherical harmonics and the cosine kernel: Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance
//! Environment Maps". YCoCg by lifting: Malvar and Sullivan 2003, "YCoCg-R: A Color Space with RGB Reversibility and Low
//! Dynamic Range".

use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::iter::Sum;
use std::ops::{Add, Mul};

/// Light that arrives at a point from all directions, as integrals over them. Adding and scaling light adds and scales this.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShLight {
    /// Luma, the three functions of l = 1, in the order of the axes.
    pub luma1: DVec3,
    /// Luma, l = 0.
    pub luma0: f64,
    /// Co and Cg, integrated without a direction.
    pub chroma: [f64; 2],
}

impl ShLight {
    /// Light of one unit direction. `radiance`: linear RGB, divided by the density per solid angle with which the direction was
    /// sampled, or times the solid angle that it stands for.
    pub fn encode(direction: DVec3, radiance: DVec3) -> Self {
        let [y, co, cg] = ycocg_from_rgb(radiance);
        Self { luma1: direction * (y * y1()), luma0: y * y0(), chroma: [co, cg] }
    }

    /// Light of one unit direction that gives a surface facing `normal`, above whose horizon it is, exactly that irradiance.
    pub fn encode_irradiance(direction: DVec3, irradiance: DVec3, normal: DVec3) -> Self {
        Self::encode(direction, irradiance / (0.25 + 0.5 * direction.dot(normal).max(0.0)))
    }

    /// Light without a direction: every normal gets that irradiance.
    pub fn constant(irradiance: DVec3) -> Self {
        let [y, co, cg] = ycocg_from_rgb(irradiance);
        let whole = PI * y0();
        Self { luma1: DVec3::ZERO, luma0: y / whole, chroma: [co, cg].map(|c| c / (whole * y0())) }
    }

    /// Irradiance of a surface that faces the unit vector `normal`, linear RGB, never negative for non-negative light. Chroma
    /// keeps its share of the whole luma, so that every normal sees the same hue.
    pub fn irradiance(&self, normal: DVec3) -> DVec3 {
        // Integrals of the clamped cosine against the bands: A_1 = 2 pi / 3, A_0 = pi.
        let y = (2.0 * PI / 3.0 * y1() * self.luma1.dot(normal) + PI * y0() * self.luma0).max(0.0);
        let whole = self.luma0 / y0();
        if whole > 0.0 {
            rgb_from_ycocg([y, self.chroma[0] * y / whole, self.chroma[1] * y / whole])
        } else {
            DVec3::ZERO
        }
    }
}

/// Radiance that a Lambertian surface, met by a bounce ray, sends back along it: one light sample of a point light. `normal`: on the ray's side;
/// `light`: position and candela; `arrives`: whether nothing is between two points.
pub fn vertex_radiance(
    position: DVec3,
    normal: DVec3,
    albedo: DVec3,
    light: (DVec3, DVec3),
    arrives: impl Fn(DVec3, DVec3) -> bool,
) -> DVec3 {
    let way = light.0 - position;
    let cosine = way.normalize().dot(normal);
    if cosine <= 0.0 || !arrives(position, light.0) {
        return DVec3::ZERO;
    }
    albedo / PI * light.1 * cosine / way.length_squared()
}

/// Form factor from a point to a rectangle in a parallel plane at the distance `height`, whose sides are parallel to the axes: irradiance over pi times the
/// rectangle's radiance. `low`, `high`: its corners, relative to the foot of the point.
pub fn rectangle_form_factor(low: [f64; 2], high: [f64; 2], height: f64) -> f64 {
    // From the foot to (a, b): Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3; odd in both.
    let quarter = |a: f64, b: f64| {
        let [a, b] = [a / height, b / height];
        let [across, along] = [(1.0 + a * a).sqrt(), (1.0 + b * b).sqrt()];
        (a / across * (b / across).atan() + b / along * (a / along).atan()) / TAU
    };
    quarter(high[0], high[1]) - quarter(low[0], high[1]) - quarter(high[0], low[1]) + quarter(low[0], low[1])
}

impl Add for ShLight {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            luma1: self.luma1 + other.luma1,
            luma0: self.luma0 + other.luma0,
            chroma: [self.chroma[0] + other.chroma[0], self.chroma[1] + other.chroma[1]],
        }
    }
}

impl Mul<f64> for ShLight {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            luma1: self.luma1 * factor,
            luma0: self.luma0 * factor,
            chroma: self.chroma.map(|c| c * factor),
        }
    }
}

impl Sum for ShLight {
    fn sum<I: Iterator<Item = Self>>(lights: I) -> Self {
        lights.fold(Self::default(), Add::add)
    }
}

/// Y_1m over the component of the direction.
fn y1() -> f64 {
    (3.0 / (4.0 * PI)).sqrt()
}

/// Y_00.
fn y0() -> f64 {
    (1.0 / (4.0 * PI)).sqrt()
}

/// Luma, Co and Cg of linear RGB.
pub fn ycocg_from_rgb(c: DVec3) -> [f64; 3] {
    [0.25 * c.x + 0.5 * c.y + 0.25 * c.z, c.x - c.z, c.y - 0.5 * (c.x + c.z)]
}

/// The inverse of [`ycocg_from_rgb`].
pub fn rgb_from_ycocg([y, co, cg]: [f64; 3]) -> DVec3 {
    let red_and_blue = y - 0.5 * cg;
    DVec3::new(red_and_blue + 0.5 * co, y + 0.5 * cg, red_and_blue - 0.5 * co)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the midpoint rule for cos^2 / (pi d^2); a rectangle beside the foot, and one that is nearly the whole plane.
    #[test]
    fn form_factors_are_integrals() {
        const N: usize = 400;
        let (low, high, height) = ([0.3, -0.8], [1.1, 0.5], 0.7);
        let step = [0, 1].map(|k| (high[k] - low[k]) / N as f64);
        let at = |k: usize, i: usize| low[k] + (i as f64 + 0.5) * step[k];
        let part = |x: f64, z: f64| height * height / (PI * (x * x + z * z + height * height).powi(2));
        let sum: f64 = (0..N * N).map(|i| part(at(0, i % N), at(1, i / N))).sum();
        let exact = rectangle_form_factor(low, high, height);
        assert!((sum * step[0] * step[1] / exact - 1.0).abs() < 1e-5, "{exact}");
        assert!((rectangle_form_factor([-1e4; 2], [1e4; 2], 1.0) - 1.0).abs() < 1e-6);
    }
}
