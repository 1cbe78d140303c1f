//! Media: solids that overlap, a camera inside of them, what is inside of glass, thin sheets with a relief.

use super::rig::{Frames, IOR, Rig, SIZE, follow, glass, near, parallel_rays, plate, rectangle, sheet};
use glam::{Affine3A, DVec3, Vec2, Vec3};
use pt_core::pack::unpack_unit_vector;
use pt_core::trace::TraceBackend;
use pt_gbuffer::oracle::dielectric;
use pt_gbuffer::{GbufferParams, ThinRefraction};
use pt_scene::{Camera, Material, Scene};
use pt_shaders::channels;
use pt_shaders::records::NONE;

const LIGHT: Vec3 = Vec3::new(2.0, 3.0, 4.0);
const COLOR: Vec3 = Vec3::new(0.9, 0.5, 0.2);
/// Metres.
const AT: f32 = 1.5;

/// Of what `length` metres of the medium let through.
fn beer_lambert(length: f64) -> DVec3 {
    COLOR.as_dvec3().powf(length / f64::from(AT))
}

fn ink(priority: u32) -> Material {
    Material { priority, attenuation_color: COLOR, attenuation_distance: AT, ..glass(true) }
}

/// Adds a plate between two depths (-z) whose faces look outwards.
fn layer(scene: &mut Scene, material: &Material, [front, back]: [f32; 2]) {
    let place = |turn: f32, z: f32| {
        Affine3A::from_translation(Vec3::new(0.0, 0.0, -z)) * Affine3A::from_rotation_y(turn)
    };
    rectangle(scene, Vec2::splat(50.0), material.clone(), place(0.0, front));
    rectangle(scene, Vec2::splat(50.0), material.clone(), place(std::f32::consts::PI, back));
}

/// Adds a wall of light that faces +Z.
fn wall(scene: &mut Scene, depth: f32) {
    let lamp = Material::lamp("lamp", LIGHT);
    rectangle(scene, Vec2::splat(40.0), lamp, Affine3A::from_translation(Vec3::new(0.0, 0.0, -depth)));
}

fn seen(rig: &Rig, scene: &Scene, camera: &Camera, passes: u32) -> Vec<DVec3> {
    rig.render(scene, [camera, camera], &follow(passes), 1).radiance
}

/// Light that goes 3 m through a coloured medium in which the camera is, whatever the number of passes; the camera finds by itself what it is in.
#[test]
fn a_camera_in_a_medium_sees_what_beer_and_lambert_say() {
    for backend in TraceBackend::CONCRETE {
        let Some(rig) = Rig::new(backend) else { continue };
        let camera = parallel_rays(Vec3::Z * -1.0);
        let mut scene = Scene::default();
        layer(&mut scene, &ink(0), [0.0, 20.0]);
        wall(&mut scene, 4.0);
        for passes in [0, 1, 3] {
            for pixel in seen(&rig, &scene, &camera, passes) {
                near(pixel, LIGHT.as_dvec3() * beer_lambert(3.0), 1e-4);
            }
        }
        // Outside of it nothing is absorbed.
        let outside = parallel_rays(Vec3::Z * -30.0);
        let mut scene = Scene::default();
        layer(&mut scene, &ink(0), [0.0, 20.0]);
        wall(&mut scene, 34.0);
        seen(&rig, &scene, &outside, 2).into_iter().for_each(|pixel| near(pixel, LIGHT.as_dvec3(), 1e-5));
    }
}

/// A clear block in the ink, of the same index: where it is stronger the way through the ink is shorter, where it is weaker it is not there. It
/// takes two passes to go through a block that is there, none to go through one that is not.
#[test]
fn the_stronger_of_two_solids_is_there() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * -1.0);
    let block = |priority: u32| {
        let mut scene = Scene::default();
        layer(&mut scene, &ink(1), [0.0, 20.0]);
        layer(&mut scene, &Material { priority, ..glass(true) }, [2.0, 3.0]);
        wall(&mut scene, 4.0);
        scene
    };
    for (priority, passes, length) in [(2, 3, 2.0), (2, 1, 2.0), (0, 0, 3.0), (0, 2, 3.0)] {
        for pixel in seen(&rig, &block(priority), &camera, passes) {
            near(pixel, LIGHT.as_dvec3() * beer_lambert(length), 2e-3);
        }
    }
    // From outside: ink that reaches 1 m into clear glass of another index is not there for that metre.
    let mut scene = Scene::default();
    layer(&mut scene, &Material { priority: 2, ior: 1.2, ..glass(true) }, [0.0, 2.0]);
    layer(&mut scene, &Material { ior: 1.2, ..ink(1) }, [1.0, 5.0]);
    wall(&mut scene, 4.0);
    let camera = parallel_rays(Vec3::Z * 3.0);
    let radiance = seen(&rig, &scene, &camera, 3);
    let through = 1.0 - dielectric::fresnel(0.0, 1.2);
    // Radiance that leaves a medium of index n becomes 1 / n^2 of it.
    let expected = 2.0 * LIGHT.as_dvec3() * beer_lambert(2.0) * (through / 1.44);
    // The throughput has half precision.
    near(Frames::fields(&radiance)[1], expected, 4e-3);
    let result = rig.render(&scene, [&camera, &camera], &follow(3), 1);
    let interior = result.images.current(channels::INTERIOR).read_u32().unwrap();
    let width = interior.len() / 4 / SIZE[1] as usize;
    let odd_field = interior.chunks(4).enumerate().filter(|(i, _)| i % width >= width / 2);
    assert!(odd_field.map(|(_, list)| list).all(|list| list.iter().any(|word| word & 0xff == 1)));
}

/// A lamp inside of glass, seen from outside.
#[test]
fn radiance_that_leaves_a_medium_is_spread() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 30.0);
    let angle = 40.0_f32;
    let mut scene = plate(glass(true), 8.0, angle);
    let turn = Affine3A::from_rotation_y(angle.to_radians());
    let lamp = Material::lamp("lamp", LIGHT);
    rectangle(&mut scene, Vec2::splat(40.0), lamp, turn * Affine3A::from_translation(Vec3::Z * -3.0));
    let through = 1.0 - dielectric::fresnel(f64::from(angle).to_radians(), IOR);
    for passes in [1, 2] {
        let radiance = seen(&rig, &scene, &camera, passes);
        let expected = 2.0 * through / (IOR * IOR) * LIGHT.as_dvec3();
        near(Frames::fields(&radiance)[1], expected, 4e-3);
    }
}

/// Normals that lean: straight on by default, refracted at both normals with the knob.
#[test]
fn thin_sheets_refract_twice_when_asked() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    let mut scene = sheet(glass(false), 0.0);
    let leaning = Vec3::new(0.2, 0.1, 1.0).normalize();
    scene.meshes[0].normals = vec![leaning; 4];
    let direction = |thin_refraction| {
        let params = GbufferParams { thin_refraction, ..follow(1) };
        let frames = rig.render(&scene, [&camera, &camera], &params, 1);
        let words = frames.images.current(channels::VIEW_DIRECTION).read_u32().unwrap();
        unpack_unit_vector(words[words.len() - 2]).as_dvec3()
    };
    assert!(direction(ThinRefraction::Straight).distance(DVec3::NEG_Z) < 1e-4);
    let inside = dielectric::refract(DVec3::NEG_Z, leaning.as_dvec3(), IOR).unwrap();
    let expected = dielectric::refract(inside, DVec3::Z, 1.0 / IOR).unwrap();
    let found = direction(ThinRefraction::Double);
    assert!(found.distance(expected) < 3e-4, "{found} for {expected}");
    assert!(found.distance(DVec3::NEG_Z) > 0.05, "{found} is straight on");
}

/// A hundred panes one behind the other, and glass that emits: everything is finite, and what the passes do not resolve goes straight on.
#[test]
fn many_panes_and_glass_that_shines() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 30.0);
    let shine = 0.01;
    for solid in [false, true] {
        let pane = Material { emissive: Vec3::splat(shine), double_sided: true, ..glass(solid) };
        let mut scene = Scene::default();
        for i in 0..100 {
            let z = 0.1 * i as f32;
            layer(&mut scene, &pane, [z, z + 0.05]);
        }
        wall(&mut scene, 20.0);
        scene.validate().unwrap();
        let frames = rig.render(&scene, [&camera, &camera], &follow(10), 4);
        assert!(frames.radiance.iter().all(|pixel| pixel.is_finite()));
        for channel in [channels::THROUGHPUT, channels::VIEW_DEPTH, channels::MOTION, channels::TRANSPARENT] {
            assert!(frames.texels(channel).iter().all(|v| v.is_finite()), "{}", channel.full_name());
        }
        let visible = frames.images.current(channels::VISIBILITY).read_u32().unwrap();
        let [even, odd] = Frames::fields(&frames.radiance);
        let mean = 0.5 * (even + odd);
        // The light of the wall, through interfaces that reflect 4 % each, and at least the shine of the first pane.
        assert!(even.x >= f64::from(shine) && mean.x < f64::from(LIGHT.x), "{even} {odd}");
        assert!(odd.x > 0.5 * f64::from(LIGHT.x), "the wall is seen: {odd}");
        assert!(visible.chunks(2).any(|v| v[0] != NONE));
    }
}
