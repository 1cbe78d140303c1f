//! Files that are old, or that other programs wrote in their own way: they load, or are refused by what they are.

use std::path::Path;

use crate::common::gltf::{Glb, plain};
use pt_import::{LoadOptions, load, load_bytes};
use pt_scene::glam::Vec3;
use pt_scene::{AnimationChoice, Scene, SceneError};
use serde_json::json;

const UNIT: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

fn triangle() -> Glb {
    let mut glb = Glb::new();
    let positions = glb.floats(&UNIT, "VEC3");
    glb.show(json!({"attributes": {"POSITION": positions}}));
    glb
}

/// Writes a `.gltf` whose buffer is a triangle at this URI; the caller puts the file there.
fn gltf(folder: &Path, uri: &str) -> std::path::PathBuf {
    let file = folder.join("scene.gltf");
    let json = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": uri, "byteLength": 36}]
    });
    std::fs::write(&file, json.to_string()).unwrap();
    file
}

fn buffer() -> Vec<u8> {
    UNIT.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn load_with(file: &Path, allow_outside: bool) -> Result<Scene, SceneError> {
    load(file, &LoadOptions { allow_outside, ..plain() })
}

#[test]
fn version_1_is_named_in_all_its_forms() {
    let binary = [b"glTF".as_slice(), &[1, 0, 0, 0, 20, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]].concat();
    let files: [Vec<u8>; 4] = [
        // Objects where glTF 2.0 has arrays.
        br#"{"asset": {"version": "1.0"}, "scene": "s", "scenes": {"s": {"nodes": []}}, "meshes": {}}"#
            .to_vec(),
        // A number for the version, or none at all, as early programs wrote it.
        br#"{"asset": {"version": 1}, "nodes": {"n": {}}}"#.to_vec(),
        br#"{"scenes": {"s": {"nodes": ["n"]}}, "nodes": {"n": {}}}"#.to_vec(),
        binary,
    ];
    for bytes in files {
        let text = load_bytes(bytes, "old.gltf", &plain()).unwrap_err().to_string();
        assert!(text.starts_with("old.gltf: ") && text.contains("is a glTF 1"), "{text}");
        assert!(text.contains("only glTF 2.0 can be read") && text.contains("gltf-pipeline"), "{text}");
    }
    // A broken file of version 2.0 keeps its own message.
    let text = load_bytes(br#"{"asset": {"version": "2.0"}, "nodes": {}}"#.to_vec(), "new.gltf", &plain());
    let text = text.unwrap_err().to_string();
    assert!(text.contains("new.gltf: nodes: ") && !text.contains("1.0"), "{text}");
}

#[test]
fn json_padded_with_zero_bytes_loads() {
    let good = triangle().file();
    let length = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    // Four more bytes of padding: the chunk and the file grow by them.
    let mut padded = [&good[..20 + length], &[0; 4], &good[20 + length..]].concat();
    padded[8..12].copy_from_slice(&(good.len() as u32 + 4).to_le_bytes());
    padded[12..16].copy_from_slice(&(length as u32 + 4).to_le_bytes());
    let scene = load_bytes(padded, "padded.glb", &plain()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.statistics().triangles, 1);
    assert!(scene.notices.iter().any(|n| n.contains("padded with zero bytes")), "{:?}", scene.notices);
    let text = [br#"{"asset": {"version": "2.0"}}"#.as_slice(), &[0, 0]].concat();
    load_bytes(text, "padded.gltf", &plain()).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn a_percent_sign_may_stand_for_itself() {
    let temp = tempfile::tempdir().unwrap();
    for (uri, name) in [
        ("ten 10%.bin", "ten 10%.bin"),
        ("100%25.bin", "100%.bin"),
        ("a%20b.bin", "a b.bin"),
        // The name that the URI stands for is not there, the raw one is.
        ("c%20d.bin", "c%20d.bin"),
        ("%ff.bin", "%ff.bin"),
    ] {
        std::fs::write(temp.path().join(name), buffer()).unwrap();
        let scene = load_with(&gltf(temp.path(), uri), false).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.statistics().triangles, 1, "{uri}");
        std::fs::remove_file(temp.path().join(name)).unwrap();
        let text = load_with(&gltf(temp.path(), uri), false).unwrap_err().to_string();
        assert!(text.contains("buffers[0].uri") && text.contains("no such file"), "{text}");
    }
    // Where both are there, the one that the URI stands for is read.
    std::fs::write(temp.path().join("e%20f.bin"), b"short").unwrap();
    std::fs::write(temp.path().join("e f.bin"), buffer()).unwrap();
    load_with(&gltf(temp.path(), "e%20f.bin"), false).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn files_elsewhere_are_read_on_request_only() {
    let temp = tempfile::tempdir().unwrap();
    let (sub, other) = (temp.path().join("sub"), temp.path().join("other"));
    std::fs::create_dir(&sub).unwrap();
    std::fs::create_dir(&other).unwrap();
    let target = other.join("data.bin");
    std::fs::write(&target, buffer()).unwrap();
    let mut uris = vec!["../other/data.bin".to_owned(), target.display().to_string()];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&target, sub.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(&other, sub.join("folder")).unwrap();
        uris.extend(["link.bin", "folder/data.bin"].map(str::to_owned));
    }
    for uri in uris {
        let file = gltf(&sub, &uri);
        let text = load_with(&file, false).unwrap_err().to_string();
        assert!(text.contains("buffers[0].uri") && text.contains("--allow-outside"), "{text}");
        let scene = load_with(&file, true).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.statistics().triangles, 1, "{uri}");
    }
    // A way out and back again does not leave the folder.
    std::fs::write(sub.join("data.bin"), buffer()).unwrap();
    std::fs::create_dir(sub.join("deep")).unwrap();
    load_with(&gltf(&sub, "deep/../data.bin"), false).unwrap_or_else(|e| panic!("{e}"));
    // The option is for files, not for other machines, and it does not make files appear.
    let text = load_with(&gltf(&sub, "http://a/b.bin"), true).unwrap_err().to_string();
    assert!(text.contains("names a scheme"), "{text}");
    let text = load_with(&gltf(&sub, "../none.bin"), true).unwrap_err().to_string();
    assert!(text.contains("../none.bin: no such file"), "{text}");
}

/// A triangle that slides along +X from `values[0]` to `values[1]` between two keys.
fn sliding(times: [f32; 2], values: [f32; 2]) -> Glb {
    let mut glb = triangle();
    let input = glb.floats(&times, "SCALAR");
    let output = glb.floats(&[values[0], 0.0, 0.0, values[1], 0.0, 0.0], "VEC3");
    glb.json["animations"] = json!([{
        "samplers": [{"input": input, "output": output}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]
    }]);
    glb
}

#[test]
fn keys_before_time_0_are_harmless() {
    let place = |glb: &Glb, time: f64, animation: AnimationChoice| {
        let options = LoadOptions { time, animation, ..plain() };
        let scene = glb.load_with(&options).unwrap_or_else(|e| panic!("{e}"));
        let notice = "animations[0].samplers[0].input: has keys before time 0; the animation begins at 0";
        assert_eq!(scene.notices, [notice]);
        Vec3::from(scene.instances[0].world_from_object.translation).x
    };
    let glb = sliding([-1.0, 1.0], [2.0, 6.0]);
    let played = |time: f64| place(&glb, time, AnimationChoice::Compatible);
    // Half way at 0, at the last key just before 1 s, where it starts again.
    assert_eq!((played(0.0), played(0.5), played(1.25)), (4.0, 5.0, 4.5));
    assert_eq!(place(&glb, 0.5, AnimationChoice::None), 0.0);
    // All keys before 0: the last pose, for ever.
    let past = sliding([-2.0, -1.0], [2.0, 6.0]);
    assert_eq!(place(&past, 0.0, AnimationChoice::Compatible), 6.0);
    assert_eq!(place(&past, 7.5, AnimationChoice::Compatible), 6.0);
    let text = sliding([1.0, 0.0], [2.0, 6.0]).refusal();
    assert!(text.contains("animations[0].samplers[0]") && text.contains("rise"), "{text}");
}
