//! Animated scene files: poses against values that another program computed, every interpolation and component type,
//! joints and morph targets in all forms.

mod common;

use std::fmt::Write as _;
use std::path::Path;

use common::shared;
use pt_scene::glam::{Affine3A, DVec3, Mat4, Quat, Vec3};
use pt_scene::{AnimationChoice, LoadOptions, Scene, load};

fn at(path: &Path, animation: AnimationChoice, time: f64) -> Scene {
    load(path, &LoadOptions { animation, time, ..LoadOptions::default() }).unwrap()
}

/// Triangle corners of all instances, world space.
fn corners(scene: &Scene) -> Vec<Vec3> {
    let place = |i: &pt_scene::Instance| {
        let mesh = &scene.meshes[i.mesh as usize];
        let corner = |&v: &u32| i.world_from_object.transform_point3(mesh.positions[v as usize]);
        mesh.indices.iter().flatten().map(corner).collect::<Vec<_>>()
    };
    scene.instances.iter().flat_map(place).collect()
}

/// File, animation (-1: all), time, and of all triangle corners the smallest, the largest and the mean coordinates, made by a
/// program of its own in double precision with 4x4 matrices.
#[expect(clippy::type_complexity, reason = "a table")]
const POSES: &[(&str, i32, f64, [f32; 3], [f32; 3], [f32; 3])] = &[
    (
        "AnimatedCube/AnimatedCube.gltf",
        -1,
        0.0,
        [-1.00000, -1.00000, -1.00000],
        [1.00000, 1.00000, 1.00000],
        [0.00000, 0.00000, 0.00000],
    ),
    (
        "AnimatedCube/AnimatedCube.gltf",
        -1,
        0.3,
        [-1.39680, -1.00000, -1.39680],
        [1.39680, 1.00000, 1.39680],
        [0.00000, 0.00000, 0.00000],
    ),
    (
        "AnimatedCube/AnimatedCube.gltf",
        -1,
        1.7,
        [-1.39680, -1.00000, -1.39680],
        [1.39680, 1.00000, 1.39680],
        [0.00000, 0.00000, 0.00000],
    ),
    (
        "BoxAnimated/BoxAnimated.gltf",
        -1,
        0.0,
        [-0.50000, -0.50000, -0.50000],
        [0.50000, 0.50000, 0.50000],
        [0.00001, -0.00784, -0.00179],
    ),
    (
        "BoxAnimated/BoxAnimated.gltf",
        -1,
        1.1,
        [-0.50000, -0.50000, -0.50000],
        [0.50000, 2.71760, 0.50000],
        [0.00001, 0.53346, -0.00179],
    ),
    (
        "BoxAnimated/BoxAnimated.gltf",
        -1,
        3.0,
        [-0.50000, -0.50000, -0.50000],
        [0.50000, 1.97724, 0.50000],
        [0.00001, 0.35273, -0.00004],
    ),
    (
        "AnimatedMorphCube/AnimatedMorphCube.gltf",
        -1,
        0.0,
        [-1.00000, -1.00000, -1.00000],
        [1.00000, 1.00000, 1.00000],
        [0.00000, 0.00000, 0.00000],
    ),
    (
        "AnimatedMorphCube/AnimatedMorphCube.gltf",
        -1,
        1.0,
        [-1.00000, -1.00000, -1.00000],
        [1.00000, 1.00000, -0.29422],
        [0.00000, 0.00000, -0.64711],
    ),
    (
        "AnimatedMorphCube/AnimatedMorphCube.gltf",
        -1,
        2.9,
        [-1.00000, -1.00000, -1.00000],
        [1.00000, 1.00000, 0.65816],
        [0.00000, 0.00000, -0.57840],
    ),
    (
        "InterpolationTest/InterpolationTest.gltf",
        -1,
        0.0,
        [-4.31140, -2.15946, -1.00000],
        [4.34012, 7.66523, 1.00894],
        [0.00819, 3.23963, 0.01923],
    ),
    (
        "InterpolationTest/InterpolationTest.gltf",
        -1,
        0.45,
        [-4.72331, -2.15946, -1.00000],
        [4.74925, 10.9273, 1.00367],
        [0.00819, 3.93193, 0.01923],
    ),
    (
        "InterpolationTest/InterpolationTest.gltf",
        -1,
        1.3,
        [-4.72042, -2.15946, -1.00000],
        [4.74831, 11.0000, 1.00367],
        [0.00819, 4.26886, 0.01923],
    ),
    (
        "MorphPrimitivesTest/MorphPrimitivesTest.gltf",
        -1,
        0.0,
        [-0.50000, 0.00000, -0.50000],
        [0.50000, 0.10000, 0.50000],
        [0.00000, 0.05625, 0.00000],
    ),
    (
        "SimpleSkin/SimpleSkin.gltf",
        -1,
        0.0,
        [-0.50000, 0.00000, 0.00000],
        [0.50000, 2.00000, 0.00000],
        [0.00000, 1.00000, 0.00000],
    ),
    (
        "SimpleSkin/SimpleSkin.gltf",
        -1,
        0.7,
        [-1.11800, 0.00000, 0.00000],
        [0.54311, 1.89930, 0.00000],
        [-0.17847, 0.91614, 0.00000],
    ),
    (
        "SimpleSkin/SimpleSkin.gltf",
        -1,
        3.2,
        [-0.53252, 0.00000, 0.00000],
        [0.78470, 2.10560, 0.00000],
        [0.05695, 0.98437, 0.00000],
    ),
    (
        "CesiumMan/CesiumMan.gltf",
        -1,
        0.0,
        [-0.31051, -0.01065, -0.44659],
        [0.19466, 1.44716, 0.44989],
        [-0.05055, 0.98134, 0.03886],
    ),
    (
        "CesiumMan/CesiumMan.gltf",
        -1,
        0.55,
        [-0.24331, 0.02470, -0.43402],
        [0.19367, 1.49488, 0.39984],
        [-0.01180, 1.01124, 0.02065],
    ),
    (
        "CesiumMan/CesiumMan.gltf",
        -1,
        1.9,
        [-0.28850, -0.02267, -0.45119],
        [0.18745, 1.44436, 0.45391],
        [-0.05761, 0.97977, 0.05108],
    ),
    (
        "Fox/Fox.glb",
        0,
        0.0,
        [-29.8998, -0.13068, -84.3404],
        [11.5953, 74.6421, 56.6529],
        [-3.26658, 32.1693, -2.83156],
    ),
    (
        "Fox/Fox.glb",
        0,
        1.25,
        [-11.5972, -0.13096, -82.7599],
        [26.5595, 75.8633, 57.6329],
        [3.10110, 32.2723, -2.57032],
    ),
    (
        "Fox/Fox.glb",
        1,
        0.3,
        [-12.6409, -1.11315, -91.4482],
        [12.5445, 75.4747, 69.9818],
        [-0.05143, 34.3482, -1.16479],
    ),
    (
        "Fox/Fox.glb",
        2,
        7.0,
        [-14.3305, -3.19555, -91.9525],
        [14.1415, 75.5638, 72.1543],
        [-0.45995, 32.3830, 2.74352],
    ),
];

#[test]
fn shared_scenes_take_their_poses() {
    let Some(folder) = shared("scenes") else { return };
    for (file, animation, time, low, high, mean) in POSES {
        let choice = usize::try_from(*animation).map_or(AnimationChoice::All, AnimationChoice::Index);
        let scene = at(&folder.join(file), choice.clone(), *time);
        // The same by way of another time.
        let mut moved = at(&folder.join(file), choice, 0.1);
        moved.set_time(*time, 0.0);
        moved.pose_meshes();
        for scene in [scene, moved] {
            let corners = corners(&scene);
            let bounds = scene.bounds().unwrap();
            let scale = bounds.size().max_element();
            let center = corners.iter().map(|c| c.as_dvec3()).sum::<DVec3>() / corners.len() as f64;
            for (got, expected) in [(bounds.min, low), (bounds.max, high), (center.as_vec3(), mean)] {
                let error = got.distance(Vec3::from_array(*expected));
                // The table has five digits behind the point, four from 10 on; single precision has seven.
                assert!(error < 2e-5 + 2e-6 * scale, "{file} at {time}: {got} for {expected:?}");
            }
        }
    }
}

#[test]
fn bounds_of_deformations_hold_every_vertex() {
    let Some(folder) = shared("scenes") else { return };
    for (file, animation, time, ..) in POSES {
        let choice = usize::try_from(*animation).map_or(AnimationChoice::All, AnimationChoice::Index);
        let scene = at(&folder.join(file), choice, *time);
        for mesh in &scene.meshes {
            let Some(deformation) = &mesh.deformation else { continue };
            let bounds = deformation.bounds().unwrap();
            for p in &mesh.positions {
                assert!(
                    p.cmpge(bounds.min).all() && p.cmple(bounds.max).all(),
                    "{file}: {p} outside {bounds:?}"
                );
            }
        }
    }
}

#[test]
fn animations_are_chosen_by_name_index_or_all() {
    let Some(folder) = shared("scenes") else { return };
    let fox = folder.join("Fox/Fox.glb");
    let playing =
        |choice| -> Vec<bool> { at(&fox, choice, 0.0).animations.iter().map(|a| a.plays).collect() };
    assert_eq!(playing(AnimationChoice::Compatible), [true, false, false]);
    assert_eq!(playing(AnimationChoice::Name("Walk".into())), [false, true, false]);
    assert_eq!(playing(AnimationChoice::Index(2)), [false, false, true]);
    assert_eq!(playing(AnimationChoice::All), [true, true, true]);
    assert_eq!(playing(AnimationChoice::None), [false; 3]);
    // Each of the nine moves another cube.
    let cubes =
        at(&folder.join("InterpolationTest/InterpolationTest.gltf"), AnimationChoice::Compatible, 0.0);
    assert!(cubes.animations.len() == 9 && cubes.animations.iter().all(|a| a.plays));
    let still = at(&fox, AnimationChoice::None, 0.0);
    assert!(still.rig.is_none() && still.meshes.iter().all(|m| m.deformation.is_none()));
    for (choice, named) in
        [(AnimationChoice::Index(3), "animation 3"), (AnimationChoice::Name("Fly".into()), "\"Fly\"")]
    {
        let error =
            load(&fox, &LoadOptions { animation: choice, ..LoadOptions::default() }).unwrap_err().to_string();
        assert!(error.contains(named) && error.contains("1 \"Walk\""), "{error}");
    }
    let options = LoadOptions { animation: AnimationChoice::Index(0), ..LoadOptions::default() };
    assert!(pt_scene::open("cornell", &options).is_err());
}

#[test]
fn previous_transforms_are_the_last_ones_to_the_bit() {
    let Some(folder) = shared("scenes") else { return };
    let file = folder.join("BoxAnimated/BoxAnimated.gltf");
    let mut scene = at(&file, AnimationChoice::Compatible, 0.0);
    let transforms =
        |scene: &Scene| -> Vec<Affine3A> { scene.instances.iter().map(|i| i.world_from_object).collect() };
    let previous = |scene: &Scene| -> Vec<Affine3A> {
        scene.instances.iter().map(|i| i.world_from_object_prev).collect()
    };
    scene.set_time(3.0, 3.0);
    assert_eq!(transforms(&scene), previous(&scene));
    let (mut last, mut last_time, mut moved) = (transforms(&scene), 3.0, 0);
    // Over the end of the animation and its beginning again.
    for frame in 1..90 {
        let time = 3.0 + f64::from(frame) / 60.0;
        scene.set_time(time, last_time);
        assert_eq!(previous(&scene), last);
        moved += usize::from(last != transforms(&scene));
        (last, last_time) = (transforms(&scene), time);
    }
    assert!(moved > 40, "{moved}");
}

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
