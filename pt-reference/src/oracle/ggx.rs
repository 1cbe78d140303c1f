//! GGX microfacets. Directions are in the frame of the surface: +Z normal, +X tangent; `alpha` along tangent and bitangent.

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Distribution of normals (Walter et al. 2007, eq. 33; anisotropic: Burley 2012, eq. 13).
pub fn d(alpha: DVec2, h: DVec3) -> f64 {
    let slope = h.truncate() / alpha;
    1.0 / (PI * alpha.x * alpha.y * (slope.length_squared() + h.z * h.z).powi(2))
}

/// Smith's Lambda (Heitz 2014, eq. 72, 86).
pub fn lambda(alpha: DVec2, v: DVec3) -> f64 {
    let tan2 = (alpha * v.truncate()).length_squared() / (v.z * v.z);
    0.5 * ((1.0 + tan2).sqrt() - 1.0)
}

/// Masking of one direction (Heitz 2014, eq. 43).
pub fn g1(alpha: DVec2, v: DVec3) -> f64 {
    1.0 / (1.0 + lambda(alpha, v))
}

/// Height-correlated masking and shadowing of a reflection (Heitz 2014, eq. 99).
pub fn g2(alpha: DVec2, v: DVec3, l: DVec3) -> f64 {
    1.0 / (1.0 + lambda(alpha, v) + lambda(alpha, l))
}

/// Normal from the distribution of those visible from `v` (Dupuy and Benyoub 2023).
pub fn sample_vndf(v: DVec3, alpha: DVec2, xi: DVec2) -> DVec3 {
    let stretched = (alpha * v.truncate()).extend(v.z).normalize();
    let phi = TAU * xi.x;
    let z = (1.0 - xi.y) * (1.0 + stretched.z) - stretched.z;
    let sin_theta = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let h = DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), z) + stretched;
    (alpha * h.truncate()).extend(h.z.max(0.0)).normalize()
}

/// Its density per solid angle of `h` (Heitz 2018, eq. 3).
pub fn vndf_pdf(v: DVec3, h: DVec3, alpha: DVec2) -> f64 {
    g1(alpha, v) * v.dot(h).max(0.0) * d(alpha, h) / v.z
}

/// Density per solid angle of `l` of reflecting `v` about such a normal (Heitz 2018, eq. 17).
pub fn reflection_pdf(v: DVec3, l: DVec3, alpha: DVec2) -> f64 {
    let h = (v + l).normalize();
    vndf_pdf(v, h, alpha) / (4.0 * v.dot(h))
}

/// BRDF x |l.z| with a Fresnel term of one.
pub fn reflection(v: DVec3, l: DVec3, alpha: DVec2) -> f64 {
    d(alpha, (v + l).normalize()) * g2(alpha, v, l) / (4.0 * v.z)
}
