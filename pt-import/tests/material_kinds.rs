//! Kinds of materials that a file asks for in the `extras` of its materials.

use crate::common::gltf::Glb;
use pt_image::image_file::{PixelLayout, write_png};
use pt_scene::{Material, MaterialKind, Shows, TextureUsage};
use serde_json::{Value, json};

/// A triangle whose material, the second one, has these extras; a camera of the name "door", index 1 in the file.
fn scene(extras: Value) -> Glb {
    let mut glb = Glb::new();
    let positions = glb.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
    glb.json["materials"] = json!([{}, {"name": "wall", "extras": extras}]);
    glb.show(json!({"attributes": {"POSITION": positions}, "material": 1}));
    let lens = json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}});
    glb.json["cameras"] = json!([lens, lens]);
    for (camera, name) in [(1, "door"), (0, "hall")] {
        let node = glb.push("nodes", json!({"camera": camera, "name": name}));
        glb.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(node.into());
    }
    glb
}

fn material(extras: Value) -> Material {
    scene(extras).load_clean().materials[1].clone()
}

#[test]
fn every_kind_can_be_forced() {
    let plain = Material { name: "wall".into(), ..Material::default() };
    for kind in MaterialKind::ALL.into_iter().filter(|kind| *kind != MaterialKind::Camera) {
        let expected = plain.clone().with_kind(kind);
        assert_eq!(material(json!({"pt_kind": kind.name()})), expected, "{}", kind.name());
    }
    assert_eq!(material(json!({"other": 1})), plain);
    assert_eq!(material(json!("a remark")), plain);
}

#[test]
fn a_camera_is_found_by_name_or_by_its_index_in_the_file() {
    // The importer sorts cameras by their index.
    for (wanted, place) in [(json!("door"), 1), (json!("hall"), 0), (json!(1), 1), (json!(0), 0)] {
        let shows = material(json!({"pt_kind": "camera", "pt_camera": wanted})).shows;
        assert_eq!(shows, Shows::Camera(place), "{wanted}");
    }
}

#[test]
fn waves_are_set_beside_the_kind() {
    let waves =
        material(json!({"pt_kind": "water", "pt_wave_slope": 0.25, "pt_wave_length": 2})).waves.unwrap();
    assert_eq!((waves.slope, waves.length), (0.25, 2.0));
    let flat = material(json!({"pt_kind": "slime", "pt_wave_slope": 0})).waves.unwrap();
    assert_eq!(flat.slope, 0.0);
}

#[test]
fn what_cannot_be_is_refused_in_one_line_that_names_the_place() {
    let cases = [
        (json!({"pt_kind": "watr"}), ".pt_kind: unknown name \"watr\"", "closest: \"water\""),
        (json!({"pt_kind": "Transparent-Wal"}), ".pt_kind: ", "closest: \"transparent-wall\""),
        (json!({"pt_kind": 3}), ".pt_kind: ", "expected the name of a kind"),
        (json!({"pt_kind": "camera"}), ".pt_camera: ", "needs the camera"),
        (json!({"pt_kind": "camera", "pt_camera": 7}), ".pt_camera: ", "no camera 7; it has 2"),
        (json!({"pt_kind": "camera", "pt_camera": "dor"}), ".pt_camera: ", "closest: \"door\""),
        (json!({"pt_kind": "camera", "pt_camera": [1]}), ".pt_camera: ", "expected the name of a camera"),
        (json!({"pt_kind": "water", "pt_wave_slope": 1e39}), "slope of the waves inf", "is not in 0..1"),
        (json!({"pt_kind": "water", "pt_wave_slope": -0.1}), "slope of the waves -0.1", "is not in 0..1"),
        (
            json!({"pt_kind": "water", "pt_wave_length": 0}),
            "length of the waves 0",
            "is not in 0.001..1000000",
        ),
        (json!({"pt_kind": "water", "pt_wave_length": "NaN"}), ".pt_wave_length: ", "expected a number"),
    ];
    for (extras, place, what) in cases {
        let text = scene(extras.clone()).refusal();
        let is_one_line = !text.contains('\n') && text.contains("materials[1]");
        assert!(is_one_line && text.contains(place) && text.contains(what), "{extras}: {text}");
    }
}

/// Mips of colours whose alpha is coverage are made in another way.
#[test]
fn the_kind_decides_on_the_use_of_the_texture() {
    for (kind, usage) in [("regular", TextureUsage::Color), ("transparent-model", TextureUsage::Cutout)] {
        let mut glb = scene(json!({"pt_kind": kind}));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("white.png");
        write_png(&file, 1, 1, PixelLayout::Rgb, &[255; 3]).unwrap();
        let png = std::fs::read(file).unwrap();
        let view = glb.view(&png, None);
        glb.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
        glb.json["textures"] = json!([{"source": 0}]);
        glb.json["materials"][1]["pbrMetallicRoughness"] = json!({"baseColorTexture": {"index": 0}});
        assert_eq!(glb.load().unwrap().textures[0].usage, usage, "{kind}");
    }
}
