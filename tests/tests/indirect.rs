//! Indirect light of whole frames: a furnace whose light is known bounce by bounce, and the reference path tracer with paths of the same
//! length. Numbers of different frames are independent, so the frames' own means give the standard error.

mod channels;
mod reuse;
mod surfaces;
mod vertex;

use crate::common;
use crate::common::{Mean, assert_same, frames_mean, frames_means, furnace, params, reference_mean};
use glam::{Affine3A, DVec3, Quat, Vec3};
use pt_core::trace::TraceBackend;
use pt_scene::{Camera, Light, Lobes, Material, Scene};
use pt_shaders::channels::{COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC, FLAT_COLOR};
use pt_shaders::records::EmissionShare;
use pt_tests::{Frames, builtin};

/// In a closed box whose walls emit e and reflect a share a, every bounce adds the light of the one before times a: with B bounces each
/// pixel is e (1 + a + ... + a^(B + 1)).
#[test]
fn the_furnace_is_known_bounce_by_bounce() {
    let (emission, albedo) = (DVec3::new(0.5, 0.3, 0.2), DVec3::new(0.5, 0.7, 0.2));
    let (scene, camera) = furnace(emission.as_vec3(), albedo.as_vec3());
    let exact = |bounces: i32| {
        let sum: DVec3 = (0..=bounces + 1).map(|n| albedo.map(|a| a.powi(n))).sum();
        Mean { mean: emission * sum, error: DVec3::ZERO }
    };
    // Triangles sampled uniformly in area have no finite variance near the edges of the box.
    let means = |bounces: &str, sets: &[&str]| {
        let with = |set: &str| {
            let bounces = format!("indirect.bounces={bounces}");
            let direct = ["lights.rays=merged", "lights.sampler=power", "lights.area_sampling=spherical"];
            params(&[&direct[..], &[&bounces, set]].concat())
        };
        let params: Vec<_> = sets.iter().map(|set| with(set)).collect();
        frames_means(&scene, &camera, [12, 12], 64, &params)
    };
    // 16 bits of base colour.
    let check = |what: &str, found: Mean, bounces: i32| assert_same(what, found, exact(bounces), 1e-4);
    check("16 bounces", means("16", &["indirect.sh=true"])[0], 16);
    // Every other row with twice the weight: the same mean, for surfaces without specular lobes.
    check("half a bounce", means("0.5", &["indirect.sh=true"])[0], 1);
    let sets = ["indirect.sh=true", "indirect.sh=false", "indirect.hemisphere=uniform"];
    for (set, found) in sets.iter().zip(means("1", &sets)) {
        check(set, found, 1);
    }
}

/// Spherical harmonics keep the energy of the light that was sampled: with the normal of the pixel they give what plain colours give, sample
/// by sample.
#[test]
fn spherical_harmonics_keep_the_energy_of_each_sample() {
    let scene = builtin("cornell");
    let camera = scene.default_camera();
    let image = |sh: bool| {
        let params = params(&[&format!("indirect.sh={sh}")]);
        let mut frames =
            Frames::with_params(scene.clone(), &camera, TraceBackend::Compute, [24, 24], 5, false, params);
        frames.render(0.0);
        let image = frames.image(FLAT_COLOR);
        let directed = frames.floats(COLOR_LF_SH).chunks_exact(4).filter(|t| t[..3] != [0.0; 3]).count();
        frames.finish();
        assert_eq!(directed > 200, sh, "{directed} texels have a direction");
        image
    };
    let (sh, plain) = (image(true), image(false));
    for (a, b) in sh.pixels.iter().zip(&plain.pixels) {
        for c in 0..3 {
            assert!((a[c] - b[c]).abs() <= 1e-4 * b[c] + 1e-6, "{a:?} and {b:?}");
        }
    }
}

/// A room in which every lobe counts: plates of coated, sheen, brushed, iridescent and tinted materials, lit by a lamp and by a point light.
fn lobes() -> (Scene, Camera) {
    let (mut scene, camera) = furnace(Vec3::ZERO, Vec3::splat(0.6));
    let base = |name: &str, color: [f32; 3], roughness: f32| Material {
        roughness,
        ..Material::diffuse(name, Vec3::from(color))
    };
    let with = |material: Material, lobes: Lobes| Material { lobes: Some(Box::new(lobes)), ..material };
    let none = Lobes::default;
    let coat = Lobes { clearcoat: 1.0, clearcoat_roughness: 0.2, ..none() };
    let sheen = Lobes { sheen_color: Vec3::new(0.3, 0.5, 0.9), sheen_roughness: 0.5, ..none() };
    let film = Lobes { iridescence: 1.0, iridescence_thickness_max: 450.0, ..none() };
    let brushed = Material::metal("brushed", Vec3::new(0.9, 0.7, 0.4), 0.4);
    let materials = [
        with(base("coat", [0.5, 0.1, 0.1], 0.6), coat),
        with(base("sheen", [0.1, 0.1, 0.3], 0.9), sheen),
        with(brushed, Lobes { anisotropy_strength: 0.8, ..none() }),
        with(base("film", [0.2; 3], 0.3), film),
        Material {
            specular: 0.5,
            specular_color: Vec3::new(1.0, 0.3, 0.1),
            ..base("tinted", [0.1, 0.4, 0.1], 0.35)
        },
        Material { metallic: 0.5, ..base("half metal", [0.8, 0.6, 0.3], 0.25) },
    ];
    for (i, material) in materials.into_iter().enumerate() {
        let at = Vec3::new(0.6 * (i % 3) as f32 - 0.6, 0.35 - 0.7 * (i / 3) as f32, -0.8);
        let turn = Quat::from_rotation_x(-0.3);
        let side = |x: f32, y: f32| at + turn * Vec3::new(0.26 * x, 0.3 * y, 0.0);
        common::polygon(
            &mut scene,
            &[side(-1.0, -1.0), side(1.0, -1.0), side(1.0, 1.0), side(-1.0, 1.0)],
            material,
        );
    }
    let lamp = Material::lamp("lamp", Vec3::new(9.0, 8.0, 7.0));
    let corner = |x: f32, z: f32| Vec3::new(0.4 * x, 0.95, 0.4 * z + 0.2);
    common::polygon(
        &mut scene,
        &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        lamp,
    );
    scene.lights.push(Light::point("point", Vec3::new(0.5, 0.0, 0.6), Vec3::new(0.4, 0.5, 0.8)));
    scene.validate().unwrap();
    (scene, camera)
}

/// All lobes, first and later, as the reference reflects them; whoever finds the lamp, it counts once, whichever sampler picks it.
fn assert_lobes(bounces: u32, sampler: &str, choice: &str) {
    let (scene, camera) = lobes();
    let size = [24, 16];
    let truth = reference_mean(&scene, &camera, size, bounces, 512);
    let sets = [
        &format!("indirect.bounces={bounces}"),
        "lights.rays=merged",
        &format!("lights.sampler={sampler}"),
        choice,
    ];
    let found = frames_mean(&scene, &camera, size, 96, params(&sets));
    // The first surface has no lobe narrower than 0.03, and normals of 16 bits.
    assert_same(&format!("lobes, {bounces} bounces, {sampler}"), found, truth, 0.005);
}

#[test]
fn lobes_bounce_as_in_the_reference() {
    assert_lobes(1, "cluster-stats", "indirect.lobe_choice=fresnel");
}

#[test]
fn lobes_bounce_thrice_as_in_the_reference() {
    assert_lobes(3, "ris", "indirect.lobe_choice=half");
}

/// A smooth metal floor under a lamp: all three ways to share its light between light samples and bounce rays have the same mean; rays find it with
/// less noise.
#[test]
fn emission_is_shared_without_loss() {
    let (mut scene, _) = furnace(Vec3::ZERO, Vec3::splat(0.3));
    let corner = |x: f32, z: f32| Vec3::new(0.8 * x, -0.7, -0.8 * z);
    let metal = Material::metal("floor", Vec3::new(0.9, 0.8, 0.7), 0.12);
    common::polygon(
        &mut scene,
        &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        metal,
    );
    let lamp = Material::lamp("lamp", Vec3::splat(4.0));
    let side = |x: f32, y: f32| Vec3::new(0.5 * x, 0.1 + 0.5 * y, -0.9);
    common::polygon(&mut scene, &[side(-1.0, -1.0), side(1.0, -1.0), side(1.0, 1.0), side(-1.0, 1.0)], lamp);
    scene.validate().unwrap();
    let camera = Camera::look_at("floor", Vec3::new(0.0, 0.2, 0.9), Vec3::new(0.0, -0.7, -0.1), 0.5);
    let truth = reference_mean(&scene, &camera, [12, 12], 1, 1024);
    let errors = EmissionShare::ALL.map(|share| {
        let set = format!("indirect.emission_share={}", share.name());
        let found = frames_mean(&scene, &camera, [12, 12], 192, params(&[&set]));
        // Light samples hardly find the lamp in the floor.
        if share == EmissionShare::LightSamples {
            assert!(
                (found.mean - truth.mean).abs().max_element() < 4.0 * found.error.max_element(),
                "{found:?}, {truth:?}"
            );
        } else {
            assert_same(share.name(), found, truth, 0.003);
        }
        found.error.y
    });
    println!("standard errors {errors:?}");
    assert!(errors[2] < 0.5 * errors[0] && errors[2] < 1.2 * errors[1], "standard errors {errors:?}");
}

/// A light in a black box that is open below, under it a thin coloured sheet: the sheet tints the light of surfaces that bounce rays meet as that
/// of the first ones.
#[test]
fn thin_glass_tints_bounced_light() {
    let (mut scene, _) = furnace(Vec3::ZERO, Vec3::new(0.5, 0.6, 0.7));
    let corner = |x: f32, y: f32, z: f32| Vec3::new(0.3 * x, y, 0.3 * z);
    let ring = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let level = |y: f32| ring.map(|(x, z)| corner(x, y, z));
    let black = || Material::lambertian("box", Vec3::ZERO);
    let (low, high) = (level(0.7), level(0.98));
    for k in 0..4 {
        let next = (k + 1) % 4;
        common::polygon(&mut scene, &[low[k], low[next], high[next], high[k]], black());
    }
    common::polygon(&mut scene, &high, black());
    let glass = Material {
        transmission: 1.0,
        roughness: 0.0,
        base_color: Vec3::new(0.9, 0.5, 0.2).extend(1.0),
        ..Material::diffuse("glass", Vec3::ONE)
    };
    common::polygon(&mut scene, &low, glass);
    scene.lights.push(Light::point("point", Vec3::new(0.05, 0.9, -0.1), Vec3::ONE));
    scene.validate().unwrap();
    // The camera does not see the sheet: what the G-buffer shows in glass counts as no bounce.
    let camera = Camera::look_at("down", Vec3::new(0.1, 0.3, 0.8), Vec3::new(0.0, -1.0, -0.1), 0.7);
    // For the reference the way through the sheet is a bounce.
    let truth = reference_mean(&scene, &camera, [16, 16], 2, 128);
    let direct = reference_mean(&scene, &camera, [16, 16], 1, 64);
    assert!(direct.mean.x < 0.9 * truth.mean.x, "bounces bring light: {direct:?}, {truth:?}");
    let found = frames_mean(&scene, &camera, [16, 16], 48, params(&["indirect.bounces=1"]));
    assert_same("through a sheet of glass", found, truth, 0.005);
}

/// Glass that absorbs nothing changes nothing in a furnace: each ray that it bends or reflects ends at a wall as bright as the others. Light
/// samples that go straight through solids tell another story, and the paths that glass reflects inside must not be lost with them.
#[test]
fn lossless_glass_leaves_a_furnace_as_it_is() {
    let (mut scene, _) = furnace(Vec3::splat(0.7), Vec3::splat(0.5));
    let at = |size: f32, x: f32, z: f32| {
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(size),
            Quat::from_rotation_y(0.4),
            Vec3::new(x, -0.3, z),
        )
    };
    common::cube(&mut scene, at(0.4, 0.3, -0.2), false, Material::solid("glass", 1.5));
    let ring = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let sheet = Material { transmission: 1.0, roughness: 0.0, ..Material::diffuse("sheet", Vec3::ONE) };
    common::polygon(&mut scene, &ring.map(|(x, y)| Vec3::new(0.6 * x, 0.6 * y, -0.8)), sheet);
    scene.validate().unwrap();
    let camera = Camera::look_at("wall", Vec3::new(-0.6, 0.5, 0.3), Vec3::new(-1.0, 0.3, 0.8), 0.7);
    let exact = Mean { mean: DVec3::splat(0.7 / (1.0 - 0.5)), error: DVec3::ZERO };
    let shadows = ["stopped", "straight", "tinted"].map(|value| {
        let glass = format!("lights.glass_shadows={value}");
        params(&["indirect.bounces=16", "lights.sampler=power", "lights.area_sampling=spherical", &glass])
    });
    let found = frames_means(&scene, &camera, [12, 12], 96, &shadows);
    // Sixteen bounces lack some of the light: a path through glass spends several.
    assert_same("stopped", found[0], exact, 0.004);
    assert_same("straight", found[1], exact, 0.004);
    // Light samples through the cube are those of its middle.
    assert_same("tinted", found[2], exact, 0.02);
}

/// The weaker of two solids that overlap is not there: paths pass its boundaries, which cost neither light nor a bounce.
#[test]
fn weak_solids_inside_of_strong_ones_leave_no_trace() {
    let image = |inner: bool| {
        let (mut scene, camera) = furnace(Vec3::splat(0.5), Vec3::splat(0.7));
        let solid = |name: &str, ior: f32, priority: u32| Material { priority, ..Material::solid(name, ior) };
        let place = |size: f32| {
            Affine3A::from_scale_rotation_translation(
                Vec3::splat(size),
                Quat::from_rotation_y(0.4),
                Vec3::new(0.2, -0.3, 0.0),
            )
        };
        common::cube(&mut scene, place(0.5), false, solid("glass", 1.5, 2));
        if inner {
            let mut ink = solid("ink", 1.3, 1);
            ink.attenuation_color = Vec3::new(0.1, 0.2, 0.9);
            ink.attenuation_distance = 0.2;
            common::cube(&mut scene, place(0.3), false, ink);
        }
        scene.validate().unwrap();
        // What the camera sees through glass is not the point here, and light samples that go straight through it would outshine the paths.
        let params =
            params(&["indirect.bounces=3", "gbuffer.reflect_refract=0", "lights.glass_shadows=stopped"]);
        let mut frames =
            Frames::with_params(scene, &camera, TraceBackend::Compute, [24, 16], 3, true, params);
        for _ in 0..4 {
            frames.render(0.0);
        }
        let image = frames.image(FLAT_COLOR);
        frames.finish();
        image
    };
    let (alone, weak) = (image(false), image(true));
    let lit = alone.pixels.iter().filter(|p| p[0] > 0.1).count();
    // The glass itself is dark.
    assert!(lit > alone.pixels.len() / 8, "{lit} pixels have light");
    // The places where rays go on are rounded: now and then one meets another triangle.
    let pairs = alone.pixels.iter().zip(&weak.pixels);
    let differ = pairs.filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > 1e-3 * a[c] + 1e-5)).count();
    assert!(
        differ <= alone.pixels.len() / 100,
        "{differ} of {} pixels see the weak solid",
        alone.pixels.len()
    );
}

/// Broken geometry, nodes without extent, and a camera inside of glass: the light is finite all the same.
#[test]
fn broken_input_stays_finite() {
    let (mut scene, camera) = lobes();
    // A triangle without area, one with normals and tangents that are no numbers, and a ball of glass round the camera.
    common::polygon(
        &mut scene,
        &[Vec3::ZERO, Vec3::X * 0.3, Vec3::X * 0.6],
        Material::lamp("line", Vec3::ONE),
    );
    let eye = Vec3::from(camera.world_from_camera.translation);
    let mut glass = Material::solid("glass", 1.5);
    glass.attenuation_color = Vec3::new(0.9, 0.8, 0.7);
    glass.attenuation_distance = 0.5;
    common::cube(
        &mut scene,
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), Quat::IDENTITY, eye),
        false,
        glass,
    );
    for scale in [Vec3::new(0.2, 0.0, 0.2), Vec3::ZERO] {
        let place = pt_scene::visible(Affine3A::from_scale(scale));
        scene.instances.push(pt_scene::Instance::new("flat", 1, place));
    }
    let broken = &mut scene.meshes[3];
    broken.tangents.iter_mut().for_each(|t| *t = glam::Vec4::NAN);
    broken.normals[0] = Vec3::ZERO;
    for glossy in [false, true] {
        let passes = format!("gbuffer.reflect_refract={}", if glossy { 0 } else { 2 });
        let params = params(&["indirect.bounces=4", &passes]);
        let mut frames =
            Frames::with_params(scene.clone(), &camera, TraceBackend::Compute, [24, 16], 3, false, params);
        for _ in 0..2 {
            frames.render(0.0);
        }
        for channel in [COLOR_LF_SH, COLOR_LF_COCG, COLOR_SPEC, FLAT_COLOR] {
            let values = frames.floats(channel);
            assert!(values.iter().all(|v| v.is_finite()), "{channel:?}, mirrors as surfaces: {glossy}");
        }
        assert!(frames.image(FLAT_COLOR).pixels.iter().any(|p| p[1] > 0.01), "there is light");
        frames.finish();
    }
}
