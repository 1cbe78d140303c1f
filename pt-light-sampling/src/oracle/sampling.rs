//! Host twins of sampling.glsl. Directions are in a local frame with the normal, or the axis, along +Z.

use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Barycentric weights of the second and third vertex, uniform in area (Heitz 2019).
pub fn sample_triangle(xi: DVec2) -> DVec2 {
    if xi.y > xi.x {
        DVec2::new(0.5 * xi.x, xi.y - 0.5 * xi.x)
    } else {
        DVec2::new(xi.x - 0.5 * xi.y, 0.5 * xi.y)
    }
}

/// Uniform in the unit disk (Shirley and Chiu 1997).
pub fn sample_disk(xi: DVec2) -> DVec2 {
    let p = 2.0 * xi - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (radius, phi) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    radius * DVec2::new(phi.cos(), phi.sin())
}

/// Uniform in the solid angle of a cone about +Z, given as 1 - cos(half angle).
pub fn sample_cone(xi: DVec2, one_minus_cos: f64) -> DVec3 {
    let k = xi.x * one_minus_cos;
    let sin_theta = (k * (2.0 - k)).sqrt();
    let phi = TAU * xi.y;
    DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), 1.0 - k)
}

/// Density of [`sample_cone`] per solid angle.
pub fn cone_pdf(one_minus_cos: f64) -> f64 {
    1.0 / (TAU * one_minus_cos)
}

/// Density cos(theta) / pi (Malley's method).
pub fn sample_cosine_hemisphere(xi: DVec2) -> DVec3 {
    let d = sample_disk(xi);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`sample_cosine_hemisphere`] per solid angle.
pub fn cosine_hemisphere_pdf(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) / PI
}

/// GGX distribution of normals (Walter et al. 2007, eq. 33).
pub fn ggx_d(alpha: f64, h: DVec3) -> f64 {
    let a2 = alpha * alpha;
    a2 / (PI * (h.z * h.z * a2 + h.x * h.x + h.y * h.y).powi(2))
}

/// Normal from the distribution of those visible from `v` (Dupuy and Benyoub 2023).
pub fn sample_ggx_vndf(v: DVec3, alpha: f64, xi: DVec2) -> DVec3 {
    let stretched = DVec3::new(alpha * v.x, alpha * v.y, v.z).normalize();
    let phi = TAU * xi.x;
    let z = (1.0 - xi.y) * (1.0 + stretched.z) - stretched.z;
    let sin_theta = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let h = DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), z) + stretched;
    DVec3::new(alpha * h.x, alpha * h.y, h.z.max(0.0)).normalize()
}

/// Density, per solid angle of l, of reflecting v about such a normal: G1(v) D(h) / (4 v.z) (Heitz 2018, eq. 17).
pub fn ggx_reflection_pdf(v: DVec3, l: DVec3, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let g1 = 2.0 * v.z / (v.z + (a2 + (1.0 - a2) * v.z * v.z).sqrt());
    g1 * ggx_d(alpha, (v + l).normalize()) / (4.0 * v.z)
}

/// Orthonormal basis around a unit vector: `basis_around` of math.glsl (Duff et al. 2017).
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
