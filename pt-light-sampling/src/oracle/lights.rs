//! Host twins of lights.glsl: candidates on the scene's lights, from the same random bits.

use super::sampling::{basis_around, cone_pdf, sample_cone, sample_triangle};
use crate::LightLists;
use crate::environment::texel_solid_angle;
use glam::{DVec2, DVec3, Vec3};
use pt_scene::Scene;
use pt_shaders::records::{LIGHT_SPOT, LightRecord};
use std::f64::consts::{PI, TAU};

/// A candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit, from the shading point to the light.
    pub direction: DVec3,
    /// Density per solid angle; of a delta light the probability of its choice.
    pub pdf: f64,
    /// Radiance towards the shading point; of a delta light the irradiance of a surface that faces it.
    pub radiance: DVec3,
    /// No other strategy can find this light.
    pub delta: bool,
    /// Where the light is, unless infinitely far away.
    pub target: Option<DVec3>,
}

/// Light samplers of a scene.
pub struct LightSampler<'a> {
    scene: &'a Scene,
    lists: &'a LightLists,
}

fn unit(bits: [u32; 4]) -> [f64; 4] {
    bits.map(|word| f64::from(word >> 8) / 16_777_216.0)
}

impl<'a> LightSampler<'a> {
    /// Samplers of `scene`, whose lights are `lists`.
    pub fn new(scene: &'a Scene, lists: &'a LightLists) -> Self {
        Self { scene, lists }
    }

    fn pick(&self, first: usize, end: usize, xi: f64) -> Option<&'a LightRecord> {
        self.lists.lights[first..end].iter().find(|light| f64::from(light.cdf) > xi)
    }

    /// A directional light.
    pub fn sun(&self, bits: [u32; 4]) -> Option<LightSample> {
        let xi = unit(bits);
        let light = self.pick(0, self.lists.sun_count as usize, xi[0])?;
        let mut s = LightSample {
            direction: -light.direction.as_dvec3(),
            pdf: f64::from(light.pmf),
            radiance: light.intensity.as_dvec3(),
            delta: light.radius <= 0.0,
            target: None,
        };
        if !s.delta {
            let angle = f64::from(light.radius);
            let one_minus_cos = 2.0 * (0.5 * angle).sin().powi(2);
            s.direction = basis_around(s.direction) * sample_cone(DVec2::new(xi[2], xi[3]), one_minus_cos);
            s.radiance /= PI * angle.sin().powi(2);
            s.pdf *= cone_pdf(one_minus_cos);
        }
        Some(s)
    }

    /// A point or spot light.
    pub fn positional(&self, position: Vec3, bits: [u32; 4]) -> Option<LightSample> {
        let xi = unit(bits);
        let light = self.pick(self.lists.sun_count as usize, self.lists.lights.len(), xi[0])?;
        let d = light.position.as_dvec3() - position.as_dvec3();
        let (distance, radius) = (d.length(), f64::from(light.radius));
        if distance <= radius {
            return None;
        }
        let mut s = LightSample {
            direction: d / distance,
            pdf: f64::from(light.pmf),
            radiance: light.intensity.as_dvec3() / (distance * distance),
            delta: radius <= 0.0,
            target: Some(light.position.as_dvec3()),
        };
        if !s.delta {
            let sin2 = (radius / distance).powi(2);
            let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
            let local = sample_cone(DVec2::new(xi[2], xi[3]), one_minus_cos);
            s.direction = basis_around(s.direction) * local;
            let off_axis = distance * local.truncate().length();
            let reach = distance * local.z - (radius * radius - off_axis * off_axis).max(0.0).sqrt();
            s.target = Some(position.as_dvec3() + reach * s.direction);
            s.radiance = light.intensity.as_dvec3() / (PI * radius * radius);
            s.pdf *= cone_pdf(one_minus_cos);
        }
        s.radiance *= spot_attenuation(light, -s.direction);
        Some(s)
    }

    /// A point of an emissive triangle. Without texture and alpha test.
    pub fn emissive(&self, position: Vec3, bits: [u32; 4]) -> Option<LightSample> {
        let xi = unit(bits);
        let alias = self.lists.emissive_alias.as_ref()?;
        let picked = alias.pick(bits[0], xi[1] as f32);
        let triangle = self.lists.emissives[picked];
        let instance = &self.scene.instances[triangle.instance as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let [a, mut b, mut c] = mesh
            .triangle(triangle.triangle as usize)
            .map(|p| instance.world_from_object.transform_point3(p).as_dvec3());
        // The front is where the cross product points to.
        if instance.world_from_object.matrix3.determinant() < 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        let bary = sample_triangle(DVec2::new(xi[2], xi[3]));
        let point = a + bary.x * (b - a) + bary.y * (c - a);
        let area2 = (b - a).cross(c - a);
        let d = point - position.as_dvec3();
        let material = instance.material_at(mesh, triangle.triangle as usize);
        let material = &self.scene.materials[material as usize];
        let mut cos = -area2.normalize().dot(d.normalize());
        if material.double_sided {
            cos = cos.abs();
        }
        (cos > 0.0).then(|| LightSample {
            direction: d.normalize(),
            pdf: alias.pmf(picked) * d.length_squared() / (0.5 * area2.length() * cos),
            radiance: material.emissive.as_dvec3(),
            delta: false,
            target: Some(point),
        })
    }

    /// A direction of the environment.
    pub fn environment(&self, bits: [u32; 4]) -> Option<LightSample> {
        let xi = unit(bits);
        let alias = self.lists.environment_alias.as_ref()?;
        let [width, height] = self.lists.environment_size.map(|side| side as usize);
        let texel = alias.pick(bits[0], xi[1] as f32);
        let (column, row) = (texel % width, texel / width);
        // As in the kernel, rows below the horizon are mirror images.
        let below = 2 * row >= height;
        let mirrored = if below { height - 1 - row } else { row } as f64;
        let k = |row: f64| (0.5 * PI * row / height as f64).sin().powi(2);
        let k = k(mirrored) + xi[3] * (k(mirrored + 1.0) - k(mirrored));
        let cos = if below { 2.0 * k - 1.0 } else { 1.0 - 2.0 * k };
        let sin = 2.0 * (k * (1.0 - k)).sqrt();
        let phi = TAU * ((column as f64 + xi[2]) / width as f64 - 0.5);
        let (x, z) = (sin * phi.cos(), sin * phi.sin());
        let [c, s] = self.lists.environment_rotation.map(f64::from);
        let direction = DVec3::new(c * x + s * z, cos, c * z - s * x);
        Some(LightSample {
            direction,
            pdf: alias.pmf(texel) / texel_solid_angle(width, height, row),
            radiance: self.scene.environment.radiance(direction.as_vec3()).as_dvec3(),
            delta: false,
            target: None,
        })
    }

    /// Density of [`LightSampler::environment`] for a direction from another strategy.
    pub fn environment_pdf(&self, direction: Vec3) -> f64 {
        let Some(alias) = &self.lists.environment_alias else { return 0.0 };
        let [width, height] = self.lists.environment_size.map(|side| side as usize);
        let uv = self.scene.environment.uv(direction);
        let column = ((uv.x * width as f32) as usize).min(width - 1);
        let row = ((uv.y * height as f32) as usize).min(height - 1);
        alias.pmf(row * width + column) / texel_solid_angle(width, height, row)
    }
}

fn spot_attenuation(light: &LightRecord, direction: DVec3) -> f64 {
    if light.kind != LIGHT_SPOT {
        return 1.0;
    }
    let ramp = light.direction.as_dvec3().dot(direction) * f64::from(light.spot_scale);
    (ramp + f64::from(light.spot_offset)).clamp(0.0, 1.0).powi(2)
}
