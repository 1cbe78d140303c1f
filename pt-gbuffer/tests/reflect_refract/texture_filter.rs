//! The stochastic texture filter in the G-buffer: means of what it draws, which numbers surfaces share, and what it does to shading.

use super::rig::{Rig, SIZE, follow, parallel_rays};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::{GbufferParams, Jitter, PrimaryRays, ReflectRefract, TextureFilter};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{
    Camera, Environment, EnvironmentImage, Instance, Material, Mesh, Scene, Texture, TextureRef, TextureUsage,
};
use pt_shaders::channels::{BASE_COLOR, METALLIC_ROUGHNESS, THROUGHPUT};
use pt_shaders::records::FrameRecord;

/// A square of 2 m in the plane z = 0 that faces +Z; u goes along +X, or along -X if `flip`, v along -Y.
fn square(scene: &mut Scene, material: Material, place: Affine3A, flip: bool) {
    let corners = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::ONE, Vec2::new(-1.0, 1.0)];
    let u = if flip { -1.0 } else { 1.0 };
    scene.meshes.push(Mesh {
        name: "square".into(),
        positions: corners.iter().map(|c| c.extend(0.0)).collect(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec4::new(u, 0.0, 0.0, u); 4],
        uv0: corners.iter().map(|c| 0.5 + 0.5 * Vec2::new(u * c.x, -c.y)).collect(),
        uv1: vec![Vec2::ZERO; 4],
        colors: vec![Vec4::ONE; 4],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![scene.materials.len() as u32; 2],
        first_masked: 2,
        ..Mesh::default()
    });
    scene.materials.push(material);
    scene.instances.push(Instance::new("square", scene.meshes.len() as u32 - 1, place));
}

/// Grey texels of a hash. A pixel of the tests is 1.5 of them wide: levels 0 and 1 are drawn, and texels of both.
fn hash() -> Texture {
    const SIDE: u32 = 72;
    let grey = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
    let texels = (0..SIDE * SIDE).flat_map(|i| [grey(i), grey(i), grey(i), 255]).collect();
    Texture::rgba8("hash", [SIDE, SIDE], TextureUsage::Data, texels)
}

fn textured(metallic: f32, roughness: f32, roughness_too: bool) -> Material {
    Material {
        metallic,
        roughness,
        base_color_texture: Some(TextureRef::new(0)),
        metallic_roughness_texture: roughness_too.then(|| TextureRef::new(0)),
        ..Material::metal("textured", Vec3::ONE, roughness)
    }
}

/// Base colour, roughness and throughput (red) of every pixel in every frame. Parallel rays come from z = 5.
fn frames(scene: &Scene, params: &GbufferParams, count: u32) -> Vec<Vec<[f32; 3]>> {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = camera_record(&parallel_rays(Vec3::Z * 5.0), SIZE);
    let mut gpu = GpuScene::new(&rig.device, scene, rig.backend).unwrap();
    let variant = params.variant(gpu.variant());
    let primary = PrimaryRays::new(&rig.device, variant).unwrap();
    let stage = ReflectRefract::new(&rig.device, variant, false, 1).unwrap();
    let images = ChannelImages::alone(&rig.device, FrameSizes::same(SIZE), &[PrimaryRays::IO]).unwrap();
    let uniforms = Uniforms::new(&rig.device, "frame_uniforms").unwrap();
    let mut recorder = Recorder::new(&rig.device).unwrap();
    let mut render = |index| {
        let mut frame = recorder.begin().unwrap();
        gpu.update(&mut frame, scene).unwrap();
        uniforms.upload(&mut frame, &FrameRecord::new(camera, camera, SIZE, index, 3)).unwrap();
        let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
        primary.record(&mut frame, &inputs, params).unwrap();
        for bounce in 0..params.reflect_refract {
            stage.record(&mut frame, &inputs, params, 0, bounce, 0).unwrap();
        }
        frame.submit().unwrap();
        recorder.finish().unwrap();
        let read = |id, channels: usize, channel: usize| -> Vec<f32> {
            let all = images.current(id).read_f32().unwrap();
            all.into_iter().skip(channel).step_by(channels).collect()
        };
        let (base, roughness, throughput) =
            (read(BASE_COLOR, 4, 0), read(METALLIC_ROUGHNESS, 2, 1), read(THROUGHPUT, 4, 0));
        (0..base.len()).map(|i| [base[i], roughness[i], throughput[i]]).collect()
    };
    (0..count).map(&mut render).collect()
}

fn stochastic(reflect_refract: u32) -> GbufferParams {
    GbufferParams { texture_filter: TextureFilter::Stochastic, ..follow(reflect_refract) }
}

/// Mean and variance over the frames of a value of a pixel.
fn moments(frames: &[Vec<[f32; 3]>], pixel: usize, value: usize) -> (f64, f64) {
    let n = frames.len() as f64;
    let mean = frames.iter().map(|f| f64::from(f[pixel][value])).sum::<f64>() / n;
    let square = frames.iter().map(|f| (f64::from(f[pixel][value]) - mean).powi(2)).sum::<f64>();
    (mean, square / (n - 1.0))
}

/// The mean over frames of each pixel is the filtered base colour; textures of a surface show the same texel.
#[test]
fn a_pixel_draws_one_texel_of_all_textures() {
    let mut scene = Scene { textures: vec![hash()], ..Scene::default() };
    square(&mut scene, textured(1.0, 1.0, true), Affine3A::IDENTITY, false);
    let filtered = &frames(&scene, &follow(0), 1)[0];
    let drawn = frames(&scene, &stochastic(0), 384);
    let pixels = filtered.len();
    assert_eq!(pixels, (2 * field_width(SIZE[0]) * SIZE[1]) as usize);
    let (mut squares, mut spread) = (0.0, 0.0);
    for pixel in 0..pixels {
        for frame in &drawn {
            let [base, roughness, _] = frame[pixel];
            assert!((base - roughness).abs() < 1e-4, "base colour {base}, roughness {roughness}");
        }
        let (mean, variance) = moments(&drawn, pixel, 0);
        // Samplers take weights of 8 bits and levels of a few bits after the point.
        let error = variance / drawn.len() as f64 + f64::powi(8e-3, 2);
        squares += (mean - f64::from(filtered[pixel][0])).powi(2) / error;
        spread += variance;
    }
    // A sum of squares of 768 numbers with variance 1: the standard deviation of their mean is 0.05.
    assert!(squares / (pixels as f64) < 1.25, "{}", squares / pixels as f64);
    assert!(spread / pixels as f64 > 0.01, "the pixels draw the same texel in all frames");
}

/// A mirror and the wall that it shows have the same texture at the same places of the picture.
#[test]
fn surfaces_of_a_path_draw_independently() {
    let mut scene = Scene { textures: vec![hash()], ..Scene::default() };
    square(&mut scene, textured(1.0, 0.0, false), Affine3A::IDENTITY, false);
    let turn = Affine3A::from_rotation_y(std::f32::consts::PI);
    square(&mut scene, textured(0.0, 1.0, false), Affine3A::from_translation(10.0 * Vec3::Z) * turn, true);
    let drawn = frames(&scene, &stochastic(1), 128);
    let (mut covariance, mut scale) = (0.0, 0.0);
    for pixel in 0..drawn[0].len() {
        let ((wall, wall_variance), (mirror, mirror_variance)) =
            (moments(&drawn, pixel, 0), moments(&drawn, pixel, 2));
        let product = |f: &Vec<[f32; 3]>| (f64::from(f[pixel][0]) - wall) * (f64::from(f[pixel][2]) - mirror);
        covariance += drawn.iter().map(product).sum::<f64>() / drawn.len() as f64;
        scale += (wall_variance * mirror_variance).sqrt();
    }
    let correlation = covariance / scale;
    assert!(scale > 1.0, "nothing is drawn");
    // 128 frames of 768 pixels: the standard error is 0.003.
    assert!(correlation.abs() < 0.02, "{correlation}");
}

/// A mirror with grooves in a normal map, at a grazing angle: each flank shows another side of the sky than the plane would. A sampler
/// averages the flanks first and so shows the plane's sky.
#[test]
fn grooves_are_filtered_after_shading() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    // Two rows of texels a flank; a pixel is about one texel wide and nine long.
    let flanks =
        |i: u32| if (i / 1024).is_multiple_of(2) { [191, 128, 238, 255] } else { [64, 128, 238, 255] };
    let texels = (0..512 * 512).flat_map(flanks).collect();
    let texture = Texture::rgba8("grooves", [512; 2], TextureUsage::Normal, texels);
    // Bright within a degree or two of where the plane reflects the camera's rays, -Z at u = 0.25; flanks show what is 6 degrees away.
    let bright = |x: i32| if (x - 90).abs() <= 1 { Vec3::ONE } else { Vec3::ZERO };
    let sky = EnvironmentImage { width: 360, height: 2, texels: (0..720).map(|i| bright(i % 360)).collect() };
    let mut scene = Scene { textures: vec![texture], environment: Environment::new(sky), ..Scene::default() };
    let grooved =
        Material { normal_texture: Some(TextureRef::new(0)), ..Material::metal("grooved", Vec3::ONE, 0.0) };
    square(&mut scene, grooved, Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2), false);
    let eye = Vec3::new(0.0, 0.12, 0.993);
    let camera = Camera::look_at("grazing", eye, Vec3::ZERO, 0.1);
    let mean = |params: GbufferParams| {
        let params = GbufferParams { jitter: Jitter::Pixel, ..params };
        let frames = rig.render(&scene, [&camera; 2], &params, 48);
        frames.radiance.iter().map(|c| c.x).sum::<f64>() / frames.radiance.len() as f64
    };
    let truth = mean(GbufferParams { texture_lod_bias: -8.0, ..follow(1) });
    let [before, after] = [follow(1), stochastic(1)].map(mean).map(|x| (x - truth).abs());
    println!("truth {truth}; error of filtering before shading {before}, after shading {after}");
    assert!(before > 0.2, "the scene does not tell the filters apart: {before}");
    assert!(after < 0.5 * before, "after shading {after}, before {before}");
}
