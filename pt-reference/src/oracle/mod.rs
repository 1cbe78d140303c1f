//! The mathematics of the path tracer's kernels on the CPU, plain and in double precision: what the kernels are tested against.
//!
//! Names are those of the GLSL functions: `ggx` is bsdf/ggx.glsl, `dielectric` is bsdf/fresnel.glsl and bsdf/refraction.glsl,
//! `layers` is bsdf/coat.glsl and bsdf/compensation.glsl, `sheen` is bsdf/sheen.glsl, `bsdf` is bsdf.glsl, `interior` is interior.glsl, `sampler` is sampler.glsl.
//! `airy` is what bsdf/thin_film.glsl approximates.

pub mod airy;
pub mod albedo;
pub mod bsdf;
pub mod dielectric;
pub mod ggx;
pub mod interior;
pub mod layers;
pub mod sampler;
pub mod sheen;
pub mod thin_film;

use glam::DVec3;
pub use pt_light_sampling::oracle::sampling::{basis_around, sample_cosine_hemisphere};

/// Rec. 709 luminance of linear RGB.
pub fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// `v` mirrored about the unit vector `h`, both pointing away from the surface.
pub fn mirror(v: DVec3, h: DVec3) -> DVec3 {
    2.0 * v.dot(h) * h - v
}
