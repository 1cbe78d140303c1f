//! The light samplers: how often a light is picked against its probability, and the mean of the direct light against that of all lights.

use crate::common::records::{SampleRecord, SamplerPush};
use crate::common::{kernels, run_sampler};
use glam::{Affine3A, Vec3};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{chi_squared, sidak};
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Error, Kernel, Location, Recorder, SceneResources};
use pt_light_sampling::SamplerChoice;
use pt_light_sampling::records::ListVisibility;
use pt_light_sampling::test_support::{Uploaded, all_kinds, polygon};
use pt_scene::{Light, Material, Scene, builtin};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::LightSampler;

const PICKS: u32 = 100_000;
/// Scenes and points: all kinds of light, without and with the environment among them, and many lamps in rooms.
const POINTS: [(&str, Vec3); 4] = [
    ("all kinds", Vec3::new(0.2, 0.1, 0.3)),
    (LISTED, Vec3::new(0.2, 0.1, 0.3)),
    ("lamps", Vec3::new(7.4, 0.02, 7.1)),
    ("lamps", Vec3::new(2.6, 1.2, 2.4)),
];
const LISTED: &str = "all kinds and the environment";

fn scene(name: &str) -> Scene {
    if name.starts_with("all kinds") { all_kinds() } else { builtin(name).unwrap() }
}

/// Samplers that have a probability for each light.
fn samplers() -> impl Iterator<Item = LightSampler> {
    let resamples = |s| matches!(s, LightSampler::Ris | LightSampler::RestirDi);
    LightSampler::VALUES.iter().copied().filter(move |&s| !resamples(s))
}

struct Picks {
    drawn: Vec<SampleRecord>,
    lights: Vec<SampleRecord>,
}

fn picks(device: &TestDevice, sampler: LightSampler, name: &str, at: Vec3) -> Picks {
    let mut uploaded = Uploaded::new(device, scene(name), TraceBackend::Compute);
    let Uploaded { scene, lights, gpu } = &mut uploaded;
    let choice = SamplerChoice { environment_listed: name == LISTED, ..sampler.into() };
    lights.prepare(device, scene, gpu, Some(choice)).unwrap();
    let count = lights.lists().local.len() as u32;
    let constants = [("light_sampler", sampler.code().into())];
    let kernel = Kernel::compute::<SamplerPush>(device, &kernels::PICK_LIGHT, &constants).unwrap();
    let mut run = |family, count| {
        let push = SamplerPush { family, count, seed: 3, parameter: 0.4, vector: at };
        run_sampler(device, &kernel, &push, Some(&mut uploaded), |pass| pass)
    };
    Picks { drawn: run(0, PICKS), lights: run(1, count) }
}

#[test]
fn lights_are_picked_as_often_as_their_probability_says() {
    let device = TestDevice::open();
    let tests = POINTS.len() * samplers().count();
    for (name, at) in POINTS {
        for sampler in samplers() {
            let Picks { drawn, lights } = picks(&device, sampler, name, at);
            let case = format!("{} in {name} at {at}", sampler.name());
            let sum: f64 = lights.iter().map(|l| f64::from(l.pdf)).sum();
            assert!(sum < 1.0 + 1e-4, "{case}: probabilities add up to {sum}");
            let mut observed = vec![0; lights.len() + 1];
            for pick in &drawn {
                let place = if pick.word == u32::MAX { lights.len() } else { pick.word as usize };
                observed[place] += 1;
                assert!((pick.pdf - pick.pdf_again).abs() <= 1e-4 * pick.pdf, "{case}: {pick:?}");
            }
            let none = (1.0 - sum).max(0.0);
            let mut expected: Vec<f64> =
                lights.iter().map(|l| f64::from(l.pdf)).chain([none]).map(|p| p * f64::from(PICKS)).collect();
            let p = chi_squared(&observed, &expected);
            assert!(p > sidak(tests), "{case}: p = {p}");
            // A wrong probability is found.
            let strongest = (0..lights.len()).max_by(|&a, &b| expected[a].total_cmp(&expected[b])).unwrap();
            let next = (strongest + 1) % lights.len();
            expected[next] += 0.05 * expected[strongest];
            expected[strongest] *= 0.95;
            if expected[strongest] > 2e4 {
                assert!(chi_squared(&observed, &expected) < 1e-6, "{case}");
            }
        }
    }
}

/// What can give light may be picked.
#[test]
fn no_light_that_counts_is_left_out() {
    let device = TestDevice::open();
    for (name, at) in POINTS {
        for sampler in samplers() {
            let lights = picks(&device, sampler, name, at).lights;
            for light in lights.iter().filter(|light| light.pdf_again > 0.0) {
                assert!(light.pdf > 0.0, "{} in {name} at {at}: {light:?}", sampler.name());
            }
            assert!(lights.iter().filter(|light| light.pdf > 0.0).count() > 3);
        }
    }
}

/// A kernel of a sampler whose tables were not prepared is refused, with the table that is missing and the call that makes it; so is one for gradient
/// pixels without last frame's tables. Without the check it would read from address 0.
#[test]
fn kernels_without_their_tables_are_refused() {
    let device = TestDevice::open();
    let mut uploaded = Uploaded::new(&device, all_kinds(), TraceBackend::Compute);
    let samples = Buffer::new(&device, "samples", 64, Location::Device).unwrap();
    let mut record = |sampler: LightSampler, replays: bool, prepared: Option<SamplerChoice>| {
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        lights.prepare(&device, scene, gpu, prepared).unwrap();
        let constants = [("light_sampler", sampler.code().into()), ("replays_samples", replays.into())];
        let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::PICK_LIGHT, &constants).unwrap();
        let mut recorder = Recorder::new(&device).unwrap();
        let mut frame = recorder.begin().unwrap();
        lights.update(&mut frame, scene, gpu).unwrap();
        let push = SamplerPush { family: 0, count: 1, seed: 3, parameter: 0.4, vector: Vec3::ZERO };
        let pass = frame.pass("picks", &kernel).write("samples", &samples).push(&push);
        gpu.bind(pass).dispatch([1, 1, 1])
    };
    let from = |sampler: LightSampler| Some(SamplerChoice::from(sampler));
    let mut check = |sampler: LightSampler, replays, prepared, table: &str, remedy: &str| {
        let error = record(sampler, replays, prepared).unwrap_err();
        let Error::MissingTable { .. } = &error else { panic!("{error}") };
        let message = error.to_string();
        let name = format!("\"{}\"", sampler.name());
        assert!([table, remedy, &name].iter().all(|word| message.contains(word)), "{message}");
    };
    const PREPARE: &str = "call LightTables::prepare";
    check(LightSampler::ClusterCdf, false, None, "the light lists", PREPARE);
    check(
        LightSampler::ClusterStats,
        false,
        from(LightSampler::ClusterCdf),
        "the shadow statistics",
        PREPARE,
    );
    check(LightSampler::LightBvh, false, from(LightSampler::ClusterStats), "the light tree", PREPARE);
    check(LightSampler::RestirDi, false, from(LightSampler::Ris), "of the last frame", PREPARE);
    check(LightSampler::Power, true, from(LightSampler::Power), "of the last frame", "keep_last_frame(true)");
    for sampler in [LightSampler::Uniform, LightSampler::Power, LightSampler::NeeAt] {
        record(sampler, false, None).unwrap();
    }
    record(LightSampler::LightBvh, false, from(LightSampler::LightBvh)).unwrap();
}

/// The weight of a light comes from 32 bytes: where the exact weight is above 0 it is too, and mostly they are alike. Triangles from a tenth of a millimetre
/// to ten metres, slivers, mirrored ones, and spot lights of narrow cones, seen from anywhere and along their planes.
#[test]
fn candidates_lose_no_light() {
    let device = TestDevice::open();
    let mut scene = Scene::default();
    for i in 0..200u32 {
        let [x, y, z, size] = random4([i, 0], 0, 0, 9);
        let [a, b, c, aspect] = random4([i, 0], 0, 1, 9);
        let size = 1e-4 * 1e5f32.powf(size);
        let at = Vec3::new(4.0 * x - 2.0, 4.0 * y - 2.0, 4.0 * z - 2.0);
        let along = (Vec3::new(a, b, c) - 0.5).normalize_or(Vec3::X);
        let across = (along.any_orthonormal_vector() + 0.5 * along) * 1e-4f32.powf(aspect * aspect);
        let lamp = Material::lamp("lamp", Vec3::ONE);
        let mirror = Affine3A::from_scale(Vec3::new(if i % 5 == 0 { -1.0 } else { 1.0 }, 1.0, 1.0));
        polygon(&mut scene, &[at, at + size * along, at + size * across], mirror, lamp);
        if i % 7 == 0 {
            scene.materials.last_mut().unwrap().double_sided = true;
        }
        if i % 4 == 0 {
            let radius = if i % 8 == 0 { 0.1 * size } else { 0.0 };
            let outer = 0.02 + 0.5 * aspect;
            let spot = Light::spot("spot", at, along, 0.98 * outer, outer, Vec3::ONE);
            scene.lights.push(Light { radius, ..spot });
        }
    }
    let mut uploaded = Uploaded::new(&device, scene, TraceBackend::Compute);
    let Uploaded { scene, lights, gpu } = &mut uploaded;
    lights.prepare(&device, scene, gpu, Some(LightSampler::ClusterCdf.into())).unwrap();
    let count = 600 * lights.lists().local.len() as u32;
    assert_eq!(count, 600 * 250);
    let constants = [("light_sampler", LightSampler::ClusterCdf.code().into())];
    let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::PICK_LIGHT, &constants).unwrap();
    let push = SamplerPush { family: 2, count, seed: 3, parameter: 0.4, vector: Vec3::ZERO };
    let weights = run_sampler(&device, &kernel, &push, Some(&mut uploaded), |pass| pass);
    let (mut counted, mut alike, mut extra) = (0, 0, 0);
    for weight in &weights {
        let (packed, exact) = (weight.pdf, weight.pdf_again);
        assert!(packed.is_finite() && packed >= 0.0, "{weight:?}");
        assert!(exact <= 0.0 || packed > 0.0, "a light that counts has no weight: {weight:?}");
        if exact > 0.0 {
            counted += 1;
            alike += usize::from(packed < 1.1 * exact && packed > 0.9 * exact);
            assert!(packed > 0.2 * exact, "{weight:?}");
        } else {
            extra += usize::from(packed > 0.0);
        }
    }
    println!("{counted} count, {alike} alike, {extra} have a weight for nothing");
    assert!(counted > 20_000 && alike > counted * 8 / 10 && extra < counted / 5, "{counted} {alike} {extra}");
}

/// Lights that nothing says may change change places: the lists of the clusters follow.
#[test]
fn lists_follow_lights_that_change_unannounced() {
    let device = TestDevice::open();
    let mut scene = Scene::default();
    let corners = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    // Some shine down from above the floor, the others from below it: these reach none of its clusters.
    let place = |i: u32, above: bool| Vec3::new(0.25 * i as f32 - 2.0, if above { 0.5 } else { -0.5 }, 0.3);
    scene
        .lights
        .extend((0..16).map(|i| Light::spot("lamp", place(i, i < 4), Vec3::NEG_Y, 1.0, 1.4, Vec3::ONE)));
    let mut uploaded = Uploaded::new(&device, scene, TraceBackend::Compute);
    let sampler = LightSampler::ClusterCdf;
    let Uploaded { scene, lights, gpu } = &mut uploaded;
    lights.prepare(&device, scene, gpu, Some(sampler.into())).unwrap();
    let constants = [("light_sampler", sampler.code().into())];
    let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::PICK_LIGHT, &constants).unwrap();
    for step in 0..3 {
        for (i, light) in (0..).zip(&mut uploaded.scene.lights) {
            light.position = place(i, (i + 5 * step) % 16 < 4 + 3 * step);
        }
        let push =
            SamplerPush { family: 1, count: 16, seed: 3, parameter: 0.4, vector: Vec3::new(0.1, 0.01, 0.2) };
        let picked = run_sampler(&device, &kernel, &push, Some(&mut uploaded), |pass| pass);
        let sum: f32 = picked.iter().map(|light| light.pdf).sum();
        assert!((sum - 1.0).abs() < 1e-4, "step {step}: probabilities add up to {sum}");
        for (i, light) in picked.iter().enumerate() {
            assert!(light.pdf > 0.0 || light.pdf_again <= 0.0, "step {step}: light {i} is left out");
        }
    }
}

/// Point lights on both sides of a wall; each side's clusters list their own. The quads of the environment, which stand before the lights, do not
/// confuse one with another; and a light that has moved since the rays were traced is listed wherever it may be seen now.
#[test]
fn lists_of_what_is_seen_name_the_right_lights() {
    let device = TestDevice::open();
    let mut scene = all_kinds();
    let wall = [(-9.0, 0.0), (9.0, 0.0), (9.0, 6.0), (-9.0, 6.0)].map(|(z, y)| Vec3::new(0.0, y, z));
    let board = Material { double_sided: true, ..Material::lambertian("wall", Vec3::ONE) };
    polygon(&mut scene, &wall, Affine3A::IDENTITY, board);
    for x in [-4.0, 4.0] {
        let corners = [(-4.0, 9.0), (4.0, 9.0), (4.0, -9.0), (-4.0, -9.0)];
        let corners = corners.map(|(dx, z)| Vec3::new(0.9 * dx + x, 0.0, z));
        polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::ONE));
    }
    scene.lights.clear();
    for i in 0..12 {
        let x = if i % 3 == 0 { 3.0 } else { -3.0 };
        let position = Vec3::new(x + 0.1 * i as f32, 1.0, 0.5 * i as f32 - 3.0);
        scene.lights.push(Light { id: i, ..Light::point("lamp", position, Vec3::splat(3.0)) });
    }
    let floor = [-6.0f32, 6.0].map(|x| Vec3::new(x, 0.001, 0.5));
    // For a point on each side the numbers of the listed lights, which begin with the first point light.
    let listed = |uploaded: &Uploaded| {
        let lists = uploaded.lights.sampler().unwrap().lists().unwrap();
        let first = uploaded.lights.lists().first_positional() as u32;
        floor.map(|at| {
            let cluster = uploaded.gpu.clusters().find(at) as usize;
            let all = lists.fixed.list(cluster).iter().chain(lists.changing.list(cluster));
            all.filter_map(|light| light.checked_sub(first)).collect::<Vec<u32>>()
        })
    };
    for environment_listed in [false, true] {
        let mut uploaded = Uploaded::new(&device, scene.clone(), TraceBackend::Compute);
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        let choice = SamplerChoice {
            environment_listed,
            list_visibility: ListVisibility::Rays,
            ..LightSampler::ClusterCdf.into()
        };
        lights.prepare(&device, scene, gpu, Some(choice)).unwrap();
        assert_eq!(lights.lists().quad_count() > 0, environment_listed);
        assert_eq!(listed(&uploaded), [vec![1, 2, 4, 5, 7, 8, 10, 11], vec![0, 3, 6, 9]]);
        // Lights 0 and 1 change sides, although nothing has said that they can.
        for (light, x) in [(0, -3.0), (1, 3.0)] {
            uploaded.scene.lights[light].position.x = x;
        }
        let mut recorder = Recorder::new(&device).unwrap();
        let mut frame = recorder.begin().unwrap();
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        lights.update(&mut frame, scene, gpu).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        let [left, right] = listed(&uploaded);
        assert!(left.contains(&0) && right.contains(&1), "{left:?} {right:?}");
        // The others are where they were, and are hidden as before.
        assert!(!left.contains(&3) && !right.contains(&2), "{left:?} {right:?}");
    }
}
