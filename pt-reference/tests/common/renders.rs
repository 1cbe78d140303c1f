//! Renders for the tests, and scenes with closed forms.

use glam::{Affine3A, DVec3, Vec2, Vec3, Vec4};
use pt_core::Device;
use pt_core::trace::TraceBackend;
use pt_light_sampling::LightTables;
use pt_reference::{Estimate, EstimatePixel, FilmState, Progressive, ReferenceParams};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, Instance, Material, Mesh, Scene};
use pt_shaders::records::FrameRecord;
use std::f32::consts::PI;
use std::ops::Range;

/// A scene on the device, to be rendered several times.
pub struct Stage<'a> {
    pub device: &'a Device,
    pub scene: Scene,
    gpu: GpuScene,
    lights: LightTables,
}

impl<'a> Stage<'a> {
    pub fn new(device: &'a Device, scene: Scene) -> Self {
        Self::on(device, scene, TraceBackend::Compute)
    }

    pub fn on(device: &'a Device, scene: Scene, backend: TraceBackend) -> Self {
        let mut gpu = GpuScene::new(device, &scene, backend).unwrap();
        let lights = LightTables::new(device, &scene).unwrap();
        lights.attach(&mut gpu);
        Self { device, scene, gpu, lights }
    }

    /// The sums over `samples`.
    pub fn state(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        params: &ReferenceParams,
        seed: u32,
        samples: Range<u32>,
    ) -> FilmState {
        let record = camera_record(camera, size);
        let frame = FrameRecord::new(record, record, size, 0, seed);
        params.prepare_lights(self.device, &self.scene, &mut self.gpu, &mut self.lights).unwrap();
        let mut render = Progressive::new(
            self.device,
            &self.gpu,
            &self.lights,
            frame,
            params.clone(),
            None,
            samples.start,
        )
        .unwrap();
        while render.next_sample() < samples.end {
            render.step(&self.scene, &mut self.gpu, &mut self.lights, samples.end).unwrap();
        }
        render.state().unwrap()
    }

    /// The image from `spp` samples.
    pub fn render(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        params: &ReferenceParams,
        seed: u32,
        spp: u32,
    ) -> Estimate {
        self.state(camera, size, params, seed, 0..spp).estimate(spp)
    }
}

/// Mean over the image with its standard error, per channel.
pub fn image_mean(estimate: &Estimate) -> (DVec3, DVec3) {
    let n = estimate.pixels.len() as f64;
    let sum = |value: fn(&EstimatePixel) -> Vec3| {
        estimate.pixels.iter().fold(DVec3::ZERO, |sum, p| sum + value(p).as_dvec3())
    };
    (sum(|p| p.mean) / n, sum(|p| p.variance).map(f64::sqrt) / n)
}

/// Checks the mean over the image: within 3 standard errors and within 0.5 %.
pub fn assert_mean(estimate: &Estimate, expected: f64, what: &str) {
    let (mean, error) = image_mean(estimate);
    assert_eq!(estimate.dropped, 0, "{what}: samples that are not finite");
    println!("{what}: {mean:.6} +- {error:.6}, exact {expected:.6}");
    for c in 0..3 {
        let off = (mean[c] - expected).abs();
        assert!(off <= 3.0 * error[c] + 1e-6 * expected, "{what}: {mean} +- {error} instead of {expected}");
        assert!(off <= 0.005 * expected, "{what}: {mean} instead of {expected}");
    }
}

/// Adds an indexed mesh of one material, flat or with the given normals.
pub fn add_mesh(
    scene: &mut Scene,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    material: Material,
) {
    let n = positions.len();
    scene.meshes.push(Mesh {
        name: material.name.clone(),
        tangents: normals.iter().map(|n| n.any_orthonormal_vector().extend(1.0)).collect(),
        positions,
        normals,
        uv0: vec![Vec2::ZERO; n],
        uv1: vec![Vec2::ZERO; n],
        colors: vec![Vec4::ONE; n],
        triangle_materials: vec![scene.materials.len() as u32; indices.len()],
        first_masked: indices.len(),
        indices,
        ..Mesh::default()
    });
    scene.materials.push(material);
    let mesh = scene.meshes.len() as u32 - 1;
    scene.instances.push(Instance::new("mesh", mesh, Affine3A::IDENTITY));
}

/// A sphere of `n` x 2n quads round the origin; `side` 1: fronts outside, -1: inside. Flat shading.
pub fn add_sphere(scene: &mut Scene, radius: f32, n: u32, side: f32, material: Material) {
    let point = |i: u32, j: u32| {
        let (theta, phi) = (PI * i as f32 / n as f32, PI * j as f32 / n as f32);
        radius * Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..2 * n {
            let corners = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
            for mut triangle in [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]] {
                let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
                if normal.length() < 1e-8 * radius * radius {
                    continue;
                }
                let outside = normal.dot(triangle[0] + triangle[1] + triangle[2]) > 0.0;
                if outside != (side > 0.0) {
                    triangle.swap(1, 2);
                }
                let first = positions.len() as u32;
                let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalize();
                positions.extend(triangle);
                normals.extend([normal; 3]);
                indices.push([first, first + 1, first + 2]);
            }
        }
    }
    add_mesh(scene, positions, normals, indices, material);
}

/// A square of 2 `half` metres in the plane y = 0, facing up.
pub fn add_floor(scene: &mut Scene, half: f32, material: Material) {
    let corners = [(-half, half), (half, half), (half, -half), (-half, -half)];
    let positions = corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec();
    add_mesh(scene, positions, vec![Vec3::Y; 4], vec![[0, 1, 2], [0, 2, 3]], material);
}

/// Inside a sphere of radius 1 m that emits 1/2 and reflects half: radiance 1 everywhere, 2^-(k+1) of it after k reflections.
pub fn glowing_sphere() -> Scene {
    let mut scene = Scene::default();
    let half = Vec3::splat(0.5);
    add_sphere(&mut scene, 1.0, 8, -1.0, Material { emissive: half, ..Material::lambertian("wall", half) });
    scene
}
