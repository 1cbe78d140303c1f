//! Animated scenes of the shared test data: poses against values that another program computed.

use std::path::Path;

use pt_import::{LoadOptions, load};
use pt_scene::glam::{Affine3A, DVec3, Quat, Vec3};
use pt_scene::{AnimationChoice, Scene};
use pt_test_data::shared;

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
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn shared_scenes_take_their_poses() {
    let folder = shared("scenes");
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
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn bounds_of_deformations_hold_every_vertex() {
    let folder = shared("scenes");
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
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn animations_are_chosen_by_name_index_or_all() {
    let folder = shared("scenes");
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
    assert!(pt_import::open("cornell", &options).is_err());
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn previous_transforms_are_the_last_ones_to_the_bit() {
    let folder = shared("scenes");
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

/// Compressed meshes below animated nodes: sizes and bounds are those that the file tells of the original vertices, rotations those of
/// its keys, interpolated by another program.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_truck_of_draco_meshes_turns_its_wheels() {
    let folder = shared("scenes");
    let file = folder.join("CesiumMilkTruck_Draco/CesiumMilkTruck.gltf");
    let upright = Affine3A::from_quat(Quat::from_array([0.5, -0.5, 0.5, 0.5]));
    for (time, [y, w]) in
        [(0.3, [-0.7320449, 0.6812564]), (0.9, [0.7544643, 0.6563411]), (1.2, [0.1218168, 0.9925527])]
    {
        let scene = at(&file, AnimationChoice::Compatible, time);
        let mesh = |name: &str| scene.meshes.iter().position(|mesh| mesh.name == name).unwrap();
        let (wheels, body) = (mesh("Wheels"), mesh("Cesium_Milk_Truck"));
        for (mesh, triangles, low, high) in [
            (wheels, 768, [-0.428834, -1.059034, -0.428834], [0.429144, 1.059034, 0.429144]),
            (body, 2088, [-2.433289, -1.398379, -2.586748], [2.440379, 1.398807, -0.265275]),
        ] {
            let mesh = &scene.meshes[mesh];
            assert_eq!(mesh.triangle_count(), triangles);
            let min = mesh.positions.iter().copied().reduce(Vec3::min).unwrap();
            let max = mesh.positions.iter().copied().reduce(Vec3::max).unwrap();
            // The encoder gave the bounds a margin of one step of its 11-bit grid on each side.
            let (low, high) = (Vec3::from(low), Vec3::from(high));
            let step = (high - low).max_element() / 2049.0;
            assert!(min.abs_diff_eq(low + step, 2e-5) && max.abs_diff_eq(high - step, 2e-5), "{min} {max}");
        }
        let turned = Quat::from_xyzw(0.0, y, 0.0, w);
        for (name, x) in [("Wheels", 1.432_67), ("Wheels.001", -1.352_33)] {
            let wheel = scene.instances.iter().find(|i| i.name == name).unwrap();
            let offset = Vec3::new(x, 0.0, -0.427_722);
            let expected = upright * Affine3A::from_rotation_translation(turned, offset);
            assert_eq!(wheel.mesh as usize, wheels);
            assert!(wheel.world_from_object.abs_diff_eq(expected, 1e-5), "{name} at {time}: {wheel:?}");
        }
        let truck = scene.instances.iter().find(|i| i.mesh as usize == body).unwrap();
        assert!(truck.world_from_object.abs_diff_eq(upright, 1e-6));
    }
}
