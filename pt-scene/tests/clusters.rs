//! The division of space into clusters: invariants on the host, and the kernel against the host to the bit.

use proptest::prelude::*;
use pt_core::SceneResources;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Kernel, Recorder};
use pt_scene::glam::{Affine3A, Vec3, Vec4};
use pt_scene::gpu::GpuScene;
use pt_scene::{Clusters, Instance, Material, Mesh, Motion, Scene, builtin};

#[allow(dead_code, reason = "each test program uses a part")]
mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

/// Triangles anywhere, each a mesh's only one's worth of corners.
fn soup(corners: &[[f32; 3]]) -> Scene {
    let positions: Vec<Vec3> = corners.iter().map(|&c| Vec3::from(c)).collect();
    let n = positions.len() / 3;
    let vertices = 3 * n;
    let mesh = Mesh {
        name: "soup".into(),
        positions: positions[..vertices].to_vec(),
        normals: vec![Vec3::Y; vertices],
        tangents: vec![Vec3::X.extend(1.0); vertices],
        uv0: vec![Default::default(); vertices],
        uv1: vec![Default::default(); vertices],
        colors: vec![Vec4::ONE; vertices],
        indices: (0..n as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        triangle_materials: vec![0; n],
        first_masked: n,
        ..Mesh::default()
    };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance::new("soup", 0, Affine3A::IDENTITY)],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

fn contains(bounds: pt_scene::Bounds, p: Vec3) -> bool {
    p.cmpge(bounds.min).all() && p.cmple(bounds.max).all()
}

fn coordinates() -> impl Strategy<Value = [f32; 3]> {
    // Also several in one plane, and places far apart in scale.
    // From integers: proptest's own 0.999..1.001 fails an assertion of its for a few seeds.
    let steps = |step: f32| (-1_000_000i32..=1_000_000).prop_map(move |i| i as f32 * step);
    let one = prop_oneof![
        steps(1e-5),
        Just(0.0),
        Just(1.0),
        steps(0.1),
        steps(1e-9).prop_map(|offset| 1.0 + offset)
    ];
    [one.clone(), one.clone(), one]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn every_point_is_in_its_cell(
        corners in prop::collection::vec(coordinates(), 3..120),
        points in prop::collection::vec(coordinates(), 1..50),
        target in 1usize..300,
    ) {
        let scene = soup(&corners);
        let clusters = Clusters::new(&scene, target);
        prop_assert!((1..=target).contains(&clusters.count()));
        prop_assert_eq!(clusters.nodes().len(), 2 * clusters.count() - 1);
        for p in points.iter().map(|&p| Vec3::from(p)) {
            let id = clusters.find(p);
            prop_assert!((id as usize) < clusters.count());
            prop_assert!(contains(clusters.cell(id), p), "{} in {:?}", p, clusters.cell(id));
            // In no other cell, but for points in a plane between two.
            let others = (0..clusters.count() as u32).filter(|&c| c != id).map(|c| clusters.cell(c));
            for cell in others {
                prop_assert!(!(p.cmpge(cell.min).all() && p.cmplt(cell.max).all()));
            }
        }
        // The bounds of what is in a cluster hold every point of the triangles that is looked up to it.
        let contents = clusters.contents(&scene);
        let mesh = &scene.meshes[0];
        for t in 0..mesh.triangle_count() {
            let [a, b, c] = mesh.triangle(t);
            for i in 0..=8 {
                for j in 0..=8 - i {
                    let (x, y) = (i as f32 / 8.0, j as f32 / 8.0);
                    let p = a * (1.0 - x - y) + b * x + c * y;
                    let own = contents[clusters.find(p) as usize];
                    prop_assert!(own.triangles > 0, "{} is in an empty cluster", p);
                    prop_assert!(own.bounds.is_some_and(|b| contains(b, p)), "{} outside of {:?}", p, own.bounds);
                }
            }
        }
        let stats = clusters.statistics(&scene);
        prop_assert_eq!(stats.histogram.iter().map(|h| h.1).sum::<usize>(), clusters.count());
        prop_assert_eq!(stats.occupied, contents.iter().filter(|c| c.bounds.is_some()).count());
    }
}

#[test]
fn clusters_do_not_move() {
    let mut scene = builtin("flicker").unwrap();
    let before = Clusters::new(&scene, 200);
    scene.set_time(3.7, 3.6);
    assert_eq!(Clusters::new(&scene, 200), before);
    // And depend on nothing that moves.
    let still = Scene {
        instances: scene
            .instances
            .iter()
            .filter(|i| i.is_static(&scene.meshes[i.mesh as usize]))
            .cloned()
            .collect(),
        ..scene.clone()
    };
    assert_eq!(Clusters::new(&still, 200), before);
    let moving = scene.instances.iter().find(|i| matches!(i.motion, Some(Motion::Slide { .. }))).unwrap();
    let at = |t: f64| before.find(moving.motion.unwrap().at(t).translation.into());
    assert_ne!(at(1.5), at(4.5), "a moving object goes through clusters");
    // Nothing that stands still: one cluster.
    let moves = |i: &Instance| !i.is_static(&scene.meshes[i.mesh as usize]);
    let moving =
        Scene { instances: scene.instances.iter().filter(|&i| moves(i)).cloned().collect(), ..still };
    assert_eq!(Clusters::new(&moving, 200).count(), 1);
    assert_eq!(Clusters::new(&Scene::default(), 200).count(), 1);
}

#[test]
fn cells_follow_the_geometry() {
    for (name, target) in
        [("gallery", Clusters::DEFAULT), ("lamps", 1000), ("cornell", Clusters::MAX), ("textures", 64)]
    {
        let scene = builtin(name).unwrap();
        let clusters = Clusters::new(&scene, target);
        let s = clusters.statistics(&scene);
        println!("{name}: {s:?}");
        assert_eq!(clusters.count(), target);
        assert!(s.occupied as f64 > 0.95 * target as f64);
    }
    // A room of the flat is 5 m wide: with 1000 cells none spans two, and the floor, which is in one plane, is not cut along it.
    let scene = builtin("lamps").unwrap();
    let clusters = Clusters::new(&scene, 1000);
    assert!(clusters.statistics(&scene).cell_size[2] < 5.0);
    for (x, z) in [(1.3, 2.2), (7.4, 7.7), (13.1, 3.9)] {
        let id = |y: f32| clusters.find(Vec3::new(x, y, z));
        assert_eq!(id(-1e-3), id(1e-3), "the floor at {x}, {z} is a border");
    }
}

#[test]
fn the_kernel_agrees_to_the_bit() {
    let device = TestDevice::open();
    let scene = builtin("lamps").unwrap();
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap();
    let kernel = Kernel::compute::<()>(&device, &kernels::CLUSTER_OF, &[]).unwrap();
    for target in [Clusters::DEFAULT, 1, Clusters::MAX] {
        let clusters = Clusters::new(&scene, target);
        if target != Clusters::DEFAULT {
            gpu.set_clusters(&device, &clusters).unwrap();
        }
        // Anywhere in and round the flat, and on both sides of every plane by one unit in the last place.
        let mut points: Vec<Vec3> = (0..6000u32)
            .map(|i| {
                let [x, y, z, _] = pt_core::rng::random4([i, 0], 1, 2, 3);
                Vec3::new(x, y, z) * Vec3::new(20.0, 5.0, 20.0) - 2.5
            })
            .collect();
        for (i, node) in clusters.nodes().iter().enumerate().filter(|(_, n)| n.link & 3 < 3) {
            for value in [node.split.next_down(), node.split, node.split.next_up()] {
                let mut p = points[i % 6000];
                p[(node.link & 3) as usize] = value;
                points.push(p);
            }
        }
        points.extend([Vec3::splat(1e30), Vec3::splat(-1e30), Vec3::ZERO, Vec3::NEG_X * 0.0]);
        let input = Buffer::from_slice(&device, "positions", &points).unwrap();
        let output = Buffer::from_slice(&device, "clusters", &vec![u32::MAX; points.len()]).unwrap();
        let mut recorder = Recorder::new(&device).unwrap();
        let mut frame = recorder.begin().unwrap();
        gpu.update(&mut frame, &scene).unwrap();
        let pass = frame.pass("cluster_of", &kernel).read("positions", &input).write("clusters", &output);
        gpu.bind(pass).dispatch([points.len() as u32, 1, 1]).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        let expected: Vec<u32> = points.iter().map(|&p| clusters.find(p)).collect();
        for ((found, expected), p) in output.read::<u32>().unwrap().iter().zip(&expected).zip(&points) {
            assert_eq!(found, expected, "{target} clusters: {p}");
        }
        let seen: std::collections::BTreeSet<u32> = expected.into_iter().collect();
        assert!(2 * seen.len() >= clusters.count(), "{} of {} seen", seen.len(), clusters.count());
    }
}
