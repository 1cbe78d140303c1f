//! Procedural textures of the gallery: stone, wood, metal, cloth, paintings, leaves and a screen.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::super::noise::{fbm, normal_map, picture, roughness_map};
use crate::hash::hash;
use crate::{Sampler, Texture, Wrap};

const SIZE: u32 = 512;

fn color(r: f32, g: f32, b: f32) -> Vec3 {
    Vec3::new(r, g, b)
}

/// Dark lines where warped noise crosses its mean: 0 off, 1 on the vein.
fn vein(uv: Vec2, period: i32, sharpness: f32, seed: u32) -> f32 {
    let warp = Vec2::new(fbm(uv, period, 2, seed + 50), fbm(uv, period, 2, seed + 60)) - 0.5;
    let n = fbm(uv + 0.12 * warp, period, 5, seed);
    (1.0 - (n - 0.5).abs() * sharpness).max(0.0).powi(2)
}

/// Which of the 2 x 2 floor tiles, and the distance to its edge (0..0.25).
fn tile(uv: Vec2) -> (bool, f32, u32) {
    let cell = (uv * 2.0).floor();
    let f = uv * 2.0 - cell;
    let edge = f.min(1.0 - f).min_element() * 0.5;
    let (x, y) = (cell.x as u32 % 2, cell.y as u32 % 2);
    ((x + y) % 2 == 0, edge, x + 2 * y)
}

/// Chequered marble with thin joints; roughness differs between light stone, dark stone, veins and joints.
pub(super) fn floor() -> [Texture; 2] {
    let stone = |uv: Vec2| -> (Vec3, f32) {
        let (light, edge, seed) = tile(uv);
        if edge < 0.004 {
            return (color(0.16, 0.14, 0.12), 0.8);
        }
        let veins = vein(uv, 3, 14.0, 10 * seed);
        let cloud = fbm(uv, 4, 3, 90 + seed);
        if light {
            (
                color(0.76, 0.71, 0.63).lerp(color(0.42, 0.36, 0.31), 0.75 * veins) * (0.82 + 0.3 * cloud),
                0.16 + 0.15 * veins,
            )
        } else {
            (
                color(0.075, 0.085, 0.095).lerp(color(0.5, 0.48, 0.42), 0.6 * veins) * (0.8 + 0.5 * cloud),
                0.10 + 0.15 * veins,
            )
        }
    };
    // Roughness is broad: half the resolution does.
    [
        picture("floor", SIZE, |uv| (stone(uv).0, 1.0)),
        roughness_map("floor roughness", SIZE / 2, |uv| stone(uv).1),
    ]
}

/// Warm veined stone for columns and arches.
pub(super) fn stone() -> Texture {
    picture("stone", SIZE, |uv| {
        let cloud = fbm(uv, 3, 4, 200);
        let veins = vein(uv, 2, 18.0, 210);
        let base = color(0.60, 0.53, 0.43).lerp(color(0.72, 0.66, 0.56), cloud);
        (base.lerp(color(0.42, 0.30, 0.21), 0.45 * veins), 1.0)
    })
}

/// Lime plaster: colour and relief.
pub(super) fn plaster() -> [Texture; 2] {
    [
        picture("plaster", SIZE, |uv| {
            let stain = fbm(uv, 3, 5, 300);
            (
                color(0.70, 0.64, 0.55).lerp(color(0.80, 0.76, 0.69), stain)
                    * (0.94 + 0.12 * fbm(uv, 32, 3, 310)),
                1.0,
            )
        }),
        normal_map("plaster relief", SIZE / 2, |uv| 0.006 * fbm(uv, 12, 5, 320)),
    ]
}

/// Oak: growth rings drawn out along u.
pub(super) fn wood() -> Texture {
    picture("wood", SIZE / 2, |uv| {
        let warp = fbm(uv, 3, 4, 400);
        let ring = 0.5 + 0.5 * (TAU * (6.0 * uv.y + 1.6 * warp)).sin();
        let pore = fbm(Vec2::new(uv.x, uv.y * 8.0), 16, 3, 410);
        (
            color(0.24, 0.12, 0.055).lerp(color(0.42, 0.24, 0.12), 0.7 * ring + 0.3 * pore)
                * (0.8 + 0.35 * pore),
            1.0,
        )
    })
}

/// Grooves along u, for brushed metal.
pub(super) fn brushed() -> Texture {
    normal_map("brushed grooves", SIZE / 2, |uv| 0.0012 * fbm(Vec2::new(uv.x * 0.125, uv.y), 64, 3, 500))
}

/// A runner of cloth: a border, diamonds and a weave. u across, v along.
pub(super) fn carpet() -> [Texture; 2] {
    let dye = |uv: Vec2| {
        let red = color(0.30, 0.025, 0.03);
        let gold = color(0.60, 0.38, 0.10);
        let navy = color(0.03, 0.045, 0.12);
        let side = uv.x.min(1.0 - uv.x);
        if side < 0.05 || (0.13..0.145).contains(&side) {
            return gold;
        }
        if side < 0.13 {
            let bead = (Vec2::new((side - 0.09) * 2.0, (uv.y * 12.0).fract() / 12.0 - 1.0 / 24.0)).length();
            return if bead < 0.025 { gold } else { navy };
        }
        let f = ((uv * Vec2::new(1.0, 2.0)).fract() - 0.5).abs();
        match f.x * 1.5 + f.y {
            d if d < 0.10 => gold,
            d if d < 0.26 => navy,
            d if d < 0.30 => gold,
            _ => red,
        }
    };
    [
        picture("carpet", SIZE, |uv| (dye(uv) * (0.7 + 0.5 * fbm(uv, 128, 2, 600)), 1.0)),
        normal_map("carpet weave", SIZE, |uv| {
            let p = uv * 64.0 * TAU;
            0.0016 * (p.x.sin() * p.y.sin()).abs()
        }),
    ]
}

/// Sunset over hills.
pub(super) fn landscape() -> Texture {
    framed(picture("landscape", SIZE, |uv| {
        let sun = uv.distance(Vec2::new(0.66, 0.42));
        let mut c = color(0.95, 0.55, 0.22).lerp(color(0.10, 0.16, 0.42), (1.0 - uv.y / 0.6).clamp(0.0, 1.0));
        c += color(1.0, 0.5, 0.15) * (-sun * 9.0).exp()
            + 0.15 * fbm(Vec2::new(uv.x, uv.y * 3.0), 4, 5, 700) * Vec3::ONE;
        if sun < 0.055 {
            c = color(1.0, 0.85, 0.5);
        }
        for layer in 0..4u32 {
            let depth = layer as f32 / 3.0;
            let ridge = 0.50
                + 0.11 * depth
                + 0.20
                    * (0.6 - 0.3 * depth)
                    * (fbm(Vec2::new(uv.x, 0.37), 3 + layer as i32, 5, 710 + layer) - 0.5);
            if uv.y > ridge {
                let grain = fbm(uv, 24, 4, 720 + layer);
                c = color(0.42, 0.25, 0.34).lerp(color(0.03, 0.07, 0.05), depth) * (0.7 + 0.6 * grain);
            }
        }
        (c, 1.0)
    }))
}

/// Overlapping discs and bars in flat colours.
pub(super) fn abstraction() -> Texture {
    framed(picture("abstraction", SIZE / 2, |uv| {
        let mut c = color(0.80, 0.74, 0.62) * (0.9 + 0.2 * fbm(uv, 32, 3, 800));
        let dyes = [
            color(0.65, 0.06, 0.05),
            color(0.04, 0.12, 0.40),
            color(0.85, 0.55, 0.05),
            color(0.02, 0.02, 0.025),
            color(0.05, 0.35, 0.30),
        ];
        for i in 0..9 {
            let center = Vec2::new(0.12 + 0.76 * hash(i, 1, 810), 0.12 + 0.76 * hash(i, 2, 810));
            let radius = 0.05 + 0.17 * hash(i, 3, 810);
            let d = uv.distance(center);
            let ring = i % 3 == 0;
            if d < radius && !(ring && d < 0.7 * radius) {
                c = c.lerp(dyes[i as usize % dyes.len()], 0.9);
            }
            let bar = (uv - center).rotate(Vec2::from_angle(TAU * hash(i, 4, 810)));
            if bar.x.abs() < 0.006 && bar.y.abs() < 0.33 {
                c = dyes[3];
            }
        }
        (c, 1.0)
    }))
}

/// Interference of three waves, in blues.
pub(super) fn waves() -> Texture {
    framed(picture("waves", SIZE / 2, |uv| {
        let ripple = |x: f32, y: f32, n: f32| (TAU * n * uv.distance(Vec2::new(x, y))).sin();
        let s = (ripple(0.2, 0.25, 11.0) + ripple(0.85, 0.4, 9.0) + ripple(0.45, 0.95, 7.0)) / 3.0;
        let c = color(0.01, 0.05, 0.16).lerp(color(0.10, 0.55, 0.62), 0.5 + 0.5 * s);
        (c.lerp(color(0.95, 0.9, 0.7), (s - 0.62).max(0.0) * 2.5), 1.0)
    }))
}

/// A leaf per texture: alpha cut, with a midrib.
pub(super) fn leaf() -> Texture {
    framed(picture("leaf", 256, |uv| {
        let p = Vec2::new((uv.x - 0.5).abs(), 1.0 - uv.y);
        let outline = 0.36 * (p.y * std::f32::consts::PI).sin().max(0.0).powf(0.75) * (1.15 - 0.5 * p.y);
        let notch = 0.05 * (p.y * 34.0).sin().abs();
        let rib = (1.0 - p.x * 60.0).max(0.0)
            + 0.5 * (1.0 - ((p.y * 11.0 - p.x * 9.0).fract() - 0.5).abs() * 9.0).max(0.0);
        let green = color(0.045, 0.16, 0.03).lerp(color(0.14, 0.33, 0.06), fbm(uv, 6, 4, 900));
        (green.lerp(color(0.30, 0.42, 0.14), 0.6 * rib.min(1.0)), f32::from(u8::from(p.x < outline - notch)))
    }))
}

/// A pierced metal screen: eight-pointed stars in a lattice.
pub(super) fn screen() -> Texture {
    picture("screen", 256, |uv| {
        let p = (uv * 2.0).fract() - 0.5;
        let a = p.abs();
        let square = a.max_element() - 0.27;
        let diamond = (a.x + a.y) * std::f32::consts::FRAC_1_SQRT_2 - 0.27;
        let star = square.min(diamond);
        let solid =
            !(-0.025..=0.0).contains(&star) && star > -0.12 && (star < 0.045 || a.min_element() < 0.03)
                || (-0.04..0.03).contains(&star);
        (Vec3::splat(0.8), f32::from(u8::from(solid)))
    })
}

/// Pictures do not repeat.
fn framed(texture: Texture) -> Texture {
    Texture {
        sampler: Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge, ..Sampler::default() },
        ..texture
    }
}
