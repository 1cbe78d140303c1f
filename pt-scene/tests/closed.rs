//! Closed bodies and clear paths of the built-in scenes.

use std::collections::BTreeMap;

use pt_core::trace::NativeScene;
use pt_scene::glam::Vec3;
use pt_scene::gpu::{mesh_geometry, placements};
use pt_scene::{BUILTIN, Mesh, Scene, builtin};
use pt_shaders::records::{NONE, Ray};

fn scene(name: &str) -> Scene {
    builtin(name).unwrap()
}

type Corner = [u32; 3];

fn corner(p: Vec3) -> Corner {
    // -0 and 0 are one place.
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// Every edge of a closed surface is gone through as often in one direction as in the other, and it encloses a volume
/// (positive: it faces outwards).
fn enclosed_volume(triangles: impl Iterator<Item = [Vec3; 3]>) -> Result<f64, String> {
    let mut balance: BTreeMap<(Corner, Corner), i32> = BTreeMap::new();
    let mut volume = 0.0;
    for t in triangles {
        for i in 0..3 {
            let (a, b) = (corner(t[i]), corner(t[(i + 1) % 3]));
            if a == b {
                return Err(format!("a triangle has two corners at {}", t[i]));
            }
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
        let [a, b, c] = t.map(|p| p.as_dvec3());
        volume += a.dot(b.cross(c)) / 6.0;
    }
    let open = balance.iter().find(|&(_, &n)| n != 0);
    match open {
        Some(((a, b), n)) => {
            let place = |c: &Corner| Vec3::from(c.map(f32::from_bits));
            Err(format!("the edge {} - {} is {n} short", place(a), place(b)))
        }
        None => Ok(volume),
    }
}

#[test]
fn a_missing_or_displaced_triangle_is_noticed() {
    let scene = scene("glass");
    let mesh = scene.meshes.iter().find(|m| m.name == "ice").unwrap();
    let mut triangles: Vec<_> = triangles_of(mesh, |_| true).collect();
    enclosed_volume(triangles.iter().copied()).unwrap();
    enclosed_volume(triangles[1..].iter().copied()).unwrap_err();
    triangles[0][0].x = triangles[0][0].x.next_up();
    enclosed_volume(triangles.into_iter()).unwrap_err();
}

fn triangles_of(mesh: &Mesh, keep: impl Fn(u32) -> bool) -> impl Iterator<Item = [Vec3; 3]> {
    (0..mesh.triangle_count()).filter(move |&t| keep(mesh.triangle_materials[t])).map(|t| mesh.triangle(t))
}

#[test]
fn solids_are_closed_and_face_outwards() {
    let mut checked = 0;
    for (name, _) in BUILTIN.iter().filter(|(name, _)| *name != "glass-gapless") {
        let scene = scene(name);
        let single = |m: u32| scene.materials[m as usize].exterior.is_none();
        for (m, material) in scene.materials.iter().enumerate() {
            // The ball of the gallery is older and has seams of a few nanometres.
            if material.transmission == 0.0 || material.thickness == 0.0 || *name == "gallery" {
                continue;
            }
            for mesh in scene.meshes.iter().filter(|mesh| mesh.triangle_materials.contains(&(m as u32))) {
                let volume = enclosed_volume(triangles_of(mesh, |t| t == m as u32 && single(t)));
                let volume = volume.unwrap_or_else(|e| panic!("{name}, {}: {e}", material.name));
                assert!(volume > 0.0, "{name}, {}: inside out", material.name);
                checked += 1;
            }
        }
    }
    assert!(checked >= 7, "{checked}");
}

#[test]
fn bodies_of_the_ground_truth_scenes_are_closed() {
    for (name, bodies) in [("furnace", 33), ("veach", 8), ("glass", 3)] {
        let scene = scene(name);
        let closed = scene.meshes.iter().filter(|m| !["room", "table"].contains(&m.name.as_str()));
        let volumes: Vec<f64> = closed
            .map(|m| enclosed_volume(triangles_of(m, |_| true)).unwrap_or_else(|e| panic!("{}: {e}", m.name)))
            .collect();
        assert_eq!(volumes.len(), bodies, "{name}");
        assert!(volumes.iter().all(|&v| v > 0.0), "{name}: {volumes:?}");
    }
}

#[test]
fn the_gapless_interfaces_bound_the_same_solids() {
    let (overlapping, gapless) = (scene("glass"), scene("glass-gapless"));
    let mesh = gapless.meshes.iter().find(|m| m.name == "interfaces").unwrap();
    let of = |name: &str| gapless.materials.iter().position(|m| m.name == name).unwrap() as u32;
    // A solid is bounded by what has it behind, and by what has it in front, turned round.
    let solid = |name: &str| {
        let (medium, wet) = (of(name), format!("{name} to water"));
        let behind = triangles_of(mesh, |m| {
            gapless.materials[m as usize].name == name || gapless.materials[m as usize].name == wet
        });
        let front = triangles_of(mesh, |m| gapless.materials[m as usize].exterior == Some(medium));
        let turned = front.map(|[a, b, c]| [a, c, b]);
        enclosed_volume(behind.chain(turned)).unwrap_or_else(|e| panic!("{name}: {e}"))
    };
    let whole = |name: &str| {
        let mesh = overlapping.meshes.iter().find(|m| m.name == name).unwrap();
        enclosed_volume(triangles_of(mesh, |_| true)).unwrap()
    };
    for name in ["glass", "ice"] {
        assert!(
            (solid(name) / whole(name) - 1.0).abs() < 1e-5,
            "{name}: {} for {}",
            solid(name),
            whole(name)
        );
    }
    // What is left to the water between the wall and the ice, in litres.
    let water = 1e3 * solid("water");
    let polygon = 128.0 / 2.0 * (std::f64::consts::TAU / 128.0).sin();
    let brim = 1e3 * polygon * 0.031f64.powi(2) * (0.072 - 0.010);
    println!("water {water:.4} l of {brim:.4} l with the ice in it");
    assert!(water < brim - 1e3 * 2.0 * 0.016f64.powi(3) && water > brim - 1e3 * 3.0 * 0.016f64.powi(3));
    // Two solids on each side of every interface, and the one in front is another.
    for m in gapless.materials.iter().filter(|m| m.exterior.is_some()) {
        assert!(m.transmission == 1.0 && gapless.materials[m.exterior.unwrap() as usize].name == "water");
    }
}

#[test]
fn ice_floats_free_and_water_reaches_into_the_wall() {
    let scene = scene("glass");
    let mesh = |name: &str| scene.meshes.iter().find(|m| m.name == name).unwrap();
    let radius = |p: &Vec3| p.x.hypot(p.z);
    let ice = mesh("ice");
    assert!(ice.positions.iter().all(|p| radius(p) < 0.0305 && p.y > 0.012));
    assert!(ice.positions.iter().any(|p| p.y > 0.073), "no ice over the water");
    let reach = mesh("water").positions.iter().map(radius).fold(0.0, f32::max);
    assert!(reach > 0.0315 && reach < 0.0335, "{reach}");
    let rank = |name: &str| scene.materials.iter().find(|m| m.name == name).unwrap().priority;
    assert!(rank("glass") > rank("ice") && rank("ice") > rank("water"));
    // 24 corners of a cube: no two cubes come nearer than their circumscribed spheres allow.
    let centers: Vec<Vec3> = ice.positions.chunks(24).map(|c| c.iter().sum::<Vec3>() / 24.0).collect();
    assert_eq!(centers.len(), 3);
    for (i, a) in centers.iter().enumerate() {
        assert!(centers[..i].iter().all(|b| a.distance(*b) > 0.016 * 3f32.sqrt()), "cubes touch");
    }
}

/// Spread evenly over the sphere (Gonzalez 2010).
fn directions(n: usize) -> impl Iterator<Item = Vec3> {
    (0..n).map(move |i| {
        let y = 1.0 - (2 * i + 1) as f32 / n as f32;
        let (sin, cos) = (2.399_963 * i as f32).sin_cos();
        let r = (1.0 - y * y).sqrt();
        Vec3::new(r * cos, y, r * sin)
    })
}

#[test]
fn camera_paths_keep_clear_of_everything() {
    const MARGIN: f32 = 0.1;
    let mut paths = 0;
    for (name, _) in BUILTIN {
        let mut scene = scene(name);
        let cameras: Vec<_> = scene.cameras.iter().filter(|c| c.path.is_some()).cloned().collect();
        if cameras.is_empty() {
            continue;
        }
        let geometry = scene.clone();
        let geometry = mesh_geometry(&geometry);
        let mut native = NativeScene::new(&geometry, &placements(&scene), Default::default()).unwrap();
        for camera in cameras {
            let duration = camera.path.as_ref().unwrap().duration();
            let step = 1.0 / 30.0;
            let (mut before, mut forward) = (camera.at(0.0).position(), camera.at(0.0).forward());
            for frame in 0..=(duration / step) as u32 {
                let t = f64::from(frame) * step;
                scene.set_time(t, t);
                native.place(&placements(&scene)).unwrap();
                let at = camera.at(t);
                let here = at.position();
                for d in directions(96) {
                    let ray = Ray { origin: here, t_min: 0.0, direction: d, t_max: MARGIN };
                    let hit = native.closest(&ray, u32::MAX, None);
                    let what = || scene.instances[hit.instance as usize].name.clone();
                    assert!(
                        hit.instance == NONE,
                        "{name}, {}, {t:.2} s: {} is {:.2} m away at {here}",
                        camera.name,
                        what(),
                        hit.t
                    );
                }
                let travelled = here - before;
                if travelled.length() > 1e-6 {
                    let ray = Ray { origin: before, t_min: 0.0, direction: travelled, t_max: 1.0 };
                    assert!(
                        !native.occluded(&ray, u32::MAX, None),
                        "{name}, {}, {t:.2} s: through a wall",
                        camera.name
                    );
                }
                // Walking pace, and no jerk of the head: at most 4 m/s and 120 degrees a second.
                assert!(travelled.length() < 4.0 * step as f32, "{name}, {}, {t:.2} s: a leap", camera.name);
                let turn = forward.angle_between(at.forward());
                assert!(
                    turn < 120f32.to_radians() * step as f32,
                    "{name}, {}, {t:.2} s: turns {turn}",
                    camera.name
                );
                (before, forward) = (here, at.forward());
            }
            paths += 1;
        }
    }
    assert_eq!(paths, 5);
}

#[test]
fn flicker_is_a_function_of_time() {
    let mut a = scene("flicker");
    let mut b = a.clone();
    assert!(a.is_animated() && !scene("cornell").is_animated());
    a.set_time(7.3, 7.2);
    b.set_time(1.0, 0.5);
    b.set_time(7.3, 7.2);
    assert_eq!(a.lights, b.lights);
    assert_eq!(a.instances, b.instances);
    let light = |name: &str, t: f64| a.lights.iter().find(|l| l.name == name).unwrap().at(t);
    assert!(light("orbiter", 0.0).position.distance(light("orbiter", 0.5).position) > 0.5);
    assert!(light("orbiter", 0.0).position.abs_diff_eq(light("orbiter", 3.0).position, 1e-5), "3 s a turn");
    assert!(light("alarm", 0.1).intensity.x > 0.0 && light("alarm", 0.6).intensity == Vec3::ZERO);
    assert!(light("search light", 1.0).direction.angle_between(light("search light", 3.0).direction) > 0.5);
    let flames: Vec<f32> = (0..100).map(|i| light("flame", 0.05 * f64::from(i)).intensity.x / 9.0).collect();
    assert!(flames.iter().all(|&f| (0.35..=1.0).contains(&f)));
    assert!(
        flames.windows(2).any(|w| (w[0] - w[1]).abs() > 0.05)
            && flames.windows(2).all(|w| (w[0] - w[1]).abs() < 0.5)
    );
    // Long runs stay in range.
    assert_eq!(light("flame", 1e9).intensity, light("flame", 1e9).intensity);
    assert!(light("flame", 1e9).intensity.is_finite());
    let moved = a.instances.iter().filter(|i| i.world_from_object != i.world_from_object_prev).count();
    assert!(moved >= 5, "{moved}");
}

#[test]
fn lamps_of_the_plates_have_equal_power() {
    let scene = scene("veach");
    let mut powers = Vec::new();
    for mesh in &scene.meshes {
        let material = &scene.materials[mesh.triangle_materials[0] as usize];
        if material.is_emissive() {
            let area: f32 = (0..mesh.triangle_count())
                .map(|t| mesh.triangle(t))
                .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
                .sum();
            powers.push(std::f32::consts::PI * area * material.emissive.x);
        }
    }
    assert_eq!(powers.len(), 4);
    assert!(powers.iter().all(|p| (p / 40.0 - 1.0).abs() < 1e-4), "{powers:?}");
}
