//! Light that glass bends onto rough surfaces (`lights.caustics`), against closed forms and the reference path tracer.

use crate::common::{cube, params, polygon, session};
use glam::{Affine3A, DVec3, Quat, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_reference::{Progressive, ReferenceParams};
use pt_scene::gpu::camera_record;
use pt_scene::{Camera, Light, Material, Projection, Scene, Waves};
use pt_shaders::channels::FLAT_COLOR;
use pt_shaders::records::FrameRecord;
use pt_tests::Frames;
use std::f64::consts::PI;

const SIZE: [u32; 2] = [24, 24];
const LUX: Vec3 = Vec3::new(3.0, 2.5, 2.0);
/// Dark: what it reflects to the glass and gets back is little.
const ALBEDO: f32 = 0.02;
const IOR: f64 = 1.5;

/// Direct light alone.
const KNOBS: [&str; 6] = [
    "lights.caustics=true",
    "lights.glass_shadows=tinted",
    "lights.caustics_photons=65536",
    "lights.caustics_cell=0.1",
    "indirect.bounces=0",
    "gbuffer.jitter=none",
];
/// Frames of a mean.
const COUNT: u32 = 24;

fn with(more: &[&str]) -> Vec<String> {
    KNOBS.iter().chain(more).map(|&knob| knob.to_owned()).collect()
}

fn sun(towards: Vec3, angular_radius: f32) -> Light {
    Light { angular_radius, ..Light::directional("sun", -towards, LUX) }
}

/// A floor of 20 m that is turned by `tilt` radians about Z, a camera that sees one square metre of it from 0.9 m above, and the sun.
fn floor(tilt: f32, sun: Light) -> (Scene, Camera) {
    let mut scene = Scene { lights: vec![sun], ..Scene::default() };
    let turn = Quat::from_rotation_z(tilt);
    let corners =
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| turn * Vec3::new(x, 0.0, z) * 10.0);
    polygon(&mut scene, &corners, Material::lambertian("floor", Vec3::splat(ALBEDO)));
    let camera = Camera::look_at("above", turn * Vec3::Y * 0.9, Vec3::ZERO, 1.0);
    (scene, Camera { projection: Projection::Orthographic { ymag: 0.5 }, ..camera })
}

/// A slab of glass with its lower side at `height`.
fn slab(scene: &mut Scene, height: f32, thickness: f32, material: Material) {
    let half = 0.5 * thickness;
    let place = Affine3A::from_translation(Vec3::Y * (height + half))
        * Affine3A::from_scale(Vec3::new(2.0, half, 2.0));
    cube(scene, place, false, material);
}

/// Mean and standard error of a picture's blocks.
struct Blocks {
    mean: Vec<DVec3>,
    error: Vec<DVec3>,
}

/// Blocks in a row and in a column.
const BLOCKS: u32 = 4;

fn block_of(pixel: usize) -> usize {
    let (x, y) = (pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]);
    (y * BLOCKS / SIZE[1] * BLOCKS + x * BLOCKS / SIZE[0]) as usize
}

fn block_sums(pixels: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; (BLOCKS * BLOCKS) as usize];
    pixels.enumerate().for_each(|(i, p)| sums[block_of(i)] += p);
    sums
}

fn per_block() -> f64 {
    f64::from(SIZE[0] * SIZE[1]) / f64::from(BLOCKS * BLOCKS)
}

fn frames(scene: &Scene, camera: &Camera, backend: TraceBackend, sets: &[String], seed: u32) -> Frames {
    scene.validate().unwrap();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    Frames::with_params(scene.clone(), camera, backend, SIZE, seed, false, params(&sets))
}

fn picture(frames: &Frames) -> Vec<DVec3> {
    frames.image(FLAT_COLOR).pixels.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect()
}

/// Of `count` frames.
fn frame_blocks(
    scene: &Scene,
    camera: &Camera,
    backend: TraceBackend,
    sets: &[String],
    count: u32,
) -> Blocks {
    let mut frames = frames(scene, camera, backend, sets, 17);
    let n = f64::from(count);
    let size = (BLOCKS * BLOCKS) as usize;
    let (mut mean, mut squares) = (vec![DVec3::ZERO; size], vec![DVec3::ZERO; size]);
    for _ in 0..count {
        frames.render(0.0);
        for (i, sum) in block_sums(picture(&frames).into_iter()).into_iter().enumerate() {
            let value = sum / per_block();
            mean[i] += value / n;
            squares[i] += value * value / n;
        }
    }
    frames.finish();
    let error = mean.iter().zip(&squares);
    let error = error.map(|(m, s)| ((*s - *m * *m).max(DVec3::ZERO) / (n - 1.0)).map(f64::sqrt)).collect();
    Blocks { mean, error }
}

fn reference_blocks(scene: &Scene, camera: &Camera, spp: u32) -> Blocks {
    let device = TestDevice::open();
    let mut session = session(&device, scene);
    let record = camera_record(camera, SIZE);
    let frame = FrameRecord::new(record, record, SIZE, 0, 99);
    let pt_app::session::Session { device, scene, gpu, lights, .. } = &mut session;
    let params = ReferenceParams { max_bounces: Some(16), spp, ..ReferenceParams::default() };
    params.prepare_lights(device, scene, gpu, lights).unwrap();
    let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0).unwrap();
    while render.next_sample() < spp {
        render.step(scene, gpu, lights, spp).unwrap();
    }
    let pixels = render.state().unwrap().estimate(spp).pixels;
    let mean = block_sums(pixels.iter().map(|p| p.mean.as_dvec3()));
    let variance = block_sums(pixels.iter().map(|p| p.variance.as_dvec3()));
    Blocks {
        mean: mean.into_iter().map(|sum| sum / per_block()).collect(),
        error: variance.into_iter().map(|sum| sum.map(f64::sqrt) / per_block()).collect(),
    }
}

/// Fails where a block is off by more than 4.5 standard errors and `bias`, relative to the brightest block.
fn assert_blocks(what: &str, found: &Blocks, expected: &Blocks, bias: f64) {
    let brightest = expected.mean.iter().fold(0.0f64, |m, v| m.max(v.max_element()));
    assert!(brightest > 0.0, "{what}: nothing is lit");
    let total = |b: &Blocks| b.mean.iter().sum::<DVec3>();
    let ratio = total(found) / total(expected);
    let squares = |b: &Blocks| b.error.iter().map(|e| e * e).sum::<DVec3>();
    let error = (squares(found) + squares(expected)).map(f64::sqrt) / total(expected);
    println!("{what}: energy {ratio:.4} +- {error:.4} of what is expected");
    for c in 0..3 {
        assert!(
            (ratio[c] - 1.0).abs() <= 4.0 * error[c] + bias,
            "{what}: energy {ratio} of what is expected"
        );
        assert!(error[c] < 0.015, "{what}: too much noise to say anything: {error}");
    }
    for (i, (f, e)) in found.mean.iter().zip(&expected.mean).enumerate() {
        let (fe, ee) = (found.error[i], expected.error[i]);
        println!("  block {i}: {:.6} +- {:.6}, expected {:.6} +- {:.6}", f.y, fe.y, e.y, ee.y);
        for c in 0..3 {
            let allowed = 4.5 * fe[c].hypot(ee[c]) + bias * brightest;
            assert!((f[c] - e[c]).abs() <= allowed, "{what}: block {i}, channel {c}: {f}, expected {e}");
        }
    }
}

/// The same value everywhere.
fn exact(value: DVec3) -> Blocks {
    let size = (BLOCKS * BLOCKS) as usize;
    Blocks { mean: vec![value; size], error: vec![DVec3::ZERO; size] }
}

/// Fresnel's reflectance of unpolarised light that enters a medium of index `eta` at this cosine.
fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    0.5 * (s * s + p * p)
}

/// What a slab lets through, with all reflections inside of it.
fn slab_transmittance(cos_i: f64) -> f64 {
    let r = fresnel(cos_i, IOR);
    (1.0 - r) / (1.0 + r)
}

/// Radiance of the floor: albedo / pi E.
fn floor_radiance(cos_floor: f64, transmittance: f64) -> DVec3 {
    LUX.as_dvec3() * (f64::from(ALBEDO) / PI * cos_floor * transmittance)
}

/// Of the closed forms: rounding of fluxes and textures, and photons that are lost after 16 surfaces.
const ROUNDING: f64 = 2e-3;

fn glass() -> Material {
    Material::solid("glass", IOR as f32)
}

fn check_slab(backend: TraceBackend) {
    if let Some(why) = backend.missing(&TestDevice::open()) {
        return println!("skipped: {why}");
    }
    for degrees in [0.0f32, 45.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (mut scene, camera) = floor(0.0, sun(Vec3::new(sin, cos, 0.0), 0.0));
        slab(&mut scene, 1.0, 0.2, glass());
        let cos = f64::from(cos);
        let found = frame_blocks(&scene, &camera, backend, &with(&[]), COUNT);
        assert_blocks(
            &format!("slab, {degrees} degrees"),
            &found,
            &exact(floor_radiance(cos, slab_transmittance(cos))),
            ROUNDING,
        );
    }
}

#[test]
fn a_slab_lets_through_what_fresnel_says_compute() {
    check_slab(TraceBackend::Compute);
}

#[test]
fn a_slab_lets_through_what_fresnel_says_ray_query() {
    check_slab(TraceBackend::RayQuery);
}

#[test]
fn a_slab_lets_through_what_fresnel_says_rt_pipeline() {
    check_slab(TraceBackend::RtPipeline);
}

/// The irradiance of a plane does not depend on how it cuts the cells.
#[test]
fn tilted_floors_are_evenly_lit() {
    for tilt in [0.3f32, 0.75, 0.9] {
        let (mut scene, camera) = floor(tilt, sun(Vec3::Y, 0.0));
        // Above the camera and what the floor has below the slab.
        slab(&mut scene, 3.5, 0.2, glass());
        let expected = floor_radiance(f64::from(tilt).cos(), slab_transmittance(1.0));
        let found = frame_blocks(
            &scene,
            &camera,
            TraceBackend::Compute,
            &with(&["lights.caustics_cell=0.07"]),
            COUNT,
        );
        assert_blocks(&format!("tilt {tilt}"), &found, &exact(expected), ROUNDING);
    }
}

/// Photons are aimed at both slabs, and a line through both is counted once.
#[test]
fn slabs_behind_each_other_are_lit_once() {
    let (mut scene, camera) = floor(0.0, sun(Vec3::Y, 0.0));
    slab(&mut scene, 1.0, 0.2, glass());
    slab(&mut scene, 1.5, 0.2, Material { name: "second".into(), ..glass() });
    // Four interfaces in a row: the reflectances of two plates and what goes to and fro between them.
    let t = slab_transmittance(1.0);
    let r = 1.0 - t;
    let expected = floor_radiance(1.0, t * t / (1.0 - r * r));
    let found = frame_blocks(&scene, &camera, TraceBackend::Compute, &with(&[]), COUNT);
    assert_blocks("two slabs", &found, &exact(expected), ROUNDING);
}

/// The floor lies in water, and the camera sees it through the surface: light is weakened on both ways, and radiance changes with the index.
#[test]
fn floors_under_water_are_lit() {
    let (mut scene, camera) = floor(0.0, sun(Vec3::new(0.6, 0.8, 0.0), 0.0));
    let (ior, color, depth) = (1.33f64, DVec3::new(0.9, 0.8, 0.5), 0.4);
    let water = Material {
        attenuation_color: color.as_vec3(),
        attenuation_distance: 1.0,
        ..Material::solid("water", ior as f32)
    };
    slab(&mut scene, -0.4, 0.4 + depth as f32, water);
    let (t_in, t_out) = (1.0 - fresnel(0.8, ior), 1.0 - fresnel(1.0, ior));
    let cos_t = (1.0 - (0.6 / ior).powi(2)).sqrt();
    let passed = (depth / cos_t + depth) * color.map(f64::ln);
    let expected = floor_radiance(0.8, t_in * t_out / (ior * ior)) * passed.map(f64::exp);
    let found = frame_blocks(&scene, &camera, TraceBackend::Compute, &with(&[]), 2 * COUNT);
    assert_blocks("under water", &found, &exact(expected), ROUNDING);
}

/// Light follows the shading normal of the water, which leans towards the sun, and reaches the floor as radiance says: between the two directions at the
/// surface the flux changes (Veach 1997, section 5.3.2), here by a sixth.
#[test]
fn floors_under_leaning_normals_are_lit() {
    let (mut scene, camera) = floor(0.0, sun(Vec3::new(60f32.to_radians().sin(), 0.5, 0.0), 0.0));
    let (ior, lean) = (1.33f64, 25f64.to_radians());
    // The camera is in the water, which is so shallow that the light of its sides ends outside of the picture.
    slab(&mut scene, -0.4, 0.8, Material::solid("water", ior as f32));
    let place = Affine3A::from_translation(-0.6 * Vec3::Y) * camera.world_from_camera;
    let camera = Camera { world_from_camera: place, ..camera };
    let normal = Vec3::new(lean.sin() as f32, lean.cos() as f32, 0.0);
    for n in scene.meshes.last_mut().unwrap().normals.iter_mut().filter(|n| n.y > 0.9) {
        *n = normal;
    }
    // Angles to the shading normal, and to that of the triangle.
    let in_shading = 60f64.to_radians() - lean;
    let out_shading = (in_shading.sin() / ior).asin();
    let out = out_shading + lean;
    let flux = (1.0 - fresnel(in_shading.cos(), ior)) * in_shading.cos() * out.cos() / out_shading.cos();
    let change = flux / (1.0 - fresnel(in_shading.cos(), ior)) / 0.5;
    assert!(change > 1.15, "{change}");
    let found = frame_blocks(&scene, &camera, TraceBackend::Compute, &with(&[]), 2 * COUNT);
    assert_blocks("leaning normals", &found, &exact(floor_radiance(flux, 1.0)), ROUNDING);
}

/// What stands between the sun and the glass, or between the glass and the floor, keeps its light.
#[test]
fn other_things_cast_shadows() {
    for height in [2.0, 0.95] {
        let (mut scene, camera) = floor(0.0, sun(Vec3::Y, 0.0));
        slab(&mut scene, 1.0, 0.2, glass());
        let corners =
            [(-3.0, -3.0), (-3.0, 3.0), (3.0, 3.0), (3.0, -3.0)].map(|(x, z)| Vec3::new(x, height, z));
        polygon(&mut scene, &corners, Material::lambertian("plate", Vec3::ONE));
        let mut frames = frames(&scene, &camera, TraceBackend::Compute, &with(&[]), 5);
        frames.render(0.0);
        assert!(picture(&frames).iter().all(|p| *p == DVec3::ZERO), "plate at {height} m");
        frames.finish();
    }
}

/// Photons leave what goes straight on to the shadow rays, whatever `glass_shadows` says, and bring what a sheet mirrors.
#[test]
fn light_through_sheets_is_there_once() {
    let pane = Material { thickness: 0.0, ..glass() };
    for shadows in ["lights.glass_shadows=tinted", "lights.glass_shadows=stopped"] {
        let (mut scene, camera) = floor(0.0, sun(Vec3::Y, 0.0));
        let corners = [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
        polygon(&mut scene, &corners, pane.clone());
        let found = frame_blocks(&scene, &camera, TraceBackend::Compute, &with(&[shadows]), COUNT);
        assert_blocks("pane", &found, &exact(floor_radiance(1.0, 1.0 - fresnel(1.0, IOR))), ROUNDING);
    }
}

/// A ball of 0.3 m over the floor: a bright spot in its shadow, blurred by the sun's disc.
fn ball(scene: &mut Scene) {
    let (rings, columns) = (48, 96);
    let mut mesh = pt_scene::Mesh::default();
    for i in 0..=rings {
        for j in 0..=columns {
            let (theta, phi) =
                (PI as f32 * i as f32 / rings as f32, 2.0 * PI as f32 * j as f32 / columns as f32);
            let n = Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
            mesh.positions.push(Vec3::new(0.0, 0.45, 0.0) + 0.3 * n);
            mesh.normals.push(n);
            if i < rings && j < columns {
                let first = (i * (columns + 1) + j) as u32;
                let (a, b, c, d) = (first, first + columns as u32 + 1, first + columns as u32 + 2, first + 1);
                if i > 0 {
                    mesh.indices.push([a, c, d]);
                }
                if i + 1 < rings {
                    mesh.indices.push([a, b, c]);
                }
            }
        }
    }
    let n = mesh.positions.len();
    mesh.name = "ball".into();
    mesh.tangents = vec![glam::Vec4::X; n];
    mesh.uv0 = vec![glam::Vec2::ZERO; n];
    mesh.uv1 = mesh.uv0.clone();
    mesh.colors = vec![glam::Vec4::ONE; n];
    mesh.triangle_materials = vec![scene.materials.len() as u32; mesh.indices.len()];
    mesh.first_masked = mesh.indices.len();
    scene.instances.push(pt_scene::Instance::new("ball", scene.meshes.len() as u32, Affine3A::IDENTITY));
    scene.meshes.push(mesh);
    scene.materials.push(Material {
        attenuation_color: Vec3::new(0.9, 0.5, 0.3),
        attenuation_distance: 0.5,
        ..glass()
    });
}

#[test]
fn blocks_are_those_of_the_reference() {
    let towards = Vec3::new(0.5, 1.0, 0.2).normalize();
    let (mut balls, camera) = floor(0.0, sun(towards, 0.35));
    ball(&mut balls);
    let (mut water, _) = floor(0.0, sun(towards, 0.35));
    let waves = Waves { slope: 0.25, length: 0.6 };
    slab(&mut water, 1.0, 0.3, Material { waves: Some(waves), ..Material::solid("water", 1.33) });
    let (mut slabs, _) = floor(0.0, sun(Vec3::new(1.0, 1.0, 0.0).normalize(), 0.35));
    slab(&mut slabs, 1.0, 0.2, glass());
    for (what, scene, low) in [("slab", slabs, 0.9), ("water", water, 0.9), ("ball", balls, 0.1)] {
        // Below the glass, which it does not see.
        let camera = Camera {
            world_from_camera: Affine3A::from_translation(Vec3::Y * (low - 0.9)) * camera.world_from_camera,
            ..camera.clone()
        };
        let truth = reference_blocks(&scene, &camera, 512);
        let found = frame_blocks(
            &scene,
            &camera,
            TraceBackend::Compute,
            &with(&["lights.caustics_cell=0.03"]),
            2 * COUNT,
        );
        // What the floor gets back from the glass, and the blur of a cell at the borders of blocks.
        assert_blocks(what, &found, &truth, 0.01);
    }
}

#[test]
fn the_same_command_has_the_same_bits() {
    let (mut scene, camera) = floor(0.0, sun(Vec3::new(0.2, 1.0, 0.0).normalize(), 0.02));
    slab(&mut scene, 1.0, 0.2, glass());
    let run = || {
        let mut frames = frames(&scene, &camera, TraceBackend::Compute, &with(&[]), 5);
        frames.render(0.0);
        frames.render(0.0);
        let values = frames.floats(FLAT_COLOR);
        frames.finish();
        values
    };
    let first = run();
    assert!(first.iter().any(|v| *v > 0.0 && *v < 1.0));
    assert_eq!(first, run());
}

/// Scenes without a sun, or without glass, and frames without sunlight have no pass for caustics, and the bits of frames without the knob.
#[test]
fn without_sun_or_glass_nothing_is_added() {
    let (dry, camera) = floor(0.0, sun(Vec3::Y, 0.01));
    let mut dark = dry.clone();
    slab(&mut dark, 1.0, 0.2, glass());
    let lit = dark.clone();
    dark.lights = vec![Light::point("lamp", Vec3::new(0.0, 0.8, 0.3), Vec3::ONE)];
    let mut rough = dry.clone();
    slab(&mut rough, 1.0, 0.2, Material { roughness: 0.3, ..glass() });
    for (what, scene, more) in [
        ("no glass", dry, "lights.sun=true"),
        ("no sun", dark, "lights.sun=true"),
        ("rough", rough, "lights.sun=true"),
        ("off", lit, "lights.sun=false"),
    ] {
        let run = |caustics: &str| {
            let mut frames = frames(&scene, &camera, TraceBackend::Compute, &with(&[more, caustics]), 5);
            frames.render(0.0);
            let values = frames.floats(FLAT_COLOR);
            let passes = frames.passes();
            frames.finish();
            (values, passes)
        };
        let (on, off) = (run("lights.caustics=true"), run("lights.caustics=false"));
        assert_eq!(on, off, "{what}");
        assert!(!on.1.iter().any(|name| name.contains("caustic")), "{what}: {:?}", on.1);
    }
}

/// Photons stop at rough glass: shadow rays do there what they do without photons.
#[test]
fn rough_glass_keeps_its_shadow_rays() {
    let (mut scene, camera) = floor(0.0, sun(Vec3::Y, 0.0));
    slab(&mut scene, 1.0, 0.2, Material { roughness: 0.3, ..glass() });
    // In the dark under the floor, so that there are photons.
    slab(&mut scene, -1.0, 0.2, glass());
    let run = |caustics: &str| {
        let mut frames = frames(&scene, &camera, TraceBackend::Compute, &with(&[caustics]), 5);
        frames.render(0.0);
        let (picture, passes) = (picture(&frames), frames.passes());
        frames.finish();
        (picture, passes.iter().any(|name| name.contains("caustic")))
    };
    let (on, off) = (run("lights.caustics=true"), run("lights.caustics=false"));
    assert_eq!([on.1, off.1], [true, false]);
    assert_eq!(on.0, off.0);
    assert!(on.0.iter().all(|p| p.y > 0.01), "{:?}", on.0[0]);
}

/// A sun below the horizon, one without light, and one beyond all measure.
#[test]
fn strange_suns_leave_the_picture_finite() {
    let (scene, camera) = floor(0.0, sun(Vec3::Y, 0.01));
    let mut scene = scene;
    slab(&mut scene, 1.0, 0.2, glass());
    for (towards, lux) in [(Vec3::new(0.3, -1.0, 0.0), 1.0), (Vec3::Y, 0.0), (Vec3::Y, 1e34), (Vec3::X, 1.0)]
    {
        let mut scene = scene.clone();
        scene.lights = vec![Light { intensity: Vec3::splat(lux), ..sun(towards.normalize(), 0.01) }];
        let mut frames = frames(&scene, &camera, TraceBackend::Compute, &with(&[]), 5);
        frames.render(0.0);
        let values = frames.floats(FLAT_COLOR);
        frames.finish();
        assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0), "{towards}, {lux} lux");
    }
}
