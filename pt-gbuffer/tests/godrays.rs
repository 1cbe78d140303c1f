//! The god rays against their oracle: the march against the integral along each ray, the filter against its formula, on all backends.

use glam::{Affine3A, DVec2, DVec3, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::split::flat_to_split;
use pt_core::test_support::TestDevice;
use pt_core::trace::{NativeScene, TraceBackend};
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::oracle::godrays::{Marched, filtered, marched_pixel, scattered};
use pt_gbuffer::{GbufferParams, Godrays, GodraysParams, Jitter, PrimaryRays, images, oracle};
use pt_light_sampling::test_support::{Uploaded, polygon};
use pt_scene::gpu::{camera_record, mesh_geometry, placements};
use pt_scene::{Camera, Light, Material, Scene};
use pt_shaders::channels::{ChannelId, THROUGHPUT, TRANSPARENT};
use pt_shaders::records::{FrameRecord, GlassShadows, Ray, SKY_DISTANCE};

/// Odd: the last blocks are cut off.
const SIZE: [u32; 2] = [37, 23];
const LUX: Vec3 = Vec3::new(3.0, 2.0, 1.0);

/// A wall with a window of 1 m before a floor; the sun shines through the window, and the camera sees the beam from the side, above it the sky.
fn room() -> (Scene, Camera) {
    let mut scene = Scene::default();
    // What shines is weakened.
    let wall =
        Material { emissive: Vec3::new(0.2, 0.3, 0.4), ..Material::lambertian("wall", Vec3::splat(0.5)) };
    let mut rectangle = |x: [f32; 2], y: [f32; 2]| {
        let corners =
            [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(|(x, y)| Vec3::new(x, y, 0.0));
        polygon(&mut scene, &corners, Affine3A::IDENTITY, wall.clone());
    };
    rectangle([-9.0, -0.5], [0.0, 3.0]);
    rectangle([0.5, 9.0], [0.0, 3.0]);
    rectangle([-0.5, 0.5], [0.0, 1.0]);
    rectangle([-0.5, 0.5], [2.0, 3.0]);
    let floor = [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &floor, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    scene.lights.push(Light::directional("sun", Vec3::new(0.1, -1.0, 1.2), LUX));
    let camera = Camera::look_at("aside", Vec3::new(4.0, 1.5, 5.0), Vec3::new(0.0, 1.2, 1.0), 0.8);
    (scene, camera)
}

fn params() -> GodraysParams {
    GodraysParams { density: 0.05, albedo: 0.8, anisotropy: 0.4, steps: 64, max_distance: 12.0 }
}

/// Renders frames of the room, and gives each to `look`.
fn render(
    device: &TestDevice,
    backend: TraceBackend,
    count: u32,
    params: &GodraysParams,
    mut look: impl FnMut(u32, &ChannelImages, &Before),
) {
    let (scene, camera) = room();
    let mut uploaded = Uploaded::new(device, scene, backend);
    let variant = uploaded.gpu.variant();
    let primary = PrimaryRays::new(device, variant).unwrap();
    let godrays = Godrays::new(device, variant).unwrap();
    let io = [PrimaryRays::IO, Godrays::MARCH, Godrays::FILTER];
    let images = ChannelImages::alone(device, FrameSizes::same(SIZE), &io).unwrap();
    let uniforms = Uniforms::new(device, "frame_uniforms").unwrap();
    let gbuffer = GbufferParams { jitter: Jitter::None, ..Default::default() };
    let camera = camera_record(&camera, SIZE);
    let mut recorder = Recorder::new(device).unwrap();
    for index in 0..count {
        let mut pass = |with: bool| {
            let mut frame = recorder.begin().unwrap();
            uploaded.lights.update(&mut frame, &uploaded.scene, &mut uploaded.gpu).unwrap();
            uploaded.gpu.update(&mut frame, &uploaded.scene).unwrap();
            uniforms.upload(&mut frame, &FrameRecord::new(camera, camera, SIZE, index, 3)).unwrap();
            let inputs =
                StageInputs { scene: Some(&uploaded.gpu), uniforms: Some(&uniforms), images: &images };
            primary.record(&mut frame, &inputs, &gbuffer).unwrap();
            if with {
                godrays.record(&mut frame, &inputs, params, GlassShadows::Tinted).unwrap();
            }
            frame.submit().unwrap();
            recorder.finish().unwrap();
        };
        pass(false);
        let before =
            Before { transparent: texels(&images, TRANSPARENT), throughput: texels(&images, THROUGHPUT) };
        pass(true);
        look(index, &images, &before);
    }
}

/// The channels before the god rays.
struct Before {
    transparent: Vec<f32>,
    throughput: Vec<f32>,
}

fn texels(images: &ChannelImages, id: ChannelId) -> Vec<f32> {
    images.current(id).read_f32().unwrap()
}

fn rgb(texels: &[f32], index: usize) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|c| f64::from(texels[4 * index + c])))
}

fn blocks() -> [u32; 2] {
    [field_width(SIZE[0]), SIZE[1].div_ceil(2)]
}

const FRAMES: u32 = 16;

/// Means over many marches of each pixel against the integral.
fn check_march(backend: TraceBackend) {
    let device = TestDevice::open();
    if let Some(why) = backend.missing(&device) {
        return println!("skipped: {why}");
    }
    let (scene, camera) = room();
    let params = params();
    let native = NativeScene::new(&mesh_geometry(&scene), &placements(&scene), Default::default()).unwrap();
    let record = camera_record(&camera, SIZE);
    let towards_sun = -scene.lights[0].direction.as_dvec3();
    let texels_of = blocks()[0] * blocks()[1];
    let mut sums = vec![[DVec3::ZERO; 4]; texels_of as usize];
    render(&device, backend, FRAMES, &params, |index, images, _| {
        let marched = texels(images, images::GODRAYS);
        for (i, sum) in sums.iter_mut().enumerate() {
            let way = f64::from(marched[4 * i + 3]);
            let opacity = 1.0 - (-f64::from(params.density) * way).exp();
            sum[index as usize % 4] += rgb(&marched, i) * opacity * 4.0 / f64::from(FRAMES);
        }
    });
    let (mut worst, mut shaded, mut lit) = (0.0f64, 0, 0);
    let mut total = [DVec3::ZERO; 2];
    for (i, sum) in (0..).zip(&sums) {
        let q = [i % blocks()[0], i / blocks()[0]];
        for (index, found) in (0..).zip(sum) {
            let [x, y] = marched_pixel(q, index, SIZE);
            let uv =
                (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / DVec2::new(SIZE[0].into(), SIZE[1].into());
            let (origin, direction) = oracle::camera_ray(&record, uv);
            let ray = |from: DVec3, direction: DVec3| Ray {
                origin: from.as_vec3(),
                t_min: 0.0,
                direction: direction.as_vec3(),
                t_max: SKY_DISTANCE,
            };
            let surface = oracle::primary(&scene, &scene, &native, &record, &record, uv);
            let way = surface.map_or(f64::INFINITY, |s| s.view_depth).min(params.max_distance.into());
            let seen = std::cell::Cell::new(0);
            let exact = scattered(&params, LUX.as_dvec3(), towards_sun, direction, way, 2000, |t| {
                let lit = !native.occluded(&ray(origin + t * direction, towards_sun), u32::MAX, None);
                seen.set(seen.get() + u32::from(lit));
                lit
            });
            shaded += u32::from(seen.get() < 2000);
            lit += u32::from(seen.get() > 0);
            let whole = scattered(&params, LUX.as_dvec3(), towards_sun, direction, way, 2000, |_| true);
            worst = worst.max((*found - exact).abs().max_element() / whole.x);
            total[0] += *found;
            total[1] += exact;
        }
    }
    println!(
        "{backend}: worst {worst:.4}, sums {:.4} and {:.4}, {shaded} in shadow, {lit} lit",
        total[0], total[1]
    );
    // An edge of a shadow is in one of 64 steps, which is lit or not: a standard deviation of 1/128 at most, half of it over four
    // frames. A ray crosses up to four edges; four standard deviations.
    assert!(worst < 0.031, "{backend}: {worst}");
    assert!((total[0] / total[1] - 1.0).abs().max_element() < 5e-4, "{backend}: {total:?}");
    assert!(shaded > 300 && lit > 800, "{shaded} pixels in shadow, {lit} lit");
}

#[test]
fn the_march_finds_the_integral() {
    TraceBackend::CONCRETE.into_iter().for_each(check_march);
}

/// Pixel by pixel: what the filter makes of the marched pixels is added, what is behind is weakened.
#[test]
fn the_filter_is_its_formula() {
    let device = TestDevice::open();
    let params = GodraysParams { steps: 2, ..params() };
    render(&device, TraceBackend::Compute, 3, &params, |index, images, before| {
        let marched = texels(images, images::GODRAYS);
        let (transparent, throughput) = (texels(images, TRANSPARENT), texels(images, THROUGHPUT));
        let depth = texels(images, pt_shaders::channels::VIEW_DEPTH);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let [sx, sy] = flat_to_split([x, y], field_width(SIZE[0]));
                let i = (sy * 2 * field_width(SIZE[0]) + sx) as usize;
                let way = f64::from(depth[i].min(params.max_distance));
                let mut around = Vec::new();
                for qy in (y / 2).saturating_sub(2)..(y / 2 + 3).min(blocks()[1]) {
                    for qx in (x / 2).saturating_sub(2)..(x / 2 + 3).min(blocks()[0]) {
                        let place = (qy * blocks()[0] + qx) as usize;
                        let [px, py] = marched_pixel([qx, qy], index, SIZE);
                        let pixel = DVec2::new(px.into(), py.into());
                        around.push(Marched {
                            pixel,
                            mean: rgb(&marched, place),
                            way: marched[4 * place + 3].into(),
                        });
                    }
                }
                let left = (-f64::from(params.density) * way).exp();
                let light = filtered(&around, DVec2::new(x.into(), y.into()), way) * (1.0 - left);
                let expected = rgb(&before.transparent, i) * left + light;
                let found = rgb(&transparent, i);
                assert!(
                    (found - expected).abs().max_element() < 2e-5 * (1e-3 + expected.max_element()),
                    "({x},{y}): {found} for {expected}"
                );
                let (found, expected) = (rgb(&throughput, i), rgb(&before.throughput, i) * left);
                // fp16.
                assert!(
                    (found - expected).abs().max_element() < 6e-4,
                    "({x},{y}): throughput {found} for {expected}"
                );
                assert_eq!(before.transparent[4 * i + 3], transparent[4 * i + 3]);
            }
        }
    });
}
