//! Scenes for the tests of the stages that sample lights.

use crate::LightTables;
use glam::{Affine3A, Vec3, Vec4};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_scene::gpu::GpuScene;
use pt_scene::{Environment, EnvironmentImage, Instance, Light, Material, Mesh, Scene};

/// A scene on the GPU.
pub struct Uploaded {
    /// On the host.
    pub scene: Scene,
    /// Its lights.
    pub lights: LightTables,
    /// On the device.
    pub gpu: GpuScene,
}

impl Uploaded {
    /// Uploads a scene with its lights.
    ///
    /// # Panics
    /// When the device fails.
    pub fn new(device: &TestDevice, scene: Scene, backend: TraceBackend) -> Self {
        let lights = LightTables::new(device, &scene).unwrap();
        let mut gpu = GpuScene::new(device, &scene, backend).unwrap();
        lights.attach(&mut gpu);
        Self { scene, lights, gpu }
    }
}

/// A flat polygon fan.
pub fn polygon(scene: &mut Scene, corners: &[Vec3], transform: Affine3A, material: Material) {
    let n = corners.len();
    let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let mesh = Mesh {
        name: "polygon".into(),
        positions: corners.to_vec(),
        normals: vec![up; n],
        tangents: vec![Vec4::X; n],
        uv0: vec![glam::Vec2::ZERO; n],
        uv1: vec![glam::Vec2::ZERO; n],
        colors: vec![Vec4::ONE; n],
        indices: (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect(),
        triangle_materials: vec![scene.materials.len() as u32; n - 2],
        first_masked: n - 2,
        ..Mesh::default()
    };
    scene.materials.push(material);
    scene.instances.push(Instance::new("polygon", scene.meshes.len() as u32, transform));
    scene.meshes.push(mesh);
}

/// Every kind of light, none of them in the way of another.
pub fn all_kinds() -> Scene {
    let mut scene = Scene::default();
    let lamp = |color: [f32; 3]| Material::lamp("lamp", Vec3::from(color));
    let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, -1.0), Vec3::NEG_Z];
    // Facing down, by a half turn about x.
    let down = |x: f32, scale: f32| {
        Affine3A::from_translation(Vec3::new(x, 2.5, 0.0))
            * Affine3A::from_rotation_x(std::f32::consts::PI)
            * Affine3A::from_scale(Vec3::splat(scale))
    };
    polygon(&mut scene, &square, down(-1.5, 1.0), lamp([4.0, 2.0, 1.0]));
    polygon(&mut scene, &square, down(0.7, 0.3), lamp([10.0, 20.0, 30.0]));
    // Mirrored: the winding turns round, the front stays.
    let mirrored = down(-3.0, 0.5) * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    polygon(&mut scene, &square, mirrored, lamp([1.0, 0.1, 0.1]));
    // Facing up and double-sided.
    let both = Material { double_sided: true, ..lamp([0.5, 0.5, 0.5]) };
    polygon(&mut scene, &square, Affine3A::from_translation(Vec3::new(1.5, 3.0, 1.0)), both);

    scene.lights = vec![
        Light::point("point", Vec3::new(0.0, 2.0, 1.0), Vec3::new(5.0, 6.0, 7.0)),
        Light { radius: 0.2, ..Light::point("ball", Vec3::new(1.0, 1.5, 0.0), Vec3::new(9.0, 1.0, 1.0)) },
        Light::directional("sun", Vec3::new(0.3, -1.0, 0.2), Vec3::new(3.0, 2.5, 2.0)),
        Light {
            angular_radius: 0.1,
            ..Light::directional("wide sun", Vec3::new(-0.5, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0))
        },
        Light::spot(
            "spot",
            Vec3::new(-1.0, 2.0, 1.0),
            Vec3::new(0.4, -1.0, 0.0),
            0.3,
            0.6,
            Vec3::new(20.0, 15.0, 5.0),
        ),
    ];
    scene.environment = bright_spot(13, 9);
    scene.environment.rotation = 0.7;
    scene.environment.intensity = 0.8;
    scene
}

/// A dim gradient with black parts and two bright texels, one of them at the seam, one at a pole.
pub fn bright_spot(width: u32, height: u32) -> Environment {
    let mut texels: Vec<Vec3> = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            if y * 2 > height { Vec3::ZERO } else { Vec3::new(0.1, 0.2, 0.3) * (1 + (x + y) % 3) as f32 }
        })
        .collect();
    texels[(2 * width) as usize] = Vec3::new(40.0, 30.0, 20.0);
    texels[(width * height - 3) as usize] = Vec3::new(5.0, 9.0, 5.0);
    Environment::new(EnvironmentImage { width, height, texels })
}
