//! Materials as surface.glsl reads them on the device.

use super::records::{MaterialCase, MaterialResult};
use glam::{Affine3A, Vec2, Vec3, Vec4, Vec4Swizzles};
use pt_core::SceneResources;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Kernel, Location, Recorder};
use pt_scene::gpu::GpuScene;
use pt_scene::{Instance, Material, Mesh, Scene, Texture};

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

/// A triangle, half of a unit square in the XY plane facing +Z: u along +X, v along -Y as in pictures; its second UV set is mirrored in u.
fn quad(color: Vec4) -> Mesh {
    let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
    Mesh {
        name: "quad".into(),
        positions: corners.iter().map(|c| Vec3::new(c.x, -c.y, 0.0)).collect(),
        normals: vec![Vec3::Z; 3],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
        uv0: corners.into(),
        uv1: corners.iter().map(|c| Vec2::new(1.0 - c.x, c.y)).collect(),
        colors: vec![color; 3],
        indices: vec![[0, 2, 1]],
        triangle_materials: vec![0],
        first_masked: 1,
        ..Mesh::default()
    }
}

pub fn scene(material: Material, textures: Vec<Texture>) -> Scene {
    let masked = material.is_masked();
    let mut mesh = quad(Vec4::new(1.0, 0.5, 1.0, 0.5));
    mesh.first_masked = usize::from(!masked);
    let instances = vec![Instance::new("quad", 0, Affine3A::IDENTITY)];
    let scene =
        Scene { meshes: vec![mesh], instances, materials: vec![material], textures, ..Scene::default() };
    scene.validate().unwrap();
    scene
}

/// A point of the quad given by its first UV.
pub fn case(uv: Vec2, footprint: Vec2, random: Vec4) -> MaterialCase {
    // The triangle's vertices are in the order 0, 2, 1: the second weight is v, the third u.
    MaterialCase {
        barycentrics: Vec2::new(uv.y, uv.x),
        instance: 0,
        triangle: 0,
        footprint,
        random_texel: random.xy(),
        random_level_place: random.zw(),
    }
}

/// The material at points of the quad given by their first UV, filtered by samplers.
pub fn samples(device: &TestDevice, scene: &Scene, at: &[Vec2], footprint: f32) -> Vec<MaterialResult> {
    let cases: Vec<_> = at.iter().map(|&uv| case(uv, Vec2::splat(footprint), Vec4::ZERO)).collect();
    samples_of(device, scene, &cases, 0)
}

/// The material at points: the same whether the kernel was made for any scene or for this one. `without`: `FEATURE_*` bits to leave out.
pub fn samples_of(
    device: &TestDevice,
    scene: &Scene,
    at: &[MaterialCase],
    without: u32,
) -> Vec<MaterialResult> {
    let mut gpu = GpuScene::new(device, scene, TraceBackend::Compute).unwrap();
    let cases = Buffer::from_slice(device, "cases", at).unwrap();
    let size = (at.len() * size_of::<MaterialResult>()) as u64;
    let results = Buffer::new(device, "results", size, Location::Device).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let [general, specialized]: [Vec<MaterialResult>; 2] = [u32::MAX, gpu.features()].map(|features| {
        let features = features & !without;
        let kernel =
            Kernel::compute::<()>(device, &kernels::MATERIAL_SAMPLES, &[("scene_features", features.into())])
                .unwrap();
        let mut frame = recorder.begin().unwrap();
        gpu.update(&mut frame, scene).unwrap();
        let pass = frame.pass("materials", &kernel).read("cases", &cases).write("results", &results);
        gpu.bind(pass).dispatch([at.len() as u32, 1, 1]).unwrap();
        frame.submit().unwrap();
        results.read().unwrap()
    });
    assert_eq!(specialized, general);
    specialized
}
