//! Image files of every kind that glTF textures may be, and those that must be refused.

use std::path::Path;

use crate::common::textured::gltf;
use pt_image::image_file::{PixelLayout, write_png};
use pt_import::{DdsTexture, LoadOptions, load};
use pt_scene::{BlockFormat, Scene, SceneError, Texels, Texture, TextureUsage};
use pt_test_data::shared;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

const BASE_COLOR: &str = r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}"#;

fn load_image(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let temp = tempfile::tempdir().unwrap();
    std::fs::write(temp.path().join(name), bytes).unwrap();
    let images = format!(r#"{{"uri": "{name}"}}"#);
    load(gltf(temp.path(), &images, r#"{"source": 0}"#, BASE_COLOR), options)
}

fn texture(name: &str, bytes: &[u8]) -> Texture {
    load_image(name, bytes, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")).textures.swap_remove(0)
}

fn rgba8(texture: &Texture) -> &[u8] {
    let Texels::Rgba8(texels) = &texture.texels else { panic!("{} has not 8 bits", texture.name) };
    texels
}

/// A red half on the left, a blue one on the right.
fn assert_red_and_blue(name: &str, t: &Texture, tolerance: u8) {
    assert_eq!((t.width, t.height), (16, 8), "{name}");
    for (i, texel) in rgba8(t).chunks_exact(4).enumerate() {
        let expected = if i % 16 < 8 { [200, 40, 40, 255] } else { [40, 60, 200, 255] };
        // Chroma of neighbours mixes at the seam of lossy images.
        let seam = (7..9).contains(&(i % 16)) && tolerance > 0;
        let near = texel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= tolerance);
        assert!(near || seam, "{name}, texel {i}: {texel:?}, expected {expected:?}");
    }
}

#[test]
fn files_of_every_kind_by_their_content() {
    for (file, tolerance) in [
        ("interlaced.png", 0),
        ("palette.png", 0),
        ("lossless.webp", 0),
        ("lossy.webp", 8),
        ("baseline.jpg", 6),
        ("progressive.jpg", 6),
        ("cmyk.jpg", 6),
    ] {
        let bytes = std::fs::read(Path::new(DATA).join(file)).unwrap();
        // The extension says something else; the content counts.
        assert_red_and_blue(file, &texture("image.bmp", &bytes), tolerance);
    }
    let grey = texture("image.bin", &std::fs::read(Path::new(DATA).join("grey.jpg")).unwrap());
    let texels = rgba8(&grey);
    assert!(
        texels[0] == texels[1] && texels[1] == texels[2] && texels[0].abs_diff(88) < 6,
        "{:?}",
        &texels[..4]
    );
}

#[test]
fn png_of_every_channel_count_and_depth() {
    use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
    let encoded = |image: DynamicImage| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let (w, h) = (3, 2);
    // An 8-bit image in a 16-bit file takes 8 bits.
    for (image, expected) in [
        (DynamicImage::ImageLuma8(ImageBuffer::from_pixel(w, h, Luma([77]))), [77, 77, 77, 255]),
        (DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(w, h, LumaA([77, 9]))), [77, 77, 77, 9]),
        (DynamicImage::ImageRgb8(ImageBuffer::from_pixel(w, h, Rgb([1, 2, 3]))), [1, 2, 3, 255]),
        (DynamicImage::ImageRgba8(ImageBuffer::from_pixel(w, h, Rgba([1, 2, 3, 4]))), [1, 2, 3, 4]),
        (DynamicImage::ImageLuma16(ImageBuffer::from_pixel(w, h, Luma([0x4d4d]))), [77, 77, 77, 255]),
        (DynamicImage::ImageLumaA16(ImageBuffer::from_pixel(w, h, LumaA([0x4d4d, 0x0909]))), [77, 77, 77, 9]),
        (
            DynamicImage::ImageRgb16(ImageBuffer::from_pixel(w, h, Rgb([0x0101, 0x0202, 0xffff]))),
            [1, 2, 255, 255],
        ),
        (DynamicImage::ImageRgba16(ImageBuffer::from_pixel(w, h, Rgba([257, 514, 771, 1028]))), [1, 2, 3, 4]),
    ] {
        let t = texture("image.png", &encoded(image));
        assert!(rgba8(&t).chunks_exact(4).all(|texel| texel == expected), "{expected:?}: {:?}", rgba8(&t));
        assert_eq!(t.usage, TextureUsage::Color);
    }
}

/// One texel is enough that needs its low byte. Normals that are no unit vectors are normalised, the others keep their bits.
#[test]
fn png_of_16_bits_keeps_what_8_bits_do_not_hold() {
    use image::{DynamicImage, ImageBuffer, ImageFormat, Rgba};
    let encoded = |pixels: [[u16; 4]; 2]| {
        let image = ImageBuffer::from_fn(2, 1, |x, _| Rgba(pixels[x as usize]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        DynamicImage::ImageRgba16(image).write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let pixels = [[0x0101, 0, 0xffff, 0x8080], [0xfefe, 0x7e7f, 0x3333, 0xffff]];
    let wide = texture("image.png", &encoded(pixels));
    assert_eq!(wide.texels, Texels::Rgba16(pixels.concat()));
    let narrow = texture("image.png", &encoded([pixels[0]; 2]));
    assert_eq!(narrow.texels, Texels::Rgba8([1, 0, 255, 128].repeat(2)));
    // The second points along (1, 0, 1) with length 0.5.
    let normals = [[0xcccd, 0x8000, 0xe666, 0xffff], [0xad41, 0x8000, 0xad41, 0xffff]];
    let texture =
        pt_import::decode_texture("normals", &encoded(normals), TextureUsage::Normal, 1 << 20).unwrap();
    let Texels::Rgba16(texels) = &texture.texels else { panic!("8 bits") };
    assert_eq!(texels[..4], normals[0]);
    let [x, y, z, _] = texture.texel(1, 0).map(|t| f64::from(2.0 * t - 1.0));
    // Half a code.
    assert!((x - 0.5f64.sqrt()).abs() < 2e-5 && y.abs() < 6e-5 && (z - x).abs() < 2e-5, "{x} {y} {z}");
}

/// A PNG that declares `width` x `height` and holds next to nothing.
fn bomb(width: u32, height: u32) -> Vec<u8> {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("one.png");
    write_png(&file, 1, 1, PixelLayout::Rgb, &[0; 3]).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = !0u32;
    for byte in &bytes[12..29] {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()));
    }
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}

#[test]
fn sizes_are_checked_before_anything_is_decoded() {
    for (width, height) in [(65_536, 65_536), (16_385, 1), (1, 1 << 30)] {
        let error =
            load_image("bomb.png", &bomb(width, height), &LoadOptions::default()).unwrap_err().to_string();
        assert!(
            error.contains("images[0]") && error.contains("bomb.png") && !error.contains('\n'),
            "{error}"
        );
    }
    // Within the sides, beyond the budget: counted from the header.
    let options = LoadOptions { max_texture_pixels: 1000, ..LoadOptions::default() };
    let error = load_image("bomb.png", &bomb(100, 100), &options).unwrap_err().to_string();
    assert!(error.contains("10000 texels") && error.contains("--max-texture-pixels"), "{error}");
    let mut dds = b"DDS ".to_vec();
    dds.resize(148, 0xff);
    load_image("bomb.dds", &dds, &LoadOptions::default()).unwrap_err();
    let mut ktx = vec![0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, 0x0d, 0x0a, 0x1a, 0x0a];
    ktx.resize(200, 1);
    load_image("bomb.ktx2", &ktx, &LoadOptions::default()).unwrap_err();
}

#[test]
fn damaged_and_foreign_images_are_refused_in_one_line() {
    for file in ["interlaced.png", "progressive.jpg", "lossy.webp", "palette.png"] {
        let bytes = std::fs::read(Path::new(DATA).join(file)).unwrap();
        for cut in [0, 3, 8, 20, 40] {
            if let Err(error) = load_image(file, &bytes[..cut.min(bytes.len())], &LoadOptions::default()) {
                let text = error.to_string();
                assert!(text.contains("images[0]") && !text.contains('\n'), "{text}");
            }
        }
    }
    let error =
        load_image("a.gif", b"GIF89a\x01\x00\x01\x00", &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("images[0]") && error.contains("PNG"), "{error}");
}

#[test]
fn extensions_choose_their_own_image() {
    let temp = tempfile::tempdir().unwrap();
    for file in ["lossless.webp", "grey.jpg"] {
        std::fs::copy(Path::new(DATA).join(file), temp.path().join(file)).unwrap();
    }
    let images = r#"{"uri": "grey.jpg"}, {"uri": "lossless.webp"}"#;
    let webp = r#"{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}"#;
    let scene = load(gltf(temp.path(), images, webp, BASE_COLOR), &LoadOptions::default()).unwrap();
    assert_red_and_blue("webp", &scene.textures[0], 0);
    // An extension that is not known leaves the fallback.
    let other = r#"{"source": 1, "extensions": {"EXT_texture_avif": {"source": 0}}}"#;
    let scene = load(gltf(temp.path(), images, other, BASE_COLOR), &LoadOptions::default()).unwrap();
    assert_red_and_blue("fallback", &scene.textures[0], 0);
    let wrong = r#"{"source": 0, "extensions": {"EXT_texture_webp": {"source": 7}}}"#;
    let error =
        load(gltf(temp.path(), images, wrong, BASE_COLOR), &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("textures[0].extensions.EXT_texture_webp.source"), "{error}");
}

#[test]
fn usage_follows_the_slot_and_transforms_are_read_everywhere() {
    let temp = tempfile::tempdir().unwrap();
    std::fs::copy(Path::new(DATA).join("palette.png"), temp.path().join("i.png")).unwrap();
    let slot = |k: u32| {
        format!(
            r#"{{"index": 0, "texCoord": 1, "extensions": {{"KHR_texture_transform":
            {{"offset": [{k}, 0.5], "scale": [2, 3], "rotation": 0, "texCoord": {}}}}}}}"#,
            k % 2
        )
    };
    let material = format!(
        r#"{{"pbrMetallicRoughness": {{"baseColorTexture": {}, "metallicRoughnessTexture": {}}},
        "normalTexture": {}, "emissiveTexture": {}, "alphaMode": "BLEND", "occlusionTexture": {},
        "extensions": {{
          "KHR_materials_clearcoat": {{"clearcoatFactor": 0.5, "clearcoatTexture": {}, "clearcoatNormalTexture": {}}},
          "KHR_materials_sheen": {{"sheenColorFactor": [0.1, 0.2, 0.3], "sheenColorTexture": {}}},
          "KHR_materials_specular": {{"specularFactor": 0.5, "specularTexture": {}, "specularColorTexture": {}}},
          "KHR_materials_iridescence": {{"iridescenceFactor": 1, "iridescenceThicknessTexture": {}}},
          "KHR_materials_anisotropy": {{"anisotropyStrength": 0.5, "anisotropyRotation": 1, "anisotropyTexture": {}}},
          "KHR_materials_dispersion": {{"dispersion": 0.25}},
          "KHR_materials_transmission": {{"transmissionFactor": 1, "transmissionTexture": {}}},
          "KHR_materials_volume": {{"thicknessFactor": 1, "thicknessTexture": {}}}}}}}"#,
        slot(0),
        slot(1),
        slot(2),
        slot(3),
        slot(4),
        slot(5),
        slot(6),
        slot(7),
        slot(8),
        slot(9),
        slot(10),
        slot(11),
        slot(12),
        slot(13)
    );
    let scene = load(
        gltf(temp.path(), r#"{"uri": "i.png"}"#, r#"{"source": 0}"#, &material),
        &LoadOptions::default(),
    );
    let scene = scene.unwrap();
    let m = &scene.materials[0];
    let l = m.lobes.as_ref().unwrap();
    use TextureUsage::{Color, Cutout, Data, Normal};
    for (k, slot, usage) in [
        (0, m.base_color_texture, Cutout),
        (1, m.metallic_roughness_texture, Data),
        (2, m.normal_texture, Normal),
        (3, m.emissive_texture, Color),
        (5, l.clearcoat_texture, Data),
        (6, l.clearcoat_normal_texture, Normal),
        (7, l.sheen_color_texture, Color),
        (8, m.specular_texture, Data),
        (9, m.specular_color_texture, Color),
        (10, l.iridescence_thickness_texture, Data),
        (11, l.anisotropy_texture, Data),
        (12, m.transmission_texture, Data),
        (13, m.thickness_texture, Data),
    ] {
        let slot = slot.unwrap_or_else(|| panic!("slot {k}"));
        assert_eq!(scene.textures[slot.texture as usize].usage, usage, "slot {k}");
        assert_eq!(slot.uv_set, k % 2, "slot {k}: the transform's texCoord counts");
        let moved = slot.transform.transform_point2(glam::Vec2::ONE);
        assert!(moved.abs_diff_eq([k as f32 + 2.0, 3.5].into(), 1e-6), "slot {k}: {moved}");
    }
    // One texture for each usage, not for each slot.
    assert_eq!(scene.textures.len(), 4);
    assert_eq!((l.clearcoat, l.anisotropy_rotation, l.dispersion, l.iridescence_ior), (0.5, 1.0, 0.25, 1.3));
    let named = |text: &str| scene.notices.iter().filter(|n| n.contains(text)).count();
    assert_eq!(named("occlusion"), 1, "{:?}", scene.notices);
    assert_eq!(named("dispersion"), 1, "{:?}", scene.notices);
}

/// The image in the binary chunk of a GLB that has one, which starts with `magic`.
fn embedded(file: &Path, magic: &[u8]) -> Vec<u8> {
    let bytes = std::fs::read(file).unwrap();
    let start = bytes.windows(magic.len()).position(|w| w == magic).unwrap();
    bytes[start..].to_vec()
}

#[test]
fn damaged_images_never_panic() {
    let mut files: Vec<_> =
        std::fs::read_dir(DATA).unwrap().map(|f| std::fs::read(f.unwrap().path()).unwrap()).collect();
    let blocks = |format: BlockFormat| {
        let levels = [16, 8, 4, 2, 1].map(|side| vec![0x5a; format.level_bytes([side, side])]).to_vec();
        DdsTexture { width: 16, height: 16, format, srgb: false, levels }.to_bytes().unwrap()
    };
    files.extend([blocks(BlockFormat::Bc7), blocks(BlockFormat::Bc1)]);
    files.iter().for_each(|file| damaged_never_panics(file));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_damaged_ktx2_image_never_panics() {
    damaged_never_panics(&embedded(&shared("scenes/AGI_KTX2/0.glb"), b"\xabKTX 20\xbb"));
}

fn damaged_never_panics(file: &[u8]) {
    let mut state = 1u32;
    let mut random = |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    };
    // Headers and tables stand in front, so that is where most of the damage goes.
    for round in 0..400 {
        let mut bytes = file.to_vec();
        for _ in 0..1 + random(4) {
            let reach = if round % 4 == 0 { bytes.len() } else { bytes.len().min(256) };
            let at = random(reach);
            bytes[at] = if random(2) == 0 { random(256) as u8 } else { bytes[at] ^ 1 << random(8) };
        }
        if random(8) == 0 {
            bytes.truncate(random(bytes.len()));
        }
        if let Err(error) = pt_import::decode_texture("damaged", &bytes, TextureUsage::Normal, 1 << 20) {
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
