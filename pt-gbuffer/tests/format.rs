//! The compact G-buffer holds what the full one does, but for the rounding of its formats.

use glam::{Affine3A, Vec3};
use pt_core::frame::Uniforms;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::{GbufferParams, PrimaryRays};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, builtin};
use pt_shaders::channels::{COMPACT, ChannelId, GbufferFormat};
use pt_shaders::records::FrameRecord;
use std::collections::BTreeMap;

const SIZE: [u32; 2] = [96, 64];

/// What primary rays store, as values and as bytes, and the bytes of all images.
struct Gbuffer {
    values: BTreeMap<ChannelId, Vec<f32>>,
    texels: BTreeMap<ChannelId, Vec<u8>>,
    bytes: u64,
}

fn gbuffer(device: &TestDevice, gbuffer_format: GbufferFormat) -> Gbuffer {
    let device = device.with_formats(gbuffer_format.others());
    let scene = builtin("gallery").unwrap();
    let params = GbufferParams { format: gbuffer_format, ..GbufferParams::default() };
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap();
    let stage = PrimaryRays::new(&device, params.variant(gpu.variant())).unwrap();
    let images = ChannelImages::alone(&device, FrameSizes::same(SIZE), &[PrimaryRays::IO]).unwrap();
    let uniforms = Uniforms::new(&device, "frame_uniforms").unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let now = scene.default_camera();
    // A turn and a step: motion of a tenth of the frame, which differs from pixel to pixel.
    let turn = Affine3A::from_rotation_y(0.1) * Affine3A::from_translation(Vec3::new(0.1, 0.05, 0.4));
    let before = Camera { world_from_camera: now.world_from_camera * turn, ..now.clone() };
    let [now, before] = [&now, &before].map(|camera| camera_record(camera, SIZE));
    let mut frame = recorder.begin().unwrap();
    gpu.update(&mut frame, &scene).unwrap();
    uniforms.upload(&mut frame, &FrameRecord::new(now, before, SIZE, 0, 1)).unwrap();
    let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
    stage.record(&mut frame, &inputs, &params).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();
    Gbuffer {
        values: images.ids().map(|id| (id, images.current(id).read_f32().unwrap())).collect(),
        texels: images.ids().map(|id| (id, images.current(id).read().unwrap())).collect(),
        bytes: images.bytes(),
    }
}

/// Largest error that a compact channel may have of a value that the full one holds.
fn largest_error(id: ChannelId, value: f32) -> f32 {
    // Half a step of 8 bits, and half a step of the 16 bits of the full channel.
    let (step, full) = (0.5 / 255.0, 0.5 / 65535.0);
    match id.channel().name {
        // (r + e)^2 - r^2 for a root r.
        "base_color" => 2.0 * value.sqrt() * step + step * step + 2.0 * full,
        "metallic_roughness" => step + full,
        // A device may round to either neighbour: 10 bits after the point, and steps of 2^-24 near zero.
        "motion" => value.abs() / 1024.0 + f32::powi(2.0, -24),
        name => panic!("{name}: no error is known"),
    }
}

#[test]
fn compact_channels_are_rounded_and_the_others_are_the_same() {
    let device = TestDevice::open();
    let [full, compact] =
        [GbufferFormat::Full, GbufferFormat::Compact].map(|format| gbuffer(&device, format));
    for (&id, values) in &full.values {
        let name = id.channel().name;
        if COMPACT.images.iter().all(|(channel, _)| *channel != id) {
            assert_eq!(full.texels[&id], compact.texels[&id], "{name}");
            continue;
        }
        let mut rounded = 0;
        for (&value, &found) in values.iter().zip(&compact.values[&id]) {
            let error = (found - value).abs();
            // Rounding of the arithmetic itself: far below a step.
            assert!(error <= largest_error(id, value) * 1.001 + 1e-9, "{name}: {found} for {value}");
            rounded += usize::from(error > 0.0);
        }
        assert!(rounded > values.len() / 20, "{name}: {rounded} of {} values are rounded", values.len());
    }
    // 4 bytes of base colour, 2 of metalness and roughness, 8 of motion; the split frame is as large as the full one here.
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    assert_eq!(full.bytes - compact.bytes, 14 * pixels);
}
