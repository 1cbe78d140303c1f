//! The light of the physical sky: frames and the reference against the integral of the model.

use crate::common::{Mean, frames_mean, params, polygon, reference_mean};
use glam::{DVec3, Vec3};
use pt_scene::{Camera, Environment, Material, PhysicalSky, Scene};
use std::f64::consts::{PI, TAU};

const ALBEDO: f32 = 0.5;
const SIZE: [u32; 2] = [24, 24];

/// Illuminance of the ground, lux: the sky by midpoints of equal weight, which are no texels, and the sun.
fn illuminance(sky: &PhysicalSky) -> DVec3 {
    let (rings, sectors) = (400, 600);
    let mut sum = DVec3::ZERO;
    for ring in 0..rings {
        let y = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
        for sector in 0..sectors {
            let (z, x) = ((f64::from(sector) + 0.5) / f64::from(sectors) * TAU).sin_cos();
            let across = (1.0 - y * y).sqrt();
            sum += sky.radiance(DVec3::new(across * x, y, across * z).as_vec3()).as_dvec3();
        }
    }
    let from_sky = sum * PI / f64::from(rings * sectors);
    from_sky + f64::from(sky.towards_sun().y) * sky.sun_illuminance().as_dvec3()
}

/// A Lambertian floor, seen from above.
fn floor(sky: &PhysicalSky) -> (Scene, Camera) {
    let mut scene = Scene { environment: sky.environment(), lights: vec![sky.sun()], ..Scene::default() };
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &corners, Material::lambertian("floor", Vec3::splat(ALBEDO)));
    scene.validate().unwrap();
    (scene, Camera::look_at("down", Vec3::new(0.0, 1.0, 1e-3), Vec3::ZERO, 0.5))
}

fn assert_light(what: &str, found: Mean, exact: DVec3) {
    println!("{what}: {:.1} +- {:.1}, expected {exact:.1}", found.mean, found.error);
    for c in 0..3 {
        let off = (found.mean[c] - exact[c]).abs();
        // Of the quadrature of the model and the image, each at most 0.2 % of the sky.
        assert!(
            off <= 4.0 * found.error[c] + 0.002 * exact[c],
            "{what}, channel {c}: {found:?}, expected {exact}"
        );
        assert!(found.error[c] < 0.005 * exact[c], "{what}: too much noise to say anything: {found:?}");
    }
}

/// Morning, noon, and haze with a sun so low that the sky gives most of the light.
#[test]
fn a_floor_has_the_light_of_sky_and_sun() {
    for [elevation, azimuth, turbidity, albedo] in
        [[12.0, 200.0, 3.0, 0.2], [65.0, 20.0, 2.0, 0.0], [3.0, 90.0, 8.0, 0.5]]
    {
        let sky = PhysicalSky::new(elevation, azimuth, turbidity, albedo).unwrap();
        let (scene, camera) = floor(&sky);
        let exact = illuminance(&sky) * f64::from(ALBEDO) / PI;
        let what = |who: &str| format!("{who}, sun {elevation} degrees high");
        assert_light(&what("frames"), frames_mean(&scene, &camera, SIZE, 64, params(&[])), exact);
        assert_light(&what("reference"), reference_mean(&scene, &camera, SIZE, 4, 256), exact);
    }
}

/// The disc is in the picture once: its radiance is that of the light, and the image has none.
#[test]
fn the_reference_shows_one_sun() {
    let sky = PhysicalSky::new(30.0, 40.0, 3.0, 0.2).unwrap();
    let (scene, _) = floor(&sky);
    let sun = &scene.lights[0];
    let solid_angle = PI * f64::from(sun.angular_radius).sin().powi(2);
    let eye = Vec3::new(0.0, 1.0, 0.0);
    // Half of the disc fills the picture.
    let camera = Camera::look_at("sun", eye, eye + sky.towards_sun(), sun.angular_radius);
    let behind = sky.radiance(sky.towards_sun()).as_dvec3();
    let exact = sky.sun_illuminance().as_dvec3() / solid_angle + behind;
    assert_light("disc", reference_mean(&scene, &camera, [8, 8], 0, 16), exact);
    // The image has nothing of a disc: without the light, only the glow of the sky.
    let glow = |environment: Environment| {
        let scene = Scene { environment, lights: vec![], ..scene.clone() };
        reference_mean(&scene, &camera, [8, 8], 0, 16)
    };
    assert_light("glow", glow(sky.environment()), behind);
}
