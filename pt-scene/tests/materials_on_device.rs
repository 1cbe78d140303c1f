//! surface.glsl reads materials and textures as the host does.

use crate::common::samples::{samples, scene};
use glam::{Affine2, Vec2, Vec3, Vec4};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_scene::gpu::GpuScene;
use pt_scene::{
    AlphaMode, BlockFormat, Filter, Lobes, Material, MipFilter, Sampler, Texels, Texture, TextureRef,
    TextureUsage, Wrap, linear_from_srgb,
};
use pt_shaders::records::{FEATURE_SECOND_UV, FEATURE_TEXTURE_TRANSFORM, FEATURE_VERTEX_COLOR};

#[test]
fn features_name_what_is_beyond_plain_textures() {
    let device = TestDevice::open();
    let texel = [200, 100, 50, 255];
    let extra = FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_UV | FEATURE_VERTEX_COLOR;
    let turned = Affine2::from_angle(0.5);
    for (color, texture, expected) in [
        (Vec4::ONE, TextureRef::new(0), 0),
        (Vec4::new(1.0, 1.0, 1.0, 0.5), TextureRef::new(0), FEATURE_VERTEX_COLOR),
        (Vec4::ONE, TextureRef { uv_set: 1, ..TextureRef::new(0) }, FEATURE_SECOND_UV),
        (Vec4::ONE, TextureRef { transform: turned, ..TextureRef::new(0) }, FEATURE_TEXTURE_TRANSFORM),
    ] {
        let material = Material { base_color_texture: Some(texture), ..Material::default() };
        let mut scene = scene(material, vec![flat(TextureUsage::Color, texel)]);
        scene.meshes[0].colors.fill(color);
        let features = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap().features();
        assert_eq!(features & extra, expected);
        let [sample] = samples(&device, &scene, &[Vec2::splat(0.3)], 0.0)[..] else { panic!() };
        near3(
            sample.base_color,
            Vec3::from_array([200, 100, 50].map(|v| linear_from_srgb(v as f32 / 255.0))),
        );
    }
}

fn flat(usage: TextureUsage, texel: [u8; 4]) -> Texture {
    Texture::rgba8("flat", [1, 1], usage, texel.to_vec())
}

fn near(actual: f32, expected: f32) {
    assert!((actual - expected).abs() < 2e-3, "{actual}, expected {expected}");
}

fn near3(actual: Vec3, expected: Vec3) {
    assert!(actual.abs_diff_eq(expected, 3e-3), "{actual}, expected {expected}");
}

#[test]
fn every_factor_is_multiplied_by_its_texture() {
    let device = TestDevice::open();
    let data = |texel| flat(TextureUsage::Data, texel);
    // All different, so that a slot or a channel that is mistaken for another shows.
    let textures = vec![
        data([51, 0, 0, 255]),
        data([255, 102, 0, 255]),
        data([255, 255, 255, 153]),
        flat(TextureUsage::Color, [188, 0, 255, 10]),
        data([204, 0, 0, 255]),
        data([0, 51, 0, 255]),
        flat(TextureUsage::Normal, [204, 128, 230, 255]),
        flat(TextureUsage::Color, [255, 188, 0, 102]),
        data([128, 255, 51, 255]),
        data([153, 77, 0, 255]),
        flat(TextureUsage::Cutout, [255, 255, 188, 204]),
    ];
    let t = |index| Some(TextureRef::new(index));
    let material = Material {
        base_color: Vec4::new(1.0, 1.0, 0.5, 0.5),
        base_color_texture: t(10),
        alpha_mode: AlphaMode::Blend,
        metallic: 0.5,
        roughness: 0.5,
        metallic_roughness_texture: t(1),
        ior: 1.7,
        transmission: 0.5,
        transmission_texture: t(0),
        specular: 0.5,
        specular_texture: t(2),
        specular_color: Vec3::new(1.0, 0.5, 0.25),
        specular_color_texture: t(3),
        lobes: Some(Box::new(Lobes {
            clearcoat: 0.5,
            clearcoat_texture: t(4),
            clearcoat_roughness: 0.5,
            clearcoat_roughness_texture: t(5),
            clearcoat_normal_texture: t(6),
            clearcoat_normal_scale: 1.0,
            sheen_color: Vec3::new(1.0, 0.5, 1.0),
            sheen_color_texture: t(7),
            sheen_roughness: 0.5,
            sheen_roughness_texture: t(7),
            anisotropy_strength: 0.5,
            anisotropy_rotation: std::f32::consts::FRAC_PI_2,
            anisotropy_texture: t(8),
            iridescence: 0.5,
            iridescence_texture: t(9),
            iridescence_ior: 1.4,
            iridescence_thickness_min: 200.0,
            iridescence_thickness_max: 300.0,
            iridescence_thickness_texture: t(9),
            dispersion: 0.3,
        })),
        ..Material::default()
    };
    let scene = scene(material, textures);
    let r = samples(&device, &scene, &[Vec2::splat(0.3)], 0.0)[0];
    let half = linear_from_srgb(188.0 / 255.0);
    near3(r.base_color, Vec3::new(1.0, 0.5, 0.5 * half));
    // Factor x texture x vertex colour.
    near(r.alpha, 0.5 * 0.8 * 0.5);
    near(r.metallic, 0.0);
    near(r.roughness, 0.2);
    near(r.ior, 1.7);
    near(r.transmission, 0.1);
    near(r.specular, 0.3);
    near3(r.specular_color, Vec3::new(half, 0.0, 0.25));
    near(r.clearcoat, 0.4);
    near(r.clearcoat_roughness, 0.1);
    near3(r.normal, Vec3::Z);
    near3(r.clearcoat_normal, Vec3::new(0.6, 0.004, 0.8));
    near3(r.sheen_color, Vec3::new(1.0, 0.5 * half, 0.0));
    near(r.sheen_roughness, 0.2);
    near(r.anisotropy, 0.1);
    // The texture points along the bitangent, a quarter turn more leads against the tangent.
    assert!(r.anisotropy_direction.abs_diff_eq(Vec2::NEG_X, 1e-2), "{}", r.anisotropy_direction);
    near(r.iridescence, 0.3);
    near(r.iridescence_ior, 1.4);
    assert!(
        (r.iridescence_thickness - 200.0 - 100.0 * 77.0 / 255.0).abs() < 0.1,
        "{}",
        r.iridescence_thickness
    );
    near(r.dispersion, 0.3);
}

#[test]
fn a_material_without_lobes_has_none() {
    let device = TestDevice::open();
    let scene = scene(Material::default(), vec![]);
    let r = samples(&device, &scene, &[Vec2::splat(0.3)], 0.0)[0];
    let absent = [r.clearcoat, r.sheen_color.length(), r.anisotropy, r.iridescence, r.dispersion];
    assert_eq!(absent, [0.0; 5]);
    near3(r.clearcoat_normal, Vec3::Z);
    assert_eq!((r.specular, r.transmission, r.alpha), (1.0, 0.0, 1.0));
}

fn random_texture(usage: TextureUsage, [width, height]: [u32; 2]) -> Texture {
    let texels = (0..width * height * 4).map(|i| (i.wrapping_mul(2_654_435_761) >> 23) as u8).collect();
    Texture::rgba8("random", [width, height], usage, texels)
}

fn centres([w, h]: [u32; 2]) -> Vec<(u32, u32, Vec2)> {
    let inside = |&(_, _, uv): &(u32, u32, Vec2)| uv.x + uv.y < 0.99;
    let at = |x: u32, y: u32| (x, y, Vec2::new((x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32));
    (0..h).flat_map(|y| (0..w).map(move |x| at(x, y))).filter(inside).collect()
}

#[test]
fn compressed_textures_read_as_the_host_decodes_them() {
    let device = TestDevice::open();
    let random = |format: BlockFormat| -> Texels {
        let mut levels = Vec::new();
        for level in 0..4 {
            let bytes = format.level_bytes([10 >> level, 12 >> level].map(|side: u32| side.max(1)));
            levels.push((0..bytes as u32).map(|i| (i.wrapping_mul(2_246_822_519) >> 21) as u8).collect());
        }
        Texels::Blocks { format, levels }
    };
    for format in [
        BlockFormat::Bc1,
        BlockFormat::Bc2,
        BlockFormat::Bc3,
        BlockFormat::Bc4,
        BlockFormat::Bc5,
        BlockFormat::Bc7,
    ] {
        // BC7 is exact to the bit. Between the end points of the others devices round in their own way.
        let tolerance = match format {
            BlockFormat::Bc7 => 1e-3,
            BlockFormat::Bc4 | BlockFormat::Bc5 => 5e-3,
            _ => 2e-2,
        };
        for usage in [TextureUsage::Cutout, TextureUsage::Data] {
            if usage.is_srgb() && matches!(format, BlockFormat::Bc4 | BlockFormat::Bc5) {
                continue;
            }
            let texture =
                Texture { texels: random(format), ..Texture::rgba8("blocks", [10, 12], usage, vec![]) };
            let material = Material {
                base_color_texture: Some(TextureRef::new(0)),
                alpha_mode: AlphaMode::Blend,
                ..Material::default()
            };
            let mut scene = scene(material, vec![texture.clone()]);
            scene.meshes[0].colors = vec![Vec4::ONE; 3];
            let points = centres([10, 12]);
            let uvs: Vec<_> = points.iter().map(|p| p.2).collect();
            for ((x, y, _), r) in points.iter().zip(samples(&device, &scene, &uvs, 0.0)) {
                let [red, green, blue, alpha] = texture.texel(*x, *y);
                let (red, green, blue) = (red.min(1.0), green.min(1.0), blue.min(1.0));
                let near = r.base_color.abs_diff_eq(Vec3::new(red, green, blue), tolerance)
                    && (r.alpha - alpha).abs() < tolerance;
                assert!(
                    near,
                    "{format:?} {usage:?} ({x}, {y}): {} {}, {red} {green} {blue} {alpha}",
                    r.base_color, r.alpha
                );
            }
        }
    }
}

#[test]
fn wrapping_filters_transforms_and_uv_sets() {
    let device = TestDevice::open();
    let texture = random_texture(TextureUsage::Data, [8, 8]);
    let texel = |x: u32, y: u32| Vec3::from_slice(&texture.texel(x, y)[..3]);
    let nearest =
        Sampler { mag: Filter::Nearest, min: Filter::Nearest, mip: MipFilter::Off, ..Sampler::default() };
    let shown = |sampler: Sampler, slot: TextureRef, at: Vec2, footprint: f32| {
        let material = Material { base_color_texture: Some(slot), ..Material::default() };
        let mut scene = scene(material, vec![Texture { sampler, ..texture.clone() }]);
        scene.meshes[0].colors = vec![Vec4::ONE; 3];
        samples(&device, &scene, &[at], footprint)[0].base_color
    };
    let slot = TextureRef::new(0);
    let at = Vec2::new(1.7 / 8.0, 2.3 / 8.0);
    near3(shown(nearest, slot, at, 0.0), texel(1, 2));
    // No mips: the finest level however wide the footprint.
    near3(shown(nearest, slot, at, 1.0), texel(1, 2));
    let coarse = shown(Sampler { mip: MipFilter::Nearest, ..nearest }, slot, at, 1.0);
    let mean = texture.mips()[3].texels.clone();
    near3(coarse, Vec3::new(f32::from(mean[0]), f32::from(mean[1]), f32::from(mean[2])) / 255.0);
    // Linear: halfway between two texels in x, on the centre in y.
    let halfway = shown(Sampler::default(), slot, Vec2::new(2.0 / 8.0, 2.5 / 8.0), 0.0);
    near3(halfway, 0.5 * (texel(1, 2) + texel(2, 2)));
    // The second UV set is mirrored in u.
    near3(shown(nearest, TextureRef { uv_set: 1, ..slot }, at, 0.0), texel(6, 2));
    // Scale by 2, a quarter turn, offset: u' = 2 v + 1, v' = -2 u + 2, both one tile on.
    let matrix = glam::Mat2::from_angle(-std::f32::consts::FRAC_PI_2) * 2.0;
    let transform = Affine2::from_mat2_translation(matrix, Vec2::new(1.0, 2.0));
    let moved = TextureRef { transform, ..slot };
    let place = transform.transform_point2(at);
    let tile = |t: f32| (t.rem_euclid(1.0) * 8.0) as u32;
    near3(shown(nearest, moved, at, 0.0), texel(tile(place.x), tile(place.y)));
    let clamped = Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::MirroredRepeat, ..nearest };
    let mirror = |t: f32| ((1.0 - (t.rem_euclid(2.0) - 1.0).abs()) * 8.0) as u32;
    near3(shown(clamped, moved, at, 0.0), texel((place.x.clamp(0.0, 0.999) * 8.0) as u32, mirror(place.y)));
}

#[test]
fn normal_maps_give_unit_vectors_from_two_channels() {
    let device = TestDevice::open();
    let texture = flat(TextureUsage::Normal, [204, 128, 230, 255]);
    let blocks = {
        // A BC5 block of one value in each channel.
        let channel = |value: u8| [value, value, 0, 0, 0, 0, 0, 0];
        let levels = vec![[channel(204), channel(128)].concat()];
        let texels = Texels::Blocks { format: BlockFormat::Bc5, levels };
        Texture { texels, ..Texture::rgba8("blocks", [4, 4], TextureUsage::Normal, vec![]) }
    };
    for texture in [texture, blocks] {
        let material = Material { normal_texture: Some(TextureRef::new(0)), ..Material::default() };
        let scene = scene(material.clone(), vec![texture.clone()]);
        near3(samples(&device, &scene, &[Vec2::splat(0.3)], 0.0)[0].normal, Vec3::new(0.6, 0.004, 0.8));
        let scene = self::scene(Material { normal_scale: 0.5, ..material }, vec![texture]);
        let expected = Vec3::new(0.3, 0.002, 0.8).normalize();
        near3(samples(&device, &scene, &[Vec2::splat(0.3)], 0.0)[0].normal, expected);
    }
}
