//! Lat-long environments: orientation, rotation, files.

use std::f32::consts::FRAC_PI_2;

use pt_scene::glam::{Vec2, Vec3};
use pt_scene::{BadTexels, Environment, EnvironmentImage, default_sky};
use pt_test_data::shared;

/// Each texel tells where it is: R = column, G = row.
fn chart(width: u32, height: u32) -> Environment {
    let texel = |i: u32| Vec3::new((i % width) as f32, (i / width) as f32, 0.0);
    Environment::new(EnvironmentImage { width, height, texels: (0..width * height).map(texel).collect() })
}

#[test]
fn axes_lie_where_the_convention_puts_them() {
    let e = Environment::black();
    let near =
        |d: Vec3, u: f32, v: f32| assert!(e.uv(d).abs_diff_eq(Vec2::new(u, v), 1e-5), "{d}: {}", e.uv(d));
    near(Vec3::X, 0.5, 0.5);
    near(Vec3::Z, 0.75, 0.5);
    near(Vec3::NEG_Z, 0.25, 0.5);
    assert!(e.uv(Vec3::Y).y < 1e-3 && e.uv(Vec3::NEG_Y).y > 0.999);
    let chart = chart(8, 4);
    assert!(
        (chart.radiance(chart.direction(Vec2::new(2.5 / 8.0, 1.5 / 4.0))) - Vec3::new(2.0, 1.0, 0.0))
            .length()
            < 1e-3
    );
}

#[test]
fn rotation_is_right_handed_about_y() {
    let mut e = chart(64, 32);
    let before = e.radiance(Vec3::Z);
    e.rotation = FRAC_PI_2;
    assert!(e.radiance(Vec3::X).abs_diff_eq(before, 1e-2), "{} was {before}", e.radiance(Vec3::X));
}

#[test]
fn direction_inverts_uv() {
    let mut e = Environment::black();
    e.rotation = 0.7;
    for i in 0..100 {
        let uv = Vec2::new(((i as f32 + 0.5) * 0.618).fract(), (i as f32 + 0.5) / 100.0);
        assert!(e.uv(e.direction(uv)).abs_diff_eq(uv, 1e-4), "{uv}");
    }
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn hdr_files_load() {
    let folder = shared("environments");
    let e = Environment::load(folder.join("royal_esplanade_1k.hdr")).unwrap();
    assert_eq!((e.image.width, e.image.height), (1024, 512));
    assert!(!e.is_black());
    Environment::load(folder.join("simple-rle.hdr")).unwrap();
    let temp = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(folder.join("royal_esplanade_1k.hdr")).unwrap();
    let file = temp.path().join("cut.hdr");
    for cut in [1, 5, 60, 200, bytes.len() / 2, bytes.len() - 9] {
        std::fs::write(&file, &bytes[..cut]).unwrap();
        let text = Environment::load(&file).expect_err("cut").to_string();
        assert!(text.contains("cut.hdr") && !text.contains('\n'), "{text}");
    }
}

#[test]
fn exr_files_load_and_bad_texels_are_named() {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("e.exr");
    exr::prelude::write_rgb_file(&file, 16, 8, |x, y| (x as f32, y as f32, 0.5f32)).unwrap();
    let e = Environment::load(&file).unwrap();
    assert_eq!(e.image.texels[3 * 16 + 5], Vec3::new(5.0, 3.0, 0.5));
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        exr::prelude::write_rgb_file(&file, 16, 8, |x, y| {
            (1.0f32, if (x, y) == (5, 3) { bad } else { 0.0 }, 0.0f32)
        })
        .unwrap();
        let text = Environment::load(&file).unwrap_err().to_string();
        assert!(text.contains("1 of 128") && text.contains("(5, 3)") && text.contains("e.exr"), "{text}");
        assert!(text.contains("--env-clamp"), "{text}");
    }
    std::fs::write(&file, b"not a picture").unwrap();
    assert!(Environment::load(&file).unwrap_err().to_string().contains("e.exr"));
    assert!(Environment::load(temp.path()).unwrap_err().to_string().contains("folder"));
}

#[test]
fn bad_texels_are_clamped_on_request() {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("e.exr");
    let bad = [
        (3, [-1e-5, 0.5, 2.0]),
        (7, [f32::NAN, f32::NAN, 1.0]),
        (9, [f32::INFINITY, -2.0, f32::NEG_INFINITY]),
    ];
    exr::prelude::write_rgb_file(&file, 16, 8, |x, y| {
        let here = bad.iter().find(|(column, _)| (*column, 2) == (x, y));
        let [r, g, b] = here.map_or([0.25; 3], |(_, color)| *color);
        (r, g, b)
    })
    .unwrap();
    let (e, notices) = Environment::read(&file, BadTexels::Clamp).unwrap();
    let row = |x: usize| e.image.texels[2 * 16 + x];
    assert_eq!(row(2), Vec3::splat(0.25));
    assert_eq!(row(3), Vec3::new(0.0, 0.5, 2.0));
    assert_eq!(row(7), Vec3::new(0.0, 0.0, 1.0));
    assert_eq!(row(9), Vec3::new(65504.0, 0.0, 0.0));
    let [notice] = notices.as_slice() else { panic!("one notice: {notices:?}") };
    assert!(
        notice.contains("e.exr") && notice.contains("3 of 128 pixels had negative values or NaN"),
        "{notice}"
    );
    assert!(notice.contains("1 of 128 pixels had infinite values"), "{notice}");
    // A map without any is left alone, and says nothing.
    exr::prelude::write_rgb_file(&file, 16, 8, |_, _| (0.0f32, 1.0f32, 2.0f32)).unwrap();
    let (e, notices) = Environment::read(&file, BadTexels::Clamp).unwrap();
    assert!(notices.is_empty() && e == Environment::load(&file).unwrap(), "{notices:?}");
}

/// The header of a Radiance file is honoured, and a notice with the name of the file says so.
#[test]
fn what_was_done_to_a_file_is_said() {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("e.hdr");
    let pixels = [128u8, 64, 32, 128].repeat(2);
    let header = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 1 +X 2\n".as_slice();
    std::fs::write(&file, [header, &pixels].concat()).unwrap();
    let (e, notices) = Environment::read(&file, BadTexels::Refuse).unwrap();
    assert_eq!(e.image.texels, [Vec3::new(0.25, 0.125, 0.0625); 2]);
    assert!(
        notices.len() == 1 && notices[0].contains("e.hdr") && notices[0].contains("EXPOSURE 2"),
        "{notices:?}"
    );
}

#[test]
fn cube_maps_are_refused_by_name() {
    use exr::meta::attribute::EnvironmentMap;
    use exr::prelude::*;
    for (kind, refused) in [(EnvironmentMap::Cube, true), (EnvironmentMap::LatitudeLongitude, false)] {
        let mut attributes = LayerAttributes::named("sky");
        attributes.environment_map = Some(kind);
        let channels = SpecificChannels::rgb(|_| (1.0f32, 1.0f32, 1.0f32));
        let layer = Layer::new((4, 24), attributes, Encoding::UNCOMPRESSED, channels);
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        match Environment::from_bytes(bytes.get_ref(), "e.exr") {
            Ok(_) => assert!(!refused),
            Err(error) => assert!(refused && error.to_string().contains("e.exr: is a cube map"), "{error}"),
        }
    }
}

#[test]
fn huge_headers_are_refused_before_anything_is_allocated() {
    for header in ["-Y 16384 +X 16384", "-Y 4000000000 +X 4000000000", "-Y 1 +X 70000"] {
        let bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{header}\n").into_bytes();
        Environment::from_bytes(&bytes, "e.hdr").expect_err(header);
    }
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("e.exr");
    exr::prelude::write_rgb_file(&file, 64, 32, |_, _| (1.0f32, 1.0f32, 1.0f32)).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    Environment::from_bytes(&bytes, "e.exr").unwrap();
    // Both windows become 16384 x 16384.
    for name in [b"dataWindow\0box2i\0".as_slice(), b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4 + 8;
        bytes[at..at + 8].copy_from_slice(&[0xff, 0x3f, 0, 0, 0xff, 0x3f, 0, 0]);
    }
    let text = Environment::from_bytes(&bytes, "e.exr").unwrap_err().to_string();
    assert!(text.contains("16384x16384"), "{text}");
}

#[test]
fn the_default_sky_is_brighter_above_than_below() {
    let sky = default_sky();
    assert!(sky.radiance(Vec3::new(0.0, 0.3, -1.0).normalize()).y > 2.0 * sky.radiance(Vec3::NEG_Y).y);
}
