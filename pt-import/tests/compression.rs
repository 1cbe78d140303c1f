//! Compressed glTF files: EXT_meshopt_compression and its other name, and sample models with either compression.

use crate::common::gltf::{F32, Glb, I8, plain, shared_scene};
use pt_import::load_bytes;
use pt_scene::glam::Vec3;
use pt_test_data::shared;
use serde_json::json;

/// A square in which every stream is compressed, with a fallback buffer that is not there.
fn meshopt(positions: &[[f32; 3]], list: &[u32]) -> Glb {
    let mut glb = Glb::new();
    let vertices = meshopt::encode_vertex_buffer(positions).unwrap();
    let normals: Vec<[i8; 4]> = meshopt::encode_filter_oct(&vec![[0.6, 0.0, 0.8, 0.0]; positions.len()], 8);
    let normals = meshopt::encode_vertex_buffer(&normals).unwrap();
    let indices = meshopt::encode_index_buffer(list, positions.len()).unwrap();
    glb.json["extensionsUsed"] = json!(["EXT_meshopt_compression", "KHR_mesh_quantization"]);
    glb.json["extensionsRequired"] = glb.json["extensionsUsed"].clone();
    let mut compressed = |data: &[u8], count: usize, stride: usize, mode: &str, filter: &str| {
        let source = glb.view(data, None);
        let source = glb.json["bufferViews"].as_array_mut().unwrap().remove(source);
        let mut view = json!({"buffer": 1, "byteLength": count * stride, "byteOffset": 0});
        if mode == "ATTRIBUTES" {
            view["byteStride"] = stride.into();
        }
        view["extensions"] = json!({"EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": source["byteOffset"], "byteLength": data.len(), "byteStride": stride,
            "count": count, "mode": mode, "filter": filter}});
        glb.push("bufferViews", view)
    };
    let p = compressed(&vertices, positions.len(), 12, "ATTRIBUTES", "NONE");
    let n = compressed(&normals, positions.len(), 4, "ATTRIBUTES", "OCTAHEDRAL");
    let i = compressed(&indices, list.len(), 4, "TRIANGLES", "NONE");
    let count = positions.len();
    glb.push("accessors", json!({"bufferView": p, "componentType": F32, "type": "VEC3", "count": count, "min": [0, 0, 0], "max": [1, 1, 1]}));
    glb.push(
        "accessors",
        json!({"bufferView": n, "componentType": I8, "type": "VEC3", "count": count, "normalized": true}),
    );
    glb.push(
        "accessors",
        json!({"bufferView": i, "componentType": 5125, "type": "SCALAR", "count": list.len()}),
    );
    glb.show(json!({"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}));
    let fallback = json!({"byteLength": 1000, "extensions": {"EXT_meshopt_compression": {"fallback": true}}});
    glb.json["buffers"] = json!([{"byteLength": glb.binary.len()}, fallback]);
    glb
}

#[test]
fn meshopt_streams_with_filters_and_fallback() {
    let positions: Vec<[f32; 3]> = (0..40).map(|i| [i as f32, (i * i) as f32 * 0.25, -1.5]).collect();
    let list: Vec<u32> = (0..38).flat_map(|i| [i, i + 1, i + 2]).collect();
    let mut glb = meshopt(&positions, &list);
    let scene = glb.load_clean();
    let mesh = &scene.meshes[0];
    assert!(mesh.positions.iter().zip(&positions).all(|(a, b)| a.to_array() == *b));
    // The codec may turn a triangle round, not over.
    let turned = |t: &[u32; 3]| (0..3).map(|k| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]).min().unwrap();
    let expected: Vec<[u32; 3]> = list.chunks(3).map(|t| turned(&[t[0], t[1], t[2]])).collect();
    assert_eq!(mesh.indices.iter().map(turned).collect::<Vec<_>>(), expected);
    assert!(
        mesh.normals.iter().all(|n| n.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 0.02)),
        "{}",
        mesh.normals[0]
    );

    // The same with the extension's other name.
    let mut other = glb.file();
    let text = String::from_utf8_lossy(&other).matches("EXT_meshopt").count();
    assert!(text > 3);
    while let Some(at) = other.windows(11).position(|w| w == b"EXT_meshopt") {
        other[at..at + 3].copy_from_slice(b"KHR");
    }
    assert_eq!(load_bytes(other, "khr.glb", &plain()).unwrap().meshes[0].positions, mesh.positions);

    for (field, value, expected) in [
        ("count", json!(39), "count x byteStride is 468, byteLength is 480"),
        ("byteLength", json!(9), "the compressed attributes are broken"),
        ("byteLength", json!(u32::MAX), "do not fit"),
        ("mode", json!("CUBES"), "unknown mode CUBES"),
        ("filter", json!("BLUR"), "unknown filter BLUR"),
        ("filter", json!("QUATERNION"), "byteStride 12 or count 40 is wrong"),
    ] {
        let extension = &mut glb.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
        let kept = std::mem::replace(&mut extension[field], value);
        let text = glb.refusal();
        assert!(
            text.contains("bufferViews[0].extensions.EXT_meshopt_compression") && text.contains(expected),
            "{text}"
        );
        glb.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][field] = kept;
    }
    // 4 GiB of zeros are a few bytes when compressed.
    let extension = &mut glb.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    extension["count"] = json!(1u64 << 40);
    glb.json["bufferViews"][0]["byteLength"] = json!(12u64 << 40);
    assert!(glb.refusal().contains("bytes of geometry"));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn compressed_sample_models_have_their_published_size() {
    let box_file = "BoxTextured_Meshopt/BoxTextured_meshopt.glb";
    let scene = shared_scene(box_file, &plain());
    let bounds = scene.bounds().unwrap();
    assert_eq!(scene.statistics().triangles, 12);
    assert!(bounds.size().abs_diff_eq(Vec3::ONE, 1e-3), "{bounds:?}");
    let scene = shared_scene("CesiumMilkTruck_Draco/CesiumMilkTruck.gltf", &plain());
    // Body of three primitives, and one wheel pair placed twice.
    assert_eq!((scene.meshes.len(), scene.instances.len()), (2, 3));
    let text = std::fs::read_to_string(shared("scenes/CesiumMilkTruck_Draco/CesiumMilkTruck.gltf"));
    let json: serde_json::Value = serde_json::from_str(&text.unwrap()).unwrap();
    let primitives =
        json["meshes"].as_array().unwrap().iter().flat_map(|m| m["primitives"].as_array().unwrap());
    let corners =
        |p: &serde_json::Value| json["accessors"][p["indices"].as_u64().unwrap() as usize]["count"].as_u64();
    let triangles = primitives.map(|p| corners(p).unwrap() / 3).sum::<u64>();
    assert_eq!(scene.statistics().triangles as u64, triangles);
    for (mesh, described) in scene.meshes.iter().zip(json["meshes"].as_array().unwrap()) {
        let primitives = described["primitives"].as_array().unwrap();
        let bound = |key: &str, pick: fn(f32, f32) -> f32| -> [f32; 3] {
            std::array::from_fn(|axis| {
                let of = |p: &serde_json::Value| {
                    let accessor = &json["accessors"][p["attributes"]["POSITION"].as_u64().unwrap() as usize];
                    accessor[key][axis].as_f64().unwrap() as f32
                };
                primitives.iter().map(of).reduce(pick).unwrap()
            })
        };
        let low = mesh.positions.iter().copied().reduce(Vec3::min).unwrap();
        let high = mesh.positions.iter().copied().reduce(Vec3::max).unwrap();
        // Quantised to 11 bits of 5 metres.
        assert!(low.abs_diff_eq(bound("min", f32::min).into(), 2.5e-3), "{low}");
        assert!(high.abs_diff_eq(bound("max", f32::max).into(), 2.5e-3), "{high}");
    }
    for mesh in &scene.meshes {
        let agree = |&[a, b, c]: &[u32; 3]| {
            let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
            (q - p).cross(r - p).dot(mesh.normals[a as usize]) > 0.0
        };
        let share = mesh.indices.iter().filter(|t| agree(t)).count() as f32 / mesh.indices.len() as f32;
        assert!(share > 0.97, "{}: normals and winding agree for {share}", mesh.name);
    }
}
