//! Accessors and primitives: small files made in code, with exactly known vertices.

use crate::common::gltf::{F32, Glb, I8, I16, U8, U16, U32, bytes};
use pt_import::LoadOptions;
use pt_scene::Scene;
use pt_scene::glam::{Vec2, Vec3, Vec4};
use serde_json::json;

const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
const UP: [f32; 12] = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];

fn square() -> [Vec3; 4] {
    std::array::from_fn(|i| Vec3::from_slice(&SQUARE[3 * i..]))
}

/// A square whose normals are in the file, so that vertices stay as they are.
fn with_square(primitive: impl FnOnce(&mut Glb, &mut serde_json::Value)) -> Glb {
    let mut glb = Glb::new();
    let position = glb.floats(&SQUARE, "VEC3");
    let normal = glb.floats(&UP, "VEC3");
    let mut json = json!({"attributes": {"POSITION": position, "NORMAL": normal}, "mode": 5});
    // As a strip 0 1 3 2, unless the caller says otherwise.
    let indices = glb.accessor(&[0, 1, 3, 2], U8, "SCALAR", 4);
    json["indices"] = indices.into();
    primitive(&mut glb, &mut json);
    glb.show(json);
    glb
}

fn normals_agree(scene: &Scene) {
    let mesh = &scene.meshes[0];
    for (t, &[a, _, _]) in mesh.indices.iter().enumerate() {
        let [p, q, r] = mesh.triangle(t);
        assert!((q - p).cross(r - p).dot(mesh.normals[a as usize]) > 0.0, "triangle {t} faces the wrong way");
    }
}

#[test]
fn indices_of_every_type_name_the_same_triangles() {
    let list = [0u32, 1, 2, 0, 2, 3];
    let encodings = [
        (U8, list.iter().map(|&i| i as u8).collect()),
        (U16, bytes(&list.map(|i| i as u16), u16::to_le_bytes)),
        (U32, bytes(&list, u32::to_le_bytes)),
    ];
    for (component, data) in encodings {
        let glb = with_square(|glb, json| {
            json["mode"] = 4.into();
            json["indices"] = glb.accessor(&data, component, "SCALAR", 6).into();
        });
        let scene = glb.load_clean();
        assert_eq!(scene.meshes[0].positions, square());
        assert_eq!(scene.meshes[0].indices, [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn every_triangle_mode_makes_the_same_square() {
    // List, strip, fan; with indices and without.
    let modes: [(u32, &[u8]); 3] = [(4, &[0, 1, 2, 0, 2, 3]), (5, &[0, 1, 3, 2]), (6, &[0, 1, 2, 3])];
    for (mode, list) in modes {
        let indexed = with_square(|glb, json| {
            json["mode"] = mode.into();
            json["indices"] = glb.accessor(list, U8, "SCALAR", list.len()).into();
        });
        let mut plain = Glb::new();
        let corners: Vec<f32> = list.iter().flat_map(|&v| square()[v as usize].to_array()).collect();
        let normals: Vec<f32> = list.iter().flat_map(|_| [0.0, 0.0, 1.0]).collect();
        let position = plain.floats(&corners, "VEC3");
        let normal = plain.floats(&normals, "VEC3");
        plain.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}, "mode": mode}));
        for glb in [indexed, plain] {
            let scene = glb.load_clean();
            let mesh = &scene.meshes[0];
            assert_eq!(mesh.triangle_count(), 2, "mode {mode}");
            normals_agree(&scene);
            let area = |t| {
                let [p, q, r]: [Vec3; 3] = mesh.triangle(t);
                0.5 * (q - p).cross(r - p).length()
            };
            assert_eq!(area(0) + area(1), 1.0);
        }
    }
}

#[test]
fn points_and_lines_get_one_notice() {
    let mut glb = with_square(|_, _| {});
    for mode in [0, 1, 2, 3] {
        let mesh = json!({"primitives": [{"attributes": {"POSITION": 0}, "mode": mode}]});
        glb.push("meshes", mesh);
    }
    let notices = glb.load().unwrap().notices;
    assert_eq!(notices.iter().filter(|n| n.contains("points or lines")).count(), 1);
    assert!(
        notices.iter().any(|n| n.starts_with("meshes[1].primitives[0] and 3 more: points")),
        "{notices:?}"
    );
}

#[test]
fn attributes_of_every_type_and_stride() {
    // Texture coordinates (0, 0.5), (0.5, 1) .. as normalised bytes, shorts, floats; interleaved and not.
    let uv = [[0.0f32, 0.6], [0.2, 0.8], [0.4, 1.0], [1.0, 0.0]];
    for (component, size) in [(U8, 1usize), (U16, 2), (F32, 4)] {
        for stride in [None, Some(12)] {
            let glb = with_square(|glb, json| {
                let step = stride.unwrap_or(2 * size);
                let mut data = vec![0xEE; 4 * step];
                for (i, value) in uv.iter().flatten().enumerate() {
                    let encoded = match component {
                        U8 => vec![(value * 255.0).round() as u8],
                        U16 => ((value * 65535.0).round() as u16).to_le_bytes().to_vec(),
                        _ => value.to_le_bytes().to_vec(),
                    };
                    data[i / 2 * step + i % 2 * size..][..size].copy_from_slice(&encoded);
                }
                let view = glb.view(&data, stride);
                let accessor = glb.push(
                    "accessors",
                    json!({"bufferView": view, "componentType": component, "type": "VEC2", "count": 4,
                        "normalized": component != F32}),
                );
                json["attributes"]["TEXCOORD_0"] = accessor.into();
            });
            let scene = glb.load().unwrap();
            let expected = uv.map(Vec2::from_array);
            assert_eq!(scene.meshes[0].uv0, expected, "{component} {stride:?}");
            assert_eq!(scene.meshes[0].uv1, [Vec2::ZERO; 4]);
        }
    }
}

#[test]
fn quantised_positions_and_normals() {
    let mut glb = Glb::new();
    glb.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    // Shorts as they are, padded to 8 bytes; normals as normalised bytes, padded to 4.
    let positions = [[-300i16, 0, 7, 0], [300, 0, 7, 0], [0, 400, 7, 0]];
    let view = glb.view(&bytes(&positions.concat(), i16::to_le_bytes), Some(8));
    let position = glb.push(
        "accessors",
        json!({"bufferView": view, "componentType": I16, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 1]}),
    );
    let view = glb.view(&[0, 0, 129, 0, 0, 0, 127, 0, 127, 0, 0, 0], Some(4));
    let normal = glb.push(
        "accessors",
        json!({"bufferView": view, "componentType": I8, "type": "VEC3", "count": 3, "normalized": true}),
    );
    glb.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}}));
    let mesh = &glb.load_clean().meshes[0];
    assert_eq!(
        mesh.positions,
        [[-300.0, 0.0, 7.0], [300.0, 0.0, 7.0], [0.0, 400.0, 7.0]].map(Vec3::from_array)
    );
    assert_eq!(mesh.normals, [Vec3::NEG_Z, Vec3::Z, Vec3::X]);
}

#[test]
fn colours_of_every_type_with_and_without_alpha() {
    let colors = [[1.0f32, 0.0, 0.2, 0.4], [0.6, 0.8, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]];
    for (component, kind) in
        [(U8, "VEC4"), (U16, "VEC4"), (F32, "VEC4"), (U8, "VEC3"), (U16, "VEC3"), (F32, "VEC3")]
    {
        let parts = if kind == "VEC3" { 3 } else { 4 };
        let glb = with_square(|glb, json| {
            let mut data = Vec::new();
            for color in &colors {
                for value in &color[..parts] {
                    match component {
                        U8 => data.push((value * 255.0).round() as u8),
                        U16 => data.extend(((value * 65535.0).round() as u16).to_le_bytes()),
                        _ => data.extend(value.to_le_bytes()),
                    }
                }
                data.resize(data.len().next_multiple_of(4), 0);
            }
            let view = glb.view(&data, Some(data.len() / 4));
            let color = json!({"bufferView": view, "componentType": component, "type": kind, "count": 4,
                "normalized": component != F32});
            json["attributes"]["COLOR_0"] = glb.push("accessors", color).into();
        });
        let expected =
            colors.map(|c| Vec4::from_array(c).truncate().extend(if parts == 3 { 1.0 } else { c[3] }));
        assert_eq!(glb.load_clean().meshes[0].colors, expected, "{component} {kind}");
    }
}

#[test]
fn sparse_with_and_without_base() {
    for base in [true, false] {
        let mut glb = Glb::new();
        let indices = glb.view(&[1, 3], None);
        let values = glb.view(&bytes(&[5.0f32, 6.0, 7.0, 8.0, 9.0, 10.0], f32::to_le_bytes), None);
        let mut accessor = json!({
            "componentType": F32, "type": "VEC3", "count": 4, "min": [0, 0, 0], "max": [1, 1, 1],
            "sparse": {
                "count": 2,
                "indices": {"bufferView": indices, "componentType": U8},
                "values": {"bufferView": values}
            }
        });
        if base {
            accessor["bufferView"] = glb.view(&bytes(&SQUARE, f32::to_le_bytes), None).into();
        }
        let position = glb.push("accessors", accessor);
        let normal = glb.floats(&UP, "VEC3");
        let indices = glb.accessor(&[0, 1, 3, 1, 2, 3], U8, "SCALAR", 6);
        glb.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices}));
        let mut expected = if base { square() } else { [Vec3::ZERO; 4] };
        expected[1] = Vec3::new(5.0, 6.0, 7.0);
        expected[3] = Vec3::new(8.0, 9.0, 10.0);
        assert_eq!(glb.load_clean().meshes[0].positions, expected);
    }
}

#[test]
fn missing_normals_are_flat() {
    let glb = with_square(|glb, json| {
        // Tangents without normals are not to be used.
        let tangent = glb.floats(&[0., 0., 1., 1.].repeat(4), "VEC4");
        json["attributes"] = json!({"POSITION": 0, "TANGENT": tangent});
    });
    let scene = glb.load_clean();
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.vertex_count(), 6);
    assert!(mesh.normals.iter().all(|&n| n == Vec3::Z));
    assert!(mesh.tangents.iter().all(|t| t.z == 0.0));
    normals_agree(&scene);
}

/// Two squares side by side, texture u along +x in the left one and mirrored in the right one; vertices shared in the
/// middle. A normal map makes tangents necessary.
fn mirrored(set: u32) -> Glb {
    let mut glb = Glb::new();
    let position =
        glb.floats(&[0., 0., 0., 1., 0., 0., 2., 0., 0., 0., 1., 0., 1., 1., 0., 2., 1., 0.], "VEC3");
    let normal = glb.floats(&[0., 0., 1.].repeat(6), "VEC3");
    let uv = glb.floats(&[0., 1., 1., 1., 0., 1., 0., 0., 1., 0., 0., 0.], "VEC2");
    let other = glb.floats(&[0.; 12], "VEC2");
    let indices = glb.accessor(&[0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4], U8, "SCALAR", 12);
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
    glb.json["images"] = json!([{"uri": png}]);
    glb.json["textures"] = json!([{"source": 0}]);
    glb.json["materials"] = json!([{"normalTexture": {"index": 0, "texCoord": set}}]);
    let (first, second) = if set == 0 { (uv, other) } else { (other, uv) };
    glb.show(json!({
        "attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": first, "TEXCOORD_1": second},
        "indices": indices, "material": 0
    }));
    glb
}

#[test]
fn computed_tangents_split_vertices_where_the_texture_is_mirrored() {
    for set in [0, 1] {
        let scene = mirrored(set).load_clean();
        let mesh = &scene.meshes[0];
        // The two vertices in the middle are doubled.
        assert_eq!(mesh.vertex_count(), 8, "set {set}");
        for (t, corners) in mesh.indices.iter().enumerate() {
            // u grows to the right in the left square; v grows downward, so the bitangent is +y in both.
            let expected =
                if t < 2 { Vec4::new(1.0, 0.0, 0.0, 1.0) } else { Vec4::new(-1.0, 0.0, 0.0, -1.0) };
            for &v in corners {
                let tangent = mesh.tangents[v as usize];
                assert!(tangent.abs_diff_eq(expected, 1e-6), "triangle {t}: {tangent}");
                let bitangent = tangent.w * mesh.normals[v as usize].cross(tangent.truncate());
                assert!(bitangent.abs_diff_eq(Vec3::Y, 1e-6));
            }
        }
        let all: Vec<Vec3> = mesh.indices.iter().flatten().map(|&v| mesh.positions[v as usize]).collect();
        let plain =
            [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4].map(|v| Vec3::new((v % 3) as f32, (v / 3) as f32, 0.0));
        assert_eq!(all, plain, "splitting moves no corner");
    }
}

#[test]
fn tangents_of_the_file_are_kept_and_none_are_computed_without_need() {
    let mut glb = mirrored(0);
    let tangent = glb.floats(&[0., 1., 0., -1.].repeat(6), "VEC4");
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = tangent.into();
    let scene = glb.load_clean();
    assert_eq!(scene.meshes[0].tangents, [Vec4::new(0.0, 1.0, 0.0, -1.0); 6]);
    let mut glb = mirrored(0);
    glb.json["materials"][0] = json!({});
    assert_eq!(glb.load_clean().meshes[0].vertex_count(), 6, "no normal map, no split vertices");
}

#[test]
fn numbers_that_are_off_are_repaired_with_a_notice() {
    let glb = with_square(|glb, json| {
        let normals = [0., 0., 3., 0., 0., 0., f32::NAN, 0., 1., 0., 0., 1e-30];
        json["attributes"]["NORMAL"] = glb.floats(&normals, "VEC3").into();
        let uv = [0.0, 0.0, f32::INFINITY, 0.5, 1.0, 1.0, 0.0, 1.0];
        json["attributes"]["TEXCOORD_0"] = glb.floats(&uv, "VEC2").into();
    });
    let scene = glb.load().unwrap();
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.normals[0], Vec3::Z);
    assert_eq!(mesh.normals[3], Vec3::Z);
    assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    assert_eq!(mesh.uv0[1], Vec2::ZERO);
    let said = |what: &str| {
        scene.notices.iter().any(|n| n.starts_with("meshes[0].primitives[0]: ") && n.contains(what))
    };
    assert!(said("normals") && said("texture coordinates"), "{:?}", scene.notices);
}

#[test]
fn broken_geometry_is_refused_with_its_path() {
    let refused = |expected: &str, change: &dyn Fn(&mut Glb, &mut serde_json::Value)| {
        let text = with_square(|glb, json| change(glb, json)).refusal();
        assert!(text.contains(expected), "{text}");
    };
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        refused("meshes[0].primitives[0].attributes.POSITION: vertex 2", &|glb, json| {
            let mut p = SQUARE;
            p[7] = bad;
            json["attributes"]["POSITION"] = glb.floats(&p, "VEC3").into();
        });
    }
    refused("meshes[0].primitives[0].indices: element 1 is vertex 4", &|glb, json| {
        json["indices"] = glb.accessor(&[0, 4, 3, 2], U8, "SCALAR", 4).into();
    });
    refused("meshes[0].primitives[0].indices: cannot be SCALAR of float", &|glb, json| {
        json["indices"] = glb.floats(&[0.0, 1.0, 2.0], "SCALAR").into();
    });
    refused("attributes.NORMAL: has 3 elements, POSITION has 4", &|glb, json| {
        json["attributes"]["NORMAL"] = glb.floats(&UP[..9], "VEC3").into();
    });
    refused(
        "accessors[3]: 2147483648 elements of 12 bytes at 0, stride 12, do not fit in 12 bytes",
        &|glb, json| {
            let view = glb.view(&[0; 12], None);
            let huge = json!({"bufferView": view, "componentType": F32, "type": "VEC3", "count": 1u32 << 31});
            let huge = glb.push("accessors", huge);
            json["attributes"] = json!({"POSITION": huge, "NORMAL": huge});
        },
    );
    refused("accessors[3].count: 4000000000 elements", &|glb, json| {
        let view = glb.view(&[0; 12], None);
        let sparse = json!({"count": 1, "indices": {"bufferView": view, "componentType": U8}, "values": {"bufferView": view}});
        let huge = json!({"componentType": F32, "type": "VEC3", "count": 4_000_000_000u64, "sparse": sparse});
        let huge = glb.push("accessors", huge);
        json["attributes"] = json!({"POSITION": huge, "NORMAL": huge});
    });
    refused("bufferViews[3]: 4294967295 bytes at 0", &|glb, json| {
        let view = glb.push("bufferViews", json!({"buffer": 0, "byteLength": u32::MAX}));
        let accessor = json!({"bufferView": view, "componentType": F32, "type": "VEC3", "count": 4});
        json["attributes"]["POSITION"] = glb.push("accessors", accessor).into();
    });
    refused("accessors[3].sparse.indices: element 0 replaces element 9", &|glb, json| {
        let index = glb.view(&[9], None);
        let values = glb.view(&[0; 12], None);
        let base = glb.view(&[0; 48], None);
        let sparse = json!({"count": 1, "indices": {"bufferView": index, "componentType": U8}, "values": {"bufferView": values}});
        let accessor =
            json!({"bufferView": base, "componentType": F32, "type": "VEC3", "count": 4, "sparse": sparse});
        json["attributes"]["NORMAL"] = glb.push("accessors", accessor).into();
    });
}

#[test]
fn the_same_data_named_too_often_is_refused() {
    let mut glb = with_square(|_, _| {});
    let primitive = glb.json["meshes"][0]["primitives"][0].clone();
    glb.json["meshes"][0]["primitives"] = vec![primitive; 1000].into();
    let options = |max_geometry_bytes| LoadOptions { max_geometry_bytes, ..LoadOptions::default() };
    assert_eq!(glb.load_with(&options(1 << 20)).unwrap().statistics().triangles, 2000);
    let text = glb.load_with(&options(1 << 16)).unwrap_err().to_string();
    assert!(text.contains("meshes[0].primitives[") && text.contains("bytes of geometry"), "{text}");
}
