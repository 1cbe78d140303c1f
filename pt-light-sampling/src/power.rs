//! Powers of lights. They are radiant fluxes in watts, with spectra weighted to one number by Rec. 709 luminance and KHR_lights_punctual
//! intensities taken one to one with radiance:
//!
//! | light | power |
//! |---|---|
//! | emissive triangles | pi x area x mean radiance, for each side that emits |
//! | point, intensity I | 4 pi I |
//! | spot, intensity I | 2 pi I ((1 - cos inner) + (cos inner - cos outer) / 3): the integral of the squared linear falloff |
//! | directional, illuminance E | pi r^2 E, what falls on the scene's bounding sphere of radius r |
//! | environment, mean radiance L | 4 pi^2 r^2 L, what falls on that sphere from all sides |

use crate::punctual::solid_angle;
use crate::{LightLists, luminance};
use pt_scene::{Environment, Light, LightKind, Scene};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A light and its power.
#[derive(Clone, Debug, Serialize)]
pub struct LightPower {
    /// point, spot, directional, emissive or environment.
    pub kind: &'static str,
    /// Name from the file.
    pub name: String,
    /// Luminance of the intensity (candela), illuminance (lux), or mean radiance.
    pub strength: f64,
    /// Emitting triangles; 0 for lights that are none.
    pub triangles: usize,
    /// Watts.
    pub power_w: f64,
}

/// Powers of all lights of a scene, strongest first: punctual ones, one entry for each instance with emissive triangles, the environment.
pub fn light_powers(scene: &Scene) -> Vec<LightPower> {
    let radius = scene.bounds().map_or(0.0, |b| 0.5 * f64::from(b.size().length()));
    let mut lights: Vec<LightPower> = scene.lights.iter().map(|light| punctual(light, radius)).collect();
    let mut by_instance: BTreeMap<u32, LightPower> = BTreeMap::new();
    for t in LightLists::new(scene).emissives {
        let instance = &scene.instances[t.instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let material = &scene.materials[mesh.triangle_materials[t.triangle as usize] as usize];
        let entry = by_instance.entry(t.instance).or_insert_with(|| LightPower {
            kind: "emissive",
            name: instance.name.clone(),
            strength: 0.0,
            triangles: 0,
            power_w: 0.0,
        });
        entry.triangles += 1;
        let sides = if material.double_sided { 2.0 } else { 1.0 };
        entry.power_w += PI * t.weight * sides;
        // The emitting area for now.
        let corners = mesh.triangle(t.triangle as usize);
        let [a, b, c] = corners.map(|p| instance.world_from_object.transform_point3(p).as_dvec3());
        entry.strength += sides * 0.5 * (b - a).cross(c - a).length();
    }
    lights.extend(by_instance.into_values().map(|mut light| {
        light.strength = light.power_w / (PI * light.strength);
        light
    }));
    if !scene.environment.is_black() {
        let mean = mean_radiance(&scene.environment);
        lights.push(LightPower {
            kind: "environment",
            name: String::new(),
            strength: mean,
            triangles: 0,
            power_w: 4.0 * (PI * radius).powi(2) * mean,
        });
    }
    lights.sort_by(|a, b| b.power_w.total_cmp(&a.power_w));
    lights
}

fn punctual(light: &Light, radius: f64) -> LightPower {
    let kind = match light.kind {
        LightKind::Point => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Directional => "directional",
    };
    let extent = solid_angle(light.kind).unwrap_or(PI * radius * radius);
    let strength = luminance(light.intensity);
    LightPower { kind, name: light.name.clone(), strength, triangles: 0, power_w: extent * strength }
}

/// Mean over the sphere.
fn mean_radiance(environment: &Environment) -> f64 {
    let (width, height) = (environment.image.width as usize, environment.image.height as usize);
    let (mut sum, mut weights) = (0.0, 0.0);
    for (y, row) in environment.image.texels.chunks_exact(width).enumerate() {
        let weight = (PI * y as f64 / height as f64).cos() - (PI * (y + 1) as f64 / height as f64).cos();
        sum += weight * row.iter().map(|&t| luminance(t)).sum::<f64>() / width as f64;
        weights += weight;
    }
    sum / weights * f64::from(environment.intensity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pt_scene::builtin;
    use std::f32::consts::FRAC_PI_2;

    fn lights(name: &str) -> Vec<LightPower> {
        light_powers(&builtin(name).unwrap())
    }

    fn light<'a>(lights: &'a [LightPower], kind: &str) -> &'a LightPower {
        lights.iter().find(|light| light.kind == kind).unwrap()
    }

    #[test]
    fn powers_by_their_formulas() {
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-3, "{a} for {b}");
        close(light(&lights("plane"), "point").power_w, 400.0 * PI);
        // The lamp of the Cornell box: 0.13 m x 0.105 m.
        let cornell = lights("cornell");
        let lamp = light(&cornell, "emissive");
        let radiance = luminance(Vec3::new(17.0, 12.0, 4.0));
        close(lamp.strength, radiance);
        close(lamp.power_w, PI * 0.13 * 0.105 * radiance);
        // All four lamps have 40 W in each channel.
        let veach = lights("veach");
        assert_eq!(veach.len(), 4);
        veach.iter().for_each(|l| close(l.power_w, 40.0));
        // Radiance 1 from everywhere: pi of irradiance on the whole sphere.
        let scene = builtin("furnace").unwrap();
        let furnace = light_powers(&scene);
        let radius = 0.5 * f64::from(scene.bounds().unwrap().size().length());
        close(light(&furnace, "environment").strength, 1.0);
        close(light(&furnace, "environment").power_w, PI * 4.0 * PI * radius * radius);
        // A hemisphere of even light is half a point light.
        let cone = Light::spot("s", Vec3::ZERO, Vec3::Y, FRAC_PI_2 - 1e-6, FRAC_PI_2, Vec3::ONE);
        close(punctual(&cone, 1.0).power_w, 2.0 * PI);
    }

    #[test]
    fn double_sided_lamps_count_twice() {
        let mut scene = builtin("cornell").unwrap();
        let once = light_powers(&scene);
        scene.materials.iter_mut().filter(|m| m.is_emissive()).for_each(|m| m.double_sided = true);
        let twice = light_powers(&scene);
        let [once, twice] = [&once, &twice].map(|s| light(s, "emissive"));
        assert!(
            (twice.power_w / once.power_w - 2.0).abs() < 1e-9
                && (twice.strength / once.strength - 1.0).abs() < 1e-9
        );
    }
}
