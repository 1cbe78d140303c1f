//! `environment_rays=list`: the mean light with the environment among the lights that a sampler picks from, against that with a ray of its
//! own; environments that change and that are odd; and the noise in a room with a window.

use crate::common::pixels::{Pixel, Rig};
use crate::common::room::{floor, image, indoors, rectangle, room};
use glam::Vec3;
use pt_core::test_support::TestDevice;
use pt_light_sampling::test_support::all_kinds;
use pt_lights::DirectParams;
use pt_lights::records::{EnvironmentRays, LightRays, NeeAtPdf};
use pt_scene::{Environment, Material, Scene};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{LightSampler, NeeAtTile, RisSource};

const SIZE: [u32; 2] = [16, 16];

fn params(sampler: LightSampler, environment_rays: EnvironmentRays) -> DirectParams {
    DirectParams { rays: LightRays::Merged, sampler, environment_rays, sun: false, ..DirectParams::default() }
}

/// All kinds of light over a floor, a board in between, and a sky that is brighter than the lamps on one side.
fn outdoors() -> Scene {
    let mut scene = all_kinds();
    let board = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)].map(|(x, z)| Vec3::new(x, 1.2, z));
    rectangle(&mut scene, board, Material::lambertian("board", Vec3::ONE));
    floor(&mut scene, 2.1);
    scene.environment = image(32, 16, |x, y| if y > 8 { 0.0 } else { 0.2 + if x < 8 { 6.0 } else { 0.0 } });
    scene.environment.rotation = 0.5;
    scene
}

/// Points spread over the floor; the lower half of the picture is glossy, so that reflections look for the environment too.
fn ground([x, y]: [u32; 2]) -> Option<Pixel> {
    let at = |k: f32| ((x + 16 * y) as f32 * k).fract() * 4.0 - 2.0;
    let view = Vec3::new(0.4, 0.8, -0.2).normalize();
    let position = Vec3::new(at(0.618_034), 0.0, at(0.754_877_7));
    let roughness = if y < SIZE[1] / 2 { 1.0 } else { 0.25 };
    Some(Pixel { position, view, roughness, base: [0.5; 4], ..Pixel::LAMBERTIAN })
}

/// Mean of each half of the picture with its standard error, over runs that start without history; of their last frame.
fn means(rig: &mut Rig, runs: u32, frames: u32, step: impl Fn(&mut Scene, u32)) -> [[f64; 2]; 2] {
    let mut sums = [[0.0; 2]; 2];
    for run in 0..runs {
        rig.images.reset_history();
        for frame in 0..frames {
            step(&mut rig.uploaded.scene, frame);
            rig.frame(frame, 100 + run, &ground);
        }
        let light = rig.light();
        for (half, sums) in light.chunks(light.len() / 2).zip(&mut sums) {
            let mean = half.iter().sum::<f64>() / half.len() as f64;
            sums[0] += mean;
            sums[1] += mean * mean;
        }
    }
    let n = f64::from(runs);
    sums.map(|[sum, squares]| {
        let mean = sum / n;
        [mean, ((squares / n - mean * mean).max(0.0) / (n - 1.0)).sqrt()]
    })
}

fn assert_same(name: &str, found: [[f64; 2]; 2], expected: [[f64; 2]; 2], precision: f64) {
    for (half, ([mean, error], [expected, spread])) in found.into_iter().zip(expected).enumerate() {
        let allowed = 4.0 * error.hypot(spread) + 1e-6;
        assert!(
            (mean - expected).abs() <= allowed,
            "{name}, half {half}: {mean} +- {error}, not {expected} +- {spread}"
        );
        assert!(
            allowed <= precision * expected + 1e-6,
            "{name}, half {half}: too noisy to tell: {allowed} of {expected}"
        );
    }
}

fn reuses(sampler: LightSampler) -> bool {
    matches!(sampler, LightSampler::RestirDi | LightSampler::NeeAt)
}

/// Every sampler has the mean of an environment with a ray of its own, on rough and on glossy surfaces, also while it learns.
#[test]
fn means_agree() {
    let device = TestDevice::open();
    let mut own = Rig::new(&device, outdoors(), SIZE, &params(LightSampler::Power, EnvironmentRays::Own));
    let expected = means(&mut own, 150, 1, |_, _| ());
    let samplers = LightSampler::VALUES.iter().map(|&sampler| params(sampler, EnvironmentRays::List));
    let ris = params(LightSampler::Ris, EnvironmentRays::List);
    let variants = [
        DirectParams { ris_source: RisSource::Power, ..ris },
        DirectParams { samples: 2, ..params(LightSampler::LightBvh, EnvironmentRays::List) },
    ];
    for params in samplers.chain(variants) {
        // The lists of clusters do not hold for points that were seen elsewhere.
        let ris_source = if reuses(params.sampler) { RisSource::Power } else { params.ris_source };
        let params = DirectParams { ris_source, ..params };
        let mut rig = Rig::new(&device, outdoors(), SIZE, &params);
        let found = if reuses(params.sampler) {
            means(&mut rig, 50, 3, |_, _| ())
        } else {
            means(&mut rig, 90, 1, |_, _| ())
        };
        assert_same(params.sampler.name(), found, expected, 0.25);
    }
}

/// Without the environment, and with the environment alone, light is that of the other lights and of the sky.
#[test]
fn kinds_can_be_switched_off() {
    let device = TestDevice::open();
    for off in [
        DirectParams { environment: false, ..params(LightSampler::LightBvh, EnvironmentRays::Own) },
        DirectParams {
            positional: false,
            emissive: false,
            ..params(LightSampler::LightBvh, EnvironmentRays::Own)
        },
    ] {
        let list = DirectParams { environment_rays: EnvironmentRays::List, ..off.clone() };
        let [own, list] = [off, list].map(|params| {
            let mut rig = Rig::new(&device, outdoors(), SIZE, &params);
            means(&mut rig, 90, 1, |_, _| ())
        });
        assert_same("one kind", list, own, 0.35);
    }
}

/// Intensity and rotation that change from frame to frame are those of the frame, with reuse of the frames before.
#[test]
fn changing_environments_keep_the_mean() {
    let device = TestDevice::open();
    let step = |scene: &mut Scene, frame: u32| {
        scene.environment.intensity = [1.0, 0.0, 2.0][frame as usize % 3];
        scene.environment.rotation = 0.5 + frame as f32;
    };
    // The last frames: without the environment, and with twice its light.
    for (frames, samplers) in [
        (2, [LightSampler::RestirDi, LightSampler::ClusterStats]),
        (3, [LightSampler::RestirDi, LightSampler::NeeAt]),
    ] {
        let mut own = Rig::new(&device, outdoors(), SIZE, &params(LightSampler::Power, EnvironmentRays::Own));
        let expected = means(&mut own, 80, frames, step);
        for sampler in samplers {
            let params =
                DirectParams { ris_source: RisSource::Power, ..params(sampler, EnvironmentRays::List) };
            let mut rig = Rig::new(&device, outdoors(), SIZE, &params);
            let found = means(&mut rig, 50, frames, step);
            assert_same(&format!("{} after {frames} frames", sampler.name()), found, expected, 0.42);
        }
    }
}

/// Black, of one colour, without intensity, one bright texel: the mean is right and every pixel is a number.
#[test]
fn odd_environments_have_the_right_mean() {
    let device = TestDevice::open();
    let sun = image(64, 32, |x, y| if (x, y) == (20, 6) { 5e4 } else { 0.0 });
    let cases = [
        ("black", Environment::black()),
        ("no intensity", Environment { intensity: 0.0, ..image(8, 4, |_, _| 1.0) }),
        ("one colour", Environment::constant(Vec3::splat(2.0))),
        ("one texel", sun),
    ];
    for (name, environment) in cases {
        let mut scene = Scene::default();
        floor(&mut scene, 2.1);
        scene.environment = environment;
        let mut own =
            Rig::new(&device, scene.clone(), SIZE, &params(LightSampler::Power, EnvironmentRays::Own));
        let expected = means(&mut own, 50, 1, |_, _| ());
        for sampler in [LightSampler::LightBvh, LightSampler::RestirDi] {
            let mut rig = Rig::new(&device, scene.clone(), SIZE, &params(sampler, EnvironmentRays::List));
            let found = means(&mut rig, 50, 1, |_, _| ());
            assert!(rig.light().iter().all(|light| light.is_finite()), "{name}: {}", sampler.name());
            assert_same(&format!("{name}: {}", sampler.name()), found, expected, 0.15);
        }
    }
}

/// Frames of learning, and frames of which the variance is taken.
const WARM: u32 = 12;
const FRAMES: u32 = 64;

/// Mean light, and its variance over frames, averaged over the pixels.
fn noise(device: &TestDevice, params: &DirectParams) -> (f64, f64) {
    let mut rig = Rig::new(device, room(), SIZE, params);
    let (mut sums, mut squares) = (vec![0.0; 256], vec![0.0; 256]);
    for frame in 0..WARM + FRAMES {
        rig.frame(frame, 3, &indoors);
        if frame < WARM {
            continue;
        }
        for (i, light) in rig.light().into_iter().enumerate() {
            sums[i] += light;
            squares[i] += light * light;
        }
    }
    let n = f64::from(FRAMES);
    let variance = |(sum, square): (&f64, &f64)| (square / n - (sum / n).powi(2)) * n / (n - 1.0);
    let variances = sums.iter().zip(&squares).map(variance).sum::<f64>() / 256.0;
    (sums.iter().sum::<f64>() / 256.0 / n, variances)
}

/// The noise in the room at one light sample a pixel. A listed environment takes one shadow ray less, and samplers that know the room find the
/// window by what they know.
#[test]
fn samplers_find_the_window() {
    let device = TestDevice::open();
    // Directions by radiance alone, as the list has them.
    let by_radiance = DirectParams { cosine_share: 0.0, ..params(LightSampler::Power, EnvironmentRays::Own) };
    let (mean, own) = noise(&device, &by_radiance);
    for (sampler, least_gain) in
        [(LightSampler::ClusterCdf, 1.2), (LightSampler::LightBvh, 1.2), (LightSampler::NeeAt, 1.3)]
    {
        let (found, list) = noise(&device, &params(sampler, EnvironmentRays::List));
        println!("{}: variance {own:.4} with a ray of its own, {list:.4} in the list", sampler.name());
        let error = ((own + list) / (256.0 * f64::from(FRAMES))).sqrt();
        assert!((found - mean).abs() < 5.0 * error, "{}: {found} +- {error}, not {mean}", sampler.name());
        assert!(own > least_gain * list, "{}: {own} {list}", sampler.name());
    }
}

/// A glossy floor under a sky, beside a lamp of that radiance.
fn glossy(radiance: f32) -> Scene {
    let mut scene = Scene::default();
    floor(&mut scene, 2.1);
    let lamp = [(-0.3, 0.3), (-0.3, -0.3), (0.3, -0.3), (0.3, 0.3)].map(|(x, z)| Vec3::new(x - 2.5, 2.0, z));
    rectangle(&mut scene, lamp, Material::lamp("lamp", Vec3::splat(radiance)));
    scene.environment = image(32, 16, |x, y| if y >= 8 { 0.0 } else { 0.5 + 0.1 * (x % 5) as f32 });
    scene
}

/// A point of it. Without metal, reflected rays also go where light samples go.
fn glossy_pixel([x, y]: [u32; 2], metallic: f32) -> Option<Pixel> {
    let at = |k: u32| k as f32 * 0.1 - 0.8;
    let position = Vec3::new(at(x), 0.0, at(y));
    let view = Vec3::new(-0.6, 0.8, 0.1).normalize();
    let base = [0.5, 0.5, 0.5, 0.04];
    Some(Pixel { position, view, roughness: 0.25, metallic, base, ..Pixel::LAMBERTIAN })
}

/// Mean light over independent runs with its standard error, after `frames` frames, and the share of the proxies of all tiles that are quads.
fn learned(
    device: &TestDevice,
    params: &DirectParams,
    (lamp, metallic): (f32, f32),
    frames: u32,
) -> [f64; 3] {
    let runs = 40;
    let mut rig = Rig::new(device, glossy(lamp), SIZE, params);
    let pixel = |at| glossy_pixel(at, metallic);
    let (mut sums, mut share) = ([0.0; 2], 0.0);
    for run in 0..runs {
        rig.images.reset_history();
        (0..frames).for_each(|frame| rig.frame(frame, 300 + run, &pixel));
        let mean = rig.light().iter().sum::<f64>() / f64::from(SIZE[0] * SIZE[1]);
        sums = [sums[0] + mean, sums[1] + mean * mean];
        let quads = rig.uploaded.lights.lists().quad_range();
        if let Some(tiles) = rig.stage.nee_at().and_then(|nee_at| nee_at.tiles()) {
            let tiles: Vec<NeeAtTile> = tiles.read().unwrap();
            let proxies = || tiles.iter().flat_map(|tile| tile.lights);
            let of_sky = proxies().filter(|light| quads.contains(&(*light as usize))).count();
            share += of_sky as f64 / proxies().count() as f64 / f64::from(runs);
        }
    }
    let n = f64::from(runs);
    let mean = sums[0] / n;
    [mean, ((sums[1] / n - mean * mean).max(0.0) / (n - 1.0)).sqrt(), share]
}

/// Both probabilities that `nee-at` may put into the weights of multiple importance sampling give the mean of an environment with rays of its own, as
/// does what is learned from reflected rays; and these teach the tiles what light samples do not find.
#[test]
fn weights_and_feedback_of_reflections_keep_the_mean() {
    let device = TestDevice::open();
    let own = DirectParams { samples: 4, ..params(LightSampler::LightBvh, EnvironmentRays::Own) };
    let list = DirectParams { nee_at_candidates: 1, ..params(LightSampler::NeeAt, EnvironmentRays::List) };
    let averaged = DirectParams { nee_at_pdf: NeeAtPdf::Averaged, nee_at_narrow: 0.1, ..list.clone() };
    let feedback = DirectParams { nee_at_bsdf_feedback: true, ..list.clone() };
    // A weak lamp, of which the samples are few, and a strong one, which most light samples choose.
    let (weak, strong) = ((20.0, 0.0), (2500.0, 1.0));
    let [expected_weak, expected_strong] = [weak, strong].map(|case| learned(&device, &own, case, 1));
    let cases = [
        ("averaged", averaged, weak, expected_weak),
        ("exact", list, strong, expected_strong),
        ("feedback of reflections", feedback, strong, expected_strong),
    ];
    let shares = cases.map(|(name, params, case, [expected, spread, _])| {
        let [mean, error, share] = learned(&device, &params, case, 5);
        let both = error.hypot(spread);
        println!("{name}: {mean:.4} +- {error:.4} of {expected:.4} +- {spread:.4}; {share:.3} of the proxies are sky");
        assert!((mean - expected).abs() < 4.0 * both, "{name}: {mean}, not {expected} +- {both}");
        assert!(both < 0.03 * expected, "{name}: too noisy to tell: {both} of {expected}");
        share
    });
    assert!(shares[2] > 1.5 * shares[1], "{shares:?}");
}
