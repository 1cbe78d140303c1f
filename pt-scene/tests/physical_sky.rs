//! The physical sky against other implementations, and what it is baked to.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use proptest::prelude::*;
use pt_scene::{LightKind, PhysicalSky};

/// Unit direction of an elevation and an azimuth, degrees, as the sun's are given.
fn towards([elevation, azimuth]: [f32; 2]) -> Vec3 {
    let (e, a) = (elevation.to_radians(), azimuth.to_radians());
    Vec3::new(e.cos() * a.cos(), e.sin(), -e.cos() * a.sin())
}

fn sky([elevation, azimuth, turbidity, albedo]: [f32; 4]) -> PhysicalSky {
    PhysicalSky::new(elevation, azimuth, turbidity, albedo).unwrap()
}

/// Cosine-weighted integral of the model over the hemisphere, by midpoints of equal weight: no grid of the image.
fn irradiance(sky: &PhysicalSky) -> Vec3 {
    let (rings, sectors) = (400, 600);
    let mut sum = Vec3::ZERO;
    for ring in 0..rings {
        let y = ((ring as f32 + 0.5) / rings as f32).sqrt();
        for sector in 0..sectors {
            let (z, x) = ((sector as f32 + 0.5) / sectors as f32 * TAU).sin_cos();
            let across = (1.0 - y * y).sqrt();
            sum += sky.radiance(Vec3::new(across * x, y, across * z));
        }
    }
    sum * (PI / (rings * sectors) as f32)
}

/// Radiance of ten directions as the emitter sunsky of Mitsuba 3.9.1 gives it (variant scalar_rgb, sun_scale 0), which has an
/// implementation of its own of Hosek and Wilkie's model: times 106.75026 x 683.002 lm/W, where the first undoes its normalisation. Each row:
/// elevation and azimuth of the sun, turbidity, albedo; elevation and azimuth of the direction; cd/m2.
const RADIANCE: [([f32; 4], [f32; 2], [f32; 3]); 10] = [
    ([45.0, 0.0, 2.0, 0.1], [30.0, 0.0], [5971.28, 8839.01, 13491.93]),
    ([45.0, 0.0, 2.0, 0.1], [5.0, 180.0], [8556.21, 13055.09, 17575.93]),
    ([45.0, 0.0, 2.0, 0.1], [80.0, 90.0], [1272.27, 2396.26, 5285.22]),
    ([10.0, 90.0, 3.0, 0.5], [12.0, 95.0], [28522.42, 24081.13, 14981.00]),
    ([10.0, 90.0, 3.0, 0.5], [1.0, -90.0], [10181.11, 10397.58, 7021.59]),
    ([10.0, 90.0, 3.0, 0.5], [60.0, 10.0], [907.22, 1697.42, 2754.74]),
    ([60.0, 200.0, 6.5, 0.0], [0.2, 30.0], [6031.31, 6027.74, 8375.21]),
    ([60.0, 200.0, 6.5, 0.0], [59.0, 198.0], [37306.78, 38789.27, 35443.98]),
    ([2.0, -30.0, 1.0, 0.8], [20.0, -30.0], [2780.76, 3106.61, 2616.16]),
    ([85.0, 0.0, 10.0, 1.0], [45.0, 270.0], [12638.00, 14221.23, 17388.15]),
];

#[test]
fn radiance_is_that_of_another_implementation() {
    for (parameters, direction, published) in RADIANCE {
        let radiance = sky(parameters).radiance(towards(direction));
        // The data are 32-bit floating point here and 64-bit there; near the horizon, that of the angle counts.
        let error = (radiance / Vec3::from_array(published) - 1.0).abs().max_element();
        println!(
            "{parameters:?} {direction:?}: {radiance:.2} cd/m2 for {published:?}: relative error {error:.1e}"
        );
        assert!(error < 1e-4, "{parameters:?} {direction:?}: {radiance} for {published:?}");
    }
}

/// Illuminance of the sun from the spectral data of Hosek and Wilkie 2013, linear between wavelengths of 360 to 720 nm, with the tables of
/// the CIE 1931 observer, a disc 0.533 degrees wide and without limb darkening. Each row: elevation, turbidity; lux.
const SUN: [([f32; 2], [f32; 3]); 8] = [
    ([85.0, 1.0], [129_154.0, 111_147.0, 91_911.0]),
    ([45.0, 2.0], [124_081.0, 103_563.0, 79_932.0]),
    ([33.0, 3.0], [116_869.0, 94_360.0, 67_967.0]),
    ([7.0, 3.0], [67_587.0, 36_205.0, 9_674.0]),
    ([12.0, 4.5], [74_453.0, 48_024.0, 21_622.0]),
    ([1.2, 2.5], [16_916.0, 3_874.0, 0.0]),
    ([17.0, 6.5], [74_863.0, 52_448.0, 29_577.0]),
    ([26.0, 10.0], [45_654.0, 32_723.0, 22_888.0]),
];

#[test]
fn the_sun_is_that_of_the_published_data() {
    for ([elevation, turbidity], published) in SUN {
        let sun = sky([elevation, 120.0, turbidity, 0.2]).sun();
        assert_eq!(sun.kind, LightKind::Directional);
        assert!(sun.direction.distance(-towards([elevation, 120.0])) < 1e-6);
        let published = Vec3::from_array(published);
        let error = (sun.intensity - published).abs().max_element() / published.max_element();
        // Between the elevations of the table up to 2 %, the fit of the observer 1 %.
        assert!(error < 0.03, "{elevation} {turbidity}: {} for {published}", sun.intensity);
    }
}

#[test]
fn the_image_has_the_light_of_the_model() {
    for parameters in
        [[5.0, 250.0, 3.0, 0.2], [45.0, 30.0, 2.0, 0.0], [90.0, 0.0, 10.0, 1.0], [0.0, 77.0, 1.0, 0.5]]
    {
        let sky = sky(parameters);
        let environment = sky.environment();
        let image = &environment.image;
        let (width, height) = (image.width as usize, image.height as usize);
        let mut sum = Vec3::ZERO;
        for (y, row) in image.texels.chunks(width).take(height / 2).enumerate() {
            let polar = (y as f32 + 0.5) * PI / height as f32;
            let texel = polar.sin() * (PI / height as f32) * (TAU / width as f32);
            sum += polar.cos() * texel * row.iter().sum::<Vec3>();
        }
        let exact = irradiance(&sky);
        // Both quadratures have more than 200,000 points; the peak round the sun is the roughest part.
        let error = (sum / exact - 1.0).abs().max_element();
        assert!(error < 2e-3, "{parameters:?}: {sum} for {exact}");
        // The ground is a diffuse plane in this light and that of the sun.
        let [_, _, _, albedo] = parameters;
        let ground = albedo / PI * (exact + sky.towards_sun().y * sky.sun_illuminance());
        let below = environment.radiance(Vec3::new(0.1, -1.0, 0.3).normalize());
        assert!((below - ground).abs().max_element() <= 2e-3 * ground.max_element(), "{below} for {ground}");
    }
}

/// Between the texels, too, also half a degree above the horizon and round the sun.
#[test]
fn the_image_resolves_the_model() {
    let sky = sky([10.0, 40.0, 3.0, 0.2]);
    let environment = sky.environment();
    for elevation in [0.2, 0.5, 1.0, 3.0, 9.7, 10.4, 45.0, 88.0] {
        for azimuth in [40.3, 41.0, 130.0, 221.0] {
            let direction = towards([elevation, azimuth]);
            let (baked, exact) = (environment.radiance(direction), sky.radiance(direction));
            let error = (baked - exact).abs().max_element() / exact.max_element();
            assert!(error < 0.01, "{elevation} {azimuth}: {baked} for {exact}");
        }
    }
}

#[test]
fn bad_skies_are_refused_with_one_line() {
    for (text, part) in [
        ("-3,0", "below the horizon"),
        ("91,0", "elevation (degrees) 91 is out of range; give 0 to 90"),
        ("-100,0", "elevation (degrees) -100 is out of range"),
        ("NaN,0", "elevation (degrees) NaN"),
        ("30,inf", "azimuth inf is not finite"),
        ("30,0,0.5", "turbidity 0.5 is out of range; give 1 to 10"),
        ("30,0,nan", "turbidity NaN"),
        ("30,0,11", "turbidity 11"),
        ("30,0,3,2", "albedo of the ground 2 is out of range; give 0 to 1"),
        ("30,0,3,-0.1", "albedo of the ground -0.1"),
        ("30", PhysicalSky::FORM),
        ("30,0,3,0.2,1", PhysicalSky::FORM),
        ("noon,0", PhysicalSky::FORM),
        ("", PhysicalSky::FORM),
    ] {
        let error = text.parse::<PhysicalSky>().unwrap_err();
        assert!(error.contains(part) && !error.contains('\n'), "{text}: {error}");
    }
    assert_eq!("30, 45".parse(), PhysicalSky::new(30.0, 45.0, 3.0, 0.2));
    assert_eq!("30,45,2,0".parse(), PhysicalSky::new(30.0, 45.0, 2.0, 0.0));
}

/// Opposite of a sun on the horizon, the model's blue is outside of Rec. 709.
#[test]
fn no_colour_is_negative() {
    let sky = sky([0.0, 0.0, 1.0, 0.0]);
    let radiance = |i: u16| sky.radiance(towards([f32::from(i % 90), f32::from(i / 90 * 2)]));
    let least = (0..90 * 180).map(|i| radiance(i).min_element()).reduce(f32::min);
    assert_eq!(least, Some(0.0));
}

proptest! {
    #[test]
    fn every_sky_is_light(
        parameters in [0.0..=90.0_f32, -1e9..=1e9_f32, 1.0..=10.0_f32, 0.0..=1.0_f32],
        seen in [0.0..=90.0_f32, 0.0..=360.0_f32],
    ) {
        let sky = sky(parameters);
        for light in [sky.radiance(towards(seen)), sky.radiance(sky.towards_sun()), sky.sun_illuminance()] {
            prop_assert!(light.is_finite() && light.min_element() >= 0.0 && light.max_element() < 1e6, "{}", light);
        }
        prop_assert!((sky.towards_sun().length() - 1.0).abs() < 1e-5 && sky.towards_sun().y >= 0.0);
    }
}
