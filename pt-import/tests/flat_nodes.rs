//! Nodes that flatten what they carry, and scenes whose light is lost.

use crate::common::gltf::{Glb, plain};
use pt_import::LoadOptions;
use pt_scene::glam::{Affine3A, Vec3, Vec3A};
use pt_scene::{Scene, is_invertible};
use serde_json::{Value, json};

/// A lamp that faces +Z, on a node with this transform below a node with that one.
fn lamp(transform: Value, parent: Value) -> Glb {
    let mut glb = Glb::new();
    glb.json["materials"] = json!([{"name": "glow", "emissiveFactor": [1, 1, 1]}]);
    let positions = glb.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
    let normals = glb.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "VEC3");
    let node = glb.show(json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "material": 0}));
    for (key, value) in transform.as_object().unwrap() {
        glb.json["nodes"][node][key] = value.clone();
    }
    let mut parent = parent;
    parent["children"] = json!([node]);
    let parent = glb.push("nodes", parent);
    glb.json["scenes"][0]["nodes"] = json!([parent]);
    glb
}

/// The corners of the lamp and the side that it shines to, which an instance that mirrors keeps.
fn placed(scene: &Scene) -> ([Vec3; 3], Vec3) {
    let instance = &scene.instances[0];
    let mesh = &scene.meshes[instance.mesh as usize];
    let world: Affine3A = instance.world_from_object;
    assert!(is_invertible(&world));
    let corners = mesh.indices[0].map(|v| world.transform_point3(mesh.positions[v as usize]));
    let normal = world.matrix3.inverse().transpose() * Vec3A::from(mesh.normals[0]);
    (corners, normal.normalize().into())
}

#[test]
fn a_flattened_lamp_keeps_its_shape_and_its_side() {
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    let cases = [
        (json!({"scale": [1, 1, 0]}), json!({}), Vec3::Z),
        (json!({"scale": [-1, 1, 0]}), json!({}), Vec3::Z),
        (json!({"scale": [1, 1, 0]}), json!({"scale": [-1, 1, 1]}), Vec3::Z),
        (json!({}), json!({"scale": [2, 2, 0]}), Vec3::Z),
        (json!({"rotation": [0.0, quarter, 0.0, quarter]}), json!({"scale": [0, 1, 1]}), Vec3::X),
        (json!({"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]}), json!({}), Vec3::Z),
    ];
    for (transform, parent, side) in cases {
        let scene = lamp(transform.clone(), parent.clone()).load_clean();
        let (corners, normal) = placed(&scene);
        assert!(normal.abs_diff_eq(side, 1e-4), "{transform} in {parent}: {normal}");
        // As with a factor of 1 along the axis that vanishes: the lamp lies in the plane anyhow.
        let with_one = |mut value: Value| {
            if let Some(scale) = value.get_mut("scale") {
                scale
                    .as_array_mut()
                    .unwrap()
                    .iter_mut()
                    .filter(|s| **s == json!(0))
                    .for_each(|s| *s = json!(1));
            }
            if let Some(matrix) = value.get_mut("matrix") {
                matrix[10] = json!(1);
            }
            value
        };
        let (expected, _) = placed(&lamp(with_one(transform.clone()), with_one(parent.clone())).load_clean());
        for (corner, expected) in corners.iter().zip(expected) {
            assert!(
                corner.abs_diff_eq(expected, 1e-5),
                "{transform} in {parent}: {corner} is not {expected}"
            );
        }
    }
}

#[test]
fn flattened_copies_keep_their_side() {
    let mut glb = lamp(json!({}), json!({"scale": [-1, 1, 1]}));
    let scales = glb.floats(&[1.0, 1.0, 0.0], "VEC3");
    let extension = json!({"EXT_mesh_gpu_instancing": {"attributes": {"SCALE": scales}}});
    glb.json["nodes"][0]["extensions"] = extension;
    glb.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let (corners, normal) = placed(&glb.load_clean());
    assert!(normal.abs_diff_eq(Vec3::Z, 1e-4), "{normal}");
    assert!(corners[1].abs_diff_eq(Vec3::NEG_X, 1e-5), "{corners:?}");
}

#[test]
fn what_is_scaled_to_a_line_is_left_out_and_missed() {
    for scale in [json!([1, 0, 0]), json!([0, 0, 0])] {
        let glb = lamp(json!({"scale": scale}), json!({}));
        let scene = glb.load_with(&LoadOptions::default()).unwrap();
        assert!(scene.instances.is_empty());
        let has = |text: &str| scene.notices.iter().any(|n| n.contains(text));
        assert!(has("nodes[0]: left out, its scale is zero along two axes"), "{:?}", scene.notices);
        let sky =
            "no triangle with the emissive material glow is left in the scene: default sky and sun added";
        assert!(has(sky), "{:?}", scene.notices);
        assert!(!glb.load_with(&plain()).unwrap().notices.iter().any(|n| n.contains("default sky")));
    }
    // A lamp that no visible node carries is missed too.
    let mut glb = lamp(json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}), json!({}));
    glb.json["materials"] = json!([{}]);
    glb.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_node_visibility"]);
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    assert_eq!(glb.load_clean().lights.len(), 1);
    glb.json["nodes"][0]["extensions"]["KHR_node_visibility"] = json!({"visible": false});
    let notices = glb.load_with(&LoadOptions::default()).unwrap().notices;
    let lost = "extensions.KHR_lights_punctual.lights: no light is placed in the scene";
    assert!(notices.iter().any(|n| n == lost), "{notices:?}");
    // A scene that never had a light says so.
    let mut glb = lamp(json!({}), json!({}));
    glb.json["materials"] = json!([{}]);
    let notices = glb.load_with(&LoadOptions::default()).unwrap().notices;
    assert_eq!(notices, ["no lights in the scene: default sky and sun added"]);
}
