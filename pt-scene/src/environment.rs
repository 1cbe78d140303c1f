use std::f32::consts::{PI, TAU};
use std::io::Cursor;
use std::path::Path;

use glam::{Quat, Vec2, Vec3};

use crate::SceneError;
use crate::error::read_file;

/// Longest side of an environment image that is accepted.
pub const MAX_ENVIRONMENT_SIDE: u32 = 16384;

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

    /// Reads a lat-long image: Radiance `.hdr` or OpenEXR (first layer with R, G and B), told apart by content.
    ///
    /// Errors name the file and, for texels that are negative or not finite, their number and the first of them (column,
    /// row).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        Self::from_bytes(&read_file(path)?, path)
    }

    /// As [`Environment::load`], from the bytes of a file; `name` stands for the file in messages. Memory is bounded by a
    /// multiple of the length of `bytes`.
    pub fn from_bytes(bytes: &[u8], name: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = name.as_ref();
        let image = match bytes {
            [0x76, 0x2f, 0x31, 0x01, ..] => read_exr(bytes),
            [b'#', b'?', ..] => read_hdr(bytes),
            _ => Err("is neither a Radiance .hdr nor an OpenEXR image".into()),
        };
        let environment = Self::new(image.map_err(|what| SceneError::file(path, what))?);
        environment.check().map_err(|what| SceneError::file(path, what))?;
        Ok(environment)
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
        let bad = |t: &Vec3| !t.is_finite() || t.min_element() < 0.0;
        if let Some(i) = texels.iter().position(bad) {
            let (x, y) = (i % *width as usize, i / *width as usize);
            let count = texels.iter().filter(|t| bad(t)).count();
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

/// `most` texels a byte is more than the file's compression can reach on a picture: a short file with a huge header is no
/// reason to allocate.
fn check_size(width: u64, height: u64, bytes: &[u8], most: u64) -> Result<(), String> {
    let limit = u64::from(MAX_ENVIRONMENT_SIDE);
    if width == 0 || height == 0 || width > limit || height > limit {
        return Err(format!("{width}x{height} is outside 1x1 .. {limit}x{limit}"));
    }
    if width * height > most * bytes.len() as u64 {
        let bytes = bytes.len();
        return Err(format!("{width}x{height} texels cannot be in {bytes} bytes; the file is cut short"));
    }
    Ok(())
}

fn read_hdr(bytes: &[u8]) -> Result<EnvironmentImage, String> {
    use image::ImageDecoder;
    let decoder = image::codecs::hdr::HdrDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), bytes, 64)?;
    let pixels = image::DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?.into_rgb32f();
    let texels = pixels.pixels().map(|p| Vec3::from_array(p.0)).collect();
    Ok(EnvironmentImage { width, height, texels })
}

fn read_exr(bytes: &[u8]) -> Result<EnvironmentImage, String> {
    use exr::prelude::*;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        check_size(header.layer_size.width() as u64, header.layer_size.height() as u64, bytes, 512)?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![Vec3::ZERO; size.area()]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| {
                texels[at.y() * *width + at.x()] = Vec3::new(r, g, b)
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let size = image.layer_data.size;
    let (_, texels) = image.layer_data.channel_data.pixels;
    Ok(EnvironmentImage { width: size.width() as u32, height: size.height() as u32, texels })
}
