//! The mathematics of the path tracer's kernels on the CPU, plain and in double precision: what the kernels are tested against.
//!
//! Names are those of the GLSL functions: `ggx` is bsdf_ggx.glsl, `dielectric` is bsdf_dielectric.glsl, `layers` is
//! bsdf_layers.glsl, `bsdf` is bsdf.glsl, `interior` is interior.glsl, `sampler` is sampler.glsl.

pub mod albedo;
pub mod bsdf;
pub mod dielectric;
pub mod ggx;
pub mod interior;
pub mod layers;
pub mod sampler;

use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Rec. 709 luminance of linear RGB.
pub fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// `v` mirrored about the unit vector `h`, both pointing away from the surface.
pub fn mirror(v: DVec3, h: DVec3) -> DVec3 {
    2.0 * v.dot(h) * h - v
}

/// Orthonormal basis around a unit vector (Duff et al. 2017).
pub fn basis_around(n: DVec3) -> DMat3 {
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    DMat3::from_cols(
        DVec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        DVec3::new(b, s + n.y * n.y * a, -n.y),
        n,
    )
}

/// Density cos(theta) / pi: the disk of Shirley and Chiu 1997 projected up.
pub fn sample_cosine_hemisphere(xi: DVec2) -> DVec3 {
    let p = 2.0 * xi - 1.0;
    if p == DVec2::ZERO {
        return DVec3::Z;
    }
    let (radius, phi) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    let d = radius * DVec2::new(phi.cos(), phi.sin());
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}
