//! Animated scene files made in code: every interpolation and component type, joints and morph targets in all forms.

use std::fmt::Write as _;

use pt_import::{LoadOptions, load};
use pt_scene::Scene;
use pt_scene::glam::{Mat4, Quat, Vec3};

/// A glTF file put together piece by piece.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: String,
    accessors: String,
    count: usize,
}

/// Components of an accessor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    F32,
}

impl Component {
    fn code(self) -> u32 {
        [5120, 5121, 5122, 5123, 5126][self as usize]
    }

    fn is_signed(self) -> bool {
        matches!(self, Self::I8 | Self::I16 | Self::F32)
    }

    fn encode(self, x: f32) -> Vec<u8> {
        match self {
            Self::I8 => vec![(x * 127.0).round() as i8 as u8],
            Self::U8 => vec![(x * 255.0).round() as u8],
            Self::I16 => ((x * 32767.0).round() as i16).to_le_bytes().to_vec(),
            Self::U16 => ((x * 65535.0).round() as u16).to_le_bytes().to_vec(),
            Self::F32 => x.to_le_bytes().to_vec(),
        }
    }

    /// Largest error of a value in 0..1.
    fn step(self) -> f32 {
        [0.5 / 127.0, 0.5 / 255.0, 0.5 / 32767.0, 0.5 / 65535.0, 1e-7][self as usize]
    }
}

impl File {
    fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let index = self.views.matches("buffer\"").count();
        let comma = if index > 0 { "," } else { "" };
        let (offset, length) = (self.bytes.len(), bytes.len());
        write!(self.views, r#"{comma}{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#).unwrap();
        self.bytes.extend_from_slice(bytes);
        index
    }

    fn accessor(&mut self, rest: &str) -> usize {
        let comma = if self.count > 0 { "," } else { "" };
        write!(self.accessors, "{comma}{{{rest}}}").unwrap();
        self.count += 1;
        self.count - 1
    }

    /// Values in -1..1 (0..1 for unsigned components), normalised where they are integers.
    fn values(&mut self, component: Component, kind: &str, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|&x| component.encode(x)).collect();
        let view = self.view(&bytes);
        let (code, count, normalized) = (component.code(), values.len() / width, component != Component::F32);
        self.accessor(&format!(
            r#""bufferView":{view},"componentType":{code},"count":{count},"type":"{kind}","normalized":{normalized}"#
        ))
    }

    fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        self.values(Component::F32, kind, width, values)
    }

    fn bytes(&mut self, kind: &str, width: usize, values: &[u8]) -> usize {
        let view = self.view(values);
        let count = values.len() / width;
        self.accessor(&format!(r#""bufferView":{view},"componentType":5121,"count":{count},"type":"{kind}""#))
    }

    /// A triangle in the plane z = 0 with normals.
    fn triangle(&mut self) -> String {
        let positions = self.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let normals = self.floats("VEC3", 3, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        format!(r#""POSITION":{positions},"NORMAL":{normals}"#)
    }

    fn load(&self, rest: &str, time: f64) -> Result<Scene, pt_scene::SceneError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("test.gltf");
        std::fs::write(folder.path().join("test.bin"), &self.bytes).unwrap();
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"test.bin","byteLength":{}}}],
            "bufferViews":[{}],"accessors":[{}],"scene":0,{rest}}}"#,
            self.bytes.len(),
            self.views,
            self.accessors
        );
        std::fs::write(&path, json).unwrap();
        load(&path, &LoadOptions { time, ..LoadOptions::default() })
    }
}

/// A triangle whose node turns from rest to a quarter turn about +Y between the keys at 1 s and 3 s.
fn turning(component: Component, interpolation: &str) -> (File, String) {
    let mut file = File::default();
    let attributes = file.triangle();
    let times = file.floats("SCALAR", 1, &[1.0, 3.0]);
    let (h, rest) = (std::f32::consts::FRAC_1_SQRT_2, [0.0, 0.0, 0.0, 1.0]);
    let quarter = [0.0, h, 0.0, h];
    let flat = [0.0f32; 4];
    let keys = match interpolation {
        "CUBICSPLINE" => [flat, rest, flat, flat, quarter, flat].concat(),
        _ => [rest, quarter].concat(),
    };
    let output = file.values(component, "VEC4", 4, &keys);
    let rest = format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":[0,0,5]}}],
        "meshes":[{{"primitives":[{{"attributes":{{{attributes}}}}}]}}],
        "animations":[{{"samplers":[{{"input":{times},"output":{output},"interpolation":"{interpolation}"}}],
        "channels":[{{"sampler":0,"target":{{"node":0,"path":"rotation"}}}}]}}]"#
    );
    (file, rest)
}

#[test]
fn rotations_of_every_component_type_and_interpolation() {
    use Component::*;
    for component in [I8, U8, I16, U16, F32] {
        for interpolation in ["STEP", "LINEAR", "CUBICSPLINE"] {
            let (file, rest) = turning(component, interpolation);
            // Share of the quarter turn at 0.5, 1.5 and 2.9 s; the animation's 3 s start again after that.
            let (s, late) = (0.25f32, 0.95f32);
            let shares = match interpolation {
                "STEP" => [0.0, 0.0, 0.0],
                "LINEAR" => [0.0, s, late],
                // Hermite weight 3 s^2 - 2 s^3 of the second quaternion, then normalised.
                _ => {
                    let share = |s: f32| {
                        let w = 3.0 * s * s - 2.0 * s * s * s;
                        let (sin, cos) = std::f32::consts::FRAC_PI_4.sin_cos();
                        2.0 * (w * sin).atan2(1.0 - w + w * cos) / std::f32::consts::FRAC_PI_2
                    };
                    [0.0, share(s), share(late)]
                }
            };
            for (time, share) in [0.5, 1.5, 2.9].into_iter().zip(shares) {
                let scene = file.load(&rest, time).unwrap();
                let expected =
                    Quat::from_rotation_y(share * std::f32::consts::FRAC_PI_2) * Vec3::X + 5.0 * Vec3::Z;
                let got = scene.instances[0].world_from_object.transform_point3(Vec3::X);
                let tolerance = 2e-6 + 4.0 * component.step();
                assert!(
                    got.distance(expected) < tolerance,
                    "{component:?} {interpolation} at {time}: {got} for {expected}"
                );
            }
        }
    }
}

#[test]
fn morph_weights_and_targets_of_every_component_type() {
    use Component::*;
    for component in [I8, U8, I16, U16, F32] {
        let mut file = File::default();
        let attributes = file.triangle();
        let times = file.floats("SCALAR", 1, &[0.0, 2.0]);
        // Two targets: lift the second vertex along +Z; shift all along +X.
        let lift = file.values(component, "VEC3", 3, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
        let shift = file.values(component, "VEC3", 3, &[0.25, 0.0, 0.0, 0.25, 0.0, 0.0, 0.25, 0.0, 0.0]);
        let tilt = file.floats("VEC3", 3, &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let weights = file.values(component, "SCALAR", 1, &[0.0, 1.0, 1.0, 0.2]);
        let rest = format!(
            r#""scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0}},{{"mesh":0,"weights":[0.5,0.0]}}],
            "meshes":[{{"weights":[0.0,1.0],"primitives":[{{"attributes":{{{attributes}}},
              "targets":[{{"POSITION":{lift},"NORMAL":{tilt}}},{{"POSITION":{shift}}}]}}]}}],
            "animations":[{{"samplers":[{{"input":{times},"output":{weights}}}],
              "channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}]}}]"#
        );
        let scene = file.load(&rest, 1.0).unwrap();
        // Half way: weights 0.5 and 0.6.
        let mesh = |i: usize| &scene.meshes[scene.instances[i].mesh as usize];
        let got = mesh(0).positions[1];
        let expected = Vec3::new(1.0 + 0.6 * 0.25, 0.0, 0.5 * 0.5);
        assert!(
            got.distance(expected) < 1e-6 + 3.0 * component.step(),
            "{component:?}: {got} for {expected}"
        );
        let tilted = Vec3::new(0.0, 0.5, 1.0).normalize();
        assert!(mesh(0).normals[1].distance(tilted) < 1e-5 + 2.0 * component.step());
        // The other node has weights of its own and never moves: it keeps a rigid mesh in that shape.
        assert!(mesh(0).deformation.is_some() && mesh(1).deformation.is_none());
        assert!(mesh(1).positions[1].distance(Vec3::new(1.0, 0.0, 0.25)) < 1e-6 + component.step());
        assert!(component.is_signed() || mesh(1).positions[0].x >= 0.0);
    }
}

#[test]
fn sparse_targets_move_only_what_they_name() {
    let mut file = File::default();
    let attributes = file.triangle();
    let (index, value) = (file.view(&[2]), file.view(bytemuck::bytes_of(&[0.0f32, 2.0, 0.0])));
    let sparse = file.accessor(&format!(
        r#""componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":1,
        "indices":{{"bufferView":{index},"componentType":5121}},"values":{{"bufferView":{value}}}}}"#
    ));
    let rest = format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"scale":[2,2,2]}}],"meshes":[{{"weights":[0.5],"primitives":
        [{{"attributes":{{{attributes}}},"targets":[{{"POSITION":{sparse}}}]}}]}}]"#
    );
    let scene = file.load(&rest, 0.0).unwrap();
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 2.0, 0.0)]);
    assert_eq!(scene.bounds().unwrap().max, Vec3::new(2.0, 4.0, 0.0));
}

/// Six joints in two sets, joint k shifted by 2^k along +X; vertex weights are given as they are.
fn skinned(weights: [f32; 8], nodes: &str, skins: &str) -> (File, String) {
    let mut file = File::default();
    let attributes = file.triangle();
    let joints =
        [file.bytes("VEC4", 4, &[0, 1, 2, 3].repeat(3)), file.bytes("VEC4", 4, &[4, 5, 0, 0].repeat(3))];
    let sets = [&weights[..4], &weights[4..]].map(|w| file.floats("VEC4", 4, &w.repeat(3)));
    let matrix = |x: f32| Mat4::from_translation(Vec3::X * x).to_cols_array();
    let inverse = file.floats("MAT4", 16, &[0.0, 0.0, 0.0, 0.0, 0.0, -1.0].map(matrix).concat());
    let joint_nodes: Vec<_> = (0..6).map(|k| format!(r#"{{"translation":[{},0,0]}}"#, 1 << k)).collect();
    let skins = skins.replace("INVERSE", &format!(r#""inverseBindMatrices":{inverse}"#));
    let rest = format!(
        r#""scenes":[{{"nodes":[0,1,2,3,4,5,6,7]}}],"nodes":[{},{nodes}],"skins":[{skins}],"meshes":[{{"primitives":
        [{{"attributes":{{{attributes},"JOINTS_0":{},"WEIGHTS_0":{},"JOINTS_1":{},"WEIGHTS_1":{}}}}}]}}]"#,
        joint_nodes.join(","),
        joints[0],
        sets[0],
        joints[1],
        sets[1]
    );
    (file, rest)
}

#[test]
fn several_joint_sets_and_skins_share_a_mesh() {
    let nodes = r#"{"mesh":0,"skin":0,"translation":[100,100,100]},{"mesh":0,"skin":1,"scale":[9,9,9]}"#;
    let skins = r#"{"joints":[0,1,2,3,4,5],INVERSE},{"joints":[5,4,3,2,1,0]}"#;
    // Shares of two: they are made to sum up to 1.
    let (file, rest) = skinned([0.5, 0.0, 0.5, 0.0, 0.5, 0.5, 0.0, 0.0], nodes, skins);
    let scene = file.load(&rest, 0.0).unwrap();
    let x = |i: usize| {
        let instance = &scene.instances[i];
        instance.world_from_object.transform_point3(scene.meshes[instance.mesh as usize].positions[0]).x
    };
    // A quarter each of joints 0, 2, 4, 5; the last one's inverse bind matrix takes 1 away. The node itself does not count.
    assert!((x(0) - 0.25 * (1.0 + 4.0 + 16.0 + 32.0 - 1.0)).abs() < 1e-5, "{}", x(0));
    assert!((x(1) - 0.25 * (32.0 + 8.0 + 2.0 + 1.0)).abs() < 1e-5, "{}", x(1));
    assert_ne!(scene.instances[0].mesh, scene.instances[1].mesh);
}

#[test]
fn a_mesh_without_skin_is_shared_and_left_alone() {
    let nodes = r#"{"mesh":0,"skin":0},{"mesh":0,"translation":[7,0,0]},{"mesh":0,"translation":[8,0,0]}"#;
    let (file, rest) =
        skinned([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], nodes, r#"{"joints":[0,1,2,3,4,5],INVERSE}"#);
    let scene = file.load(&rest.replace("6,7]}]", "6,7,8]}]"), 0.0).unwrap();
    let [skinned, a, b] = [0, 1, 2].map(|i| scene.instances[i].mesh);
    assert!(a == b && a != skinned);
    assert_eq!(scene.meshes[a as usize].positions[0], Vec3::ZERO);
    assert_eq!(scene.instances[2].world_from_object.translation.x, 8.0);
}

#[test]
fn animated_nodes_move_cameras_and_lights() {
    let mut file = File::default();
    let attributes = file.triangle();
    let times = file.floats("SCALAR", 1, &[0.0, 1.0]);
    let slide = file.floats("VEC3", 3, &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    let (h, quarter) = (std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_PI_2);
    let turn = file.floats("VEC4", 4, &[0.0, 0.0, 0.0, 1.0, 0.0, h, 0.0, h]);
    let vanish = file.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let rest = format!(
        r#""extensionsUsed":["KHR_lights_punctual"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot","spot":{{}},"intensity":5}}]}}}},
        "scenes":[{{"nodes":[0,3]}}],"cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}}}}],
        "nodes":[{{"children":[1,2]}},{{"camera":0,"translation":[0,1,0]}},
          {{"extensions":{{"KHR_lights_punctual":{{"light":0}}}},"translation":[0,2,0]}},{{"mesh":0,"scale":[0,0,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{{attributes}}}}}]}}],
        "animations":[{{"samplers":[{{"input":{times},"output":{slide}}},{{"input":{times},"output":{turn}}},
          {{"input":{times},"output":{vanish}}}],
        "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}},
          {{"sampler":1,"target":{{"node":0,"path":"rotation"}}}},{{"sampler":2,"target":{{"node":3,"path":"scale"}}}}]}}]"#
    );
    let mut scene = file.load(&rest, 0.0).unwrap();
    // What is scaled to nothing at first is there all the same.
    assert_eq!(scene.instances.len(), 1);
    assert!(scene.bounds().unwrap().size().max_element() < 1e-5);
    scene.set_time(0.5, 0.0);
    let eighth = Quat::from_rotation_y(0.5 * quarter);
    let light = &scene.lights[0];
    assert!(light.position.abs_diff_eq(Vec3::new(2.0, 2.0, 0.0), 1e-5), "{light:?}");
    assert!(light.direction.abs_diff_eq(eighth * Vec3::NEG_Z, 1e-5), "{light:?}");
    let camera = scene.cameras[0].at(0.5);
    assert!(camera.position().abs_diff_eq(Vec3::new(2.0, 1.0, 0.0), 1e-5));
    assert!(camera.forward().abs_diff_eq(eighth * Vec3::NEG_Z, 1e-5));
    assert!((scene.bounds().unwrap().size().x - 0.5).abs() < 1e-5);
    scene.validate().unwrap();
}

#[test]
fn channels_without_a_node_are_left_out() {
    let (file, rest) = turning(Component::F32, "LINEAR");
    let first = r#""channels":["#;
    for target in [
        r#"{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/materials/0/emissiveFactor"}}}"#,
        r#"{"path":"translation"}"#,
    ] {
        assert!(rest.contains(first));
        let added = rest.replace(first, &format!(r#"{first}{{"sampler":0,"target":{target}}},"#));
        let (plain, scene) = (file.load(&rest, 2.0).unwrap(), file.load(&added, 2.0).unwrap());
        assert_eq!(scene.instances, plain.instances);
        let left_out = "animations[0].channels[0]: left out, it moves no property of a node";
        assert!(scene.notices.iter().any(|n| n == left_out), "{:?}", scene.notices);
    }
}

#[test]
fn broken_animations_are_refused_by_place() {
    let (file, rest) = turning(Component::F32, "LINEAR");
    for (from, to, place) in [
        (r#""sampler":0"#, r#""sampler":4"#, "animations[0].channels[0].sampler"),
        (r#""node":0"#, r#""node":9"#, "animations[0].channels[0].target.node"),
        (r#""input":2"#, r#""input":3"#, "accessors[3]"),
        (r#""path":"rotation""#, r#""path":"scale""#, "accessors[3]"),
        (r#""output":3"#, r#""output":77"#, "animations[0].samplers[0].output"),
        (r#""interpolation":"LINEAR""#, r#""interpolation":"CUBICSPLINE""#, "2 keys take 12 numbers"),
    ] {
        assert!(rest.contains(from), "{from}");
        let error = file.load(&rest.replace(from, to), 0.0).unwrap_err().to_string();
        assert!(error.contains(place) && !error.contains('\n'), "{error}");
    }
    // A cycle of nodes that no scene reaches is a broken tree too once something may move.
    let cycle = rest
        .replace(r#""translation":[0,0,5]}"#, r#""translation":[0,0,5]},{"children":[2]},{"children":[1]}"#);
    assert!(file.load(&cycle, 0.0).unwrap_err().to_string().contains("nodes[1]"));
    let nodes = r#"{"mesh":0,"skin":0},{"mesh":0,"skin":0}"#;
    let (file, rest) = skinned([0.2; 8], nodes, r#"{"joints":[0,1,2],INVERSE}"#);
    let error = file.load(&rest, 0.0).unwrap_err().to_string();
    assert!(error.contains("names joint 3 of 3"), "{error}");
    let (file, rest) = skinned([0.2; 8], nodes, r#"{"joints":[0,1,2,3,4,50],INVERSE}"#);
    assert!(file.load(&rest, 0.0).unwrap_err().to_string().contains("skins[0].joints"));
}
