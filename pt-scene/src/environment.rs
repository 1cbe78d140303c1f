use std::f32::consts::{PI, TAU};
use std::path::Path;

use glam::{Quat, Vec2, Vec3};
use pt_image::image_file::{LinearImage, MAX_IMAGE_SIDE, is_cube_map};

use crate::SceneError;
use crate::error::read_file;

/// Longest side of an environment image that is accepted.
pub const MAX_ENVIRONMENT_SIDE: u32 = MAX_IMAGE_SIDE;

/// Largest number of 16-bit floating point. Infinite values in files are brighter ones that did not fit.
const HALF_MAX: f32 = 65504.0;

/// Treatment of texels that are negative or not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BadTexels {
    /// They are an error.
    #[default]
    Refuse,
    /// Negative values and NaN become 0, infinite ones the largest number of 16-bit floating point.
    Clamp,
}

impl BadTexels {
    /// The treatment that a switch of the command line asks for.
    pub fn clamp_if(clamp: bool) -> Self {
        if clamp { Self::Clamp } else { Self::Refuse }
    }
}

/// Lat-long radiance, row 0 at the top (+Y).
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentImage {
    /// Texels once round the horizon, >= 1.
    pub width: u32,
    /// Rows from zenith to nadir, >= 1.
    pub height: u32,
    /// Linear radiance, finite and not negative, row by row.
    pub texels: Vec<Vec3>,
}

/// Light from infinitely far away: a lat-long image, turned and scaled.
///
/// v = 0 is +Y and v = 1 is -Y; u = 0.5 + atan2(z, x) / (2 pi), so that u = 0.5 looks along +X, 0.75 along +Z and
/// 0.25 along -Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The picture.
    pub image: EnvironmentImage,
    /// Radians by which the picture is turned about +Y, right-handed: what was seen along +Z is then, for a quarter
    /// turn, seen along +X.
    pub rotation: f32,
    /// Factor on every texel, >= 0.
    pub intensity: f32,
}

impl Default for Environment {
    fn default() -> Self {
        Self::black()
    }
}

impl Environment {
    /// No light.
    pub fn black() -> Self {
        Self::constant(Vec3::ZERO)
    }

    /// The same radiance from everywhere.
    pub fn constant(radiance: Vec3) -> Self {
        Self::new(EnvironmentImage { width: 1, height: 1, texels: vec![radiance] })
    }

    /// An image as it is.
    pub fn new(image: EnvironmentImage) -> Self {
        Self { image, rotation: 0.0, intensity: 1.0 }
    }

    /// Reads a lat-long image: Radiance `.hdr` or OpenEXR, told apart by content. [`LinearImage::decode`] says what of the file is
    /// honoured. Errors name the file and, for texels that are negative or not finite, their number and the first of them
    /// (column, row).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Ok(Self::read(path, BadTexels::Refuse)?.0)
    }

    /// As [`Environment::load`], with a choice about texels that are no radiance, and with what was changed, one sentence each.
    pub fn read(path: impl AsRef<Path>, bad: BadTexels) -> Result<(Self, Vec<String>), SceneError> {
        let path = path.as_ref();
        Self::decode(&read_file(path)?, path, bad)
    }

    /// As [`Environment::load`], from the bytes of a file; `name` stands for the file in messages. Memory is bounded by a
    /// multiple of the length of `bytes`.
    pub fn from_bytes(bytes: &[u8], name: impl AsRef<Path>) -> Result<Self, SceneError> {
        Ok(Self::decode(bytes, name.as_ref(), BadTexels::Refuse)?.0)
    }

    fn decode(bytes: &[u8], path: &Path, bad: BadTexels) -> Result<(Self, Vec<String>), SceneError> {
        if !matches!(bytes, [0x76, 0x2f, 0x31, 0x01, ..] | [b'#', b'?', ..]) {
            return Err(SceneError::file(path, "is neither a Radiance .hdr nor an OpenEXR image"));
        }
        if is_cube_map(bytes) {
            return Err(SceneError::file(
                path,
                "is a cube map (attribute envmap); only lat-long images are read",
            ));
        }
        let (image, mut notices) = LinearImage::decode(bytes).map_err(|what| SceneError::file(path, what))?;
        let LinearImage { width, height, pixels, .. } = image;
        let texels = pixels.into_iter().map(Vec3::from_array).collect();
        let mut image = EnvironmentImage { width, height, texels };
        if bad == BadTexels::Clamp {
            notices.extend(image.clamp());
        }
        let environment = Self::new(image);
        environment.check().map_err(|what| match environment.image.first_bad() {
            Some(_) => {
                SceneError::file(path, format!("{what}; --env-clamp loads it with such values set to 0"))
            }
            None => SceneError::file(path, what),
        })?;
        let of_file = |notice: String| format!("{}: {notice}", path.display());
        Ok((environment, notices.into_iter().map(of_file).collect()))
    }

    /// Whether no light comes from it.
    pub fn is_black(&self) -> bool {
        self.intensity == 0.0 || self.image.texels.iter().all(|&t| t == Vec3::ZERO)
    }

    /// Image coordinates 0..1 of a unit world direction.
    pub fn uv(&self, direction: Vec3) -> Vec2 {
        let d = Quat::from_rotation_y(-self.rotation) * direction;
        Vec2::new(0.5 + d.z.atan2(d.x) / TAU, d.y.clamp(-1.0, 1.0).acos() / PI)
    }

    /// Unit world direction of image coordinates; the inverse of [`Environment::uv`].
    pub fn direction(&self, uv: Vec2) -> Vec3 {
        let (azimuth, polar) = ((uv.x - 0.5) * TAU, uv.y * PI);
        let d = Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin());
        Quat::from_rotation_y(self.rotation) * d
    }

    /// Radiance from a unit world direction, bilinear between texel centres, wrapping round the horizon.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let uv = self.uv(direction);
        let (w, h) = (self.image.width as i64, self.image.height as i64);
        let (x, y) = (uv.x * w as f32 - 0.5, uv.y * h as f32 - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let texel = |dx: i64, dy: i64| {
            let column = (x.floor() as i64 + dx).rem_euclid(w);
            let row = (y.floor() as i64 + dy).clamp(0, h - 1);
            self.image.texels[(row * w + column) as usize]
        };
        let top = texel(0, 0).lerp(texel(1, 0), fx);
        let bottom = texel(0, 1).lerp(texel(1, 1), fx);
        top.lerp(bottom, fy) * self.intensity
    }

    pub(crate) fn check(&self) -> Result<(), String> {
        let EnvironmentImage { width, height, texels } = &self.image;
        if *width == 0 || *height == 0 || texels.len() != *width as usize * *height as usize {
            return Err(format!("{} texels for {width}x{height}", texels.len()));
        }
        if let Some(i) = self.image.first_bad() {
            let (x, y) = (i % *width as usize, i / *width as usize);
            let count = texels.iter().filter(|t| is_bad(t)).count();
            return Err(format!(
                "{count} of {} pixels are negative or not finite, the first at ({x}, {y}): {}",
                texels.len(),
                texels[i]
            ));
        }
        if !self.rotation.is_finite() || !(0.0..f32::INFINITY).contains(&self.intensity) {
            return Err(format!(
                "rotation {} or intensity {} is out of range",
                self.rotation, self.intensity
            ));
        }
        Ok(())
    }
}

/// Whether a texel is no radiance.
fn is_bad(texel: &Vec3) -> bool {
    !texel.is_finite() || texel.min_element() < 0.0
}

impl EnvironmentImage {
    fn first_bad(&self) -> Option<usize> {
        self.texels.iter().position(is_bad)
    }

    /// Makes every value a radiance; says what was changed.
    fn clamp(&mut self) -> Option<String> {
        let (mut dark, mut bright) = (0, 0);
        for texel in self.texels.iter_mut().filter(|texel| is_bad(texel)) {
            let values = texel.to_array();
            dark += usize::from(values.iter().any(|v| v.is_nan() || *v < 0.0));
            bright += usize::from(values.contains(&f32::INFINITY));
            *texel = Vec3::from_array(values.map(|v| if v == f32::INFINITY { HALF_MAX } else { v.max(0.0) }));
        }
        let count = self.texels.len();
        let text = |number, what: String| (number > 0).then(|| format!("{number} of {count} pixels {what}"));
        let dark = text(dark, "had negative values or NaN, which were set to 0".into());
        let bright = text(bright, format!("had infinite values, which were set to {HALF_MAX}"));
        let parts: Vec<_> = dark.into_iter().chain(bright).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}
