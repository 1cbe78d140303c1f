//! The composite on the CPU: what `composite.comp` is tested against.

use crate::DenoiseParams;
use pt_shaders::glam::DVec3;
use pt_shaders::records::{Background, FLAG_PRIMARY};
use std::f64::consts::PI;

/// The inputs of the composite at one pixel, in the units of the channels of the same names.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Direct diffuse light.
    pub color_hf: [f32; 3],
    /// Irradiance of indirect diffuse light at the pixel's normal.
    pub irradiance_lf: [f32; 3],
    /// Specular light, demodulated.
    pub color_spec: [f32; 3],
    /// Base colour and F0 of the dielectric.
    pub base_color: [f32; 4],
    /// Metalness.
    pub metallic: f32,
    /// Material index + 1, or 0 for no surface.
    pub material: u32,
    /// Checkerboard flags.
    pub flags: u32,
    /// Path throughput.
    pub throughput: [f32; 3],
    /// Premultiplied layer in front.
    pub transparent: [f32; 4],
}

/// Specular reflection over F0 of light in spherical harmonics, as if it came from one direction. `luma`, `rgb`: the whole light in spherical harmonics, and its colour as an
/// integral over directions; `normal`, `ray`: unit vectors, the latter into the surface.
pub fn reflected(luma: [f64; 4], rgb: [f64; 3], normal: DVec3, ray: DVec3, roughness: f64) -> [f64; 3] {
    let directed = DVec3::new(luma[0], luma[1], luma[2]) / luma[3] / 3f64.sqrt();
    let sharpness = directed.length().min(1.0);
    let mirrored = ray - 2.0 * ray.dot(normal) * normal;
    let light = mirrored.lerp(directed.normalize_or_zero(), sharpness).normalize();
    let alpha = (1.0 + (roughness - 1.0) * sharpness).max(0.01).powi(2);
    let (n_l, n_v) = (normal.dot(light), -normal.dot(ray));
    if luma[3] <= 0.0 || n_l <= 0.0 || n_v <= 0.0 {
        return [0.0; 3];
    }
    let n_h = normal.dot((light - ray).normalize());
    let distribution = alpha.powi(2) / (PI * (n_h * n_h * (alpha * alpha - 1.0) + 1.0).powi(2));
    let root = |c: f64| (alpha * alpha + (1.0 - alpha * alpha) * c * c).sqrt();
    let visibility = 0.5 / (n_l * root(n_v) + n_v * root(n_l));
    rgb.map(|v| v.max(0.0) * distribution * visibility * n_l)
}

/// Diffuse albedo.
pub fn diffuse_albedo(base_color: f64, metallic: f64) -> f64 {
    base_color * (1.0 - metallic)
}

/// Specular reflectance at normal incidence of a mixture of a dielectric and a metal.
pub fn specular_f0(base_color: f64, metallic: f64, dielectric: f64) -> f64 {
    dielectric * (1.0 - metallic) + base_color * metallic
}

/// Radiance, and the flags in alpha; 0 for a pixel of a transparent background.
pub fn composite(pixel: &Pixel, params: &DenoiseParams) -> [f64; 4] {
    if params.background == Background::Transparent && pixel.material == 0 && pixel.flags == FLAG_PRIMARY {
        return [0.0; 4];
    }
    let overlay = pixel.transparent.map(f64::from);
    let mut out = [0.0, 0.0, 0.0, f64::from(pixel.flags)];
    for i in 0..3 {
        let base = f64::from(pixel.base_color[i]);
        let metallic = f64::from(pixel.metallic);
        let mut light = 0.0;
        if pixel.material != 0 {
            let albedo = params.fixed_albedo.map_or(diffuse_albedo(base, metallic), f64::from);
            let f0 = specular_f0(base, metallic, f64::from(pixel.base_color[3]));
            light += f64::from(pixel.color_hf[i]) * albedo * f64::from(params.scale_hf);
            light += f64::from(pixel.irradiance_lf[i]) / PI * albedo * f64::from(params.scale_lf);
            light += f64::from(pixel.color_spec[i]) * f0.max(0.01) * f64::from(params.scale_spec);
            light *= f64::from(pixel.throughput[i]);
        }
        out[i] = light * (1.0 - overlay[3]) + overlay[i] * f64::from(params.scale_overlay);
    }
    out
}
