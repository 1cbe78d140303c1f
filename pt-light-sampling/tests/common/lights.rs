//! Many local lights, and the irradiance from each of them.

use glam::{Affine3A, DVec3, Vec3};
use pt_core::rng::random4;
use pt_light_sampling::test_support::polygon;
use pt_light_sampling::{EmissiveTriangle, LightBounds, LightLists, local_lights, luminance};
use pt_scene::{Light, LightKind, Material, Scene};

/// Numbers in [0, 1) of stream `stream`.
pub fn numbers(i: u32, stream: u32) -> [f32; 4] {
    random4([i & 0xffff, i >> 16], stream, 0, 77)
}

pub fn direction(i: u32, stream: u32) -> Vec3 {
    let [u, v, ..] = numbers(i, stream);
    let z = 2.0 * u - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// Lights spread over a hall of 20 m x 5 m x 20 m.
pub struct Hall {
    pub scene: Scene,
    pub emissives: Vec<EmissiveTriangle>,
    pub lights: Vec<LightBounds>,
}

impl Hall {
    pub const SIZE: Vec3 = Vec3::new(20.0, 5.0, 20.0);

    pub fn place(i: u32, stream: u32) -> Vec3 {
        let [x, y, z, _] = numbers(i, stream);
        Vec3::new(x, y, z) * Self::SIZE
    }

    /// As many emissive triangles, every third of them two-sided, as point lights, as spot lights. Intensities span two decades.
    pub fn new(each: u32) -> Self {
        let mut scene = Scene::default();
        for i in 0..each {
            let [size, strength, ..] = numbers(i, 1);
            let a = Self::place(i, 2);
            let edges = [3, 4].map(|stream| direction(i, stream) * (0.1 + 0.9 * size));
            let lamp = Material::lamp("lamp", Vec3::splat(10f32.powf(2.0 * strength)));
            let lamp = Material { double_sided: i % 3 == 0, ..lamp };
            polygon(&mut scene, &[a, a + edges[0], a + edges[1]], Affine3A::IDENTITY, lamp);
        }
        for i in 0..each {
            let [size, strength, ..] = numbers(i, 5);
            let light =
                Light::point("point", Self::place(i, 6), Vec3::splat(10f32.powf(2.0 * strength - 1.0)));
            scene.lights.push(Light { radius: if i % 2 == 0 { 0.1 * size } else { 0.0 }, ..light });
        }
        for i in 0..each {
            let [outer, strength, inner, _] = numbers(i, 7);
            let outer = 0.1 + 1.4 * outer;
            let intensity = Vec3::splat(10f32.powf(2.0 * strength));
            let spot =
                Light::spot("spot", Self::place(i, 8), direction(i, 9), outer * inner, outer, intensity);
            scene.lights.push(spot);
        }
        let emissives = LightLists::new(&scene).emissives;
        let lights = local_lights(&scene, &emissives);
        assert_eq!(lights.len(), 3 * each as usize);
        Self { scene, emissives, lights }
    }

    /// Unshadowed irradiance from a light, and what it would be if both cosines were 1.
    pub fn irradiance(&self, light: usize, at: Vec3, normal: Vec3) -> (f64, f64) {
        let (at, normal) = (at.as_dvec3(), normal.as_dvec3());
        if let Some(t) = self.emissives.get(light) {
            return self.triangle(t, at, normal);
        }
        let light = &self.scene.lights[light - self.emissives.len()];
        let d = light.position.as_dvec3() - at;
        let facing = luminance(light.intensity) / d.length_squared();
        let falloff = match light.kind {
            LightKind::Spot { inner, outer } => {
                let (inner, outer) = (f64::from(inner.cos()), f64::from(outer.cos()));
                let cos = -d.normalize().dot(light.direction.as_dvec3());
                ((cos - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2)
            }
            _ => 1.0,
        };
        (facing * falloff * normal.dot(d.normalize()).max(0.0), facing)
    }

    /// Midpoints of a grid over the triangle.
    fn triangle(&self, t: &EmissiveTriangle, at: DVec3, normal: DVec3) -> (f64, f64) {
        const N: u32 = 12;
        let instance = &self.scene.instances[t.instance as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let [a, b, c] = mesh.triangle(t.triangle as usize).map(Vec3::as_dvec3);
        let material = &self.scene.materials[instance.material_at(mesh, t.triangle as usize) as usize];
        let area2 = (b - a).cross(c - a);
        let (mut sum, mut facing, mut count) = (0.0, 0.0, 0.0);
        for i in 0..N {
            for j in 0..N - i {
                let [u, v] = [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(N));
                let d = a + u * (b - a) + v * (c - a) - at;
                let mut cos = -area2.normalize().dot(d.normalize());
                if material.double_sided {
                    cos = cos.abs();
                }
                facing += 1.0 / d.length_squared();
                sum += cos.max(0.0) * normal.dot(d.normalize()).max(0.0) / d.length_squared();
                count += 1.0;
            }
        }
        let scale = luminance(material.emissive) * 0.5 * area2.length() / count;
        (sum * scale, facing * scale)
    }
}
