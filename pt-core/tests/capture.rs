//! Channels to layers and back.

use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use pt_core::capture::{CaptureError, load, read_layer, write_layer};
use pt_core::pack::pack_unit_vector;
use pt_core::split::{split_to_flat, to_split};
use pt_core::test_support::{TestDevice, channel_images};
use pt_core::{Image, StageIo};
use pt_image::image_file::{Channel, LayeredImage, Samples};
use pt_shaders::channels::{self, ChannelId, ExtentClass, Format};
use pt_shaders::glam::Vec3;

/// The texels' words as the format stores them: 2, 4 or 1 bytes each.
fn random_texels(image: &Image, id: ChannelId, bits: &mut impl FnMut() -> u32) -> Vec<u8> {
    let format = id.channel().format;
    let width = format.components() as usize;
    let words = (image.bytes() / u64::from(format.bytes())) as usize * width;
    let mut bytes = Vec::new();
    for _ in 0..words {
        let word = bits();
        match format.bytes() as usize / width {
            1 => bytes.push(word as u8),
            // Half floats: without NaN, whose payload the conversion to f32 and back may alter.
            2 if format == Format::Rgba16F => bytes.extend((word as u16 & 0xfbff).to_le_bytes()),
            2 => bytes.extend((word as u16).to_le_bytes()),
            _ => bytes.extend(word.to_le_bytes()),
        }
    }
    bytes
}

/// Zeros where a split image has no flat pixel.
fn without_the_unrecorded(texels: &mut [u8], id: ChannelId, size: [u32; 2]) {
    if id.channel().extent != ExtentClass::Split {
        return;
    }
    let half = size[0].div_ceil(2);
    for (index, texel) in texels.chunks_exact_mut(id.channel().format.bytes() as usize).enumerate() {
        let split = [index as u32 % (2 * half), index as u32 / (2 * half)];
        if split_to_flat(split, half)[0] >= size[0] {
            texel.fill(0);
        }
    }
}

#[test]
fn what_is_read_can_be_written_back() {
    let device = TestDevice::open();
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 12, failure_persistence: None, ..Config::default() },
        TestRunner::deterministic().new_rng(),
    );
    let run = |size: [u32; 2], seed: u32| {
        let images = channel_images(&device, size, ChannelId::all());
        let mut state = seed;
        let mut bits = || {
            // PCG's state and output function (O'Neill 2014).
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
            (word >> 22) ^ word
        };
        for id in ChannelId::all() {
            let image = images.current(id);
            let mut texels = random_texels(image, id, &mut bits);
            image.write(&texels).unwrap();
            let layer = read_layer(&images, id).unwrap().0;
            image.write(&vec![0xa5; texels.len()]).unwrap();
            write_layer(&images, id, &layer).unwrap();
            without_the_unrecorded(&mut texels, id, size);
            let back = image.read().unwrap();
            let name = id.channel().name;
            assert!(back == texels, "{name} at {size:?}");
            assert_eq!(read_layer(&images, id).unwrap().0.channels.len(), layer.channels.len(), "{name}");
        }
    };
    for size in [[1, 1], [1, 2], [3, 2], [2, 1]] {
        run(size, 1);
    }
    let inputs = ([1u32..40, 1u32..24], any::<u32>());
    let case = |(size, seed)| {
        run(size, seed);
        Ok(())
    };
    runner.run(&inputs, case).unwrap();
}

#[test]
fn layers_are_flat_and_unpacked() {
    let device = TestDevice::open();
    let size = [3, 2];
    let ids = [channels::NORMAL, channels::VIEW_DIRECTION, channels::SHADING_POSITION, channels::CLUSTER];
    let images = channel_images(&device, size, ids);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y];
    let codes: Vec<u32> = axes.map(pack_unit_vector).into_iter().chain([0]).collect();
    images.current(channels::NORMAL).write_u32(&to_split(&codes, size, 77)).unwrap();
    let views: Vec<[u32; 2]> = codes.iter().zip(10..).map(|(&code, flags)| [code, flags]).collect();
    images
        .current(channels::VIEW_DIRECTION)
        .write_u32(to_split(&views, size, [0; 2]).as_flattened())
        .unwrap();
    let positions: Vec<[f32; 4]> = (0..6).map(|i| [i as f32, 0.5, -1.0, f32::from_bits(i)]).collect();
    let split = to_split(&positions, size, [9.0; 4]);
    images.current(channels::SHADING_POSITION).write_f32(split.as_flattened()).unwrap();
    images.current(channels::CLUSTER).write_u32(&to_split(&[0, 1, 2, 3, 4, 0xffff], size, 5)).unwrap();

    let component = |id: ChannelId, name: &str| {
        let layer = read_layer(&images, id).unwrap().0;
        assert_eq!(layer.name, id.channel().name);
        layer.channels.into_iter().find(|c| c.name == name).map(|c| c.samples).expect(name)
    };
    for id in [channels::NORMAL, channels::VIEW_DIRECTION] {
        assert_eq!(component(id, "X").to_f32(), [1.0, 0.0, 0.0, -1.0, 0.0, 0.0]);
        assert_eq!(component(id, "Y").to_f32(), [0.0, 1.0, 0.0, 0.0, -1.0, 0.0]);
        assert_eq!(component(id, "Z").to_f32(), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    }
    assert_eq!(component(channels::VIEW_DIRECTION, "flags"), Samples::U32((10..16).collect()));
    assert_eq!(component(channels::SHADING_POSITION, "X").to_f32(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(component(channels::SHADING_POSITION, "material"), Samples::U32((0..6).collect()));
    assert_eq!(component(channels::CLUSTER, "x"), Samples::U32(vec![0, 1, 2, 3, 4, 0xffff]));
}

const STAGE: StageIo = StageIo {
    reads: &[channels::SHADING_POSITION, channels::VISIBILITY, channels::THROUGHPUT],
    writes: &[channels::COLOR],
    ..StageIo::of("stage")
};

#[test]
fn captures_go_through_files() {
    let device = TestDevice::open();
    let size = [5, 3];
    let ids = [channels::SHADING_POSITION, channels::VISIBILITY, channels::THROUGHPUT];
    let images = channel_images(&device, size, ids);
    let mut file = LayeredImage::new(size[0], size[1]).unwrap();
    for (number, id) in (1u8..).zip(ids) {
        let image = images.current(id);
        let mut texels: Vec<u8> = (0..image.bytes()).map(|i| i as u8 % 60 * number).collect();
        without_the_unrecorded(&mut texels, id, size);
        image.write(&texels).unwrap();
        file.layers.push(read_layer(&images, id).unwrap().0);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("capture.exr");
    file.write_exr(&path).unwrap();
    let capture = LayeredImage::read_exr(&path).unwrap();
    let loaded = load(&device, &capture, &[STAGE]).unwrap();
    assert_eq!(loaded.size(), size);
    for id in ids {
        assert!(
            loaded.current(id).read().unwrap() == images.current(id).read().unwrap(),
            "{}",
            id.channel().name
        );
    }
    assert_eq!(loaded.current(channels::COLOR).extent(), [6, 3]);
}

#[test]
fn what_is_missing_is_named() {
    let device = TestDevice::open();
    let images = channel_images(&device, [2, 2], [channels::MOTION, channels::VISIBILITY]);
    let layer = read_layer(&images, channels::MOTION).unwrap().0;
    let mut capture = LayeredImage::new(2, 2).unwrap();
    capture.layers.push(layer.clone());
    let reads = &[channels::MOTION, channels::VISIBILITY];
    let stage = StageIo { reads, ..StageIo::of("stage") };
    let error = load(&device, &capture, &[stage]).err().unwrap();
    assert_eq!(error.to_string(), "no layer \"visibility\"; there are motion");

    let refused = |change: &dyn Fn(&mut Vec<Channel>)| {
        let mut layer = layer.clone();
        change(&mut layer.channels);
        write_layer(&images, channels::MOTION, &layer).unwrap_err()
    };
    let gone = refused(&|components| drop(components.remove(2)));
    assert_eq!(
        gone.to_string(),
        "layer \"motion\" has no float component \"Z\"; it has float X, float Y, float W"
    );
    let integer = refused(&|components| components[0].samples = Samples::U32(vec![1; 4]));
    assert!(matches!(integer, CaptureError::MissingComponent { component: "X", .. }), "{integer}");
    let short = refused(&|components| components[3].samples = Samples::F32(vec![0.0; 3]));
    assert_eq!(short.to_string(), "layer \"motion\" has 3 samples in \"W\", the frame has 4 pixels");
}

/// `write_f32` and `write_u32` undo `read_f32` and `read_u32`, and keep to the formats' ranges.
#[test]
fn values_are_encoded() {
    let device = TestDevice::open();
    let image = |format| Image::new(&device, "values", format, [2, 1]).unwrap();
    let written = |format: Format, values: &[f32]| {
        let image = image(format);
        image.write_f32(values).unwrap();
        image.read_f32().unwrap()
    };
    let hdr = [-1.5, 65504.0, 0.25, 1e-7];
    assert_eq!(written(Format::Rg32F, &hdr), hdr);
    let half = written(Format::Rgba16F, &[&hdr[..], &[f32::INFINITY, 0.0, 1.0, 2.0]].concat());
    assert_eq!(half[..3], hdr[..3]);
    assert!((half[3] - 1e-7).abs() < 3e-8, "half floats are 6e-8 apart there");
    assert_eq!(half[4], f32::INFINITY);
    let unorm = written(Format::Rg16Unorm, &[-1.0, 2.0, f32::NAN, 0.25]);
    assert_eq!(unorm[..3], [0.0, 1.0, 0.0]);
    assert!((unorm[3] - 0.25).abs() <= 0.5 / 65535.0);
    assert_eq!(written(Format::Rg8Unorm, &[-1.0, 2.0, f32::NAN, 0.2]), [0.0, 1.0, 0.0, 0.2]);
    let roots = written(Format::Rgba8Root, &[-1.0, 2.0, f32::NAN, 0.04, 1e-5, 0.5, 0.25, 1.0]);
    assert_eq!(roots[..3], [0.0, 1.0, 0.0]);
    for (root, value) in roots[3..].iter().zip([0.04f32, 1e-5, 0.5, 0.25, 1.0]) {
        assert!((root.sqrt() - value.sqrt()).abs() <= 0.5001 / 255.0, "{root} for {value}");
    }
    // What was read is written back as it was.
    assert_eq!(written(Format::Rgba8Root, &roots), roots);
    assert_eq!(written(Format::R16Uint, &[-3.0, 1e9]), [0.0, 65535.0]);

    let words = image(Format::Rg32Uint);
    words.write_u32(&[1, u32::MAX, 0, 1 << 31]).unwrap();
    assert_eq!(words.read_u32().unwrap(), [1, u32::MAX, 0, 1 << 31]);
    let short = image(Format::R16Uint);
    short.write_u32(&[7, 1 << 20]).unwrap();
    assert_eq!(short.read_u32().unwrap(), [7, 65535]);
    assert!(short.write_u32(&[7]).unwrap_err().to_string().contains("2 bytes given for an image of 4 bytes"));
    assert!(image(Format::R32F).write_u32(&[1, 2]).unwrap_err().to_string().contains("no integers"));
}
