//! Multiple importance sampling of the environment: the reflected light of glossy surfaces against quadrature of the BRDF's oracle.

use crate::common::pixels::{Pixel, Rig};
use glam::{DVec3, Vec3};
use pt_core::test_support::TestDevice;
use pt_light_sampling::oracle::brdf::Brdf;
use pt_light_sampling::test_support::polygon;
use pt_lights::DirectParams;
use pt_scene::{Environment, EnvironmentImage, Material, Scene};
use pt_shaders::channels::COLOR_SPEC;
use std::f64::consts::PI;

const SIZE: [u32; 2] = [16, 16];
const FRAMES: u32 = 24;
const BASE: f32 = 0.75;

/// A dim sky with a bright patch about as wide as the lobes, `row` texels of 32 below the zenith: there both ways to find it have densities
/// of the same size, and none can stand in for the other.
fn sky(row: u32) -> Environment {
    let (width, height) = (64, 32);
    let bright = |x: u32, y: u32| (14..20).contains(&x) && (row..row + 4).contains(&y);
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        Vec3::splat(if bright(x, y) { 30.0 } else { 0.2 + 0.02 * (y as f32) })
    };
    Environment::new(EnvironmentImage { width, height, texels: (0..width * height).map(texel).collect() })
}

/// Reflected light over F0 by the midpoint rule on the hemisphere of the normal +Y.
fn exact(environment: &Environment, view: DVec3, roughness: f64) -> f64 {
    const N: usize = 400;
    let brdf = Brdf::new(DVec3::splat(BASE.into()), (DVec3::ZERO, 0.0), 1.0, roughness, false);
    // The oracle's normal is +Z.
    let local = |d: DVec3| DVec3::new(d.x, -d.z, d.y);
    let mut sum = 0.0;
    for i in 0..N {
        let cos2 = (i as f64 + 0.5) / N as f64;
        let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).sqrt());
        for j in 0..2 * N {
            let phi = PI * (j as f64 + 0.5) / N as f64;
            let l = DVec3::new(sin * phi.cos(), cos, sin * phi.sin());
            // Uniform in cos^2: the density of the directions has the cosine in it.
            let value = brdf.eval(local(view), local(l)).specular.y;
            sum += value * f64::from(environment.radiance(l.as_vec3()).y);
        }
    }
    PI * sum / (2 * N * N) as f64 / f64::from(BASE)
}

#[test]
fn glossy_reflections_of_a_bright_patch_have_their_energy() {
    let device = TestDevice::open();
    for row in [3, 8] {
        let environment = sky(row);
        // The view whose mirror image is the middle of the patch.
        let (u, v) = (17.0 / 64.0, (f64::from(row) + 2.0) / 32.0);
        let (phi, theta) = (2.0 * PI * (u - 0.5), PI * v);
        let patch = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        let view = DVec3::new(-patch.x, patch.y, -patch.z);
        let mut scene = Scene { environment: environment.clone(), ..Scene::default() };
        let speck = [Vec3::ZERO, 1e-3 * Vec3::X, 1e-3 * Vec3::Y];
        polygon(&mut scene, &speck, glam::Affine3A::IDENTITY, Material::lambertian("speck", Vec3::ONE));
        let mut rig = Rig::new(&device, scene, SIZE, &DirectParams::default());
        for roughness in [0.2f32, 0.28] {
            let metal = Pixel {
                view: view.as_vec3(),
                base: [BASE, BASE, BASE, 0.0],
                metallic: 1.0,
                roughness,
                position: Vec3::new(0.0, 2.0, 0.0),
                ..Pixel::LAMBERTIAN
            };
            let expected = exact(&environment, view, f64::from(roughness));
            let mut values = Vec::new();
            for frame in 0..FRAMES {
                rig.frame(frame, 3, &|_| Some(metal));
                let spec = rig.images.current(COLOR_SPEC).read_f32().unwrap();
                values.extend(spec.chunks_exact(4).map(|texel| f64::from(texel[1])));
            }
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let error = (variance / n).sqrt();
            let case = format!("row {row}, roughness {roughness}: {mean:.4} +- {error:.4} of {expected:.4}");
            println!("{case}");
            // The quadrature has less than 0.2 %, the packed view a few 1e-5 rad.
            assert!((mean - expected).abs() < 4.0 * error + 3e-3 * expected, "{case}");
            assert!(error < 0.01 * expected, "{case}: too noisy to tell");
        }
    }
}
