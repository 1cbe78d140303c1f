//! The light samplers: how often a light is picked against its probability, and the mean of the direct light against that of all lights.

mod common;

use common::records::{SampleRecord, SamplerPush};
use common::{kernels, run_sampler};
use glam::{Affine3A, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{chi_squared, sidak};
use pt_core::trace::TraceBackend;
use pt_core::{Kernel, Recorder};
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
