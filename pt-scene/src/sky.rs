use glam::Vec3;

use crate::{Environment, EnvironmentImage, Light};

/// The sky that scenes without any light get, together with [`default_sun`].
///
/// A clear-day gradient over a pale ground, made by code in a 128x64 lat-long image: radiance 1.0 in a whitish
/// horizon, falling to a deeper blue of 0.5 at the zenith, 0.25 below the horizon, with a wide soft glow round the sun.
/// No sun disc is in the image: that is the directional light, which one sample finds for certain.
pub fn default_sky() -> Environment {
    sky(sun_direction(), 1.0)
}

/// The sun that goes with [`default_sky`]: warm white, pi lux (radiance 1 on a white surface that faces it), 40 degrees high, from the
/// right and front of a camera that looks along -Z; half a degree across.
pub fn default_sun() -> Light {
    Light {
        angular_radius: 0.25_f32.to_radians(),
        ..Light::directional(
            "default sun",
            -sun_direction(),
            std::f32::consts::PI * Vec3::new(1.0, 0.93, 0.82),
        )
    }
}

fn sun_direction() -> Vec3 {
    let (elevation, azimuth) = (40.0_f32.to_radians(), 55.0_f32.to_radians());
    Vec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos())
}

/// The gradient with its glow towards `sun` (unit), times `scale`.
pub(crate) fn sky(sun: Vec3, scale: f32) -> Environment {
    let (width, height) = (128u32, 64u32);
    let mut environment = Environment::new(EnvironmentImage { width, height, texels: vec![] });
    for y in 0..height {
        for x in 0..width {
            let uv = glam::Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
            let d = environment.direction(uv);
            environment.image.texels.push(scale * gradient(d, sun));
        }
    }
    environment
}

fn gradient(d: Vec3, sun: Vec3) -> Vec3 {
    let horizon = Vec3::new(0.95, 1.0, 1.05);
    let zenith = Vec3::new(0.26, 0.48, 0.95);
    let ground = Vec3::new(0.27, 0.25, 0.22);
    let above = horizon.lerp(zenith, d.y.clamp(0.0, 1.0).powf(0.55));
    let glow = Vec3::new(1.0, 0.85, 0.6) * 0.8 * d.dot(sun).max(0.0).powi(24);
    // The horizon itself is four degrees wide, so that a mirror shows no hard edge.
    let mix = ((d.y + 0.035) / 0.07).clamp(0.0, 1.0);
    ground.lerp(above + glow, mix)
}
