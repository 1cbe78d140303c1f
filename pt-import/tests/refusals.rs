//! What a file may not say: refused in one line that names the file and the JSON path. And what it may, however odd.

use crate::common::gltf::{F32, Glb, bytes};
use pt_import::LoadOptions;
use pt_scene::automatic_camera;
use pt_scene::glam::Vec3;
use serde_json::{Value, json};

/// A triangle on node 0, of material 0.
fn triangle(positions: &[f32]) -> Glb {
    let mut glb = Glb::new();
    glb.json["materials"] = json!([{}]);
    let positions = glb.floats(positions, "VEC3");
    glb.show(json!({"attributes": {"POSITION": positions}, "material": 0}));
    glb
}

const UNIT: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

#[test]
fn material_values_out_of_range_are_refused_by_path() {
    let extension =
        |name: &str, value: Value| json!({"extensions": {format!("KHR_materials_{name}"): value}});
    let pbr = |value: Value| json!({"pbrMetallicRoughness": value});
    let cases = [
        (pbr(json!({"metallicFactor": 1.5})), "metallic 1.5 is not in 0..1"),
        (pbr(json!({"roughnessFactor": -0.5})), "roughness -0.5 is not in 0..1"),
        (pbr(json!({"baseColorFactor": [1, -1, 0, 1]})), "base colour -1 is less than 0"),
        (pbr(json!({"baseColorFactor": [1, 0, 1e39, 1]})), "base colour inf is less than 0 or not finite"),
        (json!({"emissiveFactor": [0, 0, -2]}), "emission -2 is less than 0"),
        (json!({"alphaMode": "MASK", "alphaCutoff": -1}), "alpha cutoff -1"),
        (extension("emissive_strength", json!({"emissiveStrength": 1e39})), "emission"),
        (extension("ior", json!({"ior": 0.5})), "index of refraction 0.5 is less than 1"),
        (extension("transmission", json!({"transmissionFactor": 2})), "transmission 2"),
        (extension("volume", json!({"thicknessFactor": -1})), "thickness -1"),
        (extension("volume", json!({"attenuationDistance": 0})), "attenuation distance 0 is not positive"),
        (extension("specular", json!({"specularColorFactor": [-1, 0, 0]})), "specular colour -1"),
        (extension("clearcoat", json!({"clearcoatFactor": 7})), "clearcoat 7"),
        (extension("sheen", json!({"sheenColorFactor": [0, 3, 0]})), "sheen colour 3 is not in 0..1"),
        (extension("anisotropy", json!({"anisotropyStrength": -3})), "anisotropy strength -3"),
        (extension("iridescence", json!({"iridescenceIor": 0.9})), "iridescence index of refraction 0.9"),
        (extension("dispersion", json!({"dispersion": -1})), "dispersion -1"),
    ];
    for (material, what) in cases {
        let mut glb = triangle(&UNIT);
        // Neither a name nor a twin before it hides the place.
        glb.json["materials"] = json!([{"name": "first"}, {"name": "second"}]);
        for (key, value) in material.as_object().unwrap() {
            glb.json["materials"][1][key] = value.clone();
        }
        let text = glb.refusal();
        assert!(text.contains("materials[1]") && text.contains(what), "{text} should contain {what}");
    }
}

#[test]
fn positions_that_are_not_finite_or_too_far_are_refused_by_path() {
    for (bad, what) in [
        (f32::NAN, "vertex 2 is not finite"),
        (f32::INFINITY, "vertex 2 is not finite"),
        (1.1e12, "vertex 2 is farther out than 1e12"),
        (-3e38, "vertex 2 is farther out than 1e12"),
    ] {
        let mut positions = UNIT;
        positions[7] = bad;
        let text = triangle(&positions).refusal();
        assert!(
            text.contains("meshes[0].primitives[0].attributes.POSITION: ") && text.contains(what),
            "{text}"
        );
    }
    // At the limit all is well, and the automatic camera still sees it.
    let scene = triangle(&UNIT.map(|x| 0.9e12 * x)).load_clean();
    let camera = automatic_camera(&scene);
    assert!(camera.position().is_finite() && camera.forward().is_normalized(), "{camera:?}");
}

#[test]
fn nodes_that_carry_geometry_too_far_are_refused_by_path() {
    for transform in [
        json!({"translation": [0, 2e12, 0]}),
        json!({"scale": [3e12, 3e12, 3e12]}),
        json!({"matrix": [1e13, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}),
    ] {
        let mut glb = triangle(&UNIT);
        for (key, value) in transform.as_object().unwrap() {
            glb.json["nodes"][0][key] = value.clone();
        }
        glb.json["nodes"][0]["name"] = "far away".into();
        let text = glb.refusal();
        assert!(text.contains("nodes[0]: it reaches farther out than 1e12 m"), "{text}");
    }
    let mut glb = triangle(&UNIT);
    glb.json["nodes"][0]["translation"] = json!([1e39, 0, 0]);
    assert!(glb.refusal().contains("nodes[0]: the transform is not finite"));
}

#[test]
fn a_morph_target_that_leads_too_far_is_refused_by_path() {
    let mut glb = triangle(&UNIT);
    let far = glb.floats(&[0.0, 0.0, 0.0, 3e38, 0.0, 0.0, 0.0, 0.0, 0.0], "VEC3");
    glb.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": far}]);
    glb.json["meshes"][0]["weights"] = json!([4.0]);
    // The copy in this pose has a vertex at infinity.
    let text = glb.refusal();
    assert!(text.contains("meshes[0]: vertex 1 is not finite"), "{text}");
    glb.json["meshes"][0]["weights"] = json!([0.5]);
    let text = glb.refusal();
    assert!(text.contains("nodes[0]: it reaches farther out"), "{text}");
}

#[test]
fn a_texture_without_image_is_left_out_with_a_notice() {
    let mut glb = triangle(&UNIT);
    glb.json["textures"] = json!([{}]);
    glb.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    let scene = glb.load().unwrap();
    assert!(scene.textures.is_empty() && scene.materials[0].base_color_texture.is_none());
    let notices: Vec<_> = scene.notices.iter().filter(|n| n.contains("textures[0]: has no image")).collect();
    assert_eq!(notices.len(), 1, "{:?}", scene.notices);
    // An image that is named and not there is another matter.
    glb.json["textures"] = json!([{"source": 3}]);
    let text = glb.refusal();
    assert!(text.contains("textures[0].source: index 3 does not exist"), "{text}");
}

/// Triangles that a tree cannot tell apart, or that have no area.
fn degenerate(count: usize, corner: impl Fn(usize, usize) -> Vec3) -> Glb {
    let mut glb = Glb::new();
    let positions: Vec<f32> =
        (0..count).flat_map(|t| (0..3).flat_map(|c| corner(t, c).to_array()).collect::<Vec<_>>()).collect();
    let positions = glb.accessor(&bytes(&positions, f32::to_le_bytes), F32, "VEC3", 3 * count);
    glb.show(json!({"attributes": {"POSITION": positions}}));
    glb
}

#[test]
fn degenerate_geometry_is_framed_and_traced() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let closer = |t: usize| 2f32.powf(t as f32 * 0.006 - 90.0);
    for glb in [
        degenerate(20_000, |_, _| Vec3::ZERO),
        degenerate(20_000, |_, c| corners[c]),
        degenerate(20_000, |t, _| Vec3::X * t as f32),
        degenerate(20_000, |t, c| closer(t) * corners[c]),
    ] {
        let scene = glb.load_with(&LoadOptions::default()).unwrap();
        let camera = automatic_camera(&scene);
        assert!(camera.position().is_finite() && camera.forward().is_normalized(), "{camera:?}");
    }
}

#[test]
fn instances_at_one_place_are_framed_and_traced() {
    let mut glb = triangle(&UNIT);
    let node = glb.json["nodes"][0].clone();
    glb.json["nodes"] = vec![node; 20_000].into();
    glb.json["scenes"][0]["nodes"] = (0..20_000).collect::<Vec<_>>().into();
    let scene = glb.load_with(&LoadOptions::default()).unwrap();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 20_000));
    // The triangle is seen from outside, around its bounding sphere.
    let camera = automatic_camera(&scene);
    assert!((2.0..3.0).contains(&camera.position().distance(Vec3::new(0.5, 0.5, 0.0))), "{camera:?}");
}

#[test]
fn ten_thousand_levels_of_nodes_load() {
    let mut glb = triangle(&UNIT);
    let mesh = glb.json["nodes"][0]["mesh"].clone();
    let deep = |i: usize| json!({"children": [i + 1], "translation": [0.001, 0, 0]});
    let mut nodes: Vec<Value> = (0..10_000).map(deep).collect();
    nodes.push(json!({"mesh": mesh}));
    glb.json["nodes"] = nodes.into();
    let scene = glb.load_clean();
    assert!((scene.instances[0].world_from_object.translation.x - 10.0).abs() < 1e-2);
    // The last one closes a circle.
    glb.json["nodes"][10_000]["children"] = json!([0]);
    assert!(glb.refusal().contains("is its own ancestor"), "{}", glb.refusal());
}
