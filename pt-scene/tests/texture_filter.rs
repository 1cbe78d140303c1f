//! The stochastic texture filter draws texels whose mean is what a sampler gives, and what the specification says of one.

use crate::common::samples::{case, samples_of, scene};
use glam::{Vec2, Vec3, Vec4};
use pt_core::test_support::TestDevice;
use pt_scene::{Filter, Material, MipFilter, Sampler, Texture, TextureRef, TextureUsage, Wrap};
use pt_shaders::records::{FEATURE_TEXTURE_FILTER, MAX_TEXTURE_ANISOTROPY};

const SIZE: [u32; 2] = [16, 8];
const DRAWS: usize = 4096;

/// Texels of a hash: neighbours have nothing in common.
fn texture(sampler: Sampler) -> Texture {
    let texels = (0..SIZE[0] * SIZE[1] * 4).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    Texture { sampler, ..Texture::rgba8("hash", SIZE, TextureUsage::Data, texels) }
}

fn material() -> Material {
    Material { base_color_texture: Some(TextureRef::new(0)), ..Material::default() }
}

/// Evenly distributed in four dimensions: Roberts' sequence, whose base is the root of x^5 = x + 1.
fn numbers(i: usize) -> Vec4 {
    const ROOT: f64 = 1.167_303_978_261_418_7;
    let digit = |k: i32| (0.5 + (i + 1) as f64 * ROOT.powi(-k)).fract().min(1.0 - 1e-7) as f32;
    Vec4::new(digit(1), digit(2), digit(3), digit(4))
}

/// Base colours of all draws at a point, and what the sampler gives.
fn drawn(device: &TestDevice, texture: &Texture, at: Vec2, footprint: Vec2) -> (Vec<Vec3>, Vec3) {
    let mut scene = scene(material(), vec![texture.clone()]);
    scene.meshes[0].colors.fill(Vec4::ONE);
    let cases: Vec<_> = (0..DRAWS).map(|i| case(at, footprint, numbers(i))).collect();
    let colors = samples_of(device, &scene, &cases, FEATURE_TEXTURE_FILTER);
    let filtered = samples_of(device, &scene, &cases[..1], 0)[0].base_color;
    (colors.iter().map(|r| r.base_color).collect(), filtered)
}

fn mean(colors: &[Vec3]) -> Vec3 {
    colors.iter().sum::<Vec3>() / colors.len() as f32
}

fn wrapped(wrap: Wrap, i: i32, n: i32) -> u32 {
    let at = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::MirroredRepeat => {
            let turn = i.rem_euclid(2 * n);
            turn.min(2 * n - 1 - turn)
        }
        Wrap::ClampToEdge => i.clamp(0, n - 1),
    };
    at as u32
}

/// Colour of a level at a place in UV, blended between four texels.
fn bilinear(texture: &Texture, level: usize, uv: Vec2) -> Vec3 {
    let mips = texture.mips();
    let size = SIZE.map(|side| (side >> level).max(1) as i32);
    let at = uv * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
    let (low, part) = (at.floor(), at - at.floor());
    let texel = |dx: i32, dy: i32| {
        let x = wrapped(texture.sampler.wrap_u, low.x as i32 + dx, size[0]);
        let y = wrapped(texture.sampler.wrap_v, low.y as i32 + dy, size[1]);
        let first = 4 * (y * size[0] as u32 + x) as usize;
        Vec3::from_array(std::array::from_fn(|i| f32::from(mips[level].texels[first + i]))) / 255.0
    };
    let row = |dy| texel(0, dy).lerp(texel(1, dy), part.x);
    row(0).lerp(row(1), part.y)
}

/// Vulkan 1.3, "Texel Anisotropic Filtering" and "LOD Operation", for a footprint along the axes.
fn specified(texture: &Texture, uv: Vec2, footprint: Vec2) -> Vec3 {
    let texels = footprint * Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    let ratio = (texels.max_element() / texels.min_element()).min(MAX_TEXTURE_ANISOTROPY);
    let axis = if texels.x >= texels.y { Vec2::X } else { Vec2::Y } * footprint;
    let levels = texture.mips().len();
    let lod = (texels.max_element() / ratio).log2().clamp(0.0, (levels - 1) as f32);
    let (level, part) = (lod.floor() as usize, lod.fract());
    let taps = ratio.ceil() as i32;
    let trilinear =
        |uv| bilinear(texture, level, uv).lerp(bilinear(texture, (level + 1).min(levels - 1), uv), part);
    let tap = |i: i32| trilinear(uv + axis * (i as f32 / (taps + 1) as f32 - 0.5));
    (1..=taps).map(tap).sum::<Vec3>() / taps as f32
}

/// Texels of 1/16 and 1/8 UV side; footprints from less than one texel to more than the texture.
#[test]
fn the_mean_of_draws_is_the_filtered_texture() {
    let device = TestDevice::open();
    let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    for (i, texels) in [0.3f32, 1.0, 1.7, 2.9, 6.0, 40.0].into_iter().enumerate() {
        let sampler = Sampler { wrap_u: wraps[i % 3], wrap_v: wraps[(i + 1) % 3], ..Sampler::default() };
        let texture = texture(sampler);
        let footprint = texels * Vec2::new(1.0 / 16.0, 1.0 / 8.0);
        for at in [Vec2::new(0.31, 0.47), Vec2::new(0.02, 0.03), Vec2::new(0.02, 0.96)] {
            let (colors, filtered) = drawn(&device, &texture, at, footprint);
            let (actual, expected) = (mean(&colors), specified(&texture, at, footprint));
            // 4096 evenly distributed draws of values between 0 and 1.
            assert!(actual.abs_diff_eq(expected, 4e-3), "{texels} {at}: {actual}, specified {expected}");
            // Samplers take weights of 8 bits and levels of detail of a few bits after the point.
            assert!(actual.abs_diff_eq(filtered, 1.5e-2), "{texels} {at}: {actual}, sampler {filtered}");
        }
    }
}

/// Footprints that are longer than wide: taps along the major axis.
#[test]
fn long_footprints_are_drawn_along_their_length() {
    let device = TestDevice::open();
    let texture = texture(Sampler::default());
    for [u, v] in [[5.0f32, 1.0], [1.0, 3.3], [7.9, 1.4], [16.0, 1.2], [0.5, 2.5]] {
        let footprint = Vec2::new(u / 16.0, v / 8.0);
        for at in [Vec2::new(0.31, 0.47), Vec2::new(0.02, 0.03)] {
            let (colors, _) = drawn(&device, &texture, at, footprint);
            let (actual, expected) = (mean(&colors), specified(&texture, at, footprint));
            assert!(actual.abs_diff_eq(expected, 4e-3), "{u} x {v}, {at}: {actual}, specified {expected}");
        }
    }
}

/// Every draw is a texel of the texture, not a blend.
#[test]
fn a_draw_is_one_texel() {
    let device = TestDevice::open();
    let texture = texture(Sampler::default());
    let texels: Vec<Vec3> = texture
        .mips()
        .iter()
        .flat_map(|level| {
            level
                .texels
                .as_chunks::<4>()
                .0
                .iter()
                .map(|t| t.map(|c| f32::from(c) / 255.0))
                .collect::<Vec<_>>()
        })
        .map(|[r, g, b, _]| Vec3::new(r, g, b))
        .collect();
    let (colors, _) = drawn(&device, &texture, Vec2::new(0.31, 0.47), Vec2::new(0.4, 0.2));
    for color in colors {
        assert!(texels.iter().any(|t| t.abs_diff_eq(color, 1e-3)), "{color}");
    }
}

/// Samplers that take the nearest texel or level are not filtered stochastically either.
#[test]
fn nearest_samplers_draw_the_nearest_texel() {
    let device = TestDevice::open();
    let nearest =
        Sampler { mag: Filter::Nearest, min: Filter::Nearest, mip: MipFilter::Nearest, ..Sampler::default() };
    for (sampler, texels) in [
        (nearest, 0.4),
        (nearest, 2.7),
        (Sampler { mip: MipFilter::Off, ..nearest }, 2.7),
        (Sampler { min: Filter::Linear, ..nearest }, 0.4),
        (Sampler { mag: Filter::Linear, ..nearest }, 1.2),
    ] {
        let texture = texture(sampler);
        let footprint = texels * Vec2::new(1.0 / 16.0, 1.0 / 8.0);
        let (colors, filtered) = drawn(&device, &texture, Vec2::new(0.33, 0.46), footprint);
        for color in colors {
            assert!(color.abs_diff_eq(filtered, 1e-3), "{sampler:?} {texels}: {color}, sampler {filtered}");
        }
    }
    // Linear texels of the finest level: no mips, however wide the footprint.
    let texture = texture(Sampler { mip: MipFilter::Off, ..Sampler::default() });
    let (colors, filtered) = drawn(&device, &texture, Vec2::new(0.33, 0.46), Vec2::splat(0.5));
    assert!(mean(&colors).abs_diff_eq(filtered, 1e-2), "{}, sampler {filtered}", mean(&colors));
}
