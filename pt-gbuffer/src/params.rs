//! Knobs.

use pt_core::random::RandomSource;
use pt_core::settings::{InvalidValue, Validate, check_range};
use pt_shaders::dimensions::MAX_REFLECT_REFRACT;
use pt_shaders::records::CameraRecord;
use serde::{Deserialize, Serialize};

/// Where in the pixel its ray goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Jitter {
    /// The centre.
    None,
    /// One offset for the whole frame: Halton (2, 3), period 128. What temporal anti-aliasing wants.
    Halton,
    /// One offset for the whole frame: R2 sequence, period 128.
    R2,
    /// A random offset for every pixel: the box filter, when frames are averaged.
    #[default]
    Pixel,
}

/// Knobs of the G-buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GbufferParams {
    /// `none`, `halton`, `r2` or `pixel`. Default `pixel`.
    pub jitter: Jitter,
    /// Depth of field with the camera's thin lens. Default true; without effect while the lens radius is 0.
    pub depth_of_field: bool,
    /// Thin lens radius in metres, instead of the camera's own. Range 0..1. Default: not set.
    pub lens_radius: Option<f32>,
    /// Distance in focus in metres, instead of the camera's own. Range 1e-3..1e6. Default: not set.
    pub focus_distance: Option<f32>,
    /// Bias on the texture level of detail, in mip levels; negative is sharper. Range -8..8, default 0.
    pub texture_lod_bias: f32,
    /// How many reflections and refractions are followed. Range 0..10, default 2: in and out of a glass. 0: mirrors and glass
    /// are regular surfaces.
    pub reflect_refract: u32,
    /// Perceptual roughness below which a metal is a mirror and an interface of glass is smooth. Range 0..1, default 0.02.
    pub mirror_roughness: f32,
    /// Perceptual roughness up to which transmissive materials are seen through; the rest are regular surfaces without the
    /// light that they transmit. Rough glass shows no highlights of punctual lights. Range 0..1, default 1.
    pub glass_roughness: f32,
    /// Whether reflection and refraction change fields from frame to frame, so that each pixel gets both. For averaged frames
    /// without blending of the fields. Default false: what temporal filters want.
    pub alternate_fields: bool,
    /// Where all stages of the frame have their random numbers from: `white`, `blue-noise` or `sobol`. Default `white`.
    pub random: RandomSource,
}

impl Default for GbufferParams {
    fn default() -> Self {
        Self {
            jitter: Jitter::default(),
            depth_of_field: true,
            lens_radius: None,
            focus_distance: None,
            texture_lod_bias: 0.0,
            reflect_refract: 2,
            mirror_roughness: 0.02,
            glass_roughness: 1.0,
            alternate_fields: false,
            random: RandomSource::default(),
        }
    }
}

impl GbufferParams {
    /// The camera with the lens that these knobs ask for.
    pub fn with_lens(&self, camera: CameraRecord) -> CameraRecord {
        let lens_radius = self.lens_radius.unwrap_or(camera.lens_radius);
        CameraRecord {
            lens_radius: if self.depth_of_field { lens_radius } else { 0.0 },
            focus_distance: self.focus_distance.unwrap_or(camera.focus_distance),
            ..camera
        }
    }
}

impl Validate for GbufferParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("texture_lod_bias", self.texture_lod_bias, -8.0..=8.0, "mip levels")?;
        check_range("reflect_refract", self.reflect_refract, 0..=MAX_REFLECT_REFRACT, "")?;
        check_range("mirror_roughness", self.mirror_roughness, 0.0..=1.0, "")?;
        check_range("glass_roughness", self.glass_roughness, 0.0..=1.0, "")?;
        if let Some(radius) = self.lens_radius {
            check_range("lens_radius", radius, 0.0..=1.0, "m")?;
        }
        if let Some(distance) = self.focus_distance {
            check_range("focus_distance", distance, 1e-3..=1e6, "m")?;
        }
        Ok(())
    }
}
