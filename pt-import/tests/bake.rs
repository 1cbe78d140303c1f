//! Baked textures: quality, files, the cache.

use std::path::{Path, PathBuf};

use crate::common::textured::gltf;
use pt_image::image_file::{PixelLayout, write_png};
use pt_import::Quality;
use pt_import::bake::{Outcome, bake};
use pt_import::{DdsTexture, LoadOptions, load};
use pt_scene::{BlockFormat, Scene, Texels, TextureUsage};

/// A scene with a base colour, a map of roughness and metalness and a normal map, of sizes that are no multiple of a block, and
/// a cut-out with alpha. What it shows is smooth, with a little grain.
fn scene(folder: &Path) -> PathBuf {
    let [width, height] = SIZE;
    let grain = |i: u32| (i.wrapping_mul(2_654_435_761) >> 30) as f32;
    let write = |name: &str, texel: &dyn Fn(f32, f32) -> [f32; 4]| {
        let texels = (0..width * height).flat_map(|i| {
            let (x, y) = ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
            let [r, g, b, a] = texel(x, y).map(|t| (t * 250.0 + grain(i)) as u8);
            [r, g, b, if name == "leaf.png" { a } else { 255 }]
        });
        write_png(&folder.join(name), width, height, PixelLayout::Rgba, &texels.collect::<Vec<u8>>())
            .unwrap();
    };
    let wave = |t: f32| 0.5 + 0.4 * (6.3 * t).sin();
    write("color.png", &|x, y| [wave(x), wave(y), wave(x + y), 1.0]);
    write("data.png", &|x, y| [0.0, wave(2.0 * x), wave(y), 1.0]);
    write("leaf.png", &|x, y| [wave(y), wave(x), 0.2, wave(x * 2.0 + y)]);
    write("normal.png", &|x, y| {
        let (x, y) = (0.6 * wave(x) - 0.3, 0.6 * wave(y) - 0.3);
        [0.5 + 0.5 * x, 0.5 + 0.5 * y, 0.5 + 0.5 * (1.0 - x * x - y * y).sqrt(), 1.0]
    });
    let images =
        ["color", "data", "leaf", "normal"].map(|name| format!(r#"{{"uri": "{name}.png"}}"#)).join(", ");
    let textures = (0..4).map(|i| format!(r#"{{"source": {i}}}"#)).collect::<Vec<_>>().join(", ");
    let materials = r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
        "normalTexture": {"index": 3}},
        {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}}"#;
    gltf(folder, &images, &textures, materials)
}

const SIZE: [u32; 2] = [61, 38];

fn load_with(scene: &Path, baked: Option<&Path>) -> Scene {
    let options = LoadOptions { baked: baked.map(Path::to_owned), ..LoadOptions::default() };
    load(scene, &options).unwrap_or_else(|e| panic!("{e}"))
}

fn run(scene: &Path, folder: &Path, quality: Quality) -> Vec<pt_import::bake::BakedTexture> {
    bake(scene, folder, quality, &LoadOptions::default(), |_, _| {}).unwrap_or_else(|e| panic!("{e}"))
}

fn limit(max_texture_pixels: u64) -> LoadOptions {
    LoadOptions { max_texture_pixels, ..LoadOptions::default() }
}

/// In dB, of the values as encoded.
fn psnr(a: &[u8], b: &[u8], channels: usize) -> f64 {
    let texels = || a.chunks_exact(4).zip(b.chunks_exact(4));
    let square = |x: u8, y: u8| f64::from(x.abs_diff(y)).powi(2);
    let sum: f64 = texels().flat_map(|(a, b)| (0..channels).map(move |c| square(a[c], b[c]))).sum();
    10.0 * (255.0 * 255.0 * (texels().count() * channels) as f64 / sum).log10()
}

#[test]
fn baked_textures_are_close_to_their_sources_and_cached() {
    let temp = tempfile::tempdir().unwrap();
    let (scene, out) = (scene(temp.path()), temp.path().join("baked"));
    let report = run(&scene, &out, Quality::Fast);
    let (plain, baked) = (load_with(&scene, None), load_with(&scene, Some(&out)));
    assert_eq!(report.len(), plain.textures.len());
    for ((row, plain), baked) in report.iter().zip(&plain.textures).zip(&baked.textures) {
        let Texels::Blocks { format, levels } = &baked.texels else { panic!("{} is not baked", plain.name) };
        let (expected, channels) =
            if plain.usage == TextureUsage::Normal { (BlockFormat::Bc5, 2) } else { (BlockFormat::Bc7, 3) };
        assert_eq!((*format, levels.len()), (expected, plain.full_level_count()));
        // Level for level, down to a single texel.
        for (level, (a, b)) in plain.mips().iter().zip(baked.mips()).enumerate() {
            assert_eq!((a.width, a.height), (b.width, b.height));
            let db = psnr(&a.texels, &b.texels, channels);
            println!("{} {:?} level {level}: {db:.1} dB", plain.name, plain.usage);
            // Each level doubles the contrast within a block, which costs 6 dB; a level out of place has some 10.
            let least = if level == 0 { 36.0 } else { 22.0 };
            assert!(db > least, "{} {:?} level {level}: {db} dB", plain.name, plain.usage);
        }
        assert!(row.bytes_after * 3 < row.bytes_before * 2, "{row:?}");
        assert_eq!(plain.sampler, baked.sampler);
    }
    let times = |folder: &Path| -> Vec<_> {
        let files = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap());
        let mut files: Vec<_> =
            files.map(|f| (f.file_name(), f.metadata().unwrap().modified().unwrap())).collect();
        files.sort();
        files
    };
    let before = times(&out);
    assert!(run(&scene, &out, Quality::Fast).iter().all(|t| t.outcome == Outcome::Unchanged));
    assert_eq!(times(&out), before, "nothing is written twice");
}

#[test]
fn files_have_a_dx10_header_that_others_read() {
    let temp = tempfile::tempdir().unwrap();
    let scene = scene(temp.path());
    for row in run(&scene, temp.path(), Quality::Fast) {
        let bytes = std::fs::read(temp.path().join(&row.file)).unwrap();
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        // DDS_HEADER and DDS_HEADER_DXT10 of Microsoft's description of the format.
        assert_eq!(&bytes[..4], b"DDS ");
        assert_eq!((word(4), word(76)), (124, 32), "sizes of the headers");
        assert_eq!([word(16), word(12)], row.extent);
        assert_eq!(
            word(8) & 0x000a_1007,
            0x000a_1007,
            "caps, height, width, pixel format, mips, linear size"
        );
        assert_eq!(word(28), row.extent[0].max(row.extent[1]).ilog2() + 1);
        assert_eq!(word(80) & 4, 4, "a four-character code");
        assert_eq!(&bytes[84..88], b"DX10");
        assert_eq!(word(108) & 0x0040_1008, 0x0040_1008, "complex, mips, texture");
        let dxgi = match row.usage {
            TextureUsage::Normal => 83,                       // BC5_UNORM
            TextureUsage::Data => 98,                         // BC7_UNORM
            TextureUsage::Color | TextureUsage::Cutout => 99, // BC7_UNORM_SRGB
        };
        assert_eq!((word(128), word(132), word(140)), (dxgi, 3, 1), "format, 2D, one image");
        let dds = DdsTexture::from_bytes(&bytes).unwrap();
        assert_eq!(dds.levels.iter().map(Vec::len).sum::<usize>() + 148, bytes.len());
    }
}

#[test]
fn damaged_files_are_noticed_and_rebuilt() {
    let temp = tempfile::tempdir().unwrap();
    let scene = scene(temp.path());
    let first = run(&scene, temp.path(), Quality::Fast);
    let file = temp.path().join(&first[0].file);
    let good = std::fs::read(&file).unwrap();
    for damage in [
        |bytes: &mut Vec<u8>| bytes[200] ^= 1,
        |bytes: &mut Vec<u8>| bytes.truncate(170),
        |bytes: &mut Vec<u8>| bytes.truncate(20),
        |bytes: &mut Vec<u8>| bytes[12] ^= 4,
        |bytes: &mut Vec<u8>| bytes[45] ^= 4,
    ] {
        let mut bytes = good.clone();
        damage(&mut bytes);
        std::fs::write(&file, bytes).unwrap();
        let loaded = load_with(&scene, Some(temp.path()));
        assert!(matches!(loaded.textures[0].texels, Texels::Rgba8(_)));
        let notices: Vec<_> = loaded.notices.iter().filter(|n| n.contains(&first[0].file)).collect();
        assert_eq!(notices.len(), 1, "{:?}", loaded.notices);
        let again = run(&scene, temp.path(), Quality::Fast);
        assert_eq!(again[0].outcome, Outcome::Rebuilt);
        assert_eq!(std::fs::read(&file).unwrap(), good, "the same input gives the same file");
    }
}

#[test]
fn another_quality_replaces_the_file() {
    let temp = tempfile::tempdir().unwrap();
    let scene = scene(temp.path());
    let fast = run(&scene, temp.path(), Quality::Fast);
    let best = run(&scene, temp.path(), Quality::Best);
    assert_eq!((fast[0].outcome, best[0].outcome), (Outcome::Baked, Outcome::Rebuilt));
    let color = |t: &&pt_import::bake::BakedTexture| t.usage == TextureUsage::Color;
    let psnr = |report: &[pt_import::bake::BakedTexture]| report.iter().find(color).unwrap().psnr;
    assert!(psnr(&best) > psnr(&fast), "{:?} {:?}", psnr(&best), psnr(&fast));
    let missing =
        bake(&scene, Path::new("/dev/null/x"), Quality::Fast, &limit(1), |_, _| {}).unwrap_err().to_string();
    assert!(missing.contains("/dev/null/x") && !missing.contains('\n'), "{missing}");
    let limited = bake(&scene, temp.path(), Quality::Fast, &limit(10), |_, _| {}).unwrap_err().to_string();
    assert!(limited.contains("--max-texture-pixels"), "{limited}");
}

/// A 16-bit image is baked like an 8-bit one: blocks hold 8 bits. What it takes without compression counts all of its bits, also when
/// the file is there already.
#[test]
fn images_of_16_bits_are_baked_with_8() {
    let temp = tempfile::tempdir().unwrap();
    let [width, height] = SIZE;
    let image = image::ImageBuffer::from_fn(width, height, |x, y| {
        image::Rgb([0x4001 + 300 * x as u16, 0x8003 + 500 * y as u16, 0x1234])
    });
    image.save(temp.path().join("wide.png")).unwrap();
    let material = r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}},
        "normalTexture": {"index": 0}}"#;
    let scene = gltf(temp.path(), r#"{"uri": "wide.png"}"#, r#"{"source": 0}"#, material);
    let out = temp.path().join("baked");
    let first = run(&scene, &out, Quality::Best);
    let again = run(&scene, &out, Quality::Best);
    let (plain, baked) = (load_with(&scene, None), load_with(&scene, Some(&out)));
    assert_eq!((plain.textures.len(), first.len()), (3, 3));
    for (i, (plain, baked)) in plain.textures.iter().zip(&baked.textures).enumerate() {
        assert!(plain.is_16_bit() && matches!(baked.texels, Texels::Blocks { .. }), "{:?}", plain.usage);
        assert_eq!((first[i].outcome, again[i].outcome), (Outcome::Baked, Outcome::Unchanged));
        let bytes = [first[i].bytes_before, again[i].bytes_before];
        assert_eq!(bytes, [plain.uncompressed_bytes(); 2]);
        let channels = if plain.usage == TextureUsage::Normal { 2 } else { 3 };
        let db = psnr(&plain.mips()[0].texels, &baked.mips()[0].texels, channels);
        assert!(db > 40.0, "{:?}: {db} dB", plain.usage);
        let (exact, read) = (plain.texel(30, 20), baked.texel(30, 20));
        let near = (0..channels).all(|c| (exact[c] - read[c]).abs() < 0.02);
        assert!(near, "{:?}: {exact:?}, {read:?}", plain.usage);
    }
}
