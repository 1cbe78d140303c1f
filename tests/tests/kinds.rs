//! A panel of every kind of material, side by side, in the frame and in the reference against closed forms: each panel would have another
//! radiance if its kind did nothing.
//!
//! The sky is red round +Z, where the camera is, green round -Z and black elsewhere. Behind the panels stands a plate that emits [`PLATE`].

use crate::common::{cube, params, polygon, session};
use glam::{Affine3A, DVec3, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_reference::{Progressive, ReferenceParams};
use pt_scene::gpu::camera_record;
use pt_scene::{
    Camera, Environment, EnvironmentImage, Light, Material, MaterialKind, Projection, Scene, Shows, Waves,
};
use pt_shaders::channels::FLAT_COLOR;
use pt_shaders::records::FrameRecord;
use pt_tests::{Frames, direct_light_only};
use std::f64::consts::{PI, TAU};

const PLATE: DVec3 = DVec3::new(1.0, 2.0, 3.0);
/// Base colour and alpha of all panels.
const COLOR: f32 = 0.6;
const ALPHA: f32 = 0.5;
/// Pixels of a panel's place in each direction.
const PIXELS: u32 = 8;
const COUNT: u32 = MaterialKind::ALL.len() as u32;
const SIZE: [u32; 2] = [PIXELS * COUNT, PIXELS];

/// Radiance (1, 0, 0) within 30 degrees of +Z, (0, 1, 0) within 30 degrees of -Z.
fn sky() -> Environment {
    let (width, height) = (128, 64);
    let mut sky = Environment::new(EnvironmentImage { width, height, texels: vec![] });
    for i in 0..width * height {
        let uv = glam::UVec2::new(i % width, i / width).as_vec2() + 0.5;
        let direction = sky.direction(uv / glam::UVec2::new(width, height).as_vec2());
        let edge = 30f32.to_radians().cos();
        let color = if direction.z > edge { Vec3::X } else { Vec3::ZERO };
        sky.image.texels.push(if direction.z < -edge { Vec3::Y } else { color });
    }
    sky
}

/// Irradiance that a surface facing +Z gets from the sky.
fn irradiance(sky: &Environment) -> DVec3 {
    let steps = 400;
    let mut sum = DVec3::ZERO;
    for i in 0..steps * steps {
        let [u, v] = [i % steps, i / steps].map(|k| (f64::from(k) + 0.5) / f64::from(steps));
        let (z, azimuth) = (u, TAU * v);
        let across = (1.0 - z * z).sqrt();
        let direction = DVec3::new(across * azimuth.cos(), across * azimuth.sin(), z).as_vec3();
        sum += sky.radiance(direction).as_dvec3() * z;
    }
    sum * TAU / f64::from(steps * steps)
}

/// Red light that a slab of a liquid reflects, and what it lets through, with all inner reflections.
fn slab(ior: f64, transmittance: DVec3) -> (f64, DVec3) {
    let r = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let inner = DVec3::ONE - r * r * transmittance * transmittance;
    let through = (1.0 - r).powi(2) * transmittance / inner;
    (r + (1.0 - r).powi(2) * r * transmittance.x.powi(2) / inner.x, through)
}

/// The radiance that the camera sees of a panel.
fn expected(kind: MaterialKind, sky: &Environment) -> DVec3 {
    let (color, alpha) = (f64::from(COLOR), f64::from(ALPHA));
    let diffuse = color * irradiance(sky) / PI;
    let dielectric = 0.04;
    match kind {
        MaterialKind::Regular => diffuse,
        MaterialKind::Chrome | MaterialKind::ChromeModel => color * DVec3::X,
        MaterialKind::Glass => dielectric * DVec3::X + (1.0 - dielectric) * color * PLATE,
        MaterialKind::Water | MaterialKind::Slime => {
            let (ior, extinction) = match kind {
                MaterialKind::Water => (1.33, DVec3::new(0.7, 0.26, 0.24)),
                _ => (1.34, DVec3::new(4.0, 0.2, 1.0)),
            };
            let (reflected, through) = slab(ior, (-extinction).exp());
            reflected * DVec3::X + through * PLATE
        }
        MaterialKind::Lava => diffuse + 5.0 * color,
        MaterialKind::Sky => DVec3::Y,
        MaterialKind::Invisible => PLATE,
        MaterialKind::Explosion => 10.0 * alpha * color + (1.0 - alpha) * PLATE,
        MaterialKind::TransparentWall | MaterialKind::TransparentModel => {
            alpha * diffuse + (1.0 - alpha) * PLATE
        }
        MaterialKind::Screen => color + dielectric * DVec3::X,
        MaterialKind::Camera => DVec3::X,
    }
}

/// The panels in a row, and a camera that sees them along -Z.
fn panels() -> (Scene, Camera) {
    let mut scene = Scene { environment: sky(), ..Scene::default() };
    for (i, kind) in MaterialKind::ALL.into_iter().enumerate() {
        let material = Material {
            name: kind.name().into(),
            base_color: Vec3::splat(COLOR).extend(ALPHA),
            ..Material::lambertian(kind.name(), Vec3::ONE)
        };
        let material = Material { specular: 1.0, ..material }.with_kind(kind);
        // The regular base is Lambertian, so that it has a closed form.
        let material = Material { specular: if material.roughness == 1.0 { 0.0 } else { 1.0 }, ..material };
        let x = i as f32 - 0.5 * (COUNT - 1) as f32;
        if material.is_solid() {
            // 1 m deep.
            let place = Affine3A::from_translation(Vec3::new(x, 0.0, -0.5))
                * Affine3A::from_scale(Vec3::new(0.45, 0.45, 0.5));
            cube(&mut scene, place, false, material);
            continue;
        }
        let mut corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(u, v)| Vec3::new(x + 0.45 * u, 0.45 * v, 0.0));
        if kind == MaterialKind::TransparentWall {
            // Its back.
            corners.reverse();
        }
        polygon(&mut scene, &corners, material);
    }
    let far = 100.0;
    let plate = [(-far, -far), (far, -far), (far, far), (-far, far)].map(|(x, y)| Vec3::new(x, y, -2.5));
    polygon(&mut scene, &plate, Material::lamp("plate", PLATE.as_vec3()));
    let camera = Camera::look_at("row", Vec3::Z * 3.0, Vec3::ZERO, 1.0);
    let camera = Camera { projection: Projection::Orthographic { ymag: 0.5 }, ..camera };
    let away = Camera::look_at("away", Vec3::Z * 5.0, Vec3::Z * 6.0, 0.2);
    let shows = scene.materials.iter_mut().find(|m| m.name == "camera").unwrap();
    assert_eq!(shows.shows, Shows::Camera(0));
    scene.cameras = vec![away];
    scene.validate().unwrap();
    (scene, camera)
}

/// The pixels of the middle of a panel.
fn middle(panel: u32) -> impl Iterator<Item = usize> {
    let (from, to) = (PIXELS / 4, 3 * PIXELS / 4);
    (from..to).flat_map(move |y| (from..to).map(move |x| (y * SIZE[0] + panel * PIXELS + x) as usize))
}

/// `means`, `errors`: of each panel, with its standard error.
fn check(what: &str, means: &[DVec3], errors: &[DVec3], allowance: f64) {
    let sky = sky();
    let mut wrong = Vec::new();
    for ((kind, &mean), &error) in MaterialKind::ALL.into_iter().zip(means).zip(errors) {
        let expected = expected(kind, &sky);
        let bar = 4.0 * error + allowance * (0.3 + expected);
        println!("{what} {}: {mean:.4} +- {error:.4}, expected {expected:.4}", kind.name());
        if (mean - expected).abs().cmpgt(bar).any() || !mean.is_finite() {
            wrong.push(kind.name());
        }
    }
    assert!(wrong.is_empty(), "{what}: {wrong:?}");
}

/// Also each panel differs from a regular one by much more than the bar: what a kind does cannot be lost unnoticed.
#[test]
fn every_kind_but_chrome_model_has_a_radiance_of_its_own() {
    let sky = sky();
    let all = MaterialKind::ALL.map(|kind| expected(kind, &sky));
    for (kind, radiance) in MaterialKind::ALL.into_iter().zip(all).skip(1) {
        assert!((radiance - all[0]).abs().max_element() > 0.1, "{}", kind.name());
    }
}

#[test]
fn the_frame_shows_every_kind() {
    let (scene, camera) = panels();
    let count = 192;
    let backend = TraceBackend::Compute;
    let mut frames = Frames::with_params(scene, &camera, backend, SIZE, 5, false, params(&[]));
    let (mut sums, mut squares) = (vec![DVec3::ZERO; COUNT as usize], vec![DVec3::ZERO; COUNT as usize]);
    for _ in 0..count {
        frames.render(0.0);
        let image = frames.image(FLAT_COLOR);
        for panel in 0..COUNT {
            let pixels = middle(panel).map(|i| Vec3::from(image.pixels[i]).as_dvec3());
            let mean = pixels.sum::<DVec3>() / f64::from(PIXELS * PIXELS / 4);
            sums[panel as usize] += mean;
            squares[panel as usize] += mean * mean;
        }
    }
    frames.finish();
    let n = f64::from(count);
    let means: Vec<_> = sums.iter().map(|sum| sum / n).collect();
    let errors: Vec<_> = squares
        .iter()
        .zip(&means)
        .map(|(square, mean)| ((square / n - mean * mean).max(DVec3::ZERO) / (n - 1.0)).map(f64::sqrt))
        .collect();
    // Of the frame: 16-bit albedo and fp16 throughput, inner reflections after the last pass, waves, which bend rays.
    check("frame", &means, &errors, 8e-3);
}

#[test]
fn the_reference_shows_every_kind() {
    let (scene, camera) = panels();
    let pixels = reference(&scene, &camera, SIZE, 512);
    let panel = |panel: u32| {
        let n = f64::from(PIXELS * PIXELS / 4);
        let sum = |of: fn(&(DVec3, DVec3)) -> DVec3| middle(panel).map(|i| of(&pixels[i])).sum::<DVec3>();
        (sum(|p| p.0) / n, sum(|p| p.1).map(f64::sqrt) / n)
    };
    let (means, errors): (Vec<_>, Vec<_>) = (0..COUNT).map(panel).unzip();
    // Waves bend rays: Fresnel's reflectance at a mean slope of 0.08, the length of the way.
    check("reference", &means, &errors, 4e-3);
}

/// Mean and variance of the mean of every pixel of the path traced picture.
fn reference(scene: &Scene, camera: &Camera, size: [u32; 2], spp: u32) -> Vec<(DVec3, DVec3)> {
    let device = TestDevice::open();
    let mut session = session(&device, scene);
    let record = camera_record(camera, size);
    let frame = FrameRecord::new(record, record, size, 0, 99);
    let params = ReferenceParams { spp, ..ReferenceParams::default() };
    let pt_app::session::Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights).unwrap();
    let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0).unwrap();
    while render.next_sample() < spp {
        render.step(scene, gpu, lights, spp).unwrap();
    }
    let pixels = render.state().unwrap().estimate(spp).pixels;
    pixels.iter().map(|p| (p.mean.as_dvec3(), p.variance.as_dvec3())).collect()
}

fn floor(height: f32, half: f32, up: bool) -> [Vec3; 4] {
    let mut corners =
        [(-half, half), (half, half), (half, -half), (-half, -half)].map(|(x, z)| Vec3::new(x, height, z));
    if !up {
        corners.reverse();
    }
    corners
}

/// A white sky over a floor. Between them a ceiling that shows the sky, and above that an opaque one with a lamp below it.
fn under_a_hole(ceiling: MaterialKind) -> (Scene, Camera) {
    let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
    polygon(&mut scene, &floor(0.0, 20.0, true), Material::lambertian("floor", Vec3::splat(0.5)));
    let hole = Material::lambertian("hole", Vec3::ONE).with_kind(ceiling);
    polygon(&mut scene, &floor(1.0, 60.0, false), hole);
    polygon(&mut scene, &floor(1.5, 60.0, false), Material::lambertian("roof", Vec3::ZERO));
    scene.lights.push(Light::point("lamp", Vec3::Y * 1.2, Vec3::splat(100.0)));
    let camera = Camera::look_at("floor", Vec3::new(0.0, 0.5, 1.0), Vec3::ZERO, 0.6);
    (scene, camera)
}

/// The same bits as of the floor alone under the sky, and 0.5 on the average.
#[test]
fn light_from_infinity_passes_the_sky_and_other_light_does_not() {
    let size = [16, 12];
    let (scene, camera) = under_a_hole(MaterialKind::Sky);
    let mut open = scene.clone();
    open.instances.truncate(1);
    open.lights.clear();
    for backend in [TraceBackend::Compute, TraceBackend::RayQuery, TraceBackend::RtPipeline] {
        let [hole, sky] = [&scene, &open].map(|scene| {
            let params = direct_light_only();
            let mut frames = Frames::with_params(scene.clone(), &camera, backend, size, 5, false, params);
            frames.render(0.0);
            let pixels = frames.image(FLAT_COLOR).pixels;
            frames.finish();
            pixels
        });
        assert!(hole == sky, "{backend}: {:?} is not {:?}", hole[0], sky[0]);
        assert!(hole.iter().filter(|pixel| pixel[1] > 0.0).count() > hole.len() / 4, "{backend}");
    }
    let means = reference(&scene, &camera, size, 48);
    let mean = means.iter().map(|m| m.0).sum::<DVec3>() / means.len() as f64;
    let variance = means.iter().map(|m| m.1).sum::<DVec3>();
    let error = variance.map(f64::sqrt) / means.len() as f64;
    println!("reference: {mean} +- {error}");
    assert!(error.max_element() < 0.01 && (mean - 0.5).abs().cmplt(4.0 * error).all(), "{mean} +- {error}");
}

/// The camera behind the surface sees nothing but the surface: there is no end to what it shows.
#[test]
fn a_camera_that_sees_itself_ends_black() {
    let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
    let wall = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    polygon(&mut scene, &wall, Material::default().with_kind(MaterialKind::Camera));
    let camera = Camera::look_at("itself", Vec3::Z, Vec3::ZERO, 1.0);
    scene.cameras = vec![camera.clone()];
    scene.validate().unwrap();
    let size = [16, 12];
    let mut frames =
        Frames::with_params(scene.clone(), &camera, TraceBackend::Compute, size, 5, false, params(&[]));
    frames.render(0.0);
    let pixels = frames.image(FLAT_COLOR).pixels;
    frames.finish();
    assert!(pixels.iter().all(|pixel| *pixel == [0.0; 3]), "{:?}", pixels[0]);
    assert!(reference(&scene, &camera, size, 4).iter().all(|(mean, _)| *mean == DVec3::ZERO));
}

/// The steepest and the shortest waves that there are, after eleven days.
#[test]
fn the_wildest_water_is_finite() {
    let (mut scene, camera) = panels();
    for material in scene.materials.iter_mut().filter(|m| m.waves.is_some()) {
        material.waves = Some(Waves { slope: 1.0, length: 1e-3 });
    }
    scene.validate().unwrap();
    let backend = TraceBackend::Compute;
    let mut frames = Frames::with_params(scene, &camera, backend, SIZE, 5, false, params(&[]));
    for time in [0.0, 1e6] {
        frames.render(time);
        let pixels = frames.image(FLAT_COLOR).pixels;
        assert!(pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    }
    frames.finish();
}
