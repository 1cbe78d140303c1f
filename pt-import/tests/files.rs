//! Real and broken scene files.

use std::path::Path;

use crate::common::scene_files;
use pt_import::{LoadOptions, load, open};
use pt_scene::glam::{Vec2, Vec3};
use pt_scene::{LightKind, PhysicalSky, Scene, SceneError};
use pt_test_data::shared;

fn load_plain(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    load(path, &LoadOptions { default_sky: false, ..LoadOptions::default() })
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn every_shared_scene_loads_or_is_refused_by_name() {
    let folder = shared("scenes");
    let mut refused = Vec::new();
    let files = scene_files(&folder);
    assert!(files.len() >= 45);
    for file in &files {
        let name = file.strip_prefix(&folder).unwrap().display();
        match load(file, &LoadOptions::default()) {
            Ok(scene) => {
                let s = scene.statistics();
                println!(
                    "{name}: {} triangles, {} instances, {} notices",
                    s.triangles,
                    scene.instances.len(),
                    scene.notices.len()
                );
                assert!(s.instanced_triangles > 0, "{name} is empty");
                assert!(!scene.is_unlit(), "{name} has no light");
            }
            Err(SceneError::Extension { extension, .. }) => {
                println!("{name}: refused, requires {extension}");
                refused.push(extension);
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert_eq!(refused, [""; 0]);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn cut_and_flipped_files_never_panic() {
    let folder = shared("scenes");
    let temp = tempfile::tempdir().unwrap();
    for name in [
        "GeometryCameraLight/geometry-camera-light.glb",
        "GlassTable/glass-table.glb",
        "SimpleSparseAccessor/SimpleSparseAccessor.gltf",
    ] {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let file = temp.path().join("broken.glb");
        for cut in (0..bytes.len()).step_by(bytes.len() / 97 + 1) {
            std::fs::write(&file, &bytes[..cut]).unwrap();
            let text = load_plain(&file).expect_err("a cut file cannot load").to_string();
            assert!(text.contains("broken.glb") && !text.contains('\n'), "{text}");
        }
        // Bytes of the header, the JSON and the data overwritten: any result but a panic.
        for i in 0..300usize {
            let mut broken = bytes.clone();
            let at = (i * 7919) % bytes.len().min(6000);
            broken[at] = broken[at].wrapping_add(1 + (i % 13) as u8);
            std::fs::write(&file, &broken).unwrap();
            let _ = load_plain(&file);
        }
    }
}

#[test]
fn hopeless_inputs_get_one_clear_line() {
    let temp = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = temp.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let short_glb: Vec<u8> = b"glTF".iter().copied().chain([2, 0, 0, 0, 3, 0, 0, 0]).collect();
    let cases = [
        (temp.path().to_owned(), "folder"),
        (temp.path().join("missing.gltf"), "no such file"),
        (write("empty.gltf", b""), "empty"),
        (write("text.gltf", b"hello"), "not a glTF 2.0 file"),
        (write("short.glb", &short_glb), "GLB header"),
        (write("old.gltf", br#"{"asset":{"version":"1.0"}}"#), "version 1.0"),
        (write("escape.gltf", br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"../secret.bin","byteLength":1}]}"#), "buffers[0]"),
        (write("absolute.gltf", br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"/etc/passwd","byteLength":1}]}"#), "buffers[0]"),
        (write("web.gltf", br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"http://a/b","byteLength":1}]}"#), "buffers[0]"),
        (
            write("cycle.gltf", br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}]}"#),
            "nodes[0].children: node 0 is its own ancestor",
        ),
        (write("wants.gltf", br#"{"asset":{"version":"2.0"},"extensionsRequired":["EXT_nobody_knows"]}"#), "EXT_nobody_knows"),
        (
            write("index.gltf", br#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":7}}]}]}"#),
            "meshes[0].primitives[0].attributes.POSITION",
        ),
    ];
    for (path, expected) in cases {
        let text = load_plain(&path).expect_err(expected).to_string();
        println!("{text}");
        assert!(
            text.contains(expected) && text.contains(&path.display().to_string()) && !text.contains('\n'),
            "{text}"
        );
    }
    let text = open("galery", &LoadOptions::default()).unwrap_err().to_string();
    assert!(text.contains("galery") && text.contains("gallery"), "{text}");
}

#[test]
fn an_unknown_optional_extension_is_noted_once() {
    let temp = tempfile::tempdir().unwrap();
    let path = temp.path().join("uses.gltf");
    std::fs::write(&path, r#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_nobody_knows"]}"#).unwrap();
    let notices = load_plain(&path).unwrap().notices;
    assert_eq!(notices.iter().filter(|n| n.contains("EXT_nobody_knows")).count(), 1);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn sparse_values_replace_their_vertices() {
    let folder = shared("scenes");
    let scene = load_plain(folder.join("SimpleSparseAccessor/SimpleSparseAccessor.gltf")).unwrap();
    // By the file's documentation vertices 8, 10 and 12 are moved.
    let p = &scene.meshes[0].positions;
    assert!(
        p.contains(&Vec3::new(1.0, 2.0, 0.0))
            && p.contains(&Vec3::new(3.0, 3.0, 0.0))
            && p.contains(&Vec3::new(5.0, 4.0, 0.0))
    );
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn computed_tangents_agree_with_those_of_a_file() {
    let folder = shared("scenes");
    let file = folder.join("NormalTangentMirrorTest");
    let with = load_plain(file.join("NormalTangentMirrorTest.gltf")).unwrap();
    // The same scene with the TANGENT attributes taken out.
    let temp = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&file).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), temp.path().join(entry.file_name())).unwrap();
    }
    let text = std::fs::read_to_string(file.join("NormalTangentMirrorTest.gltf")).unwrap();
    assert!(text.contains("\"TANGENT\""));
    let stripped = temp.path().join("stripped.gltf");
    std::fs::write(&stripped, text.replace("\"TANGENT\"", "\"_TANGENT\"")).unwrap();
    let without = load_plain(&stripped).unwrap();
    let (mut agree, mut total) = (0, 0);
    for (a, b) in with.meshes[0].tangents.iter().zip(&without.meshes[0].tangents) {
        total += 1;
        agree += usize::from(a.truncate().dot(b.truncate()) > 0.9 && a.w == b.w);
    }
    println!("{agree} of {total} tangents agree");
    assert!(agree as f32 > 0.9 * total as f32);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn automatic_cameras_stand_inside_rooms_and_outside_objects() {
    let folder = shared("scenes");
    let camera = |file: &str| {
        let scene = load_plain(folder.join(file)).unwrap();
        let bounds = scene.bounds().unwrap();
        let camera = scene.default_camera();
        (camera.position(), camera.forward(), bounds)
    };
    let (eye, forward, b) = camera("Sponza/Sponza.gltf");
    assert!(eye.cmpgt(b.min).all() && eye.cmplt(b.max).all(), "Sponza is seen from within: {eye}");
    assert!(forward.y.abs() < 0.1 && forward.x.abs() > 0.99, "along the longest axis: {forward}");
    assert!((eye.x - b.center().x).abs() > 0.2 * b.size().x, "from near one end: {eye}");
    for file in [
        "DamagedHelmet/DamagedHelmet.gltf",
        "Fox/Fox.glb",
        "EmissiveStrengthTest/EmissiveStrengthTest.gltf",
        "AttenuationTest/AttenuationTest.gltf",
    ] {
        let (eye, forward, b) = camera(file);
        let radius = 0.5 * b.size().length();
        assert!(eye.distance(b.center()) > radius, "{file} is seen from outside: {eye}");
        assert!(forward.dot((b.center() - eye).normalize()) > 0.999);
    }
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn lights_and_cameras_come_from_their_nodes() {
    let folder = shared("scenes");
    let scene = load_plain(folder.join("LightsPunctualLamp/LightsPunctualLamp.gltf")).unwrap();
    assert!(!scene.lights.is_empty());
    assert!(scene.lights.iter().any(|l| matches!(l.kind, LightKind::Spot { .. } | LightKind::Point)));
    let scene = load_plain(folder.join("Cameras/Cameras.gltf")).unwrap();
    assert_eq!(scene.cameras.len(), 2);
    assert!(scene.cameras[0].position().abs_diff_eq(Vec3::new(0.5, 0.5, 3.0), 1e-6));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_texture_transform_scales_turns_and_moves_in_this_order() {
    let folder = shared("scenes");
    let scene = load_plain(folder.join("TextureTransformTest/TextureTransformTest.gltf")).unwrap();
    let all = scene.materials.iter().find(|m| m.name == "All").unwrap().base_color_texture.unwrap();
    let (s, c) = 0.3f32.sin_cos();
    let expected = Vec2::new(1.5 * (c * 0.5 + s * 1.0) - 0.2, 1.5 * (-s * 0.5 + c * 1.0) - 0.1);
    assert!(all.transform.transform_point2(Vec2::new(0.5, 1.0)).abs_diff_eq(expected, 1e-5));
}

/// The sky takes the place of the environment, its sun stands beside the scene's own lights, and both turn and shine together.
#[test]
fn a_sky_comes_with_its_sun() {
    let sky: PhysicalSky = "30,70".parse().unwrap();
    let options = LoadOptions { sky: Some(sky), ..LoadOptions::default() };
    let scene = open("plane", &options).unwrap();
    assert_eq!((&scene.environment, &scene.lights[1..]), (&sky.environment(), &[sky.sun()][..]));
    assert_eq!(scene.notices, [""; 0]);

    let turned =
        LoadOptions { environment_rotation: 20_f32.to_radians(), environment_intensity: 0.5, ..options };
    let scene = open("plane", &turned).unwrap();
    let sun = scene.lights.last().unwrap();
    let other: PhysicalSky = "30,90".parse().unwrap();
    assert!(sun.direction.distance(-other.towards_sun()) < 1e-6);
    assert_eq!(sun.intensity, 0.5 * sky.sun_illuminance());
    // The glow of the image is where the light is.
    let [towards, away] = [-sun.direction, sun.direction * Vec3::new(1.0, -1.0, 1.0)];
    assert!((scene.environment.radiance(towards) - 0.5 * sky.radiance(sky.towards_sun())).length() < 100.0);
    assert!(scene.environment.radiance(towards).y > 2.0 * scene.environment.radiance(away).y);

    let notices = open("kinds", &turned).unwrap().notices;
    assert!(
        notices.contains(&"directional lights of the scene itself beside the sun of the sky: 1".into()),
        "{notices:?}"
    );
}
