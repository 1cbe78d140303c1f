use super::*;
use crate::{Material, Sampler, TextureUsage};
use glam::{Affine2, Vec3, Vec4};

/// Numbers in 0..1 that are the same in every run (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

const WIDTH: u32 = 29;
const HEIGHT: u32 = 18;

/// A hole, a solid part, and a border of single codes between them.
fn texture(wrap: Wrap) -> Texture {
    let alpha =
        |x: u32, y: u32| (20.0 * ((x as f32 - 11.0).hypot(y as f32 - 8.0) - 4.0)).clamp(0.0, 255.0) as u8;
    let texels = (0..WIDTH * HEIGHT).flat_map(|i| [0, 0, 0, alpha(i % WIDTH, i / WIDTH)]).collect();
    let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
    Texture { sampler, ..Texture::rgba8("holes", [WIDTH, HEIGHT], TextureUsage::Color, texels) }
}

/// The texel at a place that may lie outside of the picture, as the Vulkan specification defines addressing.
fn addressed(texture: &Texture, x: i64, y: i64) -> f32 {
    let wrapped = |i: i64, size: i64| match texture.sampler.wrap_u {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::ClampToEdge => i.clamp(0, size - 1),
        Wrap::MirroredRepeat => {
            let i = i.rem_euclid(2 * size);
            if i < size { i } else { 2 * size - 1 - i }
        }
    };
    texture.texel(wrapped(x, i64::from(WIDTH)) as u32, wrapped(y, i64::from(HEIGHT)) as u32)[3]
}

fn filtered(texture: &Texture, uv: Vec2) -> f32 {
    let at = uv * Vec2::new(WIDTH as f32, HEIGHT as f32) - 0.5;
    let (corner, part) = (at.floor(), at - at.floor());
    let texel = |dx: i64, dy: i64| addressed(texture, corner.x as i64 + dx, corner.y as i64 + dy);
    let row = |dy: i64| texel(0, dy) * (1.0 - part.x) + texel(1, dy) * part.x;
    row(0) * (1.0 - part.y) + row(1) * part.y
}

fn scene(wrap: Wrap, alpha_mode: AlphaMode, corners: [Vec2; 3]) -> Scene {
    let turned = Affine2::from_scale_angle_translation(Vec2::new(1.5, 0.8), 0.4, Vec2::new(0.3, 0.4));
    let material = Material {
        alpha_mode,
        base_color: Vec4::new(1.0, 1.0, 1.0, 0.9),
        base_color_texture: Some(TextureRef { transform: turned, ..TextureRef::new(0) }),
        ..Material::default()
    };
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        uv0: corners.into(),
        uv1: vec![Vec2::ZERO; 3],
        colors: vec![Vec4::ONE; 3],
        indices: vec![[0, 1, 2]],
        triangle_materials: vec![0],
        ..Mesh::default()
    };
    Scene { meshes: vec![mesh], materials: vec![material], textures: vec![texture(wrap)], ..Scene::default() }
}

/// The micro-triangle that a point lies in, by its three inequalities.
fn number(u: f64, v: f64) -> u32 {
    let mut number = 0;
    for row in 0..OPACITY_SIDE {
        for place in 0..2 * (OPACITY_SIDE - row) - 1 {
            let (left, between) = (place / 2, place % 2 == 1);
            let (u, v) = (u * 8.0 - f64::from(left), v * 8.0 - f64::from(row));
            let inside = if between {
                u <= 1.0 && v <= 1.0 && u + v >= 1.0
            } else {
                u >= 0.0 && v >= 0.0 && u + v <= 1.0
            };
            if inside {
                return number;
            }
            number += 1;
        }
    }
    unreachable!("{u}, {v}")
}

/// A known state is that of every point of its micro-triangle, and most are known where the texture has large parts of one state.
#[test]
fn states_hold_for_all_their_points() {
    let mut random = Random(5);
    for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
        for alpha_mode in
            [AlphaMode::Mask { cutoff: 0.5 }, AlphaMode::Mask { cutoff: 0.05 }, AlphaMode::Blend]
        {
            let (mut known, mut all, mut seen) = (0, 0, [0; 3]);
            for _ in 0..40 {
                let size = 2.0 * random.unit();
                let corners = [0; 3].map(|_| {
                    Vec2::new((size * random.unit() - 1.0) as f32, (size * random.unit() - 1.0) as f32)
                });
                let scene = scene(wrap, alpha_mode, corners);
                let [table] = &opacity_tables(&scene)[..] else { panic!("one mesh") };
                for _ in 0..400 {
                    let (a, b) = (random.unit(), random.unit());
                    let (u, v) = if a + b < 1.0 { (a, b) } else { (1.0 - a, 1.0 - b) };
                    let index = number(u, v);
                    let state = table[0][(index / 16) as usize] >> (2 * (index % 16)) & 3;
                    let uv = corners[0]
                        + (corners[1] - corners[0]) * u as f32
                        + (corners[2] - corners[0]) * v as f32;
                    let slot = scene.materials[0].base_color_texture.unwrap();
                    let alpha = 0.9 * filtered(&scene.textures[0], slot.transform.transform_point2(uv));
                    let expected = match alpha_mode {
                        AlphaMode::Mask { cutoff } if alpha >= cutoff => OPACITY_OPAQUE,
                        AlphaMode::Mask { .. } => OPACITY_TRANSPARENT,
                        _ if alpha >= 1.0 => OPACITY_OPAQUE,
                        _ if alpha <= 0.0 => OPACITY_TRANSPARENT,
                        _ => OPACITY_UNKNOWN,
                    };
                    all += 1;
                    known += usize::from(state != OPACITY_UNKNOWN);
                    seen[state as usize] += 1;
                    assert!(
                        state == OPACITY_UNKNOWN || state == expected,
                        "{wrap:?}, {alpha_mode:?}: {state} at {alpha}"
                    );
                }
            }
            println!("{wrap:?}, {alpha_mode:?}: {known} of {all} points need no texture");
            assert!(seen[OPACITY_TRANSPARENT as usize] > 0, "{seen:?}");
            // A factor of 0.9 leaves nothing opaque that is blended.
            assert_eq!(seen[OPACITY_OPAQUE as usize] > 0, alpha_mode != AlphaMode::Blend, "{seen:?}");
        }
    }
}

/// Coordinates that fp32 does not tell apart are left to the test of the device, and so is alpha that changes over the triangle.
#[test]
fn what_is_not_certain_is_unknown() {
    let far = scene(Wrap::Repeat, AlphaMode::Mask { cutoff: 0.5 }, [Vec2::splat(1e9), Vec2::ZERO, Vec2::X]);
    assert_eq!(opacity_tables(&far), [vec![uniform(OPACITY_UNKNOWN)]]);
    let mut changing = scene(Wrap::Repeat, AlphaMode::Blend, [Vec2::ZERO, Vec2::X, Vec2::Y]);
    changing.meshes[0].colors[1].w = 0.0;
    assert_eq!(opacity_tables(&changing), [vec![uniform(OPACITY_UNKNOWN)]]);
    let mut absent = changing.clone();
    absent.materials[0].base_color.w = 0.0;
    absent.meshes[0].colors[1].w = 1.0;
    assert_eq!(opacity_tables(&absent), [vec![uniform(OPACITY_TRANSPARENT)]]);
}
