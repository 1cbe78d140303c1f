//! Motion of what is seen through a ball of glass and in a curved mirror: where the last frame shows the same point of a wall, found in a G-buffer
//! of eight times the resolution.

use super::rig::{Rig, glass, rectangle};
use glam::{Affine3A, DVec2, Vec2, Vec3, Vec4};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::split::split_to_flat;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::{GbufferParams, Jitter, MotionOfReplaced, PrimaryRays, ReflectRefract, ReplacedMotion};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, Instance, Material, Mesh, Scene};
use pt_shaders::channels;
use pt_shaders::records::FrameRecord;

const SIZE: [u32; 2] = [48, 36];
const FINER: u32 = 8;
/// Of the wall among the instances.
const WALL: u32 = 1;

fn ball(scene: &mut Scene, material: Material) {
    let (around, down) = (96u32, 48u32);
    let mut mesh = Mesh { name: "ball".into(), ..Mesh::default() };
    for j in 0..=down {
        for i in 0..=around {
            let (polar, azimuth) = (
                std::f32::consts::PI * j as f32 / down as f32,
                std::f32::consts::TAU * i as f32 / around as f32,
            );
            let normal = Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), -polar.sin() * azimuth.sin());
            mesh.positions.push(normal);
            mesh.normals.push(normal);
            if i < around && j < down {
                let [a, b] = [j * (around + 1) + i, (j + 1) * (around + 1) + i];
                mesh.indices.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
    }
    let count = mesh.positions.len();
    mesh.tangents = vec![Vec4::X; count];
    (mesh.uv0, mesh.uv1) = (vec![Vec2::ZERO; count], vec![Vec2::ZERO; count]);
    mesh.colors = vec![Vec4::ONE; count];
    mesh.triangle_materials = vec![scene.materials.len() as u32; mesh.indices.len()];
    mesh.first_masked = mesh.indices.len();
    scene.instances.push(Instance::new("ball", scene.meshes.len() as u32, Affine3A::IDENTITY));
    scene.meshes.push(mesh);
    scene.materials.push(material);
}

/// What the split texels show: instance, position, motion.
struct Shown {
    size: [u32; 2],
    instances: Vec<u32>,
    positions: Vec<Vec3>,
    motions: Vec<DVec2>,
}

/// The last of the frames that the cameras see one after the other.
fn show(rig: &Rig, scene: &Scene, cameras: &[Camera], size: [u32; 2], params: &GbufferParams) -> Shown {
    let mut gpu = GpuScene::new(&rig.device, scene, rig.backend).unwrap();
    let variant = gpu.variant();
    let primary = PrimaryRays::new(&rig.device, variant).unwrap();
    let stage =
        ReflectRefract::new(&rig.device, variant, false, GbufferParams::default().effect_layers).unwrap();
    let search = ReplacedMotion::new(&rig.device, variant).unwrap();
    let io = [PrimaryRays::IO, ReflectRefract::IO, ReplacedMotion::IO];
    let mut images = ChannelImages::alone(&rig.device, FrameSizes::same(size), &io).unwrap();
    let uniforms = Uniforms::new(&rig.device, "frame_uniforms").unwrap();
    let mut recorder = Recorder::new(&rig.device).unwrap();
    for (index, camera) in cameras.iter().enumerate() {
        let [now, then] = [camera, &cameras[index.saturating_sub(1)]].map(|c| camera_record(c, size));
        let mut frame = recorder.begin().unwrap();
        images.begin_frame();
        gpu.update(&mut frame, scene).unwrap();
        uniforms.upload(&mut frame, &FrameRecord::new(now, then, size, index as u32, 7)).unwrap();
        let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
        primary.record(&mut frame, &inputs, params).unwrap();
        for bounce in 0..params.reflect_refract {
            stage.record(&mut frame, &inputs, params, 0, bounce, 0).unwrap();
        }
        if params.searches_motion() {
            search.record(&mut frame, &inputs, params).unwrap();
        }
        frame.submit().unwrap();
        recorder.finish().unwrap();
    }
    let floats = |id| images.current(id).read_f32().unwrap();
    let visible = images.current(channels::VISIBILITY).read_u32().unwrap();
    Shown {
        size,
        instances: visible.chunks(2).map(|v| v[0]).collect(),
        positions: floats(channels::SHADING_POSITION)
            .chunks(4)
            .map(|p| Vec3::new(p[0], p[1], p[2]))
            .collect(),
        motions: (floats(channels::MOTION).chunks(4))
            .map(|m| DVec2::new(m[0].into(), m[1].into()) * DVec2::new(size[0].into(), size[1].into()))
            .collect(),
    }
}

/// Flat place of a split texel's middle, in pixels of the coarse frame.
fn place(shown: &Shown, i: usize) -> DVec2 {
    let width = field_width(shown.size[0]);
    let flat = split_to_flat([i as u32 % (2 * width), i as u32 / (2 * width)], width);
    (DVec2::new(flat[0].into(), flat[1].into()) + 0.5) * f64::from(SIZE[0]) / f64::from(shown.size[0])
}

/// Distances between where motion vectors lead to and where the last frame shows the point, pixels; of texels of one field that see the wall by way
/// of the ball, where the last frame shows the point at all.
fn errors(now: &Shown, before: &Shown, odd_field: bool) -> Vec<f64> {
    let of_field = |shown: &Shown| {
        let width = field_width(shown.size[0]) as usize;
        let on_wall = |i: &usize| shown.instances[*i] == WALL && (i % (2 * width) >= width) == odd_field;
        // Only the middle of the picture is the ball's.
        let in_ball = |i: &usize| (place(shown, *i) - DVec2::new(24.0, 18.0)).length() < 11.0;
        (0..shown.instances.len()).filter(on_wall).filter(in_ball).collect::<Vec<_>>()
    };
    let fine = of_field(before);
    let mut found = Vec::new();
    for i in of_field(now) {
        let distance = |j: &usize| before.positions[*j].distance_squared(now.positions[i]);
        let nearest = *fine.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let truth = place(before, nearest);
        // At the rim, and where it comes into view, the last frame does not show the point.
        let neighbour = before.positions[nearest].distance(before.positions[nearest.saturating_sub(1)]);
        if distance(&nearest).sqrt() < neighbour {
            found.push((place(now, i) + now.motions[i]).distance(truth));
        }
    }
    found.sort_by(f64::total_cmp);
    found
}

/// The search against the motion of the surface alone; the truth itself is known to 0.14 pixels, half a texel of a field of the finer frame.
#[test]
fn motion_by_way_of_a_ball_is_found_in_the_last_frame() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let mirror = Material::metal("mirror", Vec3::ONE, 0.0);
    for (name, material, odd_field, wall_z) in
        [("glass", glass(true), true, -6.0), ("mirror", mirror, false, 9.0)]
    {
        let mut scene = Scene::default();
        ball(&mut scene, material);
        let mut place = Affine3A::from_translation(Vec3::Z * wall_z);
        if wall_z > 0.0 {
            place *= Affine3A::from_rotation_y(std::f32::consts::PI);
        }
        rectangle(&mut scene, Vec2::splat(60.0), Material::lambertian("wall", Vec3::ONE), place);
        let view =
            |x: f32, y: f32| Camera::look_at("view", Vec3::new(x, y, 5.0), Vec3::new(0.3 * x, 0.0, 0.0), 0.6);
        let (then, now) = (view(0.0, 0.1), view(0.12, 0.14));
        let params = |replaced_motion| GbufferParams {
            jitter: Jitter::None,
            reflect_refract: 3,
            replaced_motion,
            ..GbufferParams::default()
        };
        let fine = [SIZE[0] * FINER, SIZE[1] * FINER];
        let before =
            show(&rig, &scene, std::slice::from_ref(&then), fine, &params(MotionOfReplaced::Surface));
        let [surface, search] = [MotionOfReplaced::Surface, MotionOfReplaced::Search].map(|how| {
            errors(&show(&rig, &scene, &[then.clone(), now.clone()], SIZE, &params(how)), &before, odd_field)
        });
        let median = |e: &[f64]| e[e.len() / 2];
        let within =
            |e: &[f64], pixels: f64| e.iter().filter(|e| **e <= pixels).count() as f64 / e.len() as f64;
        for (how, e) in [("surface", &surface), ("search", &search)] {
            println!(
                "{name}, {how}: {} texels, median {:.3} pixels, within 0.1: {:.1} %, within 0.25: {:.1} %",
                e.len(),
                median(e),
                100.0 * within(e, 0.1),
                100.0 * within(e, 0.25)
            );
        }
        assert!(search.len() > 40, "{name}: {} texels", search.len());
        // What a ball mirrors moves nearly as the ball; what it refracts moves the other way.
        let (part, near) = if odd_field { (0.2, 0.8) } else { (0.8, 0.65) };
        assert!(median(&search) < part * median(&surface), "{name}");
        assert!(within(&search, 0.25) > near, "{name}");
    }
}
