//! Textures of 16 bits per channel, from the PNG file to what surface.glsl reads on the device.

use std::path::Path;

use crate::common::samples::{samples, scene};
use glam::{DVec3, Vec2, Vec4};
use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb, Rgba};
use pt_core::test_support::TestDevice;
use pt_scene::{AlphaMode, Material, Scene, Texels, Texture, TextureRef, TextureUsage};

const SIDE: u32 = 8;

/// IEC 61966-2-1 in f64.
fn linear(code: u16) -> f64 {
    let x = f64::from(code) / 65535.0;
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn unorm(code: u16) -> f64 {
    f64::from(code) / 65535.0
}

/// The texel in column `x` and row `y`: all of a gradient lies in the low byte.
fn texel(high: [u8; 4], x: u32, y: u32) -> [u16; 4] {
    let low = (y * SIDE + x) as u16 * 4 + 1;
    high.map(|high| u16::from(high) << 8 | low)
}

/// Writes a PNG of 16 bits per channel whose texels have these high bytes.
fn write(file: &Path, high: [u8; 4]) {
    let image = ImageBuffer::from_fn(SIDE, SIDE, |x, y| Rgba(texel(high, x, y)));
    DynamicImage::ImageRgba16(image).save(file).unwrap();
}

/// A triangle in glTF whose material has three images.
fn import(folder: &Path) -> Scene {
    let positions: Vec<u8> =
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(folder.join("triangle.bin"), positions).unwrap();
    let json = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "buffers": [{"uri": "triangle.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [0, 0, 0], "max": [1, 1, 0]}],
        "images": [{"uri": "color.png"}, {"uri": "data.png"}, {"uri": "normal.png"}],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}],
        "materials": [{"alphaMode": "BLEND", "normalTexture": {"index": 2}, "pbrMetallicRoughness":
            {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}}}]}"#;
    std::fs::write(folder.join("scene.gltf"), json).unwrap();
    pt_import::load(folder.join("scene.gltf"), &Default::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The texels whose centres lie on the triangle, with their UV.
fn centres() -> Vec<(u32, u32, Vec2)> {
    let at =
        |i: u32| (i % SIDE, i / SIDE, (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32);
    (0..SIDE * SIDE).map(at).filter(|(_, _, uv)| uv.x + uv.y < 0.99).collect()
}

#[track_caller]
fn near(actual: f32, exact: f64, tolerance: f64) {
    assert!((f64::from(actual) - exact).abs() <= tolerance, "{actual} is not {exact}");
}

/// Rounding to a half float is at most 1/2048 of the value; the fp32 arithmetic around it is far below that.
const HALF: f64 = 1.0 / 2047.0;

#[test]
fn png_files_reach_the_kernels_with_their_low_bytes() {
    let temp = tempfile::tempdir().unwrap();
    // Dark, medium and bright colour; directions of unit length but for the low byte.
    let (color, data, normal) = ([0x03, 0x80, 0xf0, 0x70], [0, 0x90, 0x30, 0], [0xcc, 0x80, 0xe6, 0xff]);
    write(&temp.path().join("color.png"), color);
    write(&temp.path().join("data.png"), data);
    write(&temp.path().join("normal.png"), normal);
    let imported = import(temp.path());
    let usages: Vec<_> = imported.textures.iter().map(|t| (t.is_16_bit(), t.usage)).collect();
    let expected =
        [TextureUsage::Cutout, TextureUsage::Data, TextureUsage::Normal].map(|usage| (true, usage));
    assert_eq!(usages, expected);
    let mut scene = scene(imported.materials[0].clone(), imported.textures);
    scene.meshes[0].colors.fill(Vec4::ONE);
    let points = centres();
    let uvs: Vec<_> = points.iter().map(|p| p.2).collect();
    for (&(x, y, _), r) in points.iter().zip(samples(&TestDevice::open(), &scene, &uvs, 0.0)) {
        let [red, green, blue, alpha] = texel(color, x, y);
        for (actual, code) in r.base_color.to_array().into_iter().zip([red, green, blue]) {
            near(actual, linear(code), HALF * linear(code));
        }
        near(r.alpha, unorm(alpha), HALF * unorm(alpha));
        let [_, roughness, metallic, _] = texel(data, x, y).map(unorm);
        // 16-bit codes are exact; what is left is fp32.
        near(r.roughness, roughness, 1e-6);
        near(r.metallic, metallic, 1e-6);
        let [nx, ny, ..] = texel(normal, x, y).map(|code| 2.0 * unorm(code) - 1.0);
        let direction = DVec3::new(nx, ny, (1.0 - nx * nx - ny * ny).sqrt());
        for (actual, exact) in r.normal.to_array().into_iter().zip(direction.to_array()) {
            near(actual, exact, 2e-6);
        }
    }
}

#[test]
fn the_coarsest_level_has_the_mean() {
    let device = TestDevice::open();
    let codes = |high: [u8; 4]| (0..SIDE * SIDE).flat_map(|i| texel(high, i % SIDE, i / SIDE)).collect();
    let texture = |usage, high| Texture::rgba16("gradient", [SIDE; 2], usage, codes(high));
    let (color, data, normal) = ([0x03, 0x80, 0xf0, 0xff], [0, 0x90, 0x30, 0], [0xcc, 0x80, 0xe6, 0xff]);
    let mean = |high, channel: usize, value: fn(u16) -> f64| {
        let sum: f64 = (0..SIDE * SIDE).map(|i| value(texel(high, i % SIDE, i / SIDE)[channel])).sum();
        sum / f64::from(SIDE * SIDE)
    };
    let slot = |texture| Some(TextureRef::new(texture));
    let material = Material {
        base_color_texture: slot(0),
        metallic_roughness_texture: slot(1),
        normal_texture: slot(2),
        metallic: 1.0,
        roughness: 1.0,
        ..Material::default()
    };
    let textures = vec![
        texture(TextureUsage::Color, color),
        texture(TextureUsage::Data, data),
        texture(TextureUsage::Normal, normal),
    ];
    let mut scene = scene(material, textures);
    scene.meshes[0].colors.fill(Vec4::ONE);
    let r = samples(&device, &scene, &[Vec2::splat(0.3)], 1.0)[0];
    for (channel, actual) in r.base_color.to_array().into_iter().enumerate() {
        let exact = mean(color, channel, linear);
        near(actual, exact, HALF * exact);
    }
    // Half a code, and fp32.
    near(r.roughness, mean(data, 1, unorm), 0.6 / 65535.0);
    near(r.metallic, mean(data, 2, unorm), 0.6 / 65535.0);
    let slope = DVec3::from_array([0, 1, 2].map(|c| 2.0 * mean(normal, c, unorm) - 1.0)).normalize();
    // Twice half a code; z, which follows from x and y, is less steep here.
    near(r.normal.x, slope.x, 1.2 / 65535.0);
    near(r.normal.y, slope.y, 1.2 / 65535.0);
}

/// The channels that a PNG may have.
#[test]
fn grey_and_colour_with_and_without_alpha() {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("image.png");
    type Image = (DynamicImage, [u16; 4]);
    let images: [Image; 4] = [
        (
            DynamicImage::ImageLuma16(ImageBuffer::from_pixel(3, 2, Luma([0x1234]))),
            [0x1234, 0x1234, 0x1234, 0xffff],
        ),
        (
            DynamicImage::ImageLumaA16(ImageBuffer::from_pixel(3, 2, LumaA([0xfedc, 0x0102]))),
            [0xfedc, 0xfedc, 0xfedc, 0x0102],
        ),
        (
            DynamicImage::ImageRgb16(ImageBuffer::from_pixel(3, 2, Rgb([1, 0x8000, 0xfffe]))),
            [1, 0x8000, 0xfffe, 0xffff],
        ),
        (
            DynamicImage::ImageRgba16(ImageBuffer::from_pixel(3, 2, Rgba([0x0101, 0x0202, 0x0303, 0x0405]))),
            [0x0101, 0x0202, 0x0303, 0x0405],
        ),
    ];
    for (image, codes) in images {
        image.save(&file).unwrap();
        let bytes = std::fs::read(&file).unwrap();
        for usage in [TextureUsage::Color, TextureUsage::Data] {
            let texture = pt_import::decode_texture("image", &bytes, usage, 1 << 20).unwrap();
            assert_eq!(texture.texels, Texels::Rgba16(codes.repeat(6)));
            assert_eq!((texture.bytes(), texture.uncompressed_bytes()), (48, 8 * (6 + 1)));
            for (channel, (actual, code)) in texture.texel(2, 1).into_iter().zip(codes).enumerate() {
                let srgb = usage.is_srgb() && channel < 3;
                let exact = if srgb { linear(code) } else { unorm(code) };
                near(actual, exact, 1e-6 * exact);
            }
        }
    }
}

/// An alpha that equals the cutoff is there, one that is a step of 8 bits below is not, with 8 and with 16 bits.
#[test]
fn alpha_meets_its_cutoff() {
    let device = TestDevice::open();
    for alpha in [1u8, 129] {
        let wide = u16::from(alpha) * 257;
        let textures = [
            Texture::rgba8("leaf", [1, 1], TextureUsage::Cutout, vec![9, 9, 9, alpha]),
            Texture::rgba16("leaf", [1, 1], TextureUsage::Cutout, vec![9, 9, 9, wide]),
        ];
        for (texture, step) in textures.into_iter().flat_map(|t| [(t.clone(), 0u8), (t, 1)]) {
            let cutoff = (f32::from(alpha) + f32::from(step)) / 255.0;
            let material = Material {
                base_color_texture: Some(TextureRef::new(0)),
                alpha_mode: AlphaMode::Mask { cutoff },
                ..Material::default()
            };
            let mut scene = scene(material, vec![texture]);
            scene.meshes[0].colors.fill(Vec4::ONE);
            let r = samples(&device, &scene, &[Vec2::splat(0.3)], 0.0)[0];
            assert_eq!(r.alpha, f32::from(1 - step), "alpha {alpha}, cutoff {cutoff}");
        }
    }
}
