//! Tiling noise and image helpers for procedural textures.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::hash::hash;
use crate::{Texture, TextureUsage, srgb_from_linear};

/// Value noise, 0..1, that repeats after `period` cells.
pub(super) fn value_noise(p: Vec2, period: i32, seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let (x, y) = (cell.x as i32, cell.y as i32);
    let corner = |dx: i32, dy: i32| hash((x + dx).rem_euclid(period), (y + dy).rem_euclid(period), seed);
    let top = corner(0, 0) + s.x * (corner(1, 0) - corner(0, 0));
    let bottom = corner(0, 1) + s.x * (corner(1, 1) - corner(0, 1));
    top + s.y * (bottom - top)
}

/// Fractal sum of value noise over the unit square, 0..1, tiling; `period` cells in the first octave.
pub(super) fn fbm(uv: Vec2, period: i32, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight, mut total) = (0.0, 0.5, 0.0);
    for octave in 0..octaves {
        let cells = period << octave;
        sum += weight * value_noise(uv * cells as f32, cells, seed + octave);
        total += weight;
        weight *= 0.5;
    }
    sum / total
}

/// A picture from linear colours and alpha over 0..1 x 0..1, v down.
pub(super) fn picture(name: &str, size: u32, color: impl Fn(Vec2) -> (Vec3, f32) + Sync) -> Texture {
    texture(name, size, true, |uv| {
        let (c, alpha) = color(uv);
        [
            srgb_from_linear(c.x.clamp(0.0, 1.0)),
            srgb_from_linear(c.y.clamp(0.0, 1.0)),
            srgb_from_linear(c.z.clamp(0.0, 1.0)),
            alpha,
        ]
    })
}

/// A data texture: roughness in G, metallic in B.
pub(super) fn roughness_map(name: &str, size: u32, roughness: impl Fn(Vec2) -> f32 + Sync) -> Texture {
    texture(name, size, false, |uv| [1.0, roughness(uv), 1.0, 1.0])
}

/// A normal map from heights, both in units of the texture's side: a slope of 1 is 45 degrees. Tiles.
pub(super) fn normal_map(name: &str, size: u32, height: impl Fn(Vec2) -> f32 + Sync) -> Texture {
    let at = |i: u32| Vec2::new((i % size) as f32 + 0.5, (i / size) as f32 + 0.5) / size as f32;
    let heights: Vec<f32> = (0..size * size).into_par_iter().map(|i| height(at(i))).collect();
    texture(name, size, false, |uv| {
        let (x, y) = ((uv.x * size as f32) as u32, (uv.y * size as f32) as u32);
        let h = |dx: u32, dy: u32| heights[((y + dy) % size * size + (x + dx) % size) as usize];
        let per_texel = 0.5 * size as f32;
        // v runs down, the green channel up.
        let slope = Vec2::new(h(1, 0) - h(size - 1, 0), h(0, 1) - h(0, size - 1)) * per_texel;
        let n = Vec3::new(-slope.x, slope.y, 1.0).normalize();
        [0.5 + 0.5 * n.x, 0.5 + 0.5 * n.y, 0.5 + 0.5 * n.z, 1.0]
    })
}

fn texture(name: &str, size: u32, srgb: bool, texel: impl Fn(Vec2) -> [f32; 4] + Sync) -> Texture {
    let row = |y: u32| -> Vec<u8> {
        let at = |x| Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / size as f32;
        (0..size).flat_map(|x| texel(at(x)).map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)).collect()
    };
    let texels = (0..size).into_par_iter().flat_map_iter(row).collect();
    let usage = if srgb { TextureUsage::Color } else { TextureUsage::Data };
    Texture::rgba8(name, [size, size], usage, texels)
}
