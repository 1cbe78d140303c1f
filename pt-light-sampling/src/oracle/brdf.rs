//! Host twins of brdf.glsl and reflectance.glsl.

use super::sampling::{
    cosine_hemisphere_pdf, ggx_d, ggx_reflection_pdf, sample_cosine_hemisphere, sample_ggx_vndf,
};
use crate::luminance;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Lower bound of alpha = roughness^2.
pub const MIN_ALPHA: f64 = 1e-3;

/// A metallic-roughness surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brdf {
    /// Albedo of the diffuse base.
    pub albedo: DVec3,
    /// Specular reflectance at normal incidence.
    pub f0: DVec3,
    /// Specular reflectance at grazing incidence.
    pub f90: f64,
    /// F0 and f90 of the dielectric, under which the diffuse base lies.
    pub base: (DVec3, f64),
    /// One BRDF of mixed parameters instead of a mixture of two BRDFs.
    pub mixed: bool,
    /// GGX roughness.
    pub alpha: f64,
}

/// The two parts of a BRDF in 1/sr; `diffuse` leaves the albedo out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrdfValue {
    /// (1 - F) / pi.
    pub diffuse: DVec3,
    /// F D V.
    pub specular: DVec3,
}

fn schlick(f0: DVec3, f90: f64, cos_theta: f64) -> DVec3 {
    f0 + (DVec3::splat(f90) - f0) * (1.0 - cos_theta).clamp(0.0, 1.0).powi(5)
}

impl Brdf {
    /// From base colour, F0 and f90 of the dielectric, metalness and perceptual roughness.
    pub fn new(
        base_color: DVec3,
        (f0, f90): (DVec3, f64),
        metallic: f64,
        roughness: f64,
        mixed: bool,
    ) -> Self {
        Self {
            albedo: base_color * (1.0 - metallic),
            f0: f0.lerp(base_color, metallic),
            f90: f90 + (1.0 - f90) * metallic,
            base: (f0, f90),
            mixed,
            alpha: (roughness * roughness).max(MIN_ALPHA),
        }
    }

    /// Schlick's approximation of the Fresnel term.
    pub fn fresnel(&self, cos_theta: f64) -> DVec3 {
        schlick(self.f0, self.f90, cos_theta)
    }

    /// Part of the light that passes the interface, to the diffuse base.
    pub fn passed(&self, cos_theta: f64) -> DVec3 {
        if self.mixed {
            return DVec3::ONE - self.fresnel(cos_theta);
        }
        DVec3::splat(1.0 - schlick(self.base.0, self.base.1, cos_theta).max_element())
    }

    /// The BRDF for two directions in the frame of the normal.
    pub fn eval(&self, v: DVec3, l: DVec3) -> BrdfValue {
        if v.z <= 0.0 || l.z <= 0.0 {
            return BrdfValue { diffuse: DVec3::ZERO, specular: DVec3::ZERO };
        }
        let h = (v + l).normalize();
        let f = self.fresnel(v.dot(h));
        let a2 = self.alpha * self.alpha;
        let lambda = |cos: f64| (a2 + (1.0 - a2) * cos * cos).sqrt();
        let visibility = 0.5 / (l.z * lambda(v.z) + v.z * lambda(l.z));
        BrdfValue { diffuse: self.passed(v.dot(h)) / PI, specular: f * (ggx_d(self.alpha, h) * visibility) }
    }

    /// Diffuse base with its albedo, and specular lobe, times the cosine.
    pub fn whole_times_cosine(&self, v: DVec3, l: DVec3) -> DVec3 {
        let value = self.eval(v, l);
        (value.diffuse * self.albedo + value.specular) * l.z.max(0.0)
    }

    /// Probability with which [`Brdf::sample`] takes the specular lobe.
    pub fn specular_probability(&self, v: DVec3) -> f64 {
        let f = self.fresnel(v.z);
        let specular = luminance(f.as_vec3());
        let diffuse = luminance((self.albedo * self.passed(v.z)).as_vec3());
        if self.f90 <= 0.0 && self.f0.max_element() <= 0.0 {
            return 0.0;
        }
        if self.albedo.max_element() <= 0.0 {
            return 1.0;
        }
        (specular / (specular + diffuse).max(1e-20)).clamp(0.1, 0.9)
    }

    /// Direction for (cos x whole BRDF); `None` when it lies below the surface.
    pub fn sample(&self, v: DVec3, xi: DVec3) -> Option<DVec3> {
        let xy = DVec2::new(xi.x, xi.y);
        let l = if xi.z < self.specular_probability(v) {
            let h = sample_ggx_vndf(v, self.alpha, xy);
            2.0 * v.dot(h) * h - v
        } else {
            sample_cosine_hemisphere(xy)
        };
        (l.z > 0.0).then_some(l)
    }

    /// Density of [`Brdf::sample`] per solid angle.
    pub fn pdf(&self, v: DVec3, l: DVec3) -> f64 {
        if v.z <= 0.0 || l.z <= 0.0 {
            return 0.0;
        }
        let p = self.specular_probability(v);
        let specular = if p > 0.0 { p * ggx_reflection_pdf(v, l, self.alpha) } else { 0.0 };
        specular + (1.0 - p) * cosine_hemisphere_pdf(l.z)
    }
}
