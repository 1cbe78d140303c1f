//! The surface of the path tracer; the model is described in bsdf.glsl.

use super::dielectric::{self, is_index_matched, refraction};
use super::layers::{self, Compensated, schlick};
use super::sheen;
use super::{albedo, basis_around, ggx, luminance, mirror, sample_cosine_hemisphere, thin_film};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Roughness below which a lobe is a delta.
pub const MIRROR_ROUGHNESS: f64 = 0.02;

/// A surface at a point, as seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    /// Tangent, bitangent, shading normal.
    pub frame: DMat3,
    /// Of the triangle, on the viewer's side.
    pub face_normal: DVec3,
    /// On the viewer's side.
    pub coat_normal: DVec3,
    /// Linear.
    pub base_color: DVec3,
    /// 0..1.
    pub metallic: f64,
    /// GGX along tangent and bitangent; 0: a delta.
    pub alpha: DVec2,
    /// Index of refraction behind the surface over that in front.
    pub eta: f64,
    /// KHR_materials_specular factor.
    pub specular: f64,
    /// And its colour.
    pub specular_color: DVec3,
    /// 0..1.
    pub transmission: f64,
    /// Clearcoat factor.
    pub coat: f64,
    /// 0: a delta.
    pub coat_alpha: f64,
    /// Linear.
    pub sheen_color: DVec3,
    /// Square of the sheen's roughness.
    pub sheen_alpha: f64,
    /// Strength of the thin film, 0..1.
    pub iridescence: f64,
    /// Its index of refraction.
    pub film_ior: f64,
    /// Its thickness, nm.
    pub film_thickness: f64,
    /// Light is bent on its way through.
    pub solid: bool,
    /// See bsdf.glsl.
    pub energy_compensation: bool,
}

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit.
    pub direction: DVec3,
    /// f |cos| / pdf.
    pub weight: DVec3,
    /// Density per solid angle, or probability of a delta.
    pub pdf: f64,
    /// Nothing else finds this direction.
    pub delta: bool,
    /// To the other side.
    pub transmission: bool,
}

/// Value and density for a pair of directions.
#[derive(Clone, Copy, Debug, Default)]
pub struct BsdfValue {
    /// f |cos|.
    pub f_cos: DVec3,
    /// Density per solid angle.
    pub pdf: f64,
}

/// GGX alpha of a perceptual roughness and an anisotropy strength.
pub fn ggx_alpha(roughness: f64, anisotropy: f64) -> DVec2 {
    if roughness < MIRROR_ROUGHNESS {
        return DVec2::ZERO;
    }
    let alpha = roughness * roughness;
    DVec2::new(alpha + (1.0 - alpha) * anisotropy * anisotropy, alpha)
}

/// The shading normal, bent until `wo` is reflected above the triangle (Keller et al. 2017, app. A.3).
pub fn bend_normal(n: DVec3, face_normal: DVec3, wo: DVec3) -> DVec3 {
    const ABOVE: f64 = 1e-3;
    let n = if n.dot(face_normal) <= 0.0 { face_normal } else { n };
    let mirrored = mirror(wo, n);
    let height = mirrored.dot(face_normal);
    if height >= ABOVE && n.dot(wo) > 0.0 {
        return n;
    }
    let h = wo + (mirrored + face_normal * (ABOVE - height)).normalize();
    if h.length_squared() > 1e-6 && h.dot(wo) > 0.0 { h.normalize() } else { face_normal }
}

/// Probabilities of the lobes, and what coat and sheen leave.
struct Lobes {
    coat: f64,
    base: f64,
    p: [f64; 3],
}

impl Bsdf {
    fn dielectric_fresnel(&self, cos_theta: f64) -> DVec3 {
        if self.transmission > 0.0 {
            let f = dielectric::fresnel(cos_theta, self.eta);
            if f >= 1.0 {
                return DVec3::ONE;
            }
            return dielectric::tint_specular(f, self.eta, self.specular, self.specular_color);
        }
        let f0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        schlick((f0 * self.specular_color).min(DVec3::ONE) * self.specular, self.specular, cos_theta)
    }

    /// Reflectance and transmittance of a microfacet.
    fn interface(&self, cos_theta: f64) -> (DVec3, f64) {
        let mut f = self.dielectric_fresnel(cos_theta);
        let mut metal = schlick(self.base_color, 1.0, cos_theta);
        if self.iridescence > 0.0 {
            let film = |f0, cos_theta| thin_film::fresnel(f0, self.film_ior, self.film_thickness, cos_theta);
            if f.min_element() < 1.0 {
                let inside = self.transmission > 0.0 && self.eta < 1.0;
                let sin2 = if inside { self.eta.powi(-2) } else { 1.0 } * (1.0 - cos_theta * cos_theta);
                let outside = (1.0 - sin2).max(0.0).sqrt();
                f = f.lerp(film(self.dielectric_fresnel(1.0), outside), self.iridescence);
            }
            metal = metal.lerp(film(self.base_color, cos_theta), self.iridescence);
        }
        (f.lerp(metal, self.metallic), (1.0 - self.metallic) * (1.0 - f.max_element()))
    }

    fn bends(&self) -> bool {
        self.solid && !is_index_matched(self.eta)
    }

    fn transmits_delta(&self) -> bool {
        self.alpha.x == 0.0 || self.solid && !self.bends()
    }

    fn compensated(&self) -> Compensated {
        Compensated {
            alpha: (self.alpha.x * self.alpha.y).sqrt(),
            dielectric_f0: self.dielectric_fresnel(1.0),
            specular: self.specular,
            metal_f0: self.base_color,
            metallic: self.metallic,
        }
    }

    fn lobes(&self, v: DVec3, wo: DVec3) -> Lobes {
        let coat =
            if self.coat > 0.0 { self.coat * layers::coat_fresnel(self.coat_normal.dot(wo)) } else { 0.0 };
        let base = 1.0 - coat;
        let sheen = self.sheen_color.max_element();
        let sheen_albedo = if sheen > 0.0 { albedo::charlie(v.z, self.sheen_alpha) } else { 0.0 };
        let left = base * (1.0 - sheen * sheen_albedo).max(0.0);
        let (reflected, passed) = self.interface(v.z);
        let passed = left * passed * luminance(self.base_color);
        let interface = left * luminance(reflected) + passed * self.transmission;
        let mut diffuse =
            passed * (1.0 - self.transmission) + base * luminance(self.sheen_color) * sheen_albedo;
        if self.energy_compensation && self.alpha.x > 0.0 {
            diffuse += left * luminance(self.compensated().scattered(v.z, v.z) * PI);
        }
        let p = [coat, interface, diffuse];
        let least = 0.05 * p.iter().sum::<f64>();
        let p = p.map(|x| if x > 0.0 { x.max(least) } else { 0.0 });
        let sum = p.iter().sum::<f64>().max(1e-20);
        Lobes { coat, base, p: p.map(|x| x / sum) }
    }

    fn reflect_probability(&self, (reflected, passed): (DVec3, f64)) -> f64 {
        let transmitted = passed * self.transmission * luminance(self.base_color);
        let reflected = luminance(reflected);
        if transmitted > 0.0 { reflected / (reflected + transmitted) } else { 1.0 }
    }

    fn reflection(&self, lobes: &Lobes, v: DVec3, l: DVec3) -> BsdfValue {
        let h = (v + l).normalize();
        let share = self.interface(v.dot(h));
        let mut r = BsdfValue { f_cos: DVec3::ZERO, pdf: lobes.p[2] * l.z / PI };
        if self.alpha.x > 0.0 {
            r.f_cos = share.0 * ggx::reflection(v, l, self.alpha);
            r.pdf += lobes.p[1] * self.reflect_probability(share) * ggx::reflection_pdf(v, l, self.alpha);
        }
        let mut diffuse = share.1 / PI;
        if self.energy_compensation {
            r.f_cos += self.compensated().scattered(v.z, l.z) * l.z;
            diffuse = self.compensated().base(v.z, l.z);
        }
        r.f_cos += self.base_color * (diffuse * (1.0 - self.transmission) * l.z);
        let sheen = self.sheen_color.max_element();
        if sheen > 0.0 {
            let e = albedo::charlie(v.z, self.sheen_alpha).max(albedo::charlie(l.z, self.sheen_alpha));
            r.f_cos *= (1.0 - sheen * e).max(0.0);
            r.f_cos += self.sheen_color * sheen::charlie(v, l, self.sheen_alpha);
        }
        r.f_cos *= lobes.base;
        r
    }

    fn transmission(&self, lobes: &Lobes, v: DVec3, l: DVec3) -> BsdfValue {
        if self.transmission <= 0.0 || self.metallic >= 1.0 || self.transmits_delta() {
            return BsdfValue::default();
        }
        let (h, density, value) = if self.solid {
            let Some(r) = refraction(v, l, self.alpha, self.eta) else { return BsdfValue::default() };
            (r.h, r.density, r.value)
        } else {
            let l = DVec3::new(l.x, l.y, -l.z);
            ((v + l).normalize(), ggx::reflection_pdf(v, l, self.alpha), ggx::reflection(v, l, self.alpha))
        };
        let share = self.interface(v.dot(h));
        let sheen = self.sheen_color.max_element();
        let left =
            if sheen > 0.0 { (1.0 - sheen * albedo::charlie(v.z, self.sheen_alpha)).max(0.0) } else { 1.0 };
        BsdfValue {
            f_cos: self.base_color * (share.1 * self.transmission * value * lobes.base * left),
            pdf: lobes.p[1] * (1.0 - self.reflect_probability(share)) * density,
        }
    }

    /// f |cos| and density for light from `wi` that leaves to `wo`, without deltas.
    pub fn evaluate(&self, wo: DVec3, wi: DVec3) -> BsdfValue {
        let (v, l) = (self.frame.transpose() * wo, self.frame.transpose() * wi);
        if v.z <= 0.0 {
            return BsdfValue::default();
        }
        let lobes = self.lobes(v, wo);
        if self.face_normal.dot(wi) <= 0.0 {
            return if l.z < 0.0 { self.transmission(&lobes, v, l) } else { BsdfValue::default() };
        }
        let mut r = if l.z > 0.0 { self.reflection(&lobes, v, l) } else { BsdfValue::default() };
        if lobes.coat > 0.0 && self.coat_alpha > 0.0 {
            let to_coat = basis_around(self.coat_normal).transpose();
            let (v, l) = (to_coat * wo, to_coat * wi);
            if v.z > 0.0 && l.z > 0.0 {
                let alpha = DVec2::splat(self.coat_alpha);
                r.f_cos += lobes.coat * ggx::reflection(v, l, alpha);
                r.pdf += lobes.p[0] * ggx::reflection_pdf(v, l, alpha);
            }
        }
        r
    }

    /// Draws a direction. `u`: direction within a lobe (2), which lobe, reflection or transmission. `None`: nothing.
    pub fn sample(&self, wo: DVec3, u: [f64; 4]) -> Option<BsdfSample> {
        let xi = DVec2::new(u[0], u[1]);
        let v = self.frame.transpose() * wo;
        if v.z <= 0.0 {
            return None;
        }
        let lobes = self.lobes(v, wo);
        let sheen = self.sheen_color.max_element();
        let mut base = lobes.base;
        if sheen > 0.0 {
            base *= (1.0 - sheen * albedo::charlie(v.z, self.sheen_alpha)).max(0.0);
        }
        let (mut delta, mut transmission, mut pmf, mut reflectance) = (false, false, 0.0, DVec3::ZERO);
        let direction = if u[2] < lobes.p[0] {
            let frame = basis_around(self.coat_normal);
            let v = frame.transpose() * wo;
            delta = self.coat_alpha == 0.0;
            let h = if delta { DVec3::Z } else { ggx::sample_vndf(v, DVec2::splat(self.coat_alpha), xi) };
            (pmf, reflectance) = (lobes.p[0], DVec3::splat(lobes.coat));
            let l = mirror(v, h);
            if l.z <= 0.0 {
                return None;
            }
            frame * l
        } else if u[2] < lobes.p[0] + lobes.p[1] {
            delta = self.alpha.x == 0.0;
            let h = if delta { DVec3::Z } else { ggx::sample_vndf(v, self.alpha, xi) };
            let share = self.interface(v.dot(h));
            let p = self.reflect_probability(share);
            transmission = u[3] >= p;
            let l = if !transmission {
                (pmf, reflectance) = (lobes.p[1] * p, base * share.0);
                mirror(v, h)
            } else {
                delta = self.transmits_delta();
                pmf = lobes.p[1] * (1.0 - p);
                reflectance = base * share.1 * self.transmission * self.base_color;
                if self.bends() {
                    reflectance /= self.eta * self.eta;
                    dielectric::refract(v, h, self.eta)?
                } else if delta {
                    -v
                } else {
                    let l = mirror(v, h);
                    DVec3::new(l.x, l.y, -l.z)
                }
            };
            if (l.z < 0.0) != transmission {
                return None;
            }
            self.frame * l
        } else {
            self.frame * sample_cosine_hemisphere(xi)
        };
        if (self.face_normal.dot(direction) > 0.0) == transmission {
            return None;
        }
        if delta {
            return Some(BsdfSample { direction, weight: reflectance / pmf, pdf: pmf, delta, transmission });
        }
        let value = self.evaluate(wo, direction);
        (value.pdf > 0.0).then(|| BsdfSample {
            direction,
            weight: value.f_cos / value.pdf,
            pdf: value.pdf,
            delta,
            transmission,
        })
    }
}
