//! Opacity tables: rays see the same with them and without, to the bit.

use glam::{Affine2, Affine3A, Vec2, Vec3, Vec4};
use pt_core::frame::Uniforms;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::{GbufferParams, Jitter, PrimaryRays};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{
    AlphaMode, Camera, Filter, Instance, Material, Mesh, Projection, Sampler, Scene, Texture, TextureRef,
    TextureUsage, Wrap,
};
use pt_shaders::channels::VISIBILITY;
use pt_shaders::records::{FEATURE_OPACITY_TABLE, FrameRecord};

const SIZE: [u32; 2] = [160, 120];
const ACROSS: usize = 8;
const DOWN: usize = 6;

/// Discs and stripes of full, no and half alpha, 37 x 23 texels.
fn leaves(sampler: Sampler) -> Texture {
    let alpha = |i: u32| {
        let (x, y) = (i % 37, i / 37);
        let away = (x as f32 - 14.0).hypot(y as f32 - 11.0);
        match () {
            () if away < 9.0 => 255,
            () if x > 30 && y % 4 == 0 => 128,
            () if x > 24 => 255 * u8::from(y > 15),
            () => 0,
        }
    };
    let texels = (0..37 * 23).flat_map(|i| [200, 180, 90, alpha(i)]).collect();
    Texture { sampler, ..Texture::rgba8("leaves", [37, 23], TextureUsage::Color, texels) }
}

/// A wall of squares, each with a material and texture coordinates of its own: cut out or blended, wrapped in all ways, turned, mirrored and repeated.
fn wall() -> Scene {
    let mut scene = Scene::default();
    let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    for (i, &wrap_u) in wraps.iter().enumerate() {
        for (k, &wrap_v) in wraps.iter().enumerate() {
            let mag = if (i + k) % 2 == 0 { Filter::Linear } else { Filter::Nearest };
            scene.textures.push(leaves(Sampler { wrap_u, wrap_v, mag, ..Sampler::default() }));
        }
    }
    let mut mesh = Mesh { name: "wall".into(), ..Mesh::default() };
    for i in 0..ACROSS * DOWN {
        let (x, y) = ((i % ACROSS) as f32, (i / ACROSS) as f32);
        let number = i as f32;
        let scale = [0.4, 1.0, 2.7][i % 3] * Vec2::new(1.0, if i % 2 == 0 { 1.0 } else { -1.3 });
        let transform = Affine2::from_scale_angle_translation(
            scale,
            0.7 * number,
            Vec2::new(0.37 * number - 3.0, -0.21 * number),
        );
        let texture = TextureRef { transform, ..TextureRef::new((i % scene.textures.len()) as u32) };
        let alpha_mode =
            if i % 5 == 4 { AlphaMode::Blend } else { AlphaMode::Mask { cutoff: [0.5, 0.1, 0.9][i % 3] } };
        scene.materials.push(Material {
            alpha_mode,
            double_sided: true,
            base_color: Vec4::new(1.0, 1.0, 1.0, if i % 7 == 6 { 0.6 } else { 1.0 }),
            base_color_texture: Some(texture),
            ..Material::default()
        });
        let corners = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
        let base = mesh.positions.len() as u32;
        for corner in corners {
            mesh.positions.push((Vec2::new(x, y) + corner).extend(0.0));
            mesh.uv0.push(corner);
            // Alpha of the vertices that is the same, and such that is not.
            let alpha = if i % 11 == 10 { corner.x } else { 1.0 };
            mesh.colors.push(Vec4::new(1.0, 1.0, 1.0, alpha));
        }
        mesh.indices.extend([[base, base + 1, base + 2], [base + 3, base + 2, base + 1]]);
        mesh.triangle_materials.extend([i as u32; 2]);
    }
    let vertices = mesh.positions.len();
    mesh.normals = vec![Vec3::Z; vertices];
    mesh.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); vertices];
    mesh.uv1 = vec![Vec2::ZERO; vertices];
    scene.meshes.push(mesh);
    scene.instances.push(Instance::new("wall", 0, Affine3A::IDENTITY));
    scene.validate().unwrap();
    scene
}

/// What a frame sees of the wall, with the features in which two kernels differ.
fn seen(device: &TestDevice, scene: &Scene, backend: TraceBackend, opacity_table: bool) -> (Vec<u32>, u32) {
    let middle = Vec3::new(ACROSS as f32, DOWN as f32, 0.0) / 2.0;
    let mut camera = Camera::look_at("front", middle + 5.0 * Vec3::Z, middle, 0.7);
    camera.projection = Projection::Orthographic { ymag: DOWN as f32 / 2.0 };
    let camera = camera_record(&camera, SIZE);
    let mut gpu = GpuScene::new(device, scene, backend).unwrap();
    let params = GbufferParams { jitter: Jitter::None, opacity_table, ..Default::default() };
    let variant = params.variant(gpu.variant());
    let stage = PrimaryRays::new(device, variant).unwrap();
    let images = ChannelImages::alone(device, FrameSizes::same(SIZE), &[PrimaryRays::IO]).unwrap();
    let uniforms = Uniforms::new(device, "frame_uniforms").unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    gpu.update(&mut frame, scene).unwrap();
    uniforms.upload(&mut frame, &FrameRecord::new(camera, camera, SIZE, 0, 0)).unwrap();
    let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
    stage.record(&mut frame, &inputs, &params).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();
    (images.current(VISIBILITY).read_u32().unwrap(), variant.scene_features)
}

#[test]
fn rays_see_the_same_with_a_table() {
    let device = TestDevice::open();
    let scene = wall();
    for backend in TraceBackend::CONCRETE {
        if let Some(why) = backend.missing(&device) {
            println!("skipped: {why}");
            continue;
        }
        let [(with, features), (without, none)] = [true, false].map(|t| seen(&device, &scene, backend, t));
        assert_eq!((features ^ none), FEATURE_OPACITY_TABLE);
        let surfaces = with.chunks_exact(2).filter(|v| v[0] != u32::MAX).count();
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        assert!(surfaces > pixels / 5 && surfaces < 4 * pixels / 5, "{surfaces} of {pixels}");
        let differ = with.iter().zip(&without).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "{backend}: {differ} of {}", with.len());
    }
}
