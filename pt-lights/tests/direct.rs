//! The direct lighting pass against closed forms and the BRDF oracle, on every trace backend of the device.

use glam::{Affine3A, DVec3, UVec2, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::pack::{pack_unit_vector, unpack_unit_vector};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Recorder};
use pt_core::{FrameSizes, StageInputs};
use pt_light_sampling::oracle::brdf::Brdf;
use pt_light_sampling::oracle::sampling::basis_around;
use pt_light_sampling::test_support::{Uploaded, polygon};
use pt_lights::records::LightRays;
use pt_lights::{DirectLighting, DirectParams};
use pt_scene::animation::{Deformation, Influence, Skin};
use pt_scene::{Environment, EnvironmentImage, Light, Material, Scene};
use pt_shaders::channels::{
    BASE_COLOR, CLUSTER, COLOR_HF, COLOR_SPEC, METALLIC_ROUGHNESS, NORMAL, RNG_SEED, SHADING_POSITION,
    VERTEX_NORMAL, VIEW_DIRECTION,
};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{AreaSampling, BvhImportance, FrameRecord, LightSampler, RisSource};
use std::f64::consts::PI;
use std::sync::Arc;

const SIZE: [u32; 2] = [32, 32];
/// Texel without a surface.
const HOLE: usize = 77;

/// What the G-buffer holds at every texel but [`HOLE`].
#[derive(Clone, Copy)]
struct Point {
    position: Vec3,
    normal: Vec3,
    /// Towards the viewer.
    view: Vec3,
    base: [f32; 4],
    metallic: f32,
    roughness: f32,
}

const LAMBERTIAN: Point = Point {
    position: Vec3::ZERO,
    normal: Vec3::Y,
    view: Vec3::Y,
    base: [0.5, 0.5, 0.5, 0.0],
    metallic: 0.0,
    roughness: 1.0,
};

/// The light channels of every texel and frame.
struct Light4 {
    hf: Vec<DVec3>,
    spec: Vec<DVec3>,
}

fn unorm16(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| ((v * 65535.0).round() as u16).to_le_bytes()).collect()
}

fn render(
    device: &TestDevice,
    scene: Scene,
    backend: TraceBackend,
    params: &DirectParams,
    frames: u32,
    point: impl Fn(usize) -> Point,
) -> Light4 {
    render_after(device, scene, |_| (), backend, params, frames, point)
}

/// As [`render`]; the scene changes by `step` after its tables have been made.
fn render_after(
    device: &TestDevice,
    scene: Scene,
    step: impl FnOnce(&mut Scene),
    backend: TraceBackend,
    params: &DirectParams,
    frames: u32,
    point: impl Fn(usize) -> Point,
) -> Light4 {
    let mut uploaded = Uploaded::new(device, scene, backend);
    let Uploaded { scene, lights, gpu } = &mut uploaded;
    lights.prepare(device, scene, gpu, params.sampler_choice()).unwrap();
    let stage = DirectLighting::new(device, uploaded.gpu.variant(), params).unwrap();
    step(&mut uploaded.scene);
    let images = ChannelImages::alone(device, FrameSizes::same(SIZE), &[DirectLighting::IO]).unwrap();
    let uniforms = Uniforms::<FrameRecord>::new(device, "frame_uniforms").unwrap();
    let count = (2 * field_width(SIZE[0]) * SIZE[1]) as usize;
    let points: Vec<Point> = (0..count).map(&point).collect();
    let words = |f: &dyn Fn(&Point) -> Vec<u32>| -> Vec<u8> {
        points.iter().flat_map(f).flat_map(|word| word.to_le_bytes()).collect()
    };
    let write = |id, bytes: &[u8]| images.current(id).write(bytes).unwrap();
    write(BASE_COLOR, &unorm16(&points.iter().flat_map(|p| p.base).collect::<Vec<_>>()));
    write(
        METALLIC_ROUGHNESS,
        &unorm16(&points.iter().flat_map(|p| [p.metallic, p.roughness]).collect::<Vec<_>>()),
    );
    write(NORMAL, &words(&|p| vec![pack_unit_vector(p.normal)]));
    let cluster = |p: &Point| uploaded.gpu.clusters().find(p.position) as u16;
    write(CLUSTER, &points.iter().flat_map(|p| cluster(p).to_le_bytes()).collect::<Vec<_>>());
    write(VERTEX_NORMAL, &words(&|p| vec![pack_unit_vector(p.normal)]));
    write(VIEW_DIRECTION, &words(&|p| vec![pack_unit_vector(-p.view), 1]));
    let mut position =
        words(&|p| [p.position.x, p.position.y, p.position.z, f32::from_bits(1)].map(f32::to_bits).into());
    position[16 * HOLE + 12..16 * HOLE + 16].fill(0);
    write(SHADING_POSITION, &position);
    let mut light = Light4 { hf: Vec::new(), spec: Vec::new() };
    let mut recorder = Recorder::new(device).unwrap();
    for index in 0..frames {
        let keys: Vec<u8> =
            (0..count as u32).flat_map(|i| [i, index]).flat_map(|word| word.to_le_bytes()).collect();
        write(RNG_SEED, &keys);
        let mut frame = recorder.begin().unwrap();
        let mut record: FrameRecord = bytemuck::Zeroable::zeroed();
        record.size = UVec2::from_array(SIZE);
        record.field_width = field_width(SIZE[0]);
        record.seed = 4;
        uniforms.upload(&mut frame, &record).unwrap();
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        lights.update(&mut frame, scene, gpu).unwrap();
        let inputs = StageInputs { scene: Some(&uploaded.gpu), uniforms: Some(&uniforms), images: &images };
        stage.record(&mut frame, &inputs, params, 0.0).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        for (list, id) in [(&mut light.hf, COLOR_HF), (&mut light.spec, COLOR_SPEC)] {
            let texels = images.current(id).read_f32().unwrap();
            let rgb = texels.chunks_exact(4).map(|t| DVec3::new(t[0].into(), t[1].into(), t[2].into()));
            list.extend(rgb.enumerate().filter(|(i, _)| *i != HOLE).map(|(_, c)| c));
            assert_eq!(texels[4 * HOLE..4 * HOLE + 3], [0.0; 3], "light where there is no surface");
        }
    }
    light
}

/// Mean of the green channel with its standard error.
fn mean(values: &[DVec3]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().map(|v| v.y).sum::<f64>() / n;
    let variance = values.iter().map(|v| (v.y - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Within four standard errors, of which there is to be some, and those below `precision` of the value.
fn assert_mean(name: &str, values: &[DVec3], expected: f64, precision: f64) {
    let (mean, error) = mean(values);
    assert!(
        (mean - expected).abs() < 4.0 * error + 1e-4 * expected,
        "{name}: {mean} +- {error}, not {expected}"
    );
    assert!(error < precision * expected, "{name}: the test is too noisy to tell: {mean} +- {error}");
}

fn floor() -> Scene {
    let mut scene = Scene::default();
    let corners = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    scene
}

fn backends(device: &TestDevice) -> Vec<TraceBackend> {
    let backends = TraceBackend::available(device);
    assert!(backends.contains(&TraceBackend::Compute));
    backends
}

/// Points on the floor along a diagonal, which does not shadow itself; the board over a part of it does.
#[test]
fn point_light_with_and_without_shadow() {
    let device = TestDevice::open();
    let mut scene = floor();
    let board =
        [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, z)| Vec3::new(x + 2.0, 1.0, z + 2.0));
    polygon(&mut scene, &board, Affine3A::IDENTITY, Material::lambertian("board", Vec3::ONE));
    scene.lights.push(Light::point("lamp", Vec3::new(0.0, 2.0, 0.0), Vec3::splat(10.0)));
    let at = |i: usize| Vec3::new(i as f32 * 0.008 - 3.0, 0.0, i as f32 * 0.008 - 3.0);
    for backend in backends(&device) {
        let point = |i| Point { position: at(i), ..LAMBERTIAN };
        let light = render(&device, scene.clone(), backend, &DirectParams::default(), 1, point);
        let (mut lit, mut dark) = (0, 0);
        for (i, hf) in (0..).filter(|&i| i != HOLE).zip(&light.hf) {
            let p = at(i).as_dvec3();
            // The board spans (1, 1) to (3, 3) half way up: on the floor its shadow reaches from (2, 2) to (6, 6).
            if (p.x - 2.0).abs() < 0.01 {
                continue;
            }
            if p.x > 2.0 {
                assert_eq!(hf.y, 0.0, "{backend} {p}");
                dark += 1;
            } else {
                let d2 = p.length_squared() + 4.0;
                let expected = 10.0 * 2.0 / d2.powf(1.5) / PI;
                assert!((hf.y / expected - 1.0).abs() < 2e-4, "{backend} {p}: {} {expected}", hf.y);
                lit += 1;
            }
        }
        assert!(lit > 500 && dark > 200, "{lit} {dark}");
        assert!(light.spec.iter().all(|s| *s == DVec3::ZERO), "a Lambertian surface has no specular light");
    }
}

/// Extended lights and the environment, unoccluded: closed forms, within the noise.
#[test]
fn extended_lights_have_their_closed_forms() {
    let device = TestDevice::open();
    let render = |scene: Scene, point: Point| {
        let frames = 8;
        render(&device, scene, TraceBackend::Compute, &DirectParams::default(), frames, |_| point).hf
    };
    let mut ball = floor();
    let position = Vec3::new(0.5, 1.5, 0.0);
    ball.lights.push(Light { radius: 0.3, ..Light::point("ball", position, Vec3::splat(10.0)) });
    // A sphere above the horizon lights like a point (inverse square law of Lambertian spheres).
    let d2 = f64::from(position.length_squared());
    assert_mean("ball", &render(ball, LAMBERTIAN), 10.0 * 1.5 / d2.powf(1.5) / PI, 5e-3);

    let mut sun = floor();
    let direction = Vec3::new(0.6, -0.8, 0.0);
    sun.lights.push(Light { angular_radius: 0.2, ..Light::directional("sun", direction, Vec3::splat(3.0)) });
    assert_mean("sun", &render(sun, LAMBERTIAN), 3.0 * 0.8 / PI, 5e-3);

    let mut lamps = floor();
    let corners =
        [(-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4)].map(|(x, z)| Vec3::new(x + 0.8, 1.0, z));
    polygon(&mut lamps, &corners, Affine3A::IDENTITY, Material::lamp("lamp", Vec3::splat(4.0)));
    // Turned up: no light from the back.
    let up = corners.map(|c| Vec3::new(c.x - 2.0, 1.2, -c.z));
    polygon(&mut lamps, &up, Affine3A::IDENTITY, Material::lamp("back", Vec3::splat(4.0)));
    assert_mean("lamp", &render(lamps, LAMBERTIAN), 4.0 * lambert(&corners) / PI, 2e-2);

    let mut sky = floor();
    sky.environment = Environment::constant(Vec3::splat(2.0));
    assert_mean("constant sky", &render(sky, LAMBERTIAN), 2.0, 2e-2);

    // A gradient: L = 1 + v-dependent; by quadrature of the lookup itself.
    let mut gradient = floor();
    let texels = (0..32 * 16).map(|i| Vec3::splat((i % 32) as f32 * 0.1 + (i / 32) as f32)).collect();
    gradient.environment = Environment::new(EnvironmentImage { width: 32, height: 16, texels });
    gradient.environment.rotation = 0.4;
    let expected = cosine_mean(|d| f64::from(gradient.environment.radiance(d.as_vec3()).y));
    assert_mean("gradient sky", &render(gradient.clone(), LAMBERTIAN), expected, 2e-2);
    let tilted = Point { normal: Vec3::X, view: Vec3::X, position: Vec3::new(0.0, 4.0, 0.0), ..LAMBERTIAN };
    let basis = basis_around(DVec3::X);
    let mut open = gradient.clone();
    open.instances.clear();
    polygon(
        &mut open,
        &[Vec3::ZERO, Vec3::X * 1e-3, Vec3::Y * 1e-3],
        Affine3A::IDENTITY,
        Material::lambertian("speck", Vec3::ONE),
    );
    let turn = |d: DVec3| basis * DVec3::new(d.x, d.z, d.y);
    let expected = cosine_mean(|d| f64::from(gradient.environment.radiance(turn(d).as_vec3()).y));
    assert_mean("gradient sky from the side", &render(open, tilted), expected, 2e-2);
}

/// The tables are made once: lights that move, go dark and light up reach the device all the same.
#[test]
fn moved_lights_are_where_they_are_now() {
    let device = TestDevice::open();
    let mut scene = floor();
    scene.lights.push(Light::point("goes dark", Vec3::Y, Vec3::splat(10.0)));
    scene.lights.push(Light::point("moves", Vec3::new(0.0, 1.0, 5.0), Vec3::splat(10.0)));
    scene.lights.push(Light::directional("lights up", Vec3::NEG_Y, Vec3::ZERO));
    let step = |scene: &mut Scene| {
        scene.lights[0].intensity = Vec3::ZERO;
        scene.lights[1].position = Vec3::new(0.0, 2.0, 0.0);
        scene.lights[2].intensity = Vec3::splat(3.0);
    };
    let params = DirectParams::default();
    let light = render_after(&device, scene, step, TraceBackend::Compute, &params, 1, |_| LAMBERTIAN);
    for hf in &light.hf {
        let expected = (10.0 / 4.0 + 3.0) / PI;
        assert!((hf.y / expected - 1.0).abs() < 2e-4, "{} {expected}", hf.y);
    }
}

/// A lamp whose mesh deforms, with probabilities from its first shape, in which one of its two triangles has no area.
#[test]
fn deformed_lamp_has_its_closed_form() {
    let device = TestDevice::open();
    let corners =
        [(-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4)].map(|(x, z)| Vec3::new(x + 0.8, 1.0, z));
    let mut scene = floor();
    polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lamp("lamp", Vec3::splat(4.0)));
    let mesh = &mut scene.meshes[1];
    [0, 0, 1, 1].into_iter().for_each(|joint| mesh.influences.push([Influence { joint, weight: 1.0 }]));
    let skin = Skin { joints: vec![0, 1], inverse_bind: vec![Affine3A::IDENTITY; 2] };
    let mut deformation = Deformation::new(mesh, 0, Some(Arc::new(skin)), &[]);
    deformation.joints[1] = Affine3A::from_scale(Vec3::new(0.0, 1.0, 1.0));
    mesh.deformation = Some(Box::new(deformation));
    scene.pose_meshes();
    assert_eq!(scene.meshes[1].positions[2], scene.meshes[1].positions[3]);
    let far = Affine3A::from_translation(Vec3::new(0.3, 0.0, 0.9));
    let step = |scene: &mut Scene| {
        if let Some(deformation) = &mut scene.meshes[1].deformation {
            deformation.joints[1] = far;
        }
    };
    let [a, b, c, d] = corners;
    let now = [a, b, far.transform_point3(c), far.transform_point3(d)];
    for backend in backends(&device) {
        let params = DirectParams::default();
        // The second triangle is picked once in a hundred samples.
        let hf = render_after(&device, scene.clone(), step, backend, &params, 60, |_| LAMBERTIAN).hf;
        assert_mean("deformed lamp", &hf, 4.0 * lambert(&now) / PI, 5e-2);
    }
}

/// Irradiance at the origin (normal +Y) from a polygon of radiance 1 (Lambert).
fn lambert(corners: &[Vec3]) -> f64 {
    let to = |i: usize| corners[i % corners.len()].as_dvec3().normalize();
    let edge = |i: usize| to(i).angle_between(to(i + 1)) * to(i).cross(to(i + 1)).normalize().y;
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

/// Cosine-weighted mean over the hemisphere about +Y.
fn cosine_mean(f: impl Fn(DVec3) -> f64) -> f64 {
    const N: usize = 400;
    let mut sum = 0.0;
    for i in 0..N {
        for j in 0..N {
            let (r, phi) = (((i as f64 + 0.5) / N as f64).sqrt(), 2.0 * PI * (j as f64 + 0.5) / N as f64);
            sum += f(DVec3::new(r * phi.cos(), (1.0 - r * r).sqrt(), r * phi.sin()));
        }
    }
    sum / (N * N) as f64
}

/// Both parts of the light of a sun, for many materials and views: the BRDF's oracle, demodulated.
#[test]
fn parts_equal_the_oracle() {
    let device = TestDevice::open();
    let mut scene = floor();
    let direction = Vec3::new(-0.4, -0.7, 0.3).normalize();
    scene.lights.push(Light::directional("sun", direction, Vec3::new(1.0, 2.0, 3.0)));
    let point = |i: usize| {
        let unit = |k: u32| pt_core::rng::random4([i as u32, 7], 0, k, 1);
        let ([a, b, c, d], [e, f, g, h]) = (unit(0), unit(1));
        let phi = std::f32::consts::TAU * h;
        let cos = 0.25 + 0.75 * g;
        let sin = (1.0 - cos * cos).sqrt();
        let quantise = |v: f32| (v * 65535.0).round() / 65535.0;
        Point {
            position: Vec3::ZERO,
            normal: unpack_unit_vector(pack_unit_vector(
                Vec3::new(0.2 * a - 0.1, 1.0, 0.2 * b - 0.1).normalize(),
            )),
            view: unpack_unit_vector(pack_unit_vector(Vec3::new(sin * phi.cos(), cos, sin * phi.sin()))),
            base: [a, b, c, 0.04 * d].map(quantise),
            metallic: (3.0 * e).floor() / 2.0,
            roughness: quantise(0.2 + 0.8 * f),
        }
    };
    let light = render(&device, scene, TraceBackend::Compute, &DirectParams::default(), 1, point);
    for ((i, hf), spec) in (0..).filter(|&i| i != HOLE).zip(&light.hf).zip(&light.spec) {
        let p: Point = point(i);
        let base = p.base.map(f64::from);
        let roughness = f64::from((p.roughness * 65535.0).round()) / 65535.0;
        let color = DVec3::new(base[0], base[1], base[2]);
        let metallic = (f64::from(p.metallic) * 65535.0).round() / 65535.0;
        // The material's own F0 is 0.04 and f90 1; KHR_materials_specular's factor scales both.
        let dielectric = (DVec3::splat(base[3]), (base[3] / 0.04).min(1.0));
        let brdf = Brdf::new(color, dielectric, metallic, roughness, false);
        let local = basis_around(p.normal.as_dvec3()).transpose();
        let (v, l) = (local * p.view.as_dvec3(), local * -direction.as_dvec3());
        let value = brdf.eval(v, l);
        let irradiance = DVec3::new(1.0, 2.0, 3.0) * l.z;
        let diffuse = value.diffuse * irradiance;
        let specular = value.specular * irradiance / brdf.f0.max(DVec3::splat(0.01));
        let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= 2e-3 * b.abs().max_element().max(1e-2);
        assert!(near(*hf, diffuse), "{i}: {hf} {diffuse}");
        assert!(near(*spec, specular), "{i}: {spec} {specular}");
    }
}

/// Every kind of light can be switched off, and the kinds add up.
#[test]
fn kinds_add_up() {
    let device = TestDevice::open();
    let off = DirectParams {
        sun: false,
        positional: false,
        emissive: false,
        environment: false,
        ..DirectParams::default()
    };
    let kinds = [
        DirectParams { sun: true, ..off.clone() },
        DirectParams { positional: true, ..off.clone() },
        DirectParams { emissive: true, ..off.clone() },
        DirectParams { environment: true, ..off.clone() },
    ];
    let light = |params: &DirectParams| {
        let point = Point { position: Vec3::new(0.2, 0.0, 0.3), ..LAMBERTIAN };
        render(
            &device,
            pt_light_sampling::test_support::all_kinds(),
            TraceBackend::Compute,
            params,
            1,
            |_| point,
        )
        .hf
    };
    assert!(light(&off).iter().all(|c| *c == DVec3::ZERO));
    let parts = kinds.map(|params| light(&params));
    for part in &parts {
        assert!(part.iter().any(|c| c.y > 0.0));
    }
    for (i, whole) in light(&DirectParams::default()).iter().enumerate() {
        let sum: DVec3 = parts.iter().map(|part| part[i]).sum();
        assert!((*whole - sum).abs().max_element() <= 1e-5 * sum.max_element(), "{whole} {sum}");
    }
}

/// Every sampler of local lights, also while it learns, has the mean that one ray for each kind of light has; the wrong probability of one light
/// would be found. Points are spread under lamps that a board hides in part.
#[test]
fn samplers_agree() {
    let device = TestDevice::open();
    let scene = || {
        let mut scene = pt_light_sampling::test_support::all_kinds();
        let board = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)].map(|(x, z)| Vec3::new(x, 1.2, z));
        polygon(&mut scene, &board, Affine3A::IDENTITY, Material::lambertian("board", Vec3::ONE));
        // The lists of clusters hold for points on surfaces.
        let floor = [(-2.1, 2.1), (2.1, 2.1), (2.1, -2.1), (-2.1, -2.1)].map(|(x, z)| Vec3::new(x, 0.0, z));
        polygon(&mut scene, &floor, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::ONE));
        scene
    };
    let point = |i: usize| {
        let at = |k: f32| (i as f32 * k).fract() * 4.0 - 2.0;
        Point { position: Vec3::new(at(0.618_034), 0.0, at(0.754_877_7)), ..LAMBERTIAN }
    };
    let only_local = DirectParams { sun: false, environment: false, ..DirectParams::default() };
    // Mean and its standard error over frames: points differ, frames don't.
    let mean = |params: &DirectParams| {
        let light = render(&device, scene(), TraceBackend::Compute, params, FRAMES, point).hf;
        let per_frame = light.len() / FRAMES as usize;
        let means: Vec<f64> =
            light.chunks(per_frame).map(|f| f.iter().map(|c| c.y).sum::<f64>() / per_frame as f64).collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
        (mean, (variance / means.len() as f64 / (means.len() as f64 - 1.0)).sqrt())
    };
    const FRAMES: u32 = 128;
    let (expected, spread) = mean(&DirectParams { rays: LightRays::PerKind, ..only_local.clone() });
    assert!(spread < 0.015 * expected, "{expected} +- {spread}");
    // Those with passes of their own have tests of their own.
    let alone = |s: &&LightSampler| !matches!(s, LightSampler::RestirDi | LightSampler::NeeAt);
    let samplers = LightSampler::VALUES
        .iter()
        .filter(alone)
        .map(|&sampler| DirectParams { sampler, ..only_local.clone() });
    let variants = [
        DirectParams { sampler: LightSampler::Ris, ris_source: RisSource::Power, ..only_local.clone() },
        DirectParams { area_sampling: AreaSampling::Projected, ..only_local.clone() },
        DirectParams { area_sampling: AreaSampling::Uniform, samples: 3, ..only_local.clone() },
        DirectParams {
            bvh_importance: BvhImportance::Bounds,
            sampler: LightSampler::LightBvh,
            ..only_local.clone()
        },
    ];
    for params in samplers.chain(variants) {
        let params = DirectParams { rays: LightRays::Merged, ..params };
        let (found, error) = mean(&params);
        let allowed = 4.0 * error.hypot(spread);
        assert!((found - expected).abs() < allowed, "{params:?}: {found} +- {error}, {expected} +- {spread}");
        assert!(
            allowed < 0.12 * expected,
            "{params:?}: {allowed} of {expected}: the test is too noisy to tell"
        );
    }
}
