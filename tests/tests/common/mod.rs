//! Scenes and means of whole frames for the tests of indirect light.

use glam::{Affine3A, DVec3, Vec2, Vec3, Vec4};
use pt_app::args::CameraArgs;
use pt_app::params::FrameParams;
use pt_app::session::Session;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_reference::{Progressive, ReferenceParams};
use pt_scene::gpu::camera_record;
use pt_scene::{Camera, Instance, Material, Mesh, Scene};
use pt_shaders::channels::FLAT_COLOR;
use pt_shaders::records::FrameRecord;
use pt_tests::Frames;

/// Mean of an image with its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    pub mean: DVec3,
    pub error: DVec3,
}

/// Fails when two means differ by more than 4 standard errors and `rounding`, relative.
pub fn assert_same(what: &str, found: Mean, expected: Mean, rounding: f64) {
    println!(
        "{what}: {:.5} +- {:.5}, expected {:.5}, ratio {:.4}",
        found.mean,
        found.error,
        expected.mean,
        found.mean / expected.mean
    );
    for c in 0..3 {
        let off = (found.mean[c] - expected.mean[c]).abs();
        let error = found.error[c].hypot(expected.error[c]);
        assert!(
            off <= 4.0 * error + rounding * expected.mean[c],
            "{what}: channel {c}: {found:?}, expected {expected:?}"
        );
        assert!(
            error < 0.01 * expected.mean[c],
            "{what}: too much noise to say anything: {found:?}, {expected:?}"
        );
    }
}

/// Parameters for pictures that are averaged, textures as the reference reads them.
pub fn params(sets: &[&str]) -> FrameParams {
    let sets: Vec<_> = sets.iter().map(|set| (*set).to_owned()).collect();
    pt_app::params::resolve(Some("unbiased"), &sets, false).unwrap()
}

/// Mean over the pixels of `count` frames.
pub fn frames_mean(scene: &Scene, camera: &Camera, size: [u32; 2], count: u32, params: FrameParams) -> Mean {
    frames_means(scene, camera, size, count, &[params])[0]
}

/// The same for several parameters that differ in knobs which are not structural.
pub fn frames_means(
    scene: &Scene,
    camera: &Camera,
    size: [u32; 2],
    count: u32,
    params: &[FrameParams],
) -> Vec<Mean> {
    let backend = TraceBackend::Compute;
    let mut frames = Frames::with_params(scene.clone(), camera, backend, size, 17, false, params[0].clone());
    let mut mean = |params: &FrameParams| {
        frames.set_params(params.clone());
        let means: Vec<DVec3> = (0..count)
            .map(|_| {
                frames.render(0.0);
                let pixels = frames.image(FLAT_COLOR).pixels;
                let sum: DVec3 = pixels.iter().map(|p| DVec3::from_array(p.map(f64::from))).sum();
                sum / pixels.len() as f64
            })
            .collect();
        let n = f64::from(count);
        let mean = means.iter().sum::<DVec3>() / n;
        let variance = means.iter().map(|m| (m - mean) * (m - mean)).sum::<DVec3>() / (n - 1.0);
        Mean { mean, error: (variance / n).map(f64::sqrt) }
    };
    let means = params.iter().map(&mut mean).collect();
    frames.finish();
    means
}

/// A scene on the device of the tests.
pub fn session(device: &TestDevice, scene: &Scene) -> Session {
    Session::on(device, TraceBackend::Compute, &CameraArgs::default(), scene.clone()).unwrap()
}

/// The same of the reference path tracer, with paths of at most `bounces` bounces.
pub fn reference_mean(scene: &Scene, camera: &Camera, size: [u32; 2], bounces: u32, spp: u32) -> Mean {
    let params = ReferenceParams { max_bounces: Some(bounces), spp, ..ReferenceParams::default() };
    reference_mean_with(scene, camera, size, params)
}

/// The same with parameters of one's own.
pub fn reference_mean_with(scene: &Scene, camera: &Camera, size: [u32; 2], params: ReferenceParams) -> Mean {
    let spp = params.spp;
    let device = TestDevice::open();
    let mut session = session(&device, scene);
    let record = camera_record(camera, size);
    let frame = FrameRecord::new(record, record, size, 0, 99);
    let Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights).unwrap();
    let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0).unwrap();
    while render.next_sample() < spp {
        render.step(scene, gpu, lights, spp).unwrap();
    }
    let estimate = render.state().unwrap().estimate(spp);
    let n = estimate.pixels.len() as f64;
    let mean = estimate.pixels.iter().map(|p| p.mean.as_dvec3()).sum::<DVec3>() / n;
    let variance = estimate.pixels.iter().map(|p| p.variance.as_dvec3()).sum::<DVec3>();
    Mean { mean, error: variance.map(f64::sqrt) / n }
}

/// Adds a flat polygon with normals of its own.
pub fn polygon(scene: &mut Scene, corners: &[Vec3], material: Material) {
    let n = corners.len();
    let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize().unwrap_or(Vec3::Y);
    let tangent = (corners[1] - corners[0]).try_normalize().unwrap_or(Vec3::X).extend(1.0);
    add(
        scene,
        corners.to_vec(),
        vec![up; n],
        vec![tangent; n],
        (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect(),
        material,
    );
}

/// Adds a cube from -1 to 1; its fronts are inside or outside.
pub fn cube(scene: &mut Scene, place: Affine3A, inside: bool, material: Material) {
    let (mut positions, mut normals, mut tangents, mut indices) = (vec![], vec![], vec![], vec![]);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let normal = Vec3::AXES[axis] * side;
            let (u, v) = (Vec3::AXES[(axis + 1) % 3] * side, Vec3::AXES[(axis + 2) % 3]);
            let first = positions.len() as u32;
            positions.extend([normal - u - v, normal + u - v, normal + u + v, normal - u + v]);
            normals.extend([if inside { -normal } else { normal }; 4]);
            tangents.extend([u.extend(1.0); 4]);
            let quad = [[0, 1, 2], [0, 2, 3]].map(|[a, b, c]: [u32; 3]| {
                if inside { [first + a, first + c, first + b] } else { [first + a, first + b, first + c] }
            });
            indices.extend(quad);
        }
    }
    let positions = positions.into_iter().map(|p: Vec3| place.transform_point3(p)).collect();
    let across = place.matrix3.inverse().transpose();
    let normals = normals.into_iter().map(|n: Vec3| (across * n).normalize()).collect();
    let tangents = tangents
        .into_iter()
        .map(|t: Vec4| place.transform_vector3(t.truncate()).normalize().extend(t.w))
        .collect();
    add(scene, positions, normals, tangents, indices, material);
}

fn add(
    scene: &mut Scene,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<Vec4>,
    indices: Vec<[u32; 3]>,
    material: Material,
) {
    let n = positions.len();
    scene.instances.push(Instance::new(&material.name, scene.meshes.len() as u32, Affine3A::IDENTITY));
    scene.meshes.push(Mesh {
        name: material.name.clone(),
        positions,
        normals,
        tangents,
        uv0: vec![Vec2::ZERO; n],
        uv1: vec![Vec2::ZERO; n],
        colors: vec![Vec4::ONE; n],
        triangle_materials: vec![scene.materials.len() as u32; indices.len()],
        first_masked: if material.is_masked() { 0 } else { indices.len() },
        indices,
        ..Mesh::default()
    });
    scene.materials.push(material);
}

/// A closed Lambertian box from -1 to 1, seen from inside.
pub fn furnace(emission: Vec3, albedo: Vec3) -> (Scene, Camera) {
    let mut scene = Scene::default();
    let wall = Material { emissive: emission, ..Material::lambertian("wall", albedo) };
    cube(&mut scene, Affine3A::IDENTITY, true, wall);
    let camera = Camera::look_at("inside", Vec3::new(0.1, 0.05, 0.9), Vec3::new(0.0, 0.0, -1.0), 1.0);
    (scene, camera)
}
