//! Interfaces between dielectrics, smooth and rough. `eta`: index of refraction on the far side over that on the viewer's.

use super::ggx;
use glam::{DVec2, DVec3};

/// An interface with an index this close to 1 is passed straight.
pub const INDEX_MATCHED: f64 = 1e-3;

/// Whether the interface bends no light that fp32 could tell.
pub fn is_index_matched(eta: f64) -> bool {
    (eta - 1.0).abs() < INDEX_MATCHED
}

/// Reflectance for unpolarised light: Fresnel's equations. 1: total internal reflection.
pub fn fresnel(cos_theta: f64, eta: f64) -> f64 {
    let sin2 = (1.0 - cos_theta * cos_theta) / (eta * eta);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let cos = (1.0 - sin2).sqrt();
    let s = (cos_theta - eta * cos) / (cos_theta + eta * cos);
    let p = (eta * cos_theta - cos) / (eta * cos_theta + cos);
    0.5 * (s * s + p * p)
}

/// KHR_materials_specular on [`fresnel`]: the colour scales the reflectance at normal incidence, the factor all of it.
pub fn tint_specular(f: f64, eta: f64, specular: f64, color: DVec3) -> DVec3 {
    let f0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let tinted = (f0 * color).min(DVec3::ONE);
    let rise = (f - f0) / (1.0 - f0).max(1e-6);
    (specular * (tinted + (DVec3::ONE - tinted) * rise)).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Direction of light that arrives opposite to `v` and is bent at the normal `h`; `None`: total internal reflection.
pub fn refract(v: DVec3, h: DVec3, eta: f64) -> Option<DVec3> {
    let cos = v.dot(h);
    let k = 1.0 - (1.0 - cos * cos) / (eta * eta);
    (k > 0.0).then(|| (cos / eta - k.sqrt()) * h - v / eta)
}

/// A microfacet that refracts `v` to `l`.
#[derive(Clone, Copy, Debug)]
pub struct Refraction {
    /// Its normal, on the side of `v`.
    pub h: DVec3,
    /// Density of `l` per solid angle, when normals are drawn by visibility from `v`.
    pub density: f64,
    /// BTDF (radiance) x |l.z|, without 1 - F.
    pub value: f64,
}

/// Walter et al. 2007, eq. 16 (half vector), 17 (Jacobian), 21 (BTDF). `None`: no microfacet does.
pub fn refraction(v: DVec3, l: DVec3, alpha: DVec2, eta: f64) -> Option<Refraction> {
    let h = (v + eta * l).normalize();
    let h = if h.z < 0.0 { -h } else { h };
    let (vh, lh) = (v.dot(h), l.dot(h));
    if vh <= 0.0 || lh >= 0.0 {
        return None;
    }
    let denominator = (vh + eta * lh).powi(2);
    let jacobian = eta * eta * lh.abs() / denominator;
    // Light goes from l to v: eq. 21 with i = l, o = v, and the indices of those sides; n_v = 1, n_l = eta.
    let g = ggx::g1(alpha, v) * ggx::g1(alpha, l);
    let value = vh * lh.abs() / (v.z * l.z.abs()) * g * ggx::d(alpha, h) / denominator * l.z.abs();
    Some(Refraction { h, density: ggx::vndf_pdf(v, h, alpha) * jacobian, value })
}
