//! The noise that the reuse of sampler restir-di makes: samples that neighbours share, and bright single pixels.

use crate::common::pixels::{Pixel, Rig};
use glam::{Affine3A, Vec3};
use pt_core::test_support::TestDevice;
use pt_light_sampling::test_support::polygon;
use pt_lights::records::{LightRays, RestirVisibility};
use pt_lights::{DirectParams, duplicated_samples};
use pt_scene::{Light, Material, Scene};
use pt_shaders::records::{AreaSampling, LightSampler, RisSource};

const SIZE: [u32; 2] = [16, 16];
const RUNS: u32 = 16;
const FRAMES: u32 = 8;

fn params(sampler: LightSampler) -> DirectParams {
    DirectParams {
        sampler,
        rays: LightRays::Merged,
        ris_source: RisSource::Power,
        ris_candidates: 4,
        restir_radius: 5.0,
        restir_spatial: 4,
        ..DirectParams::default()
    }
}

/// A corner of the small triangle.
const NEAR: Vec3 = Vec3::new(0.9, 0.03, 0.9);

/// A floor under 30 lamps far away, and two lights so near to it that they are thousands of times as bright for one pixel as for its
/// neighbours: a point, and a triangle of 2 cm, of which points see quite different solid angles.
fn scene() -> Scene {
    let mut scene = Scene::default();
    let floor = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &floor, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    let corners = [NEAR, NEAR + 0.02 * Vec3::X, NEAR + 0.02 * Vec3::Z];
    polygon(&mut scene, &corners, Affine3A::IDENTITY, Material::lamp("near", Vec3::splat(300.0)));
    scene.lights.push(Light::point("near", Vec3::new(-0.85, 0.03, -0.85), Vec3::splat(0.06)));
    for i in 0..30 {
        let angle = i as f32;
        let position = Vec3::new(4.0 * angle.cos(), 3.0, 4.0 * angle.sin());
        scene.lights.push(Light::point("far", position, Vec3::splat(1.0)));
    }
    scene
}

/// Four metres of the floor.
fn ground([x, y]: [u32; 2]) -> Option<Pixel> {
    let at = |i: u32| (i as f32 - 7.5) * 0.25;
    Some(Pixel { position: Vec3::new(at(x), 0.0, at(y)), ..Pixel::LAMBERTIAN })
}

/// Runs of frames; `seen` gets the rig after the last one of each.
fn runs(device: &TestDevice, params: &DirectParams, frames: u32, mut seen: impl FnMut(&Rig)) {
    let mut rig = Rig::new(device, scene(), SIZE, params);
    for seed in 0..RUNS {
        rig.images.reset_history();
        (0..frames).for_each(|frame| rig.frame(frame, 400 + seed, &ground));
        seen(&rig);
    }
}

/// Neighbours pass samples on to each other, and the past hands on what they have passed on: with both, most of all share a sample. What looks
/// stable over time is correlated noise, which a denoiser takes for a feature of the picture.
#[test]
fn reuse_over_time_adds_to_the_samples_that_neighbours_share() {
    let device = TestDevice::open();
    let of = |restir_temporal, restir_spatial| {
        let params = DirectParams { restir_temporal, restir_spatial, ..params(LightSampler::RestirDi) };
        let mut sum = 0.0;
        runs(&device, &params, FRAMES, |rig| sum += duplicated_samples(&rig.images).unwrap());
        sum / f64::from(RUNS)
    };
    let [none, time, neighbours, both] = [of(false, 0), of(true, 0), of(false, 4), of(true, 4)];
    println!("of 8 neighbours: {none:.3}, over time {time:.3}, neighbours {neighbours:.3}, both {both:.3}");
    // A sample names a light and 32 bits: none is drawn twice by chance.
    assert!(none < 0.01 && time < 0.01, "{none} {time}");
    assert!(neighbours > 0.05 && both > 2.0 * neighbours && both < 8.0, "{neighbours} {both}");
}

/// A sample from a point that hardly sees a lamp has a large weight. Where the lamp is thousands of times as bright it must not shine
/// as much the more: the weights of multiple importance sampling keep every term below the estimate of the reservoir that it comes from.
#[test]
fn reuse_makes_no_fireflies() {
    let device = TestDevice::open();
    let mut exact = vec![0.0; 256];
    let many = DirectParams { samples: 64, ..params(LightSampler::Ris) };
    runs(&device, &many, 1, |rig| {
        exact.iter_mut().zip(rig.light()).for_each(|(sum, light)| *sum += light / f64::from(RUNS));
    });
    let brightest = |params: &DirectParams| {
        let mut most = 0.0f64;
        runs(&device, params, FRAMES, |rig| {
            let pixels = rig.light().into_iter().zip(&exact).map(|(light, exact)| light / exact);
            most = pixels.fold(most, f64::max);
        });
        most
    };
    let alone = brightest(&params(LightSampler::Ris));
    println!("ris: {alone:.1} times the light of a pixel");
    for restir_visibility in [RestirVisibility::None, RestirVisibility::InWeight] {
        let most = brightest(&DirectParams { restir_visibility, ..params(LightSampler::RestirDi) });
        println!("{}: {most:.1}", restir_visibility.name());
        // Of five reservoirs: the sum of five such estimates at most.
        assert!(most < 5.0 * alone, "{}: {most}, {alone} without reuse", restir_visibility.name());
    }
}

/// A reservoir may come from a point that sees the lamp under a solid angle hundreds of times as large or as small: whoever multiplies by a ratio of
/// densities there (a Jacobian outside [1/8, 8]), or limits it, changes the light. Near the lamp, around it and far away it is that of the closed form.
#[test]
fn reuse_between_points_of_unlike_densities_keeps_the_light() {
    const RADIANCE: f64 = 300.0;
    let device = TestDevice::open();
    let corners = [NEAR, NEAR + 0.02 * Vec3::X, NEAR + 0.02 * Vec3::Z];
    let mut scene = scene();
    scene.lights.clear();
    // Irradiance from a lamp of a few pixels' solid angle (Lambert).
    let exact = |point: Vec3| {
        let to = corners.map(|corner| (corner - point).as_dvec3().normalize());
        let edge = |i: usize| {
            let (a, b) = (to[i], to[(i + 1) % 3]);
            a.angle_between(b) * a.cross(b).normalize().y
        };
        0.5 * RADIANCE * (0..3).map(edge).sum::<f64>().abs()
    };
    let solid_angle = |point: Vec3| {
        let d = (NEAR - point).as_dvec3();
        d.y / d.length().powi(3)
    };
    let points: Vec<Vec3> =
        (0..256).map(|i| ground([i % 16, i / 16]).map_or(Vec3::ZERO, |p| p.position)).collect();
    let ring = |point: Vec3| match point.distance(NEAR) {
        d if d < 0.3 => 0,
        d if d < 0.8 => 1,
        _ => 2,
    };
    // Pixels within the reach of reuse, 5 of 25 cm, of which the densities are unlike.
    let ratios = points.iter().flat_map(|a| points.iter().map(move |b| (a, b)));
    let unlike = ratios
        .filter(|(a, b)| a.distance(**b) < 1.25)
        .filter(|(a, b)| solid_angle(**a) > 8.0 * solid_angle(**b))
        .count();
    assert!(unlike > 500, "{unlike} pairs");
    for (area_sampling, restir_visibility) in [
        (AreaSampling::Spherical, RestirVisibility::None),
        (AreaSampling::Uniform, RestirVisibility::InWeight),
    ] {
        let params = DirectParams { area_sampling, restir_visibility, ..params(LightSampler::RestirDi) };
        let mut rig = Rig::new(&device, scene.clone(), SIZE, &params);
        let mut means: Vec<[f64; 3]> = Vec::new();
        for seed in 0..RUNS {
            rig.images.reset_history();
            (0..FRAMES).for_each(|frame| rig.frame(frame, 900 + seed, &ground));
            let mut sums = [[0.0; 2]; 3];
            for (light, &point) in rig.light().into_iter().zip(&points) {
                // What the rig says of a surface whose diffuse light is the irradiance over pi.
                let sum = &mut sums[ring(point)];
                *sum = [sum[0] + light, sum[1] + 0.5 * exact(point) / std::f64::consts::PI];
            }
            means.push(sums.map(|[light, exact]| light / exact));
        }
        let n = means.len() as f64;
        for ring in 0..3 {
            let mean = means.iter().map(|run| run[ring]).sum::<f64>() / n;
            let variance = means.iter().map(|run| (run[ring] - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
            let error = variance.sqrt();
            let case = format!("{}, ring {ring}: {mean:.4} +- {error:.4}", area_sampling.name());
            println!("{case}");
            // Rays start beside the floor: a few micrometres of 3 cm.
            assert!((mean - 1.0).abs() < 4.0 * error + 1e-3, "{case}");
            assert!(error < 0.03, "{case}: too noisy to tell");
        }
    }
}
