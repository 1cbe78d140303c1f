//! The light sampler nee-at: probabilities of what was learned, the mean while it learns, what it gains, and how it starts over.

use crate::common::kernels;
use crate::common::records::{NeeAtPicksPush, SampleRecord};
use crate::common::view::{Surface, View, look};
use glam::{Affine3A, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{chi_squared, sidak};
use pt_core::{Buffer, Kernel, Location, Recorder, SceneResources};
use pt_light_sampling::test_support::polygon;
use pt_lights::DirectParams;
use pt_lights::records::LightRays;
use pt_scene::{Light, Material, Scene, builtin};
use pt_shaders::records::{LightSampler, NEE_AT_PROXIES, NeeAtTile};

const SIZE: [u32; 2] = [32, 18];

fn params(sampler: LightSampler) -> DirectParams {
    DirectParams { sampler, rays: LightRays::Merged, ..DirectParams::default() }
}

/// A built-in scene from its first camera.
fn view<'d>(device: &'d TestDevice, name: &str, params: DirectParams, size: [u32; 2]) -> View<'d> {
    let scene = builtin(name).unwrap();
    let surfaces = look(&scene, &scene.cameras[0], size);
    let mut view = View::new(device, scene, params, size);
    view.show(&surfaces);
    view
}

fn tiles(view: &View<'_>) -> Vec<NeeAtTile> {
    view.stage.nee_at().unwrap().tiles().unwrap().read().unwrap()
}

fn tile_picks(view: &View<'_>, tile: usize, family: u32, count: u32) -> Vec<SampleRecord> {
    let device = view.device();
    let table = view.stage.nee_at().unwrap().tiles().unwrap();
    let constants = [("light_sampler", LightSampler::NeeAt.code().into())];
    let kernel = Kernel::compute::<NeeAtPicksPush>(device, &kernels::NEE_AT_PICKS, &constants).unwrap();
    let size = u64::from(count) * size_of::<SampleRecord>() as u64;
    let samples = Buffer::new(device, "samples", size, Location::Device).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let address = table.address() + (tile * size_of::<NeeAtTile>()) as u64;
    let push = NeeAtPicksPush { tile: address, family, count };
    let pass = frame.pass("picks", &kernel).write("samples", &samples).addresses(&table).push(&push);
    view.uploaded.gpu.bind(pass).dispatch([count, 1, 1]).unwrap();
    frame.submit().unwrap();
    samples.read().unwrap()
}

#[test]
fn lights_are_picked_as_often_as_their_probability_says() {
    const PICKS: u32 = 100_000;
    let device = TestDevice::open();
    let learning = DirectParams { nee_at_uniform: 0.3, ..params(LightSampler::NeeAt) };
    let cases = [("lamps", params(LightSampler::NeeAt)), ("lamps", learning)];
    let tests = 2 * cases.len();
    for (name, params) in cases {
        let mut view = view(&device, name, params, SIZE);
        (0..6).for_each(|_| drop(view.frame()));
        let learned = tiles(&view);
        let lights = view.uploaded.lights.lists().local.len() as u32;
        for tile in [1, learned.len() - 2] {
            assert!(learned[tile].narrow > 0.1, "tile {tile} has learned nothing: {}", learned[tile].narrow);
            assert!(learned[tile].lights.is_sorted(), "{:?}", learned[tile].lights);
            let expected: Vec<f64> =
                tile_picks(&view, tile, 1, lights).iter().map(|l| f64::from(l.pdf)).collect();
            let sum: f64 = expected.iter().sum();
            assert!((sum - 1.0).abs() < 1e-5, "probabilities add up to {sum}");
            let mut observed = vec![0; expected.len()];
            for pick in tile_picks(&view, tile, 0, PICKS) {
                observed[pick.word as usize] += 1;
                assert_eq!(pick.pdf, pick.pdf_again);
            }
            let mut expected: Vec<f64> = expected.iter().map(|p| p * f64::from(PICKS)).collect();
            let p = chi_squared(&observed, &expected);
            assert!(p > sidak(tests), "tile {tile}: p = {p}");
            // A wrong probability is found.
            let strongest = (0..expected.len()).max_by(|&a, &b| expected[a].total_cmp(&expected[b])).unwrap();
            expected[(strongest + 1) % lights as usize] += 0.5 * expected[strongest];
            expected[strongest] *= 0.5;
            assert!(chi_squared(&observed, &expected) < 1e-6);
        }
    }
}

/// Means over the pixels of six parts of the picture.
fn parts(picture: &[f64], size: [u32; 2]) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for (i, value) in (0..).zip(picture) {
        let part = (i % size[0] * 3 / size[0]) + 3 * (i / size[0] * 2 / size[1]);
        sums[part as usize] += value;
    }
    sums.map(|sum| sum * 6.0 / f64::from(size[0] * size[1]))
}

/// Means and variances of the mean over independent runs: of the parts of the picture, over `frames` frames after a reset.
fn runs(view: &mut View<'_>, runs: u32, frames: u32, mut step: impl FnMut(&mut Scene, u32)) -> [[f64; 2]; 6] {
    let mut sums = [[0.0; 2]; 6];
    for run in 0..runs {
        view.seed = 100 + run;
        view.reset();
        let mut means = [0.0; 6];
        for frame in 0..frames {
            step(&mut view.uploaded.scene, frame);
            let now = parts(&view.frame(), SIZE);
            means.iter_mut().zip(now).for_each(|(mean, now)| *mean += now / f64::from(frames));
        }
        for (sum, mean) in sums.iter_mut().zip(means) {
            *sum = [sum[0] + mean, sum[1] + mean * mean];
        }
    }
    let n = f64::from(runs);
    sums.map(|[sum, squares]| [sum / n, (squares / n - (sum / n).powi(2)).max(0.0) / (n - 1.0)])
}

/// Both samplers have the same mean over independent runs, within four standard errors of the difference.
fn assert_same_means(name: &str, learned: [[f64; 2]; 6], expected: [[f64; 2]; 6], precision: f64) {
    for (part, ([mean, variance], [expected, other])) in learned.into_iter().zip(expected).enumerate() {
        let error = (variance + other).sqrt();
        println!("{name}, part {part}: {mean:.5}, by power {expected:.5}, standard error {error:.5}");
        assert!(
            (mean - expected).abs() < 4.0 * error,
            "{name}, part {part}: {mean}, not {expected} +- {error}"
        );
        assert!(error < precision * expected, "{name}, part {part}: {expected} +- {error} tells nothing");
    }
}

#[test]
fn the_mean_is_right_while_it_learns() {
    let device = TestDevice::open();
    let mean = |params| runs(&mut view(&device, "lamps", params, SIZE), 64, 8, |_, _| ());
    let expected = mean(params(LightSampler::Power));
    assert_same_means("chosen among candidates", mean(params(LightSampler::NeeAt)), expected, 0.08);
    let alone = DirectParams { nee_at_candidates: 1, nee_at_uniform: 0.2, ..params(LightSampler::NeeAt) };
    assert_same_means("one candidate", mean(alone), expected, 0.08);
}

/// A closed-off hall: a floor with point lights over it that are seen from everywhere.
fn hall(lights: &[(Vec3, f32)], size: [u32; 2]) -> (Scene, Vec<Option<Surface>>) {
    let mut scene = Scene::default();
    let corners = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    for &(position, intensity) in lights {
        scene.lights.push(Light::point("lamp", position, Vec3::splat(intensity)));
    }
    let surface = |i: u32| {
        let x = (i % size[0]) as f32 * 8.0 / size[0] as f32 - 4.0;
        let position = Vec3::new(x, 0.0, (i / size[0]) as f32 * 0.25 - 2.25);
        Some(Surface { position, normal: Vec3::Y, to_viewer: Vec3::Y, material: 0 })
    };
    (scene, (0..size[0] * size[1]).map(surface).collect())
}

/// A lamp that is in another place in every frame, and two that blink in turn: what was learned of them is wrong in every frame.
#[test]
fn lights_that_move_and_blink_are_never_missing() {
    let device = TestDevice::open();
    let mut lights = vec![(Vec3::new(0.0, 0.5, 0.0), 3.0), (Vec3::new(-2.0, 1.0, 1.0), 4.0), (Vec3::Y, 0.0)];
    lights.extend((0..12).map(|i| (Vec3::new(i as f32 - 6.0, 2.0, 0.5 * i as f32 - 3.0), 0.5)));
    let (scene, surfaces) = hall(&lights, SIZE);
    let step = |scene: &mut Scene, frame: u32| {
        let place = Vec3::new((frame * 5 % 8) as f32 - 3.5, 0.5, (frame * 3 % 4) as f32 - 1.5);
        scene.lights[0].position = place;
        scene.lights[1].intensity = Vec3::splat(4.0 * (frame % 2) as f32);
        scene.lights[2].intensity = Vec3::splat(4.0 * ((frame + 1) % 2) as f32);
    };
    let mean = |params| {
        let mut view = View::new(&device, scene.clone(), params, SIZE);
        view.show(&surfaces);
        runs(&mut view, 64, 8, step)
    };
    let expected = mean(params(LightSampler::Power));
    assert_same_means("chosen among candidates", mean(params(LightSampler::NeeAt)), expected, 0.05);
    let alone = DirectParams { nee_at_candidates: 1, ..params(LightSampler::NeeAt) };
    assert_same_means("one candidate", mean(alone), expected, 0.05);
}

/// Mean over the pixels of the variance of frame `frame` after a reset, over independent runs, relative to the squared mean.
fn noise(view: &mut View<'_>, runs: u32, frame: u32) -> f64 {
    let mut sums: Vec<[f64; 2]> = Vec::new();
    for run in 0..runs {
        view.seed = 900 + run;
        view.reset();
        (0..frame).for_each(|_| drop(view.frame()));
        let picture = view.frame();
        sums.resize(picture.len(), [0.0; 2]);
        sums.iter_mut().zip(picture).for_each(|(s, v)| *s = [s[0] + v, s[1] + v * v]);
    }
    let n = f64::from(runs);
    let mean = sums.iter().map(|s| s[0] / n).sum::<f64>() / sums.len() as f64;
    let variance = sums.iter().map(|s| (s[1] - s[0] * s[0] / n) / (n - 1.0)).sum::<f64>() / sums.len() as f64;
    variance / (mean * mean)
}

#[test]
fn what_was_learned_lowers_the_variance() {
    let device = TestDevice::open();
    let size = [64, 36];
    let noise_of = |params: DirectParams, frame| noise(&mut view(&device, "lamps", params, size), 48, frame);
    let [power, cluster] =
        [LightSampler::Power, LightSampler::ClusterCdf].map(|sampler| noise_of(params(sampler), 0));
    println!("relative variance: power {power:.2}, cluster-cdf {cluster:.2}");
    let [alone, chosen] = [1, 8].map(|candidates| {
        let params = DirectParams { nee_at_candidates: candidates, ..params(LightSampler::NeeAt) };
        let noise = noise_of(params, 8);
        let [to_power, to_cluster] = [noise / power, noise / cluster];
        println!("nee-at, {candidates} candidates: {noise:.2}, {to_power:.3} of power, {to_cluster:.3} of cluster-cdf");
        noise
    });
    assert!(chosen < 0.2 * power && chosen < 0.9 * cluster && chosen < alone);
}

#[test]
fn a_reset_gives_the_first_frame_and_a_seed_the_same_bits() {
    let device = TestDevice::open();
    let mut view = view(&device, "lamps", params(LightSampler::NeeAt), SIZE);
    let sequence = |view: &mut View<'_>| -> Vec<Vec<f64>> { (0..5).map(|_| view.frame()).collect() };
    let first = sequence(&mut view);
    let learned = tiles(&view);
    assert!(learned.iter().any(|tile| tile.narrow > 0.1));
    view.reset();
    assert!(sequence(&mut view) == first, "after a reset");
    assert!(tiles(&view) == learned);
    let mut again = self::view(&device, "lamps", params(LightSampler::NeeAt), SIZE);
    assert!(sequence(&mut again) == first, "in another run");
    again.seed = 2;
    again.reset();
    assert!(sequence(&mut again) != first, "with another seed");
    // Without a choice among candidates the first frame is that of the power sampler: nothing was learned.
    let alone = DirectParams { nee_at_candidates: 1, ..params(LightSampler::NeeAt) };
    let [alone, power] =
        [alone, params(LightSampler::Power)].map(|params| self::view(&device, "lamps", params, SIZE).frame());
    assert!(alone == power && alone != first[0]);
}

/// Lists of other tiles or frames are other lists: none is drawn with the numbers of another, as those that scroll from frame to frame.
#[test]
fn tiles_and_frames_draw_their_own_proxies() {
    let device = TestDevice::open();
    let all_global =
        DirectParams { nee_at_global_share: 1.0, nee_at_history: 0.0, ..params(LightSampler::NeeAt) };
    let mut view = view(&device, "lamps", all_global, SIZE);
    let mut lists = Vec::new();
    for frame in 0..6 {
        view.frame();
        for tile in tiles(&view) {
            // In the first frame there are none.
            assert_eq!(tile.narrow > 0.0, frame > 0, "{}", tile.narrow);
            lists.extend((frame > 0).then_some(tile.lights));
        }
    }
    // Half of a list is drawn by power: by chance two share about a seventh of all, with the same numbers at least half.
    let common = |a: &[u32], b: &[u32]| {
        let mut left = b.to_vec();
        a.iter()
            .filter(|light| left.iter().position(|l| l == *light).map(|at| left.swap_remove(at)).is_some())
            .count()
    };
    for (i, a) in lists.iter().enumerate() {
        for b in &lists[..i] {
            let shared = common(a, b);
            assert!(shared < 60, "{shared} common proxies of {NEE_AT_PROXIES}");
        }
    }
}

/// Two halves of a picture with a wall between them, each with a lamp of its own. The picture moves by half its width: what was learned
/// moves with it. Tiles of the sky learn nothing.
#[test]
fn what_was_learned_moves_with_the_picture() {
    const SIZE: [u32; 2] = [64, 18];
    let device = TestDevice::open();
    let lights = [(Vec3::new(-2.0, 1.0, 0.0), 5.0), (Vec3::new(2.0, 1.0, 0.0), 5.0)];
    let (mut scene, mut surfaces) = hall(&lights, SIZE);
    let wall = [(-9.0, 0.0), (9.0, 0.0), (9.0, 9.0), (-9.0, 9.0)].map(|(z, y)| Vec3::new(-0.06, y, z));
    polygon(&mut scene, &wall, Affine3A::IDENTITY, Material::lambertian("wall", Vec3::ONE));
    // All but the first four rows show the sky.
    surfaces.iter_mut().skip((SIZE[0] * 4) as usize).for_each(|s| *s = None);
    let params = DirectParams { nee_at_global_share: 0.0, ..params(LightSampler::NeeAt) };
    let mut view = View::new(&device, scene, params, SIZE);
    view.show(&surfaces);
    let share = |tile: &NeeAtTile, light: u32| {
        tile.lights.iter().filter(|&&l| l == light).count() as f64 / tile.lights.len() as f64
    };
    (0..5).for_each(|_| drop(view.frame()));
    // A row has four tiles of the even field, then four of the odd one. Those in the middle see over the wall with their margins.
    let still = tiles(&view);
    for field in [0, 4] {
        let shares = [share(&still[field], 0), share(&still[field + 3], 1)];
        assert!(shares.into_iter().all(|share| share > 0.8), "{shares:?}");
    }
    assert!(still[16..].iter().all(|tile| tile.narrow == 0.0), "sky");
    let half = SIZE[0] / 2;
    let shifted: Vec<_> = (0..surfaces.len())
        .map(|i| if i as u32 % SIZE[0] < half { surfaces[i + half as usize] } else { surfaces[i] })
        .collect();
    view.show(&shifted);
    view.set_motion(|_, _| [half as f32, 0.0]);
    view.frame();
    let moved = tiles(&view);
    for field in [0, 4] {
        let tile = &moved[field + 1];
        assert!(
            tile.narrow > 0.0 && share(tile, 1) > 0.8,
            "the second tile is the last one of before: {tile:?}"
        );
        assert_eq!(moved[field + 3].narrow, 0.0, "new in the picture");
    }
}
