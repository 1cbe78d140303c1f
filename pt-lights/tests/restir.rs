//! The sampler restir-di: the mean light with reuse against that without, over independent runs; histories, lights that change, and noise.
//!
//! A run is a sequence of frames with a seed of its own that starts without history. Frames of a run and pixels of a frame depend on each
//! other through reuse, so errors are standard errors of the means of runs.

use crate::common::pixels::{Pixel, Rig};
use glam::{Affine3A, Vec2, Vec3};
use pt_core::test_support::TestDevice;
use pt_light_sampling::test_support::{all_kinds, polygon};
use pt_light_sampling::{LightBounds, LightLists};
use pt_lights::records::{LightRays, RestirVisibility, RestirWeights};
use pt_lights::{DirectParams, duplicated_samples};
use pt_scene::{Light, Material, Scene, builtin};
use pt_shaders::records::{AreaSampling, LightSampler, RisSource};

const SIZE: [u32; 2] = [16, 16];
const RUNS: u32 = 64;
const FRAMES: u32 = 4;
/// Parts of the frame whose means are compared: four columns, over which the horizon turns.
const BANDS: usize = 4;

fn local(sampler: LightSampler) -> DirectParams {
    DirectParams {
        sampler,
        sun: false,
        environment: false,
        rays: LightRays::Merged,
        // The lists of clusters are made for the surfaces of the scene, which the pixels of these tests are not.
        ris_source: RisSource::Power,
        ris_candidates: 4,
        ..DirectParams::default()
    }
}

fn restir(weights: RestirWeights, visibility: RestirVisibility) -> DirectParams {
    DirectParams {
        restir_weights: weights,
        restir_visibility: visibility,
        restir_radius: 4.0,
        restir_spatial: 4,
        ..local(LightSampler::RestirDi)
    }
}

/// Lamps above and at the horizon, and a board (the last instance) between some of them and the ground.
fn scene() -> Scene {
    let mut scene = all_kinds();
    let side = [(0.1, -1.0), (0.1, 1.0), (1.1, 1.0), (1.1, -1.0)];
    for (x, turn) in [(-3.5, 1.0), (3.5, -1.0)] {
        // They face the middle.
        let corners = side.map(|(y, z)| Vec3::new(x, y, -z * turn));
        polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lamp("side", Vec3::splat(3.0)));
    }
    let board = [(-0.7, 0.8), (0.9, 0.8), (0.9, -0.6), (-0.7, -0.6)].map(|(x, z)| Vec3::new(x, 1.0, z));
    polygon(&mut scene, &board, Affine3A::IDENTITY, Material::lambertian("board", Vec3::ONE));
    scene
}

/// A ground whose normal turns from left to right, so that neighbours have other horizons; the upper half is glossy.
fn ground([x, y]: [u32; 2]) -> Option<Pixel> {
    let (u, v) = (x as f32 / 15.0 - 0.5, y as f32 / 15.0 - 0.5);
    let angle = 2.2 * u;
    let normal = Vec3::new(angle.sin(), angle.cos(), 0.4 * v).normalize();
    Some(Pixel {
        position: Vec3::new(4.0 * u, 0.0, 4.0 * v),
        normal,
        view: (normal + Vec3::new(0.3, 0.5, 0.2)).normalize(),
        base: [0.5, 0.5, 0.5, if y < 8 { 0.04 } else { 0.0 }],
        roughness: 0.5,
        ..Pixel::LAMBERTIAN
    })
}

/// Means over runs, with their standard errors.
struct Means {
    mean: [f64; BANDS],
    error: [f64; BANDS],
}

impl Means {
    fn of(runs: &[[f64; BANDS]]) -> Self {
        let n = runs.len() as f64;
        let mean: [f64; BANDS] = std::array::from_fn(|b| runs.iter().map(|run| run[b]).sum::<f64>() / n);
        let square = |b: usize| runs.iter().map(|run| (run[b] - mean[b]).powi(2)).sum::<f64>();
        Self { mean, error: std::array::from_fn(|b| (square(b) / (n - 1.0) / n).sqrt()) }
    }

    fn total(&self) -> f64 {
        self.mean.iter().sum()
    }

    /// Differences from `other` in standard errors of both.
    fn deviations(&self, other: &Self) -> [f64; BANDS] {
        std::array::from_fn(|b| (self.mean[b] - other.mean[b]) / self.error[b].hypot(other.error[b]))
    }

    /// Within 4 standard errors in each band, which are to be below `precision` of the value.
    fn assert_equal(&self, other: &Self, precision: f64, case: &str) {
        let deviations = self.deviations(other);
        println!("{case}: {:.4} of {:.4}, in standard errors {deviations:.1?}", self.total(), other.total());
        for b in 0..BANDS {
            let error = self.error[b].hypot(other.error[b]);
            assert!(
                error < precision * other.mean[b],
                "{case}: too noisy to tell: {error} of {}",
                other.mean[b]
            );
        }
        assert!(deviations.iter().all(|d| d.abs() < 4.0), "{case}: {:?} {:?}", self.mean, other.mean);
    }
}

fn bands(light: &[f64]) -> [f64; BANDS] {
    let mut sums = [0.0; BANDS];
    let width = SIZE[0] as usize;
    for (i, value) in light.iter().enumerate() {
        assert!(value.is_finite(), "pixel {i}: {value}");
        sums[i % width * BANDS / width] += value;
    }
    sums.map(|sum| sum * BANDS as f64 / light.len() as f64)
}

/// Means of the last frame of each run. `step` brings the scene to where it is in a frame.
fn run(
    device: &TestDevice,
    scene: Scene,
    params: &DirectParams,
    frames: u32,
    pixel: &dyn Fn(u32, [u32; 2]) -> Option<Pixel>,
    step: &dyn Fn(u32, &mut Scene),
) -> Means {
    let mut rig = Rig::new(device, scene, SIZE, params);
    let mut runs = Vec::new();
    for seed in 0..RUNS {
        rig.images.reset_history();
        for frame in 0..frames {
            step(frame, &mut rig.uploaded.scene);
            rig.frame(frame, 1000 + seed, &|at| pixel(frame, at));
        }
        runs.push(bands(&rig.light()));
    }
    Means::of(&runs)
}

/// The same without reuse, of the scene as it is in frame `last`.
fn without_reuse(device: &TestDevice, scene: Scene, last: u32, step: &dyn Fn(u32, &mut Scene)) -> Means {
    let params = DirectParams { samples: 16, ..local(LightSampler::Ris) };
    run(device, scene, &params, 1, &|_, at| ground(at), &|_, scene| step(last, scene))
}

const UNBIASED: [(RestirWeights, RestirVisibility); 4] = [
    (RestirWeights::Balance, RestirVisibility::None),
    (RestirWeights::Pairwise, RestirVisibility::None),
    (RestirWeights::Balance, RestirVisibility::InWeight),
    (RestirWeights::Pairwise, RestirVisibility::InWeight),
];

#[test]
fn reuse_keeps_the_mean() {
    let device = TestDevice::open();
    let still = |_, _: &mut Scene| ();
    let expected = without_reuse(&device, scene(), 0, &still);
    let areas =
        [AreaSampling::Spherical, AreaSampling::Uniform, AreaSampling::Projected, AreaSampling::Spherical];
    for ((weights, visibility), area_sampling) in UNBIASED.into_iter().zip(areas) {
        let params = DirectParams { area_sampling, ..restir(weights, visibility) };
        let means = run(&device, scene(), &params, FRAMES, &|_, at| ground(at), &still);
        let case = format!("{}, {}, {}", weights.name(), visibility.name(), area_sampling.name());
        means.assert_equal(&expected, 0.06, &case);
    }
}

/// With one point light every candidate is the same sample: its weight is 1 wherever the weights of all reservoirs that could hold it add up to
/// 1, and so the light has no noise. Half of the neighbours have the light below their horizon, others are rejected.
#[test]
fn one_light_has_no_noise() {
    let device = TestDevice::open();
    let mut scene = scene();
    scene.instances.truncate(1);
    scene.lights = vec![Light::point("low", Vec3::new(9.0, 1.5, 0.3), Vec3::splat(50.0))];
    scene.materials.iter_mut().for_each(|m| m.emissive = Vec3::ZERO);
    let light = |params: &DirectParams| {
        let mut rig = Rig::new(&device, scene.clone(), SIZE, params);
        (0..FRAMES).for_each(|frame| rig.frame(frame, 3, &ground));
        rig.light()
    };
    let exact = light(&local(LightSampler::Power));
    let lit = exact.iter().filter(|v| **v > 0.0).count();
    assert!(lit > 64 && lit < 192, "{lit} of 256 pixels are lit");
    let same = |light: &[f64]| light.iter().zip(&exact).all(|(a, b)| (a - b).abs() <= 1e-4 * b.max(1e-3));
    for (weights, visibility) in UNBIASED {
        let light = light(&restir(weights, visibility));
        assert!(same(&light), "{}, {}", weights.name(), visibility.name());
    }
    assert!(!same(&light(&restir(RestirWeights::OneOverM, RestirVisibility::None))));
}

/// Each kind of reuse alone.
#[test]
fn parts_of_the_reuse_keep_the_mean() {
    let device = TestDevice::open();
    let still = |_, _: &mut Scene| ();
    let expected = without_reuse(&device, scene(), 0, &still);
    let base = restir(RestirWeights::Pairwise, RestirVisibility::None);
    let cases = [
        ("neither", DirectParams { restir_temporal: false, restir_spatial: 0, ..base.clone() }),
        ("time alone", DirectParams { restir_spatial: 0, ..base.clone() }),
        ("neighbours alone", DirectParams { restir_temporal: false, restir_spatial: 8, ..base.clone() }),
        // The sample stands for both light samples.
        ("two samples", DirectParams { samples: 2, ..base }),
    ];
    for (case, params) in cases {
        let means = run(&device, scene(), &params, FRAMES, &|_, at| ground(at), &still);
        means.assert_equal(&expected, 0.06, case);
    }
}

/// How much light the settings lose that are said to be biased; `one-over-m` so much that the other tests would see it.
#[test]
fn biased_settings_lose_light() {
    let device = TestDevice::open();
    let still = |_, _: &mut Scene| ();
    let expected = without_reuse(&device, scene(), 0, &still);
    let biased = [
        (RestirWeights::OneOverM, RestirVisibility::None),
        (RestirWeights::OneOverM, RestirVisibility::Final),
        (RestirWeights::Pairwise, RestirVisibility::Final),
    ];
    for (weights, visibility) in biased {
        let means = run(&device, scene(), &restir(weights, visibility), FRAMES, &|_, at| ground(at), &still);
        let share = means.total() / expected.total();
        let deviations = means.deviations(&expected);
        let case = format!("{}, {}", weights.name(), visibility.name());
        println!("{case}: {share:.3} of the light, in standard errors {deviations:.1?}");
        assert!((0.6..1.01).contains(&share), "{case}: {share}");
        if weights == RestirWeights::OneOverM {
            assert!(deviations.iter().any(|d| *d < -4.0), "{case}: {deviations:?}");
        }
    }
}

/// The board has been in the way of the light, and then is not, or the other way round: what the last frame saw says nothing.
#[test]
fn what_stands_in_the_way_may_move() {
    let device = TestDevice::open();
    let board = scene().instances.len() - 1;
    let away = Affine3A::from_translation(Vec3::new(0.0, 50.0, 0.0));
    for leaves in [true, false] {
        let step = move |frame, scene: &mut Scene| {
            let is_away = (frame == FRAMES - 1) == leaves;
            scene.instances[board].world_from_object = if is_away { away } else { Affine3A::IDENTITY };
        };
        let expected = without_reuse(&device, scene(), FRAMES - 1, &step);
        for (weights, visibility) in [UNBIASED[1], UNBIASED[3]] {
            let params = restir(weights, visibility);
            let means = run(&device, scene(), &params, FRAMES, &|_, at| ground(at), &step);
            let case = format!("board {leaves}, {}, {}", weights.name(), visibility.name());
            means.assert_equal(&expected, 0.06, &case);
        }
    }
}

/// Lights that light up, go dark, move and turn: the last frame's targets are those of its own lights.
#[test]
fn lights_may_change() {
    let device = TestDevice::open();
    let step = |frame, scene: &mut Scene| {
        let now = frame == FRAMES - 1;
        scene.lights[0].intensity = Vec3::splat(if now { 15.0 } else { 0.0 });
        scene.lights[1].intensity = Vec3::splat(if now { 0.0 } else { 9.0 });
        scene.lights[4].position.x = if now { 1.2 } else { -1.0 };
        scene.lights[4].direction = Vec3::new(if now { -0.8 } else { 0.8 }, -1.0, 0.0).normalize();
    };
    let expected = without_reuse(&device, scene(), FRAMES - 1, &step);
    for (weights, visibility) in UNBIASED {
        let params = restir(weights, visibility);
        let means = run(&device, scene(), &params, FRAMES, &|_, at| ground(at), &step);
        let case = format!("{}, {}", weights.name(), visibility.name());
        means.assert_equal(&expected, 0.06, &case);
    }
}

/// The picture moves by 3 pixels in the last frame. What comes in from the side has no past, nor has what was behind something nearer.
#[test]
fn motion_and_disocclusion_keep_the_mean() {
    let device = TestDevice::open();
    let still = |_, _: &mut Scene| ();
    let expected = without_reuse(&device, scene(), 0, &still);
    let pixel = |frame: u32, [x, y]: [u32; 2]| {
        let last = frame == FRAMES - 1;
        let shift = if last { 0 } else { 3 };
        // Before, the ground was 3 pixels further right; at its upper right something nearer was in front of it.
        let before = ground([x.saturating_sub(shift), y])?;
        let near = !last && y < 8 && x >= 8;
        let motion = if last { Vec2::new(3.0 / 16.0, 0.0) } else { Vec2::ZERO };
        Some(Pixel { motion, depth: if near { 2.0 } else { 5.0 }, ..before })
    };
    for weights in [RestirWeights::Balance, RestirWeights::Pairwise] {
        let params = restir(weights, RestirVisibility::None);
        let means = run(&device, scene(), &params, FRAMES, &pixel, &still);
        means.assert_equal(&expected, 0.06, weights.name());
    }
}

#[test]
fn first_frame_after_a_reset_equals_a_first_frame() {
    let device = TestDevice::open();
    for visibility in [RestirVisibility::None, RestirVisibility::Final] {
        let params = restir(RestirWeights::Pairwise, visibility);
        let mut rig = Rig::new(&device, scene(), SIZE, &params);
        let pixel = |at| ground(at);
        rig.frame(5, 1, &pixel);
        let first = rig.light();
        rig.frame(6, 1, &pixel);
        rig.frame(5, 1, &pixel);
        assert_ne!(rig.light(), first, "the history has no effect");
        rig.images.reset_history();
        rig.frame(5, 1, &pixel);
        assert_eq!(rig.light(), first);
    }
}

/// No lights, none that shine, and a history of lights that are not there any more.
#[test]
fn missing_lights_are_dark() {
    let device = TestDevice::open();
    let floor = || {
        let mut scene = Scene::default();
        let corners =
            [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, -1.0, z));
        polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
        scene
    };
    // Holes in the surface as well.
    let pixel = |[x, y]: [u32; 2]| if (x + 3 * y).is_multiple_of(7) { None } else { ground([x, y]) };
    let params = restir(RestirWeights::Balance, RestirVisibility::InWeight);
    let mut rig = Rig::new(&device, scene(), SIZE, &params);
    let frames = |rig: &mut Rig, lit: bool, case: &str| {
        for frame in 0..3 {
            rig.frame(frame, 1, &pixel);
            let light = rig.light();
            assert!(light.iter().all(|v| v.is_finite()), "{case}");
            assert_eq!(light.iter().any(|v| *v > 0.0), lit, "{case}");
            let holes = (0..16).flat_map(|y| (0..16).map(move |x| [x, y])).filter(|&at| pixel(at).is_none());
            assert!(holes.map(|[x, y]| light[(16 * y + x) as usize]).all(|v| v == 0.0), "{case}");
        }
    };
    frames(&mut rig, true, "many lights");
    rig.replace_scene(&device, floor());
    frames(&mut rig, false, "no lights");
    let mut one = floor();
    one.lights.push(Light::point("one", Vec3::new(0.0, 2.0, 0.0), Vec3::ONE));
    rig.replace_scene(&device, one);
    frames(&mut rig, true, "one light");
    rig.uploaded.scene.lights[0].intensity = Vec3::ZERO;
    frames(&mut rig, false, "one dark light");
    rig.uploaded.scene.lights[0].intensity = Vec3::ONE;
    frames(&mut rig, true, "one light again");
    rig.replace_scene(&device, scene());
    frames(&mut rig, true, "many lights again");
}

/// The first surface along a ray, by brute force.
fn trace(scene: &Scene, origin: Vec3, direction: Vec3) -> Option<(f32, Vec3)> {
    let mut nearest: Option<(f32, Vec3)> = None;
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for triangle in &mesh.indices {
            let [a, b, c] =
                triangle.map(|i| instance.world_from_object.transform_point3(mesh.positions[i as usize]));
            let normal = (b - a).cross(c - a);
            let t = normal.dot(a - origin) / normal.dot(direction);
            let p = origin + t * direction;
            let inside =
                [(a, b), (b, c), (c, a)].iter().all(|&(v, w)| normal.dot((w - v).cross(p - v)) >= 0.0);
            if t > 1e-3 && inside && nearest.is_none_or(|(best, _)| t < best) {
                nearest = Some((t, normal.normalize()));
            }
        }
    }
    nearest.map(|(t, normal)| (t, if normal.dot(direction) > 0.0 { -normal } else { normal }))
}

/// The built-in scene of many lamps, seen by its camera.
fn lamps(size: [u32; 2]) -> (Scene, Vec<Option<Pixel>>) {
    let scene = builtin("lamps").unwrap();
    let camera = scene.cameras[0].world_from_camera;
    let tan = (0.5_f32 * 1.1).tan();
    let origin: Vec3 = camera.translation.into();
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).map(|[x, y]| {
        let [w, h] = size.map(|s| s as f32);
        let (u, v) = ((2.0 * x as f32 + 1.0 - w) / h, (h - 2.0 * y as f32 - 1.0) / h);
        let direction = camera.transform_vector3(Vec3::new(tan * u, tan * v, -1.0)).normalize();
        trace(&scene, origin, direction).map(|(t, normal)| Pixel {
            position: origin + t * direction,
            normal,
            view: -direction,
            depth: t,
            ..Pixel::LAMBERTIAN
        })
    });
    let pixels = pixels.collect();
    (scene, pixels)
}

/// Variance at equal numbers of shadow rays, one a pixel, of a frame that stands still; and how alike the noise of neighbours is.
#[test]
fn reuse_takes_noise_away() {
    const SIZE: [u32; 2] = [48, 27];
    const RUNS: u32 = 16;
    let device = TestDevice::open();
    let (scene, pixels) = lamps(SIZE);
    let pixel = |[x, y]: [u32; 2]| pixels.get((y * SIZE[0] + x) as usize).copied().flatten();
    // Mean variance of the pixels, mean with its standard error, duplicates.
    let noise = |params: &DirectParams, frames: u32| {
        let mut rig = Rig::new(&device, scene.clone(), SIZE, params);
        let mut sums = vec![(0.0, 0.0); pixels.len()];
        let mut runs = Vec::new();
        let mut duplicates = None;
        for seed in 0..RUNS {
            rig.images.reset_history();
            (0..frames).for_each(|frame| rig.frame(frame, 77 + seed, &pixel));
            let light = rig.light();
            runs.push([light.iter().sum::<f64>() / light.len() as f64; BANDS]);
            for (sum, v) in sums.iter_mut().zip(light) {
                *sum = (sum.0 + v, sum.1 + v * v);
            }
            if params.sampler == LightSampler::RestirDi {
                duplicates = Some(duplicated_samples(&rig.images).unwrap());
            }
        }
        let n = f64::from(RUNS);
        let variance = sums.iter().map(|s| (s.1 - s.0 * s.0 / n) / (n - 1.0)).sum::<f64>();
        (variance / pixels.len() as f64, Means::of(&runs), duplicates)
    };
    let ris_candidates = 8;
    let ris_source = RisSource::Cluster;
    let sampler = |sampler| DirectParams { ris_candidates, ris_source, ..local(sampler) };
    let (ris, mean, _) = noise(&sampler(LightSampler::Ris), 1);
    let (cluster, _, _) = noise(&sampler(LightSampler::ClusterCdf), 1);
    println!("mean {:.4}; variance of ris {ris:.4}, of cluster-cdf {cluster:.4}", mean.mean[0]);
    let alone = DirectParams { restir_temporal: false, restir_spatial: 0, ..sampler(LightSampler::RestirDi) };
    let (_, _, unshared) = noise(&alone, 1);
    println!("without reuse: {:.3} duplicates among 8 neighbours", unshared.unwrap());
    let settings = [
        (RestirWeights::Pairwise, RestirVisibility::None),
        (RestirWeights::Balance, RestirVisibility::None),
        (RestirWeights::OneOverM, RestirVisibility::Final),
        (RestirWeights::Pairwise, RestirVisibility::Final),
        (RestirWeights::Pairwise, RestirVisibility::InWeight),
    ];
    for (weights, visibility) in settings {
        let params =
            DirectParams { ris_candidates, ris_source, restir_radius: 10.0, ..restir(weights, visibility) };
        let (variance, means, duplicates) = noise(&params, 8);
        let duplicates = duplicates.unwrap();
        println!(
            "{}, {}: mean {:.4}, variance {:.3} of ris, {:.3} of cluster-cdf; {duplicates:.3} duplicates",
            weights.name(),
            visibility.name(),
            means.mean[0],
            variance / ris,
            variance / cluster,
        );
        assert!(variance < ris, "{variance} {ris}");
        if UNBIASED.contains(&(weights, visibility)) {
            means.assert_equal(&mean, 0.1, "lamps");
        }
        assert!(duplicates > unshared.unwrap() && duplicates < 8.0, "{duplicates}");
    }
}

/// In `lamps` a neighbour or the past may see a lamp under a solid angle more than 8 times as large or as small. Whoever multiplies by that ratio (a
/// Jacobian outside [1/8, 8]) makes fireflies, and changes the mean: no pixel is brighter than five estimates without reuse, and the light of the
/// pixels near lamps is that without reuse.
#[test]
fn unlike_densities_make_no_fireflies_in_lamps() {
    const SIZE: [u32; 2] = [32, 18];
    const RUNS: u32 = 12;
    let device = TestDevice::open();
    let (scene, pixels) = lamps(SIZE);
    let pixel = |[x, y]: [u32; 2]| pixels.get((y * SIZE[0] + x) as usize).copied().flatten();
    let lists = LightLists::new(&scene);
    // Where a pixel's nearest lamp fills so much: pairs within the reach of reuse, 10 pixels, of which it fills unlike angles.
    let nearness: Vec<Option<(f32, usize)>> = pixels
        .iter()
        .map(|pixel| {
            let at = pixel.as_ref()?.position;
            let distance = |light: &LightBounds| light.bounds.center().distance_squared(at);
            let lights = lists.local.iter().map(distance).zip(0..);
            lights.min_by(|a: &(f32, usize), b| a.0.total_cmp(&b.0))
        })
        .collect();
    let mut unlike = vec![false; pixels.len()];
    for (a, b) in (0..pixels.len()).flat_map(|a| (0..pixels.len()).map(move |b| (a, b))) {
        let [ax, ay, bx, by] = [a % 32, a / 32, b % 32, b / 32];
        let near = ax.abs_diff(bx).max(ay.abs_diff(by)) <= 10;
        let (Some((own, light)), true) = (nearness[a], near) else { continue };
        let Some(other) = &pixels[b] else { continue };
        let far = lists.local[light].bounds.center().distance_squared(other.position);
        unlike[a] |= far > 8.0 * own;
    }
    let count = unlike.iter().filter(|unlike| **unlike).count();
    assert!(count > 100, "{count} pixels have neighbours of unlike densities");
    let run = |rig: &mut Rig, frames: u32| {
        let mut means = Vec::new();
        let mut brightest = 0.0f64;
        for seed in 0..RUNS {
            rig.images.reset_history();
            (0..frames).for_each(|frame| rig.frame(frame, 177 + seed, &pixel));
            let light = rig.light();
            let of_unlike = || (0..light.len()).filter(|i| unlike[*i]).map(|i| light[i]);
            means.push(of_unlike().sum::<f64>() / count as f64);
            brightest = light.iter().copied().fold(brightest, f64::max);
        }
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let error = (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        (mean, error, brightest)
    };
    let ris_source = RisSource::Cluster;
    let plain = DirectParams { ris_source, ..local(LightSampler::Ris) };
    let mut rig = Rig::new(&device, scene.clone(), SIZE, &plain);
    let (_, _, alone) = run(&mut rig, 1);
    rig.params.samples = 64;
    let (expected, spread, _) = run(&mut rig, 1);
    let reuse = restir(RestirWeights::Pairwise, RestirVisibility::None);
    let reuse = DirectParams { ris_source, restir_radius: 10.0, ..reuse };
    let (mean, error, brightest) = run(&mut Rig::new(&device, scene.clone(), SIZE, &reuse), 4);
    let case = format!("{mean:.4} +- {error:.4} of {expected:.4} +- {spread:.4}");
    println!("{case}; brightest {brightest:.2}, {alone:.2} without reuse");
    assert!((mean - expected).abs() < 4.0 * error.hypot(spread), "{case}");
    assert!(error < 0.1 * expected, "{case}: too noisy to tell");
    assert!(brightest < 5.0 * alone, "{case}: fireflies");
}
