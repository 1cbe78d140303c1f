//! Nodes, scenes, cameras, instances, variants and URIs of glTF files.

use crate::common;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::gltf::{Glb, I8, U8, bytes, plain, shared_scene};
use pt_import::{EXTENSIONS, LoadOptions, load, load_bytes, open, support};
use pt_scene::glam::{Affine3A, Quat, Vec3};
use pt_scene::{Projection, Scene, SceneError, Support};
use pt_test_data::shared;
use serde_json::json;

const TRIANGLE: [f32; 9] = [0., 0., 0., 1., 0., 0., 0., 1., 0.];

pub fn triangle() -> Glb {
    let mut glb = Glb::new();
    let position = glb.floats(&TRIANGLE, "VEC3");
    glb.show(json!({"attributes": {"POSITION": position}}));
    glb
}

#[test]
fn transforms_multiply_down_the_tree_with_mirrors_and_uneven_scales() {
    let mut glb = triangle();
    let turn = Quat::from_rotation_y(0.5);
    glb.json["nodes"][0] = json!({"mesh": 0, "scale": [-1, 2, 0.5], "rotation": turn.to_array()});
    let matrix = [0., 2., 0., 0., -1., 0., 0., 0., 0., 0., 1., 0., 3., 4., 5., 1.];
    let parent = glb.push("nodes", json!({"children": [0], "matrix": matrix}));
    glb.json["scenes"][0]["nodes"] = json!([parent]);
    let scene = glb.load_clean();
    let p = Vec3::new(1.0, 1.0, 1.0);
    let local = turn * (p * Vec3::new(-1.0, 2.0, 0.5));
    let expected = Vec3::new(3.0 - local.y, 4.0 + 2.0 * local.x, 5.0 + local.z);
    assert!(scene.instances[0].world_from_object.transform_point3(p).abs_diff_eq(expected, 1e-5));
}

#[test]
fn a_chain_of_ten_thousand_nodes_loads() {
    let mut glb = triangle();
    for i in 0..10_000 {
        glb.push("nodes", json!({"children": [i], "translation": [0.5, 0, 0]}));
    }
    glb.json["scenes"][0]["nodes"] = json!([10_000]);
    let scene = glb.load_clean();
    assert_eq!(scene.instances[0].world_from_object.translation.x, 5000.0);
}

/// Found by fuzzing: names in the file are part of the places that messages tell.
#[test]
fn names_with_line_breaks_stay_in_one_line() {
    for text in [
        r#"{"asset":{"version":"2.0"},"extra\ns": [1,}"#,
        r#"{"asset":{"version":"2.0"},"extras": 1,"meshes":[{"primitives":[{"attributes":{"_A\nB":{}}}]}]}"#,
    ] {
        let error = load_bytes(text.into(), "test.gltf", &plain()).unwrap_err().to_string();
        assert!(error.starts_with("test.gltf: ") && !error.contains('\n'), "{error}");
    }
    let mut glb = triangle();
    glb.json["meshes"][0]["primitives"][0]["attributes"]["foo\nbar"] = json!(0);
    let notices = glb.load().unwrap().notices;
    assert!(
        notices.iter().any(|n| n.contains("foo bar")) && !notices.iter().any(|n| n.contains('\n')),
        "{notices:?}"
    );
}

#[test]
fn deep_json_is_refused_where_it_is_read_and_skipped_where_not() {
    let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":{deep}}}"#);
    let error = load_bytes(text.into_bytes(), "deep.gltf", &plain()).unwrap_err().to_string();
    assert!(error.starts_with("deep.gltf: nodes[0]") && !error.contains('\n'), "{error}");
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"unknown":{deep}}}"#);
    let error = load_bytes(text.into_bytes(), "deep.gltf", &plain()).unwrap_err().to_string();
    assert!(error.contains("recursion limit"), "{error}");
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"extras":{deep}}}"#);
    assert!(load_bytes(text.into_bytes(), "deep.gltf", &plain()).is_ok());
}

#[test]
fn cycles_are_refused_wherever_they_are() {
    let mut glb = triangle();
    // Not reached from the scene.
    glb.push("nodes", json!({"children": [2]}));
    glb.push("nodes", json!({"children": [1]}));
    assert!(glb.refusal().contains("nodes[1].children: node 1 is its own ancestor"));
    let mut glb = triangle();
    glb.push("nodes", json!({"children": [0]}));
    glb.push("nodes", json!({"children": [0]}));
    assert!(glb.refusal().contains("nodes[2].children[0]: node 0 is a child of node 1 too"));
}

#[test]
fn a_scene_is_chosen_by_name_or_index() {
    let mut glb = triangle();
    glb.push("nodes", json!({"mesh": 0, "translation": [7, 0, 0]}));
    glb.json["scenes"] =
        json!([{"nodes": [0], "name": "a"}, {"nodes": [1], "name": "b"}, {"nodes": [0, 1], "name": "b"}]);
    glb.json["scene"] = json!(1);
    let x = |scene: Option<&str>| -> Vec<f32> {
        let options = LoadOptions { scene: scene.map(Into::into), ..plain() };
        let scene = glb.load_with(&options).unwrap();
        assert_eq!(scene.scenes, ["a", "b", "b"]);
        assert!(scene.notices.iter().any(|n| n.contains("names are not unique")));
        scene.instances.iter().map(|i| i.world_from_object.translation.x).collect()
    };
    assert_eq!(x(None), [7.0]);
    assert_eq!(x(Some("a")), [0.0]);
    assert_eq!(x(Some("b")), [7.0]);
    assert_eq!(x(Some("2")), [0.0, 7.0]);
    let options = LoadOptions { scene: Some("c".into()), ..plain() };
    let text = glb.load_with(&options).unwrap_err().to_string();
    assert!(text.contains(r#"scenes: no scene "c"; there are 3"#), "{text}");
    let error = open("cornell", &LoadOptions { scene: Some("0".into()), ..plain() });
    assert!(matches!(error, Err(SceneError::Inconsistent { .. })));
}

#[test]
fn a_scene_may_have_no_nodes() {
    let mut glb = triangle();
    glb.json["scenes"] = json!([{"nodes": [0]}, {"name": "empty"}]);
    let scene = glb.load().unwrap();
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(scene.notices, ["scenes[0]: shown; the file has 1 more"]);
    let empty = glb.load_with(&LoadOptions { scene: Some("empty".into()), ..plain() }).unwrap();
    assert!(empty.instances.is_empty());
    // What is wrong elsewhere is still told, by its own place.
    glb.json["nodes"][0]["mesh"] = json!("first");
    assert!(glb.refusal().contains("nodes[0].mesh"), "{}", glb.refusal());
}

#[test]
fn variants_change_materials() {
    let mut glb = triangle();
    glb.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    glb.json["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "red"}, {"name": "blue"}, {"name": "plain"}]}});
    glb.json["materials"] = json!([{"name": "m0"}, {"name": "m1"}, {"name": "m2"}]);
    let primitive = &mut glb.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["extensions"] = json!({"KHR_materials_variants": {"mappings": [
        {"material": 1, "variants": [0]}, {"material": 2, "variants": [1, 5]}]}});
    let material = |variant: Option<&str>| {
        let scene = glb.load_with(&LoadOptions { variant: variant.map(Into::into), ..plain() }).unwrap();
        assert_eq!(scene.variants, ["red", "blue", "plain"]);
        scene.materials[scene.meshes[0].triangle_materials[0] as usize].name.clone()
    };
    assert_eq!(material(None), "m0");
    assert_eq!(material(Some("red")), "m1");
    assert_eq!(material(Some("1")), "m2");
    assert_eq!(material(Some("plain")), "m0");
    let text =
        glb.load_with(&LoadOptions { variant: Some("green".into()), ..plain() }).unwrap_err().to_string();
    assert!(text.contains("red, blue, plain"), "{text}");
}

#[test]
fn gpu_instances_are_placed_in_the_space_of_their_node() {
    let mut glb = triangle();
    glb.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let translation = glb.floats(&[1., 0., 0., 0., 2., 0.], "VEC3");
    let scale = glb.floats(&[1., 1., 1., 2., 2., -2.], "VEC3");
    // A quarter turn about z, as normalised bytes.
    let half = (127.0 * std::f32::consts::FRAC_1_SQRT_2).round() as i8 as u8;
    let view = glb.view(&[0, 0, 0, 127, 0, 0, half, half], None);
    let rotation =
        json!({"bufferView": view, "componentType": I8, "type": "VEC4", "count": 2, "normalized": true});
    let rotation = glb.push("accessors", rotation);
    let attributes = json!({"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale});
    glb.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    glb.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    let scene = glb.load_clean();
    assert_eq!(scene.meshes.len(), 1);
    let expected = [
        Affine3A::from_translation(Vec3::new(11.0, 0.0, 0.0)),
        Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, 2.0, -2.0),
            Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            Vec3::new(10.0, 2.0, 0.0),
        ),
    ];
    for (instance, expected) in scene.instances.iter().zip(expected) {
        assert!(instance.world_from_object.abs_diff_eq(expected, 1e-5), "{instance:?}");
    }
    assert_eq!(scene.instances.len(), 2);
    glb.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(0);
    assert!(glb.refusal().contains("nodes[0].extensions.EXT_mesh_gpu_instancing.attributes"));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn the_instancing_sample_has_its_instances() {
    let scene = shared_scene("SimpleInstancing/SimpleInstancing.gltf", &plain());
    assert_eq!((scene.instances.len(), scene.meshes.len()), (125, 1));
}

#[test]
fn cameras_keep_the_height_of_their_view() {
    let mut glb = triangle();
    glb.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 2.0, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 3.0, "ymag": 2.0, "znear": 0.1, "zfar": 10.0}}
    ]);
    glb.json["nodes"][0]["camera"] = json!(0);
    let other = glb.push("nodes", json!({"camera": 1, "name": "top", "translation": [0, 0, 5]}));
    glb.json["scenes"][0]["nodes"] = json!([0, other]);
    let scene = glb.load_clean();
    assert_eq!(scene.cameras[0].projection, Projection::Perspective { yfov: 0.7 });
    assert_eq!(scene.cameras[1].projection, Projection::Orthographic { ymag: 2.0 });
    assert_eq!(
        (scene.cameras[1].name.as_str(), scene.cameras[1].position()),
        ("top", Vec3::new(0.0, 0.0, 5.0))
    );
    glb.json["cameras"][0]["perspective"]["yfov"] = json!(4.0);
    assert!(glb.refusal().contains("cameras[0].perspective.yfov: 4 is not between 0 and pi"));
}

#[test]
fn a_camera_is_found_by_its_index_in_the_file() {
    let mut glb = triangle();
    let camera = |yfov: f32| json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": 0.1}});
    glb.json["cameras"] = json!([camera(0.25), camera(0.5), camera(0.75), camera(1.0)]);
    // The nodes carry 3, 1, 0 and 1 again; nothing carries 2.
    let mut nodes = vec![0];
    for (camera, name) in [(3, "d"), (1, "b"), (0, "a"), (1, "b too")] {
        nodes.push(glb.push("nodes", json!({"camera": camera, "name": name})));
    }
    glb.json["scenes"][0]["nodes"] = json!(nodes);
    let scene = glb.load_clean();
    let names: Vec<_> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "b too", "d"]);
    let found = |index: usize| {
        let camera = scene.camera(index)?;
        let Projection::Perspective { yfov } = camera.projection else { panic!("{camera:?}") };
        Some((camera.name.as_str(), yfov))
    };
    let expected = [Some(("a", 0.25)), Some(("b", 0.5)), None, Some(("d", 1.0)), None];
    assert_eq!([0, 1, 2, 3, 4].map(found), expected);
    // Of a scene made by code: its own list.
    let gallery = pt_scene::builtin("gallery").unwrap();
    assert_eq!(gallery.camera(1), gallery.cameras.get(1));
    assert!(gallery.camera(1).is_some());
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn the_cameras_sample_has_both_kinds() {
    let scene = shared_scene("Cameras/Cameras.gltf", &plain());
    assert!(matches!(scene.cameras[0].projection, Projection::Perspective { .. }));
    assert!(matches!(scene.cameras[1].projection, Projection::Orthographic { .. }));
}

#[test]
fn invisible_nodes_hide_what_is_below_them() {
    let mut glb = triangle();
    glb.json["extensionsUsed"] = json!(["KHR_node_visibility"]);
    let hidden = glb
        .push("nodes", json!({"children": [0], "extensions": {"KHR_node_visibility": {"visible": false}}}));
    let shown =
        glb.push("nodes", json!({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}}));
    glb.json["scenes"][0]["nodes"] = json!([hidden, shown]);
    assert_eq!(glb.load_clean().instances.len(), 1);
}

/// `extras.pt_portal` of a node: a rectangle in its XY plane, centred. What is none is left out with a notice; other extras are of no concern.
#[test]
fn portals_are_rectangles_of_nodes() {
    let mut glb = triangle();
    let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let window =
        json!({"translation": [1, 2, 3], "rotation": turn.to_array(), "extras": {"pt_portal": [2, 0.5]}});
    let mut nodes = vec![0, glb.push("nodes", window)];
    for extras in [json!({"portal": "other"}), json!([1, 2]), json!(null)] {
        nodes.push(glb.push("nodes", json!({"extras": extras})));
    }
    glb.json["scenes"][0]["nodes"] = json!(nodes);
    let scene = glb.load_clean();
    let [portal] = scene.portals[..] else { panic!("{:?}", scene.portals) };
    assert!(portal.corner.abs_diff_eq(Vec3::new(1.0, 1.75, 4.0), 1e-5), "{portal:?}");
    assert!(portal.edges[0].abs_diff_eq(Vec3::new(0.0, 0.0, -2.0), 1e-5), "{portal:?}");
    assert!(portal.edges[1].abs_diff_eq(Vec3::new(0.0, 0.5, 0.0), 1e-5), "{portal:?}");
    for bad in [json!("wide"), json!([1]), json!([0, 1]), json!([1e300, 1]), json!({"width": 1})] {
        let mut glb = triangle();
        glb.json["nodes"][0]["extras"] = json!({"pt_portal": bad});
        let scene = glb.load().unwrap();
        assert!(scene.portals.is_empty(), "{bad}");
        assert!(
            scene.notices.iter().any(|notice| notice.contains("extras.pt_portal")),
            "{:?}",
            scene.notices
        );
    }
    // More than samplers look at.
    let mut glb = triangle();
    let many =
        (0..40).map(|_| glb.push("nodes", json!({"extras": {"pt_portal": [1, 1]}}))).collect::<Vec<_>>();
    glb.json["scenes"][0]["nodes"] = json!(many);
    let scene = glb.load().unwrap();
    assert_eq!(scene.portals.len(), pt_scene::MAX_PORTALS);
    assert!(scene.notices.iter().any(|notice| notice.contains("at most 32")), "{:?}", scene.notices);
}

#[test]
fn every_extension_is_supported_ignored_or_refused() {
    for &(name, status) in EXTENSIONS {
        let mut glb = triangle();
        glb.json["extensionsUsed"] = json!([name]);
        let optional = glb.load().unwrap();
        let noticed = optional.notices.iter().filter(|n| n.contains(name)).count();
        assert_eq!(noticed, usize::from(status != Support::Supported), "{name}");
        let shown = if status == Support::Supported { Support::Supported } else { Support::Ignored };
        assert_eq!(optional.extensions[0].support, shown);
        glb.json["extensionsRequired"] = json!([name]);
        match (glb.load(), status) {
            (Ok(scene), Support::Supported | Support::Ignored) => assert!(scene.extensions[0].required),
            (Err(SceneError::Extension { extension, .. }), Support::Refused) => assert_eq!(extension, name),
            (other, _) => panic!("{name}: {other:?}"),
        }
    }
    assert_eq!(support("EXT_nobody_knows"), Support::Refused);
}

#[test]
fn meshes_that_differ_in_their_material_only_are_stored_once() {
    let mut glb = triangle();
    glb.json["materials"] = json!([{"name": "a"}, {"name": "b"}, {"name": "c", "alphaMode": "MASK"}]);
    for material in 0..3 {
        glb.show(json!({"attributes": {"POSITION": 0}, "material": material}));
    }
    let scene = glb.load_clean();
    // The masked one has triangles of another kind.
    assert_eq!(scene.meshes.len(), 2);
    let materials = scene.instances.iter().map(|i| i.material_at(&scene.meshes[i.mesh as usize], 0));
    let names: Vec<_> = materials.map(|m| scene.materials[m as usize].name.as_str()).collect();
    assert_eq!(names, ["default", "a", "b", "c"]);
    let mut merged = scene.clone();
    merged.merge_static("world");
    merged.validate().unwrap();
    assert_eq!(merged.meshes[0].triangle_materials, [3, 0, 1, 2]);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn spheres_of_many_materials_are_stored_once() {
    let file = "MetalRoughSpheresNoTextures/MetalRoughSpheresNoTextures.glb";
    let scene = shared_scene(file, &plain());
    let s = scene.statistics();
    println!(
        "{} meshes, {} instances, {} triangles stored, {} instanced",
        scene.meshes.len(),
        scene.instances.len(),
        s.triangles,
        s.instanced_triangles
    );
    assert_eq!((scene.meshes.len(), scene.instances.len()), (5, 102));
    assert_eq!(s.instanced_triangles, 1_040_409);
    assert!(s.triangles < s.instanced_triangles / 20);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn sample_models_of_single_features() {
    let scene = shared_scene("MultipleScenes/MultipleScenes.gltf", &plain());
    assert_eq!(scene.scenes.len(), 2);
    assert_eq!(scene.statistics().instanced_triangles, 2, "the default scene shows the square");
    let options = LoadOptions { scene: Some("0".into()), ..plain() };
    let other = shared_scene("MultipleScenes/MultipleScenes.gltf", &options);
    assert_eq!(other.statistics().instanced_triangles, 1);
    let count = |file: &str| shared_scene(file, &plain()).statistics().instanced_triangles;
    assert_eq!(count("TriangleWithoutIndices/TriangleWithoutIndices.gltf"), 1);
    assert_eq!(count("BoxWithSpaces/Box With Spaces.gltf"), 12);
    assert_eq!(count("BoxVertexColors/BoxVertexColors.gltf"), 12);
    let modes = shared_scene("MeshPrimitiveModes/MeshPrimitiveModes.gltf", &plain());
    assert_eq!(
        modes.notices.iter().filter(|n| n.contains("points or lines")).count(),
        1,
        "{:?}",
        modes.notices
    );
    let uv = shared_scene("MultiUVTest/MultiUVTest.gltf", &plain());
    assert!(uv.meshes[0].uv0 != uv.meshes[0].uv1);
    let colors = shared_scene("BoxVertexColors/BoxVertexColors.gltf", &plain());
    assert!(colors.meshes[0].colors.iter().any(|c| c.x != c.y));
    let negative = shared_scene("NegativeScaleTest/NegativeScaleTest.gltf", &plain());
    let mirrored =
        negative.instances.iter().filter(|i| i.world_from_object.matrix3.determinant() < 0.0).count();
    assert!(mirrored > 0 && mirrored < negative.instances.len());
}

fn with_buffer(uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"{uri}","byteLength":36}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]}}"#
    )
}

#[test]
fn buffers_are_found_beside_and_below_and_nowhere_else() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("scene");
    std::fs::create_dir_all(folder.join("übung 1/b")).unwrap();
    let data = bytes(&TRIANGLE, f32::to_le_bytes);
    for name in ["a b.bin", "übung 1/b/c%d.bin", "../outside.bin"] {
        std::fs::write(folder.join(name), &data).unwrap();
    }
    let scene = folder.join("scene.gltf");
    let try_load = |uri: &str| {
        std::fs::write(&scene, with_buffer(uri)).unwrap();
        load(&scene, &plain())
    };
    for uri in ["a b.bin", "a%20b.bin", "./a%20b.bin", "%C3%BCbung%201/b/c%25d.bin", "übung 1/b/c%25d.bin"] {
        assert_eq!(try_load(uri).unwrap_or_else(|e| panic!("{e}")).statistics().triangles, 1);
    }
    let outside = temp.path().join("outside.bin");
    let absolute = outside.to_str().unwrap();
    for uri in ["../outside.bin", "%2E%2E/outside.bin", "b/../../outside.bin", absolute] {
        let text = try_load(uri).unwrap_err().to_string();
        assert!(text.contains("buffers[0].uri: ") && text.contains("beside or below"), "{text}");
    }
    for uri in ["C:/outside.bin", "file:///outside.bin"] {
        let text = try_load(uri).unwrap_err().to_string();
        assert!(text.contains("buffers[0].uri: ") && text.contains("only files are read"), "{text}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, folder.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(temp.path(), folder.join("up")).unwrap();
        std::os::unix::fs::symlink("a b.bin", folder.join("inside.bin")).unwrap();
        for uri in ["link.bin", "up/outside.bin"] {
            let text = try_load(uri).unwrap_err().to_string();
            assert!(text.contains("link that leaves the folder"), "{text}");
        }
        assert!(try_load("inside.bin").is_ok());
    }
    let text =
        load_bytes(with_buffer("a b.bin").into_bytes(), "memory.gltf", &plain()).unwrap_err().to_string();
    assert!(text.contains("a scene from memory cannot name files"), "{text}");
}

#[test]
fn data_uris_hold_buffers() {
    // Base64 of the triangle's 36 bytes.
    let text = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    for media in ["application/octet-stream", "application/gltf-buffer"] {
        let json = with_buffer(&format!("data:{media};base64,{text}"));
        let scene = load_bytes(json.into_bytes(), "data.gltf", &plain()).unwrap();
        assert_eq!(scene.meshes[0].positions[1], Vec3::X);
        assert_eq!(scene.notices, [""; 0]);
    }
}

/// Found by fuzzing: bounds of large scenes are rounded by more than a fixed tolerance.
#[test]
fn scenes_of_any_size_get_a_camera() {
    for size in [1e-3f32, 1.0, 1e3, 1e7, 1e12] {
        let mut glb = Glb::new();
        let corner = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32 * size;
        let position = glb.floats(&(0..900).map(corner).collect::<Vec<_>>(), "VEC3");
        glb.show(json!({"attributes": {"POSITION": position}}));
        let camera = glb.load_clean().default_camera();
        assert!(camera.position().is_finite(), "{size}: {camera:?}");
    }
}

/// A board with a block before it, whose back lies in the middle of everything: from there all that is seen are fronts, the
/// block's own back among them.
#[test]
fn a_block_at_the_centre_makes_no_room() {
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let mut quad = |[a, b, c, d]: [[f32; 3]; 4]| corners.extend([a, b, c, a, c, d]);
    quad([[-10.0, -10.0, -2.0], [10.0, -10.0, -2.0], [10.0, 10.0, -2.0], [-10.0, 10.0, -2.0]]);
    let (a, b, c, d) = ([-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]);
    let at = |[x, y]: [f32; 2], z: f32| [x, y, z];
    quad([at(a, 2.0), at(b, 2.0), at(c, 2.0), at(d, 2.0)]);
    quad([at(b, 0.0), at(a, 0.0), at(d, 0.0), at(c, 0.0)]);
    for [from, to] in [[a, b], [b, c], [c, d], [d, a]] {
        quad([at(from, 0.0), at(to, 0.0), at(to, 2.0), at(from, 2.0)]);
    }
    let mut glb = Glb::new();
    let position = glb.floats(corners.as_flattened(), "VEC3");
    glb.show(json!({"attributes": {"POSITION": position}}));
    let camera = glb.load_clean().default_camera();
    assert!(camera.position().length() > 14.0, "{camera:?}");
}

#[test]
fn an_empty_scene_is_noted() {
    let mut glb = triangle();
    let four = glb.accessor(&[0; 4], U8, "SCALAR", 4);
    glb.json["meshes"][0]["primitives"][0]["indices"] = four.into();
    let notices = glb.load().unwrap().notices;
    assert!(notices.iter().any(|n| n.contains("no triangle is placed")), "{notices:?}");
}

/// What the validator's reports call errors, and why we may load such a file: the first sentence of the comment says what
/// we do.
const HARMLESS: &[(&str, &str)] = &[
    ("ACCESSOR_MATRIX_ALIGNMENT", "elements are read byte by byte"),
    ("ACCESSOR_NORMALIZED_INVALID", "floats are read as they are"),
    ("ACCESSOR_OFFSET_ALIGNMENT", "elements are read byte by byte"),
    ("ACCESSOR_TOTAL_OFFSET_ALIGNMENT", "elements are read byte by byte"),
    ("BUFFER_BYTE_LENGTH_MISMATCH", "harmless only when there are more bytes than stated; fewer are refused"),
    ("BUFFER_DATA_URI_MIME_TYPE_INVALID", "the bytes are what counts"),
    ("BUFFER_VIEW_INVALID_BYTE_STRIDE", "a stride is followed wherever it is given"),
    ("BUFFER_VIEW_TARGET_OVERRIDE", "targets are hints for OpenGL; they are not read"),
    ("BUFFER_VIEW_TOO_BIG_BYTE_STRIDE", "what an accessor needs is checked by itself"),
    ("EMPTY_ENTITY", "an empty list is as good as none"),
    ("GLB_CHUNK_LENGTH_UNALIGNED", "chunks are read byte by byte"),
    ("MESH_INVALID_WEIGHTS_COUNT", "missing weights are 0, further ones are left out"),
    ("MESH_PRIMITIVE_ACCESSOR_UNALIGNED", "elements are read byte by byte"),
    ("MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", "elements are taken as tightly packed"),
    ("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", "custom attributes are not read"),
    ("MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", "sets are looked up by their number"),
    ("MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE", "a stride is followed wherever it is given"),
    ("MESH_PRIMITIVE_INVALID_ATTRIBUTE", "unknown attributes are not read"),
    ("MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", "joints without weights are left out"),
    ("MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR", "there is nothing to displace"),
    ("MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS", "bounds come from the positions"),
    ("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", "textures are read at (0, 0)"),
    ("NODE_MATRIX_NON_TRS", "any affine matrix can be rendered"),
    ("NODE_MATRIX_TRS", "the matrix is used"),
    ("NODE_SKIN_WITH_NON_SKINNED_MESH", "parts without joints follow their node"),
    ("NODE_WEIGHTS_INVALID", "missing weights are 0, further ones are left out"),
    ("ROTATION_NON_UNIT", "normalised"),
    ("SCENE_NON_ROOT_NODE", "the node is shown where it stands in its parent's space"),
    ("UNSATISFIED_DEPENDENCY", "a property without the one that gives it a meaning is not read"),
    ("VALUE_MULTIPLE_OF", "elements are read byte by byte"),
    ("VALUE_NOT_IN_RANGE", "an empty buffer holds no accessor"),
];

/// Codes of the errors in a validator's report beside a file; empty without a report.
fn validator_errors(file: &Path) -> Vec<String> {
    let mut report = file.as_os_str().to_owned();
    report.push(".report.json");
    let Ok(text) = std::fs::read_to_string(report) else { return Vec::new() };
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    let messages = report["issues"]["messages"].as_array().unwrap();
    let errors = messages.iter().filter(|m| m["severity"] == 0);
    let mut codes: Vec<String> = errors.map(|m| m["code"].as_str().unwrap().to_owned()).collect();
    codes.sort();
    codes.dedup();
    codes
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn invalid_files_are_refused_or_load_with_a_notice() {
    let folder = shared("scenes_invalid");
    let files = common::scene_files(&folder);
    assert!(files.len() > 100);
    let mut wrong = Vec::new();
    for file in &files {
        let start = Instant::now();
        let result = load(file, &plain());
        assert!(start.elapsed() < Duration::from_secs(10), "{} hangs", file.display());
        let errors = validator_errors(file);
        let name = file.strip_prefix(&folder).unwrap().display().to_string();
        let verdict = match &result {
            Ok(scene) if scene.notices.is_empty() => "loads".to_owned(),
            Ok(scene) => format!("notice: {}", scene.notices[0]),
            Err(e) => {
                let text = e.to_string();
                assert!(!text.contains('\n') && text.starts_with(&file.display().to_string()), "{text}");
                format!("refused: {}", &text[file.as_os_str().len() + 2..])
            }
        };
        println!("{name:60} | {:60} | {verdict}", errors.join(" "));
        let harmless = |code: &String| HARMLESS.iter().any(|(known, _)| known == code);
        // "No triangle is placed" says nothing about the deviation.
        let noticed = |scene: &Scene| scene.notices.iter().any(|n| !n.contains("no triangle is placed"));
        match &result {
            Ok(scene) if !(errors.is_empty() || noticed(scene) && errors.iter().all(harmless)) => {
                wrong.push(format!("{name}: {errors:?}"))
            }
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "loaded in spite of errors:\n{}", wrong.join("\n"));
}
