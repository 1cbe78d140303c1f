//! The built-in scenes.

use pt_scene::glam::{Affine3A, Vec3};
use pt_scene::{BUILTIN, Camera, CameraKey, CameraPath, Scene, automatic_camera, builtin};

fn scene(name: &str) -> Scene {
    builtin(name).unwrap()
}

type Change = fn(&mut Scene);

#[test]
fn flaws_are_said_in_words() {
    let flaw = |change: Change| {
        let mut scene = scene("plane");
        change(&mut scene);
        scene.validate().unwrap_err().to_string()
    };
    let cases: [(Change, &str); 4] = [
        (|s| s.lights[0].intensity.x = -1.0, ": intensity -1 is less than 0"),
        (|s| s.lights[0].direction *= 2.0, ": direction "),
        (|s| s.cameras[0].world_from_camera *= Affine3A::from_scale(Vec3::splat(2.0)), ": its transform is"),
        (|s| s.cameras[0].focus_distance = 0.0, ": focus distance 0 is not above 0"),
    ];
    for (change, what) in cases {
        let text = flaw(change);
        assert!(text.contains(what) && !text.contains('{'), "{text}");
    }
}

#[test]
fn all_are_valid_now_and_later_and_lit() {
    for (name, about) in BUILTIN {
        let mut scene = scene(name);
        assert!(!about.is_empty() && scene.name == *name && !scene.is_unlit());
        assert!(!scene.cameras.is_empty());
        for (now, previous) in [(0.0, 0.0), (0.5, 0.4), (1e6, 1e6 - 0.1)] {
            scene.set_time(now, previous);
            scene.validate().unwrap();
        }
    }
    assert!(builtin("nothing").is_none());
}

#[test]
fn the_same_bits_every_time() {
    let (a, b) = (scene("gallery"), scene("gallery"));
    assert_eq!(a.meshes, b.meshes);
    assert_eq!(a.textures, b.textures);
}

#[test]
fn cornell_has_its_classic_measures() {
    let scene = scene("cornell");
    let s = scene.statistics();
    assert_eq!((s.triangles, s.emissive_triangles), (32, 2));
    let b = scene.bounds().unwrap();
    assert!(b.size().abs_diff_eq(Vec3::new(0.556, 0.5488, 0.5592), 1e-4), "{}", b.size());
    let lamp = scene.meshes.iter().find(|m| m.name == "lamp").unwrap();
    assert!(lamp.normals.iter().all(|n| n.abs_diff_eq(Vec3::NEG_Y, 1e-5)), "the lamp shines down");
    let [a, b, c] = lamp.triangle(0);
    assert!(((b - a).cross(c - a).length() - 0.13 * 0.105).abs() < 1e-6);
    // Red on the left, green on the right of the picture.
    let room = scene.meshes.iter().find(|m| m.name == "room").unwrap();
    let side = |name: &str| {
        let t =
            room.triangle_materials.iter().position(|&m| scene.materials[m as usize].name == name).unwrap();
        room.triangle(t).iter().sum::<Vec3>() / 3.0 - scene.cameras[0].position()
    };
    assert!(side("red").x < -0.2 && side("green").x > 0.2);
}

#[test]
fn lamps_are_many() {
    let s = scene("lamps").statistics();
    println!("{s:?}");
    assert!(s.emissive_triangles >= 400);
}

#[test]
fn gallery_is_rich_and_moves() {
    let mut scene = scene("gallery");
    let s = scene.statistics();
    println!("{s:?}");
    assert!((100_000..=300_000).contains(&s.instanced_triangles));
    assert!(s.emissive_triangles > 200 && s.masked_triangles > 1000);
    let some = |f: fn(&pt_scene::Material) -> bool| scene.materials.iter().any(f);
    assert!(
        some(|m| m.transmission > 0.0 && m.thickness > 0.0)
            && some(|m| m.transmission > 0.0 && m.thickness == 0.0)
    );
    assert!(some(|m| m.metallic == 1.0 && m.roughness == 0.0) && some(|m| m.normal_texture.is_some()));
    scene.set_time(1.0, 0.5);
    let moved = scene.instances.iter().filter(|i| i.world_from_object != i.world_from_object_prev).count();
    assert!(moved >= 3, "{moved} instances move");
    let before: Vec<_> = scene.instances.iter().map(|i| i.world_from_object_prev).collect();
    scene.set_time(0.5, 0.0);
    assert!(scene.instances.iter().map(|i| i.world_from_object).eq(before), "time is a pure function");
    let tour = scene.cameras.iter().find(|c| c.name == "tour").unwrap();
    assert!(tour.path.as_ref().unwrap().duration() >= 10.0);
}

#[test]
fn textures_of_the_gallery_tile() {
    // Across the seam of a repeating texture, neighbours differ no more than they do elsewhere.
    for t in scene("gallery")
        .textures
        .iter()
        .filter(|t| ["stone", "plaster", "plaster relief"].contains(&t.name.as_str()))
    {
        let differs = |x: u32| -> f32 {
            (0..t.height).map(|y| (t.texel(x, y)[0] - t.texel((x + 1) % t.width, y)[0]).abs()).sum::<f32>()
                / t.height as f32
        };
        let usual = (0..t.width - 1).map(differs).fold(0.0, f32::max);
        assert!(
            differs(t.width - 1) <= 1.2 * usual,
            "{}: {} at the seam, {usual} at most elsewhere",
            t.name,
            differs(t.width - 1)
        );
    }
}

#[test]
fn paths_pass_through_their_stations_smoothly() {
    let key = |time: f64, x: f32| CameraKey {
        time,
        position: Vec3::new(x, 1.0, 0.0),
        target: Vec3::new(x, 1.0, -1.0),
    };
    let path = CameraPath::new(vec![key(0.0, 0.0), key(1.0, 2.0), key(3.0, 3.0)]).unwrap();
    for key in path.keys() {
        assert!(path.at(key.time).0.abs_diff_eq(key.position, 1e-5));
    }
    let speed = |t: f64| (path.at(t + 1e-3).0.x - path.at(t).0.x) / 1e-3;
    assert!((speed(0.999) - speed(1.001)).abs() < 0.02, "{} {}", speed(0.999), speed(1.001));
    assert_eq!(path.at(-1.0), path.at(0.0));
    assert_eq!(path.at(99.0), path.at(3.0));
    assert!(CameraPath::new(vec![key(0.0, 0.0), key(0.0, 1.0)]).is_none());
    let camera = Camera::on_path("c", path, 1.0);
    assert!(camera.at(1.0).position().abs_diff_eq(Vec3::new(2.0, 1.0, 0.0), 1e-5));
    assert!(camera.at(1.0).forward().abs_diff_eq(Vec3::NEG_Z, 1e-5));
}

#[test]
fn validation_names_what_is_wrong() {
    let broken = |change: fn(&mut Scene), expected: &str| {
        let mut scene = scene("cornell");
        change(&mut scene);
        let text = scene.validate().expect_err(expected).to_string();
        assert!(text.contains(expected), "{text}");
    };
    broken(|s| s.meshes[0].indices[3][1] = 9999, "triangle 3");
    broken(|s| s.meshes[0].triangle_materials[2] = 77, "material");
    broken(|s| s.meshes[0].positions[1].y = f32::NAN, "vertex 1");
    broken(|s| s.meshes[0].first_masked = 0, "first_masked");
    broken(|s| s.instances[0].mesh = 50, "mesh 50");
    broken(|s| s.instances[0].world_from_object.matrix3.x_axis *= 0.0, "invertible");
    broken(|s| s.materials[0].roughness = 2.0, "roughness");
    broken(|s| s.materials[0].base_color_texture = Some(pt_scene::TextureRef::new(3)), "texture 3");
}

#[test]
fn a_mirrored_room_is_still_seen_from_within() {
    let mut room = scene("lamps");
    room.cameras.clear();
    let within = |scene: &Scene| {
        let (bounds, camera) = (scene.bounds().unwrap(), automatic_camera(scene));
        let eye = camera.position();
        assert!(eye.cmpgt(bounds.min).all() && eye.cmplt(bounds.max).all(), "{eye} in {bounds:?}");
        camera
    };
    let camera = within(&room);
    for instance in &mut room.instances {
        instance.world_from_object =
            Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * instance.world_from_object;
    }
    // As far up as before.
    assert!((within(&room).position().y - camera.position().y).abs() < 1e-3);
}
