//! Coat and energy compensation around the microfacet lobes.

use super::albedo;
use glam::DVec3;
use std::f64::consts::PI;

/// Schlick 1994, eq. 15.
pub fn schlick(f0: DVec3, f90: f64, cos_theta: f64) -> DVec3 {
    f0 + (DVec3::splat(f90) - f0) * (1.0 - cos_theta).clamp(0.0, 1.0).powi(5)
}

/// Fresnel factor of light that has met more than one microfacet (Kulla and Conty 2017).
pub fn multiple_scattering_fresnel(f0: DVec3, f90: f64, mean_albedo: f64) -> DVec3 {
    let f = f0 + (DVec3::splat(f90) - f0) / 21.0;
    f * f * mean_albedo / (DVec3::ONE - f * (1.0 - mean_albedo))
}

/// Reflectance of the coat towards a viewer at that angle to the coat's normal.
pub fn coat_fresnel(cos_theta: f64) -> f64 {
    schlick(DVec3::splat(0.04), 1.0, cos_theta).x
}

/// An opaque surface's lobes as the compensation sees them.
#[derive(Clone, Copy, Debug)]
pub struct Compensated {
    /// Isotropic GGX alpha.
    pub alpha: f64,
    /// Reflectance of the dielectric at normal incidence.
    pub dielectric_f0: DVec3,
    /// Its specular factor.
    pub specular: f64,
    /// Reflectance of the metal at normal incidence.
    pub metal_f0: DVec3,
    /// Share of the metal.
    pub metallic: f64,
}

impl Compensated {
    /// BRDF of light that meets more than one microfacet (Kulla and Conty 2017).
    pub fn scattered(&self, v_z: f64, l_z: f64) -> DVec3 {
        let f0 = self.dielectric_f0.lerp(self.metal_f0, self.metallic);
        let f90 = self.specular + (1.0 - self.specular) * self.metallic;
        let whole = albedo::ggx_mean(self.alpha).element_sum();
        let lost = |z| 1.0 - albedo::ggx(z, self.alpha).element_sum();
        multiple_scattering_fresnel(f0, f90, whole) * (lost(v_z) * lost(l_z) / (1.0 - whole).max(1e-6)) / PI
    }

    /// BRDF of a white diffuse base under the dielectric (Kelemen and Szirmay-Kalos 2001).
    pub fn base(&self, v_z: f64, l_z: f64) -> f64 {
        let f0 = self.dielectric_f0.max_element();
        let mean = albedo::ggx_mean(self.alpha);
        let whole = mean.element_sum();
        let again = multiple_scattering_fresnel(DVec3::splat(f0), self.specular, whole).x;
        let e = |a: glam::DVec2| f0 * a.x + self.specular * a.y + again * (1.0 - a.element_sum());
        let [v, l] = [v_z, l_z].map(|z| 1.0 - e(albedo::ggx(z, self.alpha)));
        (1.0 - self.metallic) * v * l / (1.0 - e(mean)).max(1e-6) / PI
    }
}
