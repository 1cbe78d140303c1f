//! What holds for every sampler: lights that move are where they are now, tiny ones have their closed form, and what was learned can be
//! forgotten.

use crate::common::pixels::{Pixel, Rig};
use glam::{Affine3A, DVec3, Vec3};
use pt_core::Error;
use pt_core::test_support::TestDevice;
use pt_light_sampling::SamplerChoice;
use pt_light_sampling::test_support::polygon;
use pt_lights::DirectParams;
use pt_lights::records::LightRays;
use pt_scene::{Blink, Instance, Light, LightMotion, Material, Motion, Scene};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{AreaSampling, LightSampler};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [16, 16];
/// Side of the ground that the pixels show, metres.
const GROUND: f32 = 6.0;

/// All samplers, and the rays for each kind of light.
fn all_params() -> Vec<(String, DirectParams)> {
    let merged = |&sampler: &LightSampler| {
        let params = DirectParams { sampler, rays: LightRays::Merged, samples: 4, ..DirectParams::default() };
        (sampler.name().to_owned(), params)
    };
    let per_kind = DirectParams { rays: LightRays::PerKind, samples: 4, ..DirectParams::default() };
    let samplers = LightSampler::VALUES.iter().map(merged);
    samplers.chain([("per-kind".to_owned(), per_kind)]).collect()
}

fn floor() -> Scene {
    let mut scene = Scene::default();
    let corners = [(-4.0, 4.0), (4.0, 4.0), (4.0, -4.0), (-4.0, -4.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    scene
}

fn place([x, y]: [u32; 2]) -> Vec3 {
    let at = |i: u32| (i as f32 + 0.5) / SIZE[0] as f32 * GROUND - 0.5 * GROUND;
    Vec3::new(at(x), 0.0, at(y))
}

fn ground(at: [u32; 2]) -> Option<Pixel> {
    Some(Pixel { position: place(at), ..Pixel::LAMBERTIAN })
}

/// Irradiance of the ground from a polygon of radiance 1 above it, which faces it (Lambert).
fn lambert(point: Vec3, corners: &[Vec3]) -> f64 {
    let to = |i: usize| (corners[i % corners.len()] - point).as_dvec3().normalize();
    let edge = |i: usize| to(i).angle_between(to(i + 1)) * to(i).cross(to(i + 1)).normalize().y;
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

/// What [`Rig::light`] says of an irradiance of the ground.
fn shown(irradiance: f64) -> f64 {
    0.5 * irradiance / PI
}

const LAMP: [Vec3; 4] = [
    Vec3::new(-0.4, 1.0, -0.4),
    Vec3::new(0.4, 1.0, -0.4),
    Vec3::new(0.4, 1.0, 0.4),
    Vec3::new(-0.4, 1.0, 0.4),
];
const LAMP_RADIANCE: f32 = 6.0;
const POINT_CANDELA: f32 = 2.0;

/// A point light and a lamp above it that go from side to side, by metres in each frame; two point lights of which one is above the ground while
/// the other is below; and weak lights that stand still.
fn moving_lights() -> Scene {
    let mut scene = floor();
    polygon(&mut scene, &LAMP, Affine3A::IDENTITY, Material::lamp("lamp", Vec3::splat(LAMP_RADIANCE)));
    if let Some(lamp) = scene.instances.pop() {
        scene.instances.push(Instance::moving("lamp", lamp.mesh, slide(0.5)));
    }
    let motion = LightMotion { path: slide(0.4), peak: Vec3::splat(POINT_CANDELA), blink: Blink::Steady };
    scene.lights.push(Light::point("moves", Vec3::ZERO, Vec3::splat(POINT_CANDELA)).moving(motion));
    for (name, rise) in [("sets", 0.6), ("rises", -0.6)] {
        let path = Motion::Slide {
            rest: Affine3A::from_translation(-0.2 * Vec3::Y),
            reach: rise * Vec3::Y,
            period_s: 4.0,
        };
        let motion = LightMotion { path, peak: Vec3::splat(POINT_CANDELA), blink: Blink::Steady };
        scene.lights.push(Light::point(name, Vec3::ZERO, Vec3::splat(POINT_CANDELA)).moving(motion));
    }
    for i in 0..6 {
        let position = Vec3::new(i as f32 - 2.5, 0.7, (i % 3) as f32 - 1.0);
        scene.lights.push(Light::point("still", position, Vec3::splat(0.1)));
    }
    scene
}

fn slide(height: f32) -> Motion {
    let rest = Affine3A::from_translation(height * Vec3::Y);
    Motion::Slide { rest, reach: 2.0 * Vec3::X, period_s: 4.0 }
}

/// Half of a period: the next frame has the lights on the other side.
fn time(frame: u32) -> f64 {
    1.0 + 2.0 * f64::from(frame)
}

/// Closed form of the light of a pixel.
fn expected(scene: &Scene, at: [u32; 2]) -> f64 {
    let point = place(at);
    let from_point = |light: &Light| {
        let d = (light.position - point).as_dvec3();
        f64::from(light.intensity.y) * d.y.max(0.0) / d.length().powi(3)
    };
    let lamp = scene.instances[1].world_from_object;
    let corners = LAMP.map(|corner| lamp.transform_point3(corner));
    shown(
        scene.lights.iter().map(from_point).sum::<f64>()
            + f64::from(LAMP_RADIANCE) * lambert(point, &corners),
    )
}

/// Means of the left and the right half of the ground.
fn halves(light: impl Iterator<Item = ([u32; 2], f64)>) -> [f64; 2] {
    let mut sums = [0.0; 2];
    light.for_each(|([x, _], value)| sums[usize::from(2 * x >= SIZE[0])] += value);
    sums.map(|sum| 2.0 * sum / f64::from(SIZE[0] * SIZE[1]))
}

fn pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]))
}

/// In every frame the light is that of the lights where they are then: none is a frame late.
#[test]
fn lights_that_move_in_every_frame_are_never_missing() {
    const RUNS: u32 = 32;
    const FRAMES: u32 = 4;
    let device = TestDevice::open();
    for (name, params) in all_params() {
        let mut rig = Rig::new(&device, moving_lights(), SIZE, &params);
        let mut seen = vec![Vec::new(); FRAMES as usize];
        let mut exact = vec![[0.0; 2]; FRAMES as usize];
        for seed in 0..RUNS {
            rig.images.reset_history();
            rig.uploaded.lights.forget().unwrap();
            for frame in 0..FRAMES {
                rig.uploaded.scene.set_time(time(frame), time(frame) - 2.0);
                rig.frame(frame, 50 + seed, &ground);
                seen[frame as usize].push(halves(pixels().zip(rig.light())));
                exact[frame as usize] = halves(pixels().map(|at| (at, expected(&rig.uploaded.scene, at))));
            }
        }
        for (frame, (runs, exact)) in seen.iter().zip(&exact).enumerate() {
            for half in 0..2 {
                let n = f64::from(RUNS);
                let mean = runs.iter().map(|run| run[half]).sum::<f64>() / n;
                let variance = runs.iter().map(|run| (run[half] - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
                let (error, exact) = (variance.sqrt(), exact[half]);
                let case =
                    format!("{name}, frame {frame}, half {half}: {mean:.4} +- {error:.4} of {exact:.4}");
                println!("{case}");
                assert!((mean - exact).abs() < 4.0 * error + 1e-3 * exact, "{case}");
                assert!(error < 0.08 * exact, "{case}: too noisy to tell");
            }
        }
        // Lights of the frame before would be noticed.
        assert!(exact[1][0] > 1.5 * exact[0][0] || exact[0][0] > 1.5 * exact[1][0], "{exact:?}");
    }
}

/// A lamp of one triangle, down to a micrometre, of which the normal hangs on the last digits of the edges: the light of a point with its power
/// and normal. Edges with the digits of half floats would have other normals.
#[test]
fn tiny_emitters_have_their_closed_form() {
    const RADIANCE: f32 = 1e10;
    let device = TestDevice::open();
    let middle = Vec3::new(0.3, 1.2, -0.4);
    let corners = [Vec3::ZERO, Vec3::new(1.0, 0.3, 0.2), Vec3::new(1.0, 0.33, 0.27)];
    let across = corners[1].as_dvec3().cross(corners[2].as_dvec3());
    let (normal, area) = (across.normalize(), 0.5 * across.length());
    let mut scene = floor();
    let lamp = Material::lamp("lamp", Vec3::splat(RADIANCE));
    polygon(&mut scene, &corners, Affine3A::IDENTITY, lamp);
    if let Some(lamp) = scene.instances.pop() {
        scene.instances.push(Instance::moving("lamp", lamp.mesh, slide(0.5)));
    }
    let methods = AreaSampling::ALL.map(|area_sampling| DirectParams {
        area_sampling,
        sampler: LightSampler::Power,
        rays: LightRays::Merged,
        ..DirectParams::default()
    });
    let reused = DirectParams { sampler: LightSampler::RestirDi, ..methods[1].clone() };
    let per_kind = DirectParams { rays: LightRays::PerKind, ..methods[1].clone() };
    for params in methods.iter().chain([&reused, &per_kind]) {
        let mut rig = Rig::new(&device, scene.clone(), SIZE, params);
        for (frame, size) in (0..).zip([1e-3f32, 1e-4, 1e-5, 1e-6]) {
            let place_lamp = Affine3A::from_translation(middle) * Affine3A::from_scale(Vec3::splat(size));
            rig.uploaded.scene.instances[1].world_from_object = place_lamp;
            rig.frame(frame, 1, &ground);
            let power = f64::from(RADIANCE) * area * f64::from(size).powi(2);
            let mut lit = 0;
            for (at, light) in pixels().zip(rig.light()) {
                let d: DVec3 = middle.as_dvec3() - place(at).as_dvec3();
                let cos = -normal.dot(d) / d.length();
                let exact = shown(power * cos.max(0.0) * d.y / d.length().powi(3));
                let case =
                    format!("{size} m, {}, {}, {at:?}", params.area_sampling.name(), params.rays.name());
                // Near the lamp's horizon a rounding of its normal counts more.
                let tolerance = if cos < 0.05 { 0.05 } else { 3e-3 };
                assert!((light / exact - 1.0).abs() < tolerance || cos < 0.005, "{case}: {light} of {exact}");
                lit += u32::from(cos > 0.05);
            }
            assert!(lit > 64, "{lit} of 256 pixels are lit");
        }
    }
}

/// What a run has taught a sampler is not known to the next one: the comparison of samplers relies on runs that are independent.
#[test]
fn a_sampler_that_has_forgotten_is_new() {
    let device = TestDevice::open();
    // A board hides half of the lights from each point: there is something to learn.
    let scene = || {
        let mut scene = moving_lights();
        let board = [(0.0, -4.0), (0.0, 4.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
        let corners = [board[0], board[1], board[1] + 0.6 * Vec3::Y, board[0] + 0.6 * Vec3::Y];
        polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("board", Vec3::ONE));
        scene
    };
    // The other samplers keep nothing.
    let some = ["power", "cluster-stats", "restir-di", "nee-at"];
    for (name, params) in all_params().into_iter().filter(|(name, _)| some.contains(&name.as_str())) {
        let mut rig = Rig::new(&device, scene(), SIZE, &params);
        let run = |rig: &mut Rig| -> Vec<Vec<f64>> {
            let frame = |index| {
                rig.frame(index, 7, &ground);
                rig.light()
            };
            (0..5).map(frame).collect()
        };
        let first = run(&mut rig);
        let learned = run(&mut rig);
        assert_eq!(first != learned, name != "power", "{name}: without a reset");
        rig.images.reset_history();
        rig.uploaded.lights.forget().unwrap();
        assert!(run(&mut rig) == first, "{name}");
    }
}

/// Tables that were made for another sampler, or not brought to this frame: the stage is refused with an error that says which table is missing and
/// what makes it. Without the check its kernels read from address 0. (`pt-light-sampling/tests/samplers.rs` has all samplers.)
#[test]
fn a_stage_without_its_tables_is_refused() {
    const PREPARE: &str = "call LightTables::prepare";
    let device = TestDevice::open();
    let from = |sampler: LightSampler| Some(SamplerChoice::from(sampler));
    type Case = (Option<SamplerChoice>, bool, Option<[&'static str; 2]>);
    let check = |sampler: LightSampler, cases: &[Case]| {
        let params = DirectParams { sampler, rays: LightRays::Merged, ..DirectParams::default() };
        let mut rig = Rig::new(&device, floor(), [2, 2], &params);
        for &(prepared, updates, missing) in cases {
            let (lights, gpu) = (&mut rig.uploaded.lights, &mut rig.uploaded.gpu);
            lights.prepare(&device, &rig.uploaded.scene, gpu, prepared).unwrap();
            let name = format!("\"{}\"", sampler.name());
            match (rig.try_record(updates), missing) {
                (Ok(()), None) => {}
                (Err(error @ Error::MissingTable { .. }), Some(words)) => {
                    let message = error.to_string();
                    assert!(words.iter().chain([&&*name]).all(|word| message.contains(word)), "{message}");
                }
                (result, _) => {
                    panic!("{name}: {:?}, expected {missing:?}", result.map_err(|e| e.to_string()))
                }
            }
        }
    };
    let tree = LightSampler::LightBvh;
    let listed = Some(SamplerChoice { environment_listed: true, ..tree.into() });
    check(
        tree,
        &[
            (None, true, Some(["the light tree", PREPARE])),
            (from(LightSampler::ClusterCdf), true, Some(["the light tree", PREPARE])),
            (listed, true, Some(["without quads of the environment", PREPARE])),
            (from(tree), false, Some(["in this frame", "call LightTables::update"])),
            (from(tree), true, None),
        ],
    );
    check(
        LightSampler::RestirDi,
        &[
            (None, true, Some(["the light lists", PREPARE])),
            (from(LightSampler::Ris), true, Some(["of the last frame", PREPARE])),
            (from(LightSampler::RestirDi), true, None),
        ],
    );
}
