//! What a frame of a deforming mesh costs: the deformation kernel and the refit of every trace backend (GPU time), beside a new
//! tree on one core of the host. `cargo bench -p pt-scene [-- FILE.glb...]`; without files a sheet of 100,352 triangles on 64 joints.

use std::sync::Arc;
use std::time::Instant;

use pt_core::harness::{PassRow, WARM_UP, measure};
use pt_core::trace::{BvhQuality, Leaf, MeshBvh, TraceBackend};
use pt_core::{Device, DeviceOptions};
use pt_import::{LoadOptions, load};
use pt_scene::animation::{Deformation, Influence, Skin};
use pt_scene::glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use pt_scene::gpu::GpuScene;
use pt_scene::{Instance, Material, Mesh, Scene};

const FRAMES: u32 = 16;
/// Quads along a side of the sheet.
const SIDE: u32 = 224;
const JOINTS: u32 = 64;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let device = Device::open(&DeviceOptions::default())?;
    println!("{} ({})", device.info().name, device.info().driver_line());
    if files.is_empty() {
        bench(&device, sheet(), |scene, frame| wave(scene, 0.05 * frame as f32))?;
    }
    for file in files {
        let scene = load(&file, &LoadOptions::default())?;
        bench(&device, scene, |scene, frame| scene.set_time(f64::from(frame) / 60.0, 0.0))?;
    }
    Ok(())
}

/// A sheet of 10 x 10 m; every vertex hangs on the two joints beside it.
fn sheet() -> Scene {
    let mut mesh = Mesh { name: "sheet".into(), ..Mesh::default() };
    for i in 0..(SIDE + 1) * (SIDE + 1) {
        let at = Vec2::new((i % (SIDE + 1)) as f32, (i / (SIDE + 1)) as f32) / SIDE as f32;
        mesh.positions.push(Vec3::new(10.0 * at.x, 0.0, 10.0 * at.y));
        mesh.normals.push(Vec3::Y);
        mesh.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
        mesh.uv0.push(at);
        mesh.uv1.push(at);
        mesh.colors.push(Vec4::ONE);
        let place = at.x * (JOINTS - 1) as f32;
        let (joint, share) = ((place as u32).min(JOINTS - 2), place.fract());
        let pair = [(joint, 1.0 - share), (joint + 1, share)].into_iter().filter(|(_, weight)| *weight > 0.0);
        mesh.influences.push(pair.map(|(joint, weight)| Influence { joint, weight }));
    }
    for z in 0..SIDE {
        for x in 0..SIDE {
            let v = z * (SIDE + 1) + x;
            mesh.indices.extend([[v, v + SIDE + 1, v + 1], [v + 1, v + SIDE + 1, v + SIDE + 2]]);
        }
    }
    mesh.triangle_materials = vec![0; mesh.indices.len()];
    mesh.first_masked = mesh.indices.len();
    let skin =
        Skin { joints: (0..JOINTS).collect(), inverse_bind: vec![Affine3A::IDENTITY; JOINTS as usize] };
    mesh.deformation = Some(Box::new(Deformation::new(&mesh, 0, Some(Arc::new(skin)), &[])));
    Scene {
        name: "sheet".into(),
        instances: vec![Instance::new("sheet", 0, Affine3A::IDENTITY)],
        meshes: vec![mesh],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

fn wave(scene: &mut Scene, time: f32) {
    if let Some(deformation) = &mut scene.meshes[0].deformation {
        for (k, joint) in deformation.joints.iter_mut().enumerate() {
            let phase = 0.3 * k as f32 + time;
            *joint = Affine3A::from_translation(Vec3::Y * phase.sin())
                * Affine3A::from_quat(Quat::from_rotation_x(0.2 * phase.cos()));
        }
    }
}

fn bench(
    device: &Device,
    mut scene: Scene,
    step: impl Fn(&mut Scene, u32),
) -> Result<(), Box<dyn std::error::Error>> {
    let deforming: Vec<usize> =
        (0..scene.meshes.len()).filter(|&m| scene.meshes[m].deformation.is_some()).collect();
    let sum = |count: fn(&Mesh) -> usize| deforming.iter().map(|&m| count(&scene.meshes[m])).sum::<usize>();
    println!(
        "{}: {} vertices and {} triangles deform",
        scene.name,
        sum(Mesh::vertex_count),
        sum(Mesh::triangle_count)
    );
    step(&mut scene, 9);
    scene.pose_meshes();
    let start = Instant::now();
    for mesh in &scene.meshes {
        std::hint::black_box(mesh.deformed());
    }
    println!("  vertices on the host: {:.3} ms", start.elapsed().as_secs_f64() * 1e3);
    let mut rebuilt = [0.0; 2];
    for (ms, quality) in rebuilt.iter_mut().zip([BvhQuality::Fast, BvhQuality::Medium]) {
        let build = || -> Result<f64, pt_core::trace::TraceError> {
            let start = Instant::now();
            for &m in &deforming {
                let mesh = &scene.meshes[m];
                let indices = bytemuck::cast_slice(&mesh.indices);
                std::hint::black_box(MeshBvh::build(&mesh.positions, indices, quality, Leaf::Triangle)?);
            }
            Ok(start.elapsed().as_secs_f64() * 1e3)
        };
        *ms =
            (0..3).map(|_| build()).collect::<Result<Vec<_>, _>>()?.into_iter().fold(f64::INFINITY, f64::min);
        println!("  new trees on the host ({quality:?}): {ms:.3} ms");
    }
    for backend in TraceBackend::available(device) {
        let mut gpu = GpuScene::new(device, &scene, backend)?;
        let mut frame_number = 10;
        let times = measure(device, [1, 1], WARM_UP, FRAMES, |frame| {
            frame_number += 1;
            step(&mut scene, frame_number);
            gpu.update(frame, &scene)
        })?;
        let of = |pass: &str| -> f64 {
            let rows = times.passes.iter().filter(|row: &&PassRow| row.pass.starts_with(pass));
            rows.map(|row| row.time.median_ms).fold(0.0, |a, b| a + b)
        };
        let (deform, refit) = (of("deform"), of("refit"));
        let total = deform + refit;
        println!(
            "  {backend}: deform {deform:.3} ms, refit {refit:.3} ms, top level {:.3} ms; a new Fast tree takes {:.1} x, a Medium one {:.1} x as long as both",
            of("top-level structure"),
            rebuilt[0] / total,
            rebuilt[1] / total,
        );
    }
    Ok(())
}
