//! Image files: round trips, reproducible bytes, refusals, and writes that survive a kill.

use std::fs;
use std::path::{Path, PathBuf};

use half::f16;
use proptest::prelude::*;
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::{
    Channel, IMAGE_STATE_KEY, ImageFileError, ImageState, Layer, LayeredImage, LinearImage, MAX_IMAGE_SIDE,
    OutputFormat, PixelLayout, Samples, check_output, check_size, srgb_decode, write_png,
};

fn rgb_image(width: u32, height: u32) -> LayeredImage {
    let values: Vec<f32> = (0..width * height * 3).map(|index| index as f32 * 0.37 - 2.0).collect();
    let mut image = LayeredImage::new(width, height).unwrap();
    image.layers.push(Layer::from_interleaved("", &["B", "G", "R"], 3, &values));
    image
}

/// Every sample type, odd values, metadata of several kinds; in the order that files keep.
fn rich_image() -> LayeredImage {
    let (width, height) = (37, 41);
    let count = (width * height) as usize;
    let mut image = rgb_image(width, height);
    let normals: Vec<f32> = (0..count * 4).map(|index| (index as f32).sin()).collect();
    image.layers.push(Layer::from_interleaved("normal", &["X", "Y", "Z"], 4, &normals));
    let half = (0..count).map(|index| f16::from_f32(index as f32 * 0.5)).collect();
    image.layers.push(Layer {
        name: "view_depth".into(),
        channels: vec![
            Channel { name: "H".into(), samples: Samples::F16(half) },
            Channel { name: "Z".into(), samples: Samples::F32(vec![f32::INFINITY; count]) },
        ],
    });
    let ids = (0..count as u32).map(|index| u32::MAX - index).collect();
    image.layers.push(Layer {
        name: "visible.deep".into(),
        channels: vec![Channel { name: "id".into(), samples: Samples::U32(ids) }],
    });
    for (key, value) in [
        ("camera", "{\"eye\":[0,1,2]}"),
        ("device", "llvmpipe"),
        ("driver", "Müller 25.0"),
        ("seed", "7"),
        ("version", "0.1.0"),
        ("empty", ""),
    ] {
        image.metadata.insert(key.into(), value.into());
    }
    image
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn exr_keeps_layers_types_and_metadata() {
    let folder = folder();
    let path = folder.path().join("rich.exr");
    let image = rich_image();
    image.write_exr(&path).unwrap();
    let read = LayeredImage::read_exr(&path).unwrap();
    assert_eq!(read, image);
    assert_eq!(read.channel("normal", "Y").unwrap().len(), 37 * 41);
    assert!(read.channel("normal", "W").is_none());
}

#[test]
fn nan_payloads_survive() {
    let folder = folder();
    let path = folder.path().join("nan.exr");
    let bits = [0x7fc0_1234u32, 0xffc0_0001, 0x0000_0001, 0x8000_0000];
    let mut image = LayeredImage::new(4, 1).unwrap();
    let samples = Samples::F32(bits.map(f32::from_bits).to_vec());
    image.layers.push(Layer { name: String::new(), channels: vec![Channel { name: "Y".into(), samples }] });
    image.write_exr(&path).unwrap();
    let read = LayeredImage::read_exr(&path).unwrap().channel("", "Y").unwrap().to_f32();
    assert_eq!(read.iter().map(|value| value.to_bits()).collect::<Vec<_>>(), bits);
}

/// The exr crate's own attribute order is random per image; 16 tries would show it.
#[test]
fn same_content_same_bytes() {
    let folder = folder();
    let write = |index: usize| {
        let path = folder.path().join(format!("{index}.exr"));
        rich_image().write_exr(&path).unwrap();
        fs::read(path).unwrap()
    };
    let first = write(0);
    for index in 1..16 {
        assert!(write(index) == first, "file {index} differs from file 0");
    }
}

#[test]
fn layers_in_another_order_give_the_same_bytes() {
    let folder = folder();
    let (first, second) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
    let mut image = rich_image();
    image.write_exr(&first).unwrap();
    image.layers.reverse();
    image.layers[0].channels.reverse();
    image.write_exr(&second).unwrap();
    assert!(fs::read(first).unwrap() == fs::read(second).unwrap());
}

#[test]
fn other_readers_see_the_main_layer() {
    let folder = folder();
    let path = folder.path().join("main.exr");
    rich_image().write_exr(&path).unwrap();
    let set = |rows: &mut Vec<[f32; 3]>, at: exr::math::Vec2<usize>, (r, g, b): (f32, f32, f32)| {
        rows[at.1 * 37 + at.0] = [r, g, b];
    };
    let create = |size: exr::math::Vec2<usize>, _: &_| vec![[0.0; 3]; size.area()];
    let read = {
        use exr::prelude::*;
        read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(create, set)
            .first_valid_layer()
            .all_attributes()
            .from_file(&path)
            .unwrap()
    };
    assert_eq!(read.layer_data.channel_data.pixels, LinearImage::read(&path).unwrap().pixels);
    assert_eq!(read.layer_data.channel_data.pixels[0], [-2.0 + 2.0 * 0.37, -2.0 + 0.37, -2.0]);
}

#[test]
fn rules_of_the_format_are_checked() {
    let folder = folder();
    let path = folder.path().join("bad.exr");
    let refused = |change: &dyn Fn(&mut LayeredImage), expected: &str| {
        let mut image = rgb_image(4, 3);
        change(&mut image);
        let message = image.write_exr(&path).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains("bad.exr"), "{message}");
        assert!(!path.exists());
    };
    refused(&|image| image.layers.clear(), "no channels");
    refused(
        &|image| image.layers[0].channels[1].samples = Samples::F32(vec![0.0; 11]),
        "11 samples, 4x3 pixels need 12",
    );
    refused(&|image| image.layers.push(image.layers[0].clone()), "twice");
    refused(&|image| image.layers[0].channels[0].name = "x.y".into(), "dot");
    refused(&|image| image.layers[0].channels[0].name.clear(), "empty");
    refused(&|image| image.layers[0].name = "n".repeat(254), "at most 255 bytes");
    refused(&|image| drop(image.metadata.insert("k".repeat(253), String::new())), "at most 255 bytes");
    refused(&|image| image.width = 0, "0x3 is out of range");
}

#[test]
fn sizes_out_of_range_are_refused() {
    for (width, height) in [(0, 1), (1, 0), (MAX_IMAGE_SIDE + 1, 1), (1, 100_000)] {
        let message = LayeredImage::new(width, height).unwrap_err().to_string();
        assert_eq!(
            message,
            format!("image size {width}x{height} is out of range, each side must be 1 to 16384 pixels")
        );
        let png = write_png(Path::new("never.png"), width, height, PixelLayout::Rgb, &[]).unwrap_err();
        assert!(matches!(png, ImageFileError::Size { .. }));
    }
    check_size(1, 1).unwrap();
    check_size(MAX_IMAGE_SIDE.into(), MAX_IMAGE_SIDE.into()).unwrap();
}

fn chunks(png: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut rest = &png[8..];
    let mut found = Vec::new();
    while rest.len() >= 12 {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        found.push((String::from_utf8(rest[4..8].to_vec()).unwrap(), rest[8..8 + length].to_vec()));
        rest = &rest[12 + length..];
    }
    found
}

#[test]
fn png_is_tagged_srgb_and_reads_back_linear() {
    let folder = folder();
    let path = folder.path().join("ramp.png");
    let codes: Vec<u8> = (0..=255).flat_map(|code| [code, 255 - code, 7]).collect();
    write_png(&path, 64, 4, PixelLayout::Rgb, &codes).unwrap();
    let chunks = chunks(&fs::read(&path).unwrap());
    assert!(chunks.contains(&("sRGB".into(), vec![0])), "perceptual intent: {chunks:?}");
    assert!(chunks.iter().all(|(name, _)| name != "tIME" && name != "tEXt"), "{chunks:?}");
    let read = LinearImage::read(&path).unwrap();
    assert_eq!((read.width, read.height, read.state), (64, 4, ImageState::DisplayReferred));
    assert_eq!(read.pixels[200], [200u8, 55, 7].map(|code| srgb_decode(f32::from(code) / 255.0)));
}

#[test]
fn png_with_alpha_reads_back_without() {
    let folder = folder();
    let path = folder.path().join("alpha.png");
    write_png(&path, 1, 2, PixelLayout::Rgba, &[255, 0, 0, 128, 0, 255, 0, 0]).unwrap();
    assert_eq!(LinearImage::read(&path).unwrap().pixels, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn png_with_too_few_bytes_is_refused() {
    let folder = folder();
    let path = folder.path().join("short.png");
    let message = write_png(&path, 2, 2, PixelLayout::Rgb, &[0; 11]).unwrap_err().to_string();
    assert!(message.contains("short.png"), "{message}");
    assert!(!path.exists());
}

#[test]
fn hdr_and_jpeg_are_read() {
    let folder = folder();
    let hdr = folder.path().join("a.hdr");
    let pixels = vec![image::Rgb([0.5f32, 2.0, 64.0]); 12];
    image::codecs::hdr::HdrEncoder::new(fs::File::create(&hdr).unwrap()).encode(&pixels, 4, 3).unwrap();
    let read = LinearImage::read(&hdr).unwrap();
    assert_eq!((read.width, read.height, read.state), (4, 3, ImageState::SceneReferred));
    // RGBE shares the exponent of the largest channel: 64 / 128 per step.
    assert!(
        (read.pixels[7][2] - 64.0).abs() <= 0.5 && (read.pixels[7][0] - 0.5).abs() <= 0.5,
        "{:?}",
        read.pixels[7]
    );

    let jpeg = folder.path().join("a.JPG");
    let grey = image::RgbImage::from_pixel(16, 16, image::Rgb([128, 128, 128]));
    grey.save_with_format(&jpeg, image::ImageFormat::Jpeg).unwrap();
    let read = LinearImage::read(&jpeg).unwrap();
    assert_eq!(read.state, ImageState::DisplayReferred);
    assert!((read.pixels[0][1] - srgb_decode(128.0 / 255.0)).abs() < 0.01);
}

#[test]
fn linear_reader_finds_the_beauty_layer() {
    let folder = folder();
    let path = folder.path().join("layers.exr");
    let mut image = rgb_image(2, 2);
    image.metadata.insert(IMAGE_STATE_KEY.into(), "display".into());
    image.write_exr(&path).unwrap();
    assert_eq!(LinearImage::read(&path).unwrap().state, ImageState::DisplayReferred);

    image.metadata.clear();
    image.layers[0].name = "ViewLayer.Combined".into();
    image.write_exr(&path).unwrap();
    let read = LinearImage::read(&path).unwrap();
    assert_eq!(read.state, ImageState::SceneReferred);
    assert_eq!(read.pixels[1], [-2.0 + 5.0 * 0.37, -2.0 + 4.0 * 0.37, -2.0 + 3.0 * 0.37]);

    image.layers[0].name = "left".into();
    let mut second = image.layers[0].clone();
    second.name = "right".into();
    image.layers.push(second);
    image.write_exr(&path).unwrap();
    let message = LinearImage::read(&path).unwrap_err().to_string();
    assert!(message.contains("more than one layer has a picture (left, right)"), "{message}");

    image.layers.truncate(1);
    image.layers[0].channels.pop();
    image.write_exr(&path).unwrap();
    let message = LinearImage::read(&path).unwrap_err().to_string();
    assert!(message.contains("no layer has channels R, G, B"), "{message}");
}

#[test]
fn crop_takes_the_named_pixels() {
    let pixels: Vec<_> = (0..20).map(|index| [index as f32; 3]).collect();
    let image = LinearImage { width: 5, height: 4, pixels, state: ImageState::SceneReferred };
    let part = image.crop(3, 1, 2, 2).unwrap();
    assert_eq!((part.width, part.height), (2, 2));
    assert_eq!(part.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>(), [8.0, 9.0, 13.0, 14.0]);
    assert_eq!(image.crop(0, 0, 5, 4).unwrap(), image);
    assert!(image.crop(4, 0, 2, 1).is_none() && image.crop(0, 0, 0, 1).is_none());
    assert!(image.crop(u32::MAX, 0, 2, 1).is_none());
}

#[test]
fn refusals_name_the_path_and_the_reason() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("folder.png")).unwrap();
    fs::write(at("file"), "").unwrap();
    let message = |path: PathBuf| {
        let message = check_output(&path).unwrap_err().to_string();
        assert!(message.contains(&path.display().to_string()), "{message}");
        message
    };
    assert!(message(at("a.tiff")).contains("unknown image extension \"tiff\", use one of: png, jpg, exr"));
    assert!(message(at("plain")).contains("the name has no extension"));
    assert!(message(folder.path().into()).contains("is a folder; give the name of an image"));
    assert!(message(at("missing/a.png")).contains("does not exist, create it first"));
    assert!(message(at("folder.png")).contains("is a directory"));
    assert!(message(at("file/a.exr")).contains("file is not a folder"));
    assert_eq!(check_output(&at("a.PNG")).unwrap(), OutputFormat::Png);
    assert!(!at("a.PNG").exists(), "the check leaves nothing");

    let reading = |name: &str| LinearImage::read(&at(name)).unwrap_err().to_string();
    assert!(reading("none.png").contains("none.png") && reading("none.png").contains("No such file"));
    assert!(reading("a.bmp").contains("use one of: png, jpg, jpeg, hdr, exr"));
    assert!(reading("folder.png").contains("folder.png"));
    for name in ["empty.png", "empty.exr", "empty.hdr", "empty.jpg"] {
        fs::write(at(name), "").unwrap();
        assert!(reading(name).contains(name));
    }
}

/// A device must never be replaced by a file.
#[cfg(unix)]
#[test]
fn only_regular_files_are_replaced() {
    let message = check_writable(Path::new("/dev/null")).unwrap_err().to_string();
    assert!(message.contains("not a regular file"), "{message}");
    for path in ["", ".", "/", ".."] {
        check_writable(Path::new(path)).unwrap_err();
    }
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_the_umask_is_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let (real, link, plain) =
        (folder.path().join("real"), folder.path().join("link"), folder.path().join("plain"));
    fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write_atomic(&link, b"new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&real).unwrap(), b"new");
    fs::write(&plain, "").unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&real), mode(&plain), "as any other file made here");
}

/// Kills a writer at several moments; the final name must hold one whole content or the other.
#[test]
fn a_killed_writer_leaves_a_whole_file() {
    const CHILD: &str = "PT_ATOMIC_WRITE_CHILD";
    let content = |byte: u8| vec![byte; 8 << 20];
    if let Some(path) = std::env::var_os(CHILD) {
        for byte in (1..=2).cycle() {
            write_atomic(Path::new(&path), &content(byte)).unwrap();
        }
    }
    let folder = folder();
    let path = folder.path().join("result");
    let mut caught_in_the_act = 0;
    for moment in 0..12 {
        let mut child = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "image_file::a_killed_writer_leaves_a_whole_file"])
            .env(CHILD, &path)
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        while !path.exists() {
            assert!(child.try_wait().unwrap().is_none(), "the writer ended by itself");
            std::thread::yield_now();
        }
        std::thread::sleep(std::time::Duration::from_millis(3 + 5 * moment));
        child.kill().unwrap();
        child.wait().unwrap();
        let found = fs::read(&path).unwrap();
        assert!(found == content(1) || found == content(2), "a partial file of {} bytes", found.len());
        fs::remove_file(&path).unwrap();
        for entry in fs::read_dir(folder.path()).unwrap() {
            caught_in_the_act += 1;
            fs::remove_file(entry.unwrap().path()).unwrap();
        }
    }
    assert!(caught_in_the_act > 0, "no kill hit a write: the test showed nothing");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Damaged EXR files are errors or images, never panics.
    #[test]
    fn damaged_exr_is_no_panic(cut in 0usize..4000, at in 0usize..600, byte in any::<u8>()) {
        thread_local! {
            static WHOLE: Vec<u8> = {
                let folder = folder();
                let path = folder.path().join("small.exr");
                let mut image = rgb_image(9, 18);
                image.metadata.insert("seed".into(), "1".into());
                image.write_exr(&path).unwrap();
                fs::read(path).unwrap()
            };
        }
        let folder = folder();
        let path = folder.path().join("damaged.exr");
        let mut bytes = WHOLE.with(Clone::clone);
        let length = bytes.len();
        let truncated = cut < length;
        if truncated {
            bytes.truncate(cut);
        } else {
            bytes[at.min(length - 1)] ^= byte;
        }
        fs::write(&path, bytes).unwrap();
        let read = LayeredImage::read_exr(&path);
        prop_assert!(!truncated || read.is_err());
    }
}
