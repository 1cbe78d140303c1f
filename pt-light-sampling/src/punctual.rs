//! Records of the punctual lights (KHR_lights_punctual): two groups, in each of which a light is picked by its power.

use crate::luminance;
use glam::Vec3;
use pt_scene::{Light, LightKind, Scene};
use pt_shaders::records::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LightRecord};
use std::f64::consts::PI;

/// Resolution of [`LightRecord::cdf`]: the random numbers it is compared with are multiples of 2^-24.
const STEPS: u64 = 1 << 24;

/// The directional lights of a scene.
pub(crate) fn suns(scene: &Scene) -> impl Iterator<Item = &Light> + Clone {
    scene.lights.iter().filter(|light| light.kind == LightKind::Directional)
}

/// The point and spot lights of a scene.
pub(crate) fn positional(scene: &Scene) -> impl Iterator<Item = &Light> + Clone {
    scene.lights.iter().filter(|light| light.kind != LightKind::Directional)
}

/// The directional lights, then the positional ones, each by their places. Free places and lights without intensity have probability 0.
pub(crate) fn records(suns: &[Option<&Light>], positional: &[Option<&Light>]) -> Vec<LightRecord> {
    let (no_sun, no_lamp) =
        (Light::directional("", Vec3::NEG_Y, Vec3::ZERO), Light::point("", Vec3::ZERO, Vec3::ZERO));
    let all = |lights: &[Option<&Light>], none: &Light| {
        group(&lights.iter().map(|light| light.unwrap_or(none)).collect::<Vec<_>>())
    };
    all(suns, &no_sun).into_iter().chain(all(positional, &no_lamp)).collect()
}

fn group(lights: &[&Light]) -> Vec<LightRecord> {
    let weights: Vec<f64> = lights.iter().map(|light| weight(light)).collect();
    let mut sum = 0;
    let counts = apportion(&weights);
    lights
        .iter()
        .zip(counts)
        .map(|(light, count)| {
            sum += count;
            record(light, count as f32 / STEPS as f32, sum as f32 / STEPS as f32)
        })
        .collect()
}

/// What the intensity of a point or spot light is multiplied by to give its power: the integral over all directions of how much of
/// it goes there. `None` for directional lights.
pub(crate) fn solid_angle(kind: LightKind) -> Option<f64> {
    match kind {
        LightKind::Point => Some(4.0 * PI),
        // The full cone inside, and the integral of the squared ramp between the cosines.
        LightKind::Spot { inner, outer } => {
            let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            Some(2.0 * PI * ((1.0 - inner) + (inner - outer) / 3.0))
        }
        LightKind::Directional => None,
    }
}

/// Luminous power (point, spot) or illuminance (directional).
fn weight(light: &Light) -> f64 {
    luminance(light.intensity) * solid_angle(light.kind).unwrap_or(1.0)
}

/// Shares of 2^24 in proportion to the weights, zero only for weights of zero: the cdf can then be compared with 24-bit random numbers
/// and the probabilities are exact.
fn apportion(weights: &[f64]) -> Vec<u64> {
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return vec![0; weights.len()];
    }
    let spread = STEPS.saturating_sub(weights.len() as u64);
    let share = |w: &f64| if *w > 0.0 { 1 + (w / total * spread as f64).floor() as u64 } else { 0 };
    let mut counts: Vec<u64> = weights.iter().map(share).collect();
    let rest = STEPS.saturating_sub(counts.iter().sum());
    let heaviest = (0..weights.len()).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
    if let Some(count) = counts.get_mut(heaviest) {
        *count += rest;
    }
    counts
}

fn record(light: &Light, pmf: f32, cdf: f32) -> LightRecord {
    let (kind, radius) = match light.kind {
        LightKind::Point => (LIGHT_POINT, light.radius),
        LightKind::Spot { .. } => (LIGHT_SPOT, light.radius),
        LightKind::Directional => (LIGHT_DIRECTIONAL, light.angular_radius),
    };
    let (spot_scale, spot_offset) = match light.kind {
        LightKind::Spot { inner, outer } => spot(inner, outer),
        _ => (0.0, 0.0),
    };
    LightRecord {
        intensity: light.intensity,
        kind,
        position: light.position,
        radius,
        direction: light.direction.normalize_or(Vec3::NEG_Y),
        spot_scale,
        spot_offset,
        pmf,
        cdf,
        pad: 0,
    }
}

/// Scale and offset of the angular attenuation that KHR_lights_punctual recommends, with its guard against equal angles.
fn spot(inner: f32, outer: f32) -> (f32, f32) {
    let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
    (scale, -outer.cos() * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Vec<Light> {
        vec![
            Light::point("a", Vec3::ZERO, Vec3::splat(10.0)),
            Light::directional("b", Vec3::NEG_Y, Vec3::splat(3.0)),
            Light::spot("c", Vec3::ONE, Vec3::X, 0.2, 0.5, Vec3::splat(1e-6)),
            Light::directional("d", Vec3::X, Vec3::splat(1.0)),
            Light::point("dark", Vec3::ZERO, Vec3::ZERO),
        ]
    }

    #[test]
    fn groups_stand_in_order_with_exact_probabilities() {
        let scene = Scene { lights: scene(), ..Scene::default() };
        let [suns, lamps] =
            [suns(&scene).map(Some).collect::<Vec<_>>(), positional(&scene).map(Some).collect()];
        assert_eq!(suns.len(), 2);
        let records = records(&suns, &lamps);
        assert_eq!(
            records.iter().map(|r| r.kind).collect::<Vec<_>>(),
            [LIGHT_DIRECTIONAL, LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LIGHT_POINT]
        );
        for group in [&records[..2], &records[2..]] {
            let mut sum = 0.0;
            for light in group {
                assert_eq!(light.pmf > 0.0, light.intensity != Vec3::ZERO);
                assert_eq!(light.cdf - sum, light.pmf);
                sum = light.cdf;
            }
            assert_eq!(sum, 1.0);
        }
        assert!((records[0].pmf - 0.75).abs() < 1e-6);
    }

    #[test]
    fn spot_attenuation_is_one_inside_and_zero_outside() {
        let (scale, offset) = spot(0.2, 0.5);
        assert!((0.2f32.cos() * scale + offset - 1.0).abs() < 1e-5);
        assert!((0.5f32.cos() * scale + offset).abs() < 1e-5);
    }
}
