//! The noise that the reuse of sampler restir-di makes: samples that neighbours share, and bright single pixels.

mod common;

use common::pixels::{Pixel, Rig};
use glam::{Affine3A, Vec3};
use pt_core::test_support::TestDevice;
use pt_light_sampling::test_support::polygon;
use pt_lights::records::{LightRays, RestirVisibility};
use pt_lights::{DirectParams, duplicated_samples};
use pt_scene::{Light, Material, Scene};
use pt_shaders::records::{LightSampler, RisSource};

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

/// A floor under 30 lamps far away, and two lights so near to it that they are thousands of times as bright for one pixel as for its
/// neighbours: a point, and a triangle of 2 cm, of which points see quite different solid angles.
fn scene() -> Scene {
    let mut scene = Scene::default();
    let floor = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &floor, Affine3A::IDENTITY, Material::lambertian("floor", Vec3::splat(0.5)));
    let near = Vec3::new(0.9, 0.03, 0.9);
    let corners = [near, near + 0.02 * Vec3::X, near + 0.02 * Vec3::Z];
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
