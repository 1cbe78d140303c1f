//! The composite kernel against its oracle and against closed forms.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use pt_core::pack::pack_unit_vector;
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, Recorder};
use pt_core::{FrameSizes, SplitLight, StageInputs};
use pt_denoise::oracle::{Pixel, composite, reflected};
use pt_denoise::{Composite, DenoiseParams};
use pt_shaders::channels::{
    BASE_COLOR, COLOR, COLOR_HF, COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC, ChannelId, METALLIC_ROUGHNESS,
    NORMAL, SHADING_POSITION, THROUGHPUT, TRANSPARENT, VIEW_DIRECTION,
};
use pt_shaders::glam::{DVec3, Vec3};
use pt_shaders::records::Background;

/// The normal of all pixels.
const NORMAL_OF_ALL: Vec3 = Vec3::new(0.6, 0.0, 0.8);

/// Runs the kernel over `pixels`, one frame of the given size, with or without indirect light; returns colours in the order of the split
/// image.
fn run(
    device: &TestDevice,
    size: [u32; 2],
    pixels: &mut [Pixel],
    params: &DenoiseParams,
    indirect: bool,
) -> Vec<[f32; 4]> {
    let (light, io) = match indirect {
        true => (SplitLight::UNFILTERED_INDIRECT, Composite::IO_INDIRECT),
        false => (SplitLight::UNFILTERED, Composite::IO),
    };
    let images = ChannelImages::alone(device, FrameSizes::same(size), &[light, io]).unwrap();
    let write = |id: ChannelId, texel: &dyn Fn(&Pixel) -> Vec<f32>| {
        let values: Vec<f32> = pixels.iter().flat_map(texel).collect();
        images.current(id).write_f32(&values).unwrap();
    };
    let rgb0 = |v: [f32; 3]| vec![v[0], v[1], v[2], 0.0];
    write(COLOR_HF, &|p| rgb0(p.color_hf));
    write(COLOR_SPEC, &|p| rgb0(p.color_spec));
    write(BASE_COLOR, &|p| p.base_color.to_vec());
    write(METALLIC_ROUGHNESS, &|p| vec![p.metallic, 0.5]);
    write(SHADING_POSITION, &|p| vec![1.0, 2.0, 3.0, f32::from_bits(p.material)]);
    write(VIEW_DIRECTION, &|p| vec![7.0, p.flags as f32]);
    write(THROUGHPUT, &|p| rgb0(p.throughput));
    write(TRANSPARENT, &|p| p.transparent.to_vec());
    if indirect {
        // Light of one direction, whose irradiance at the normal is that of the pixel: luma L (1/4 + cos/2) with the hue of L.
        let [d, n] = [Vec3::new(0.0, 0.6, 0.8), NORMAL_OF_ALL];
        let radiance = |p: &Pixel| p.irradiance_lf.map(|e| e / (0.25 + 0.5 * d.dot(n)));
        let ycocg = |[r, g, b]: [f32; 3]| [0.25 * r + 0.5 * g + 0.25 * b, r - b, g - 0.5 * (r + b)];
        write(COLOR_LF_SH, &|p| {
            let y = ycocg(radiance(p))[0];
            (d * (0.488_602_5 * y)).extend(0.282_094_8 * y).to_array().to_vec()
        });
        write(COLOR_LF_COCG, &|p| ycocg(radiance(p))[1..].to_vec());
        images.current(NORMAL).write_u32(&vec![pack_unit_vector(NORMAL_OF_ALL); pixels.len()]).unwrap();
    }
    // The oracle gets what the images hold after rounding to their formats.
    let read = |id: ChannelId| images.current(id).read_f32().unwrap();
    let (base, metal, throughput) = (read(BASE_COLOR), read(METALLIC_ROUGHNESS), read(THROUGHPUT));
    for (i, pixel) in pixels.iter_mut().enumerate() {
        pixel.base_color.copy_from_slice(&base[4 * i..4 * i + 4]);
        pixel.metallic = metal[2 * i];
        pixel.throughput.copy_from_slice(&throughput[4 * i..4 * i + 3]);
    }

    let stage = if indirect { Composite::with_indirect(device) } else { Composite::new(device) }.unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    stage.record(&mut frame, &StageInputs::new(&images), SplitLight::unfiltered(&images), params).unwrap();
    frame.submit().unwrap();
    read(COLOR).chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]]).collect()
}

fn split_pixels(size: [u32; 2]) -> usize {
    (size[0].div_ceil(2) * 2 * size[1]) as usize
}

fn pixel() -> impl Strategy<Value = Pixel> {
    let hdr = || prop_oneof![Just(0.0f32), (-4.0f32..4.0).prop_map(|e| 10f32.powf(e))];
    let unit = || prop_oneof![Just(0.0f32), Just(1.0), 0.0f32..1.0];
    let light = || [hdr(), hdr(), hdr()];
    // Material word: none, small indices (denormal as floats), the largest.
    let material = prop_oneof![Just(0u32), 1u32..100, Just(0x7f7f_ffff)];
    let base = [unit(), unit(), unit(), unit()];
    let overlay = (light(), unit()).prop_map(|(c, a)| [c[0], c[1], c[2], a]);
    let lights = (light(), light(), light());
    (lights, base, unit(), material, 0u32..8, [unit(), unit(), unit()], overlay).prop_map(
        |(
            (color_hf, irradiance_lf, color_spec),
            base_color,
            metallic,
            material,
            flags,
            throughput,
            transparent,
        )| Pixel {
            color_hf,
            irradiance_lf,
            color_spec,
            base_color,
            metallic,
            material,
            flags,
            throughput,
            transparent,
        },
    )
}

#[test]
fn kernel_agrees_with_the_oracle() {
    let device = TestDevice::open();
    let mut runner = TestRunner::deterministic();
    let altered = DenoiseParams {
        scale_hf: 0.5,
        scale_lf: 2.0,
        scale_spec: 3.0,
        scale_overlay: 0.25,
        fixed_albedo: Some(0.7),
        ..DenoiseParams::default()
    };
    let transparent = DenoiseParams { background: Background::Transparent, ..DenoiseParams::default() };
    for size in [[1, 1], [3, 1], [17, 5], [31, 33], [64, 16]] {
        for (params, indirect) in [
            (DenoiseParams::default(), false),
            (DenoiseParams::default(), true),
            (altered.clone(), false),
            (altered.clone(), true),
            (transparent.clone(), false),
        ] {
            let strategy = prop::collection::vec(pixel(), split_pixels(size));
            let mut pixels = strategy.new_tree(&mut runner).unwrap().current();
            if !indirect {
                pixels.iter_mut().for_each(|pixel| pixel.irradiance_lf = [0.0; 3]);
            }
            let gpu = run(&device, size, &mut pixels, &params, indirect);
            for (got, pixel) in gpu.iter().zip(&pixels) {
                let want = composite(pixel, &params);
                for (g, w) in got.iter().zip(want) {
                    // All terms are positive except 1 - a, which is exact enough: about eight roundings of 6e-8. Indirect light is made
                    // of luma and chroma with signs, and the normal has 16 bits.
                    let error = (f64::from(*g) - w).abs();
                    let largest = pixel.irradiance_lf.iter().fold(0.0, |a: f32, b| a.max(*b));
                    let rounding = 5e-5 * f64::from(largest * params.scale_lf);
                    assert!(error <= 2e-6 * w.abs() + 1e-7 + rounding, "{pixel:?}: {got:?}, oracle {want:?}");
                }
            }
        }
    }
}

#[test]
fn closed_forms() {
    let device = TestDevice::open();
    let surface = Pixel {
        color_hf: [2.0; 3],
        color_spec: [10.0; 3],
        base_color: [0.5, 0.25, 0.0, 0.04],
        material: 1,
        flags: 1,
        throughput: [1.0; 3],
        ..Default::default()
    };
    let metal = Pixel { metallic: 1.0, ..surface };
    // F0 = 0: the specular channel is demodulated by 0.01.
    let matte = Pixel { base_color: [0.5, 0.5, 0.5, 0.0], ..surface };
    let veiled = Pixel { transparent: [3.0, 3.0, 3.0, 0.5], ..surface };
    let sky = Pixel {
        material: 0,
        flags: 5,
        transparent: [7.0, 8.0, 9.0, 1.0],
        color_hf: [f32::NAN; 3],
        ..surface
    };
    let background = Pixel { material: 0, ..surface };
    let mut pixels = [surface, metal, matte, veiled, sky, background];
    let colors = run(&device, [6, 1], &mut pixels, &DenoiseParams::default(), false);
    let expected = [
        [1.4, 0.9, 0.4, 1.0],
        [5.0, 2.5, 0.1, 1.0],
        [1.1, 1.1, 1.1, 1.0],
        [3.7, 3.45, 3.2, 1.0],
        [7.0, 8.0, 9.0, 5.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    for (got, want) in colors.iter().zip(&expected) {
        for (g, w) in got.iter().zip(want) {
            // 16-bit base colour: half a step of 1/65535, times the light of 10.
            assert!((g - w).abs() < 1e-4, "{colors:?}, expected {expected:?}");
        }
    }
}

/// The specular reflection of spherical harmonics against the oracle; uniform light of radiance 1 gives 1 at normal incidence, and surfaces below the threshold reflect nothing.
#[test]
fn spherical_harmonics_are_reflected() {
    let device = TestDevice::open();
    let images = ChannelImages::alone(
        &device,
        FrameSizes::same([2, 1]),
        &[SplitLight::UNFILTERED_INDIRECT, Composite::IO_INDIRECT],
    )
    .unwrap();
    let stage = Composite::with_indirect(&device).unwrap();
    let fill = |id: ChannelId, values: &[f32]| images.current(id).write_f32(&values.repeat(2)).unwrap();
    for (id, value) in [(COLOR_HF, 0.0), (COLOR_SPEC, 0.0), (TRANSPARENT, 0.0)] {
        fill(id, &[value; 4]);
    }
    fill(THROUGHPUT, &[1.0, 1.0, 1.0, 0.0]);
    // A metal, which has no diffuse light.
    fill(BASE_COLOR, &[1.0; 4]);
    fill(SHADING_POSITION, &[1.0, 2.0, 3.0, f32::from_bits(1)]);
    let run = |luma: [f32; 4], chroma: [f32; 2], normal: Vec3, ray: Vec3, roughness: f32, least: f32| {
        fill(COLOR_LF_SH, &luma);
        images.current(COLOR_LF_COCG).write_f32(&chroma.repeat(2)).unwrap();
        fill(METALLIC_ROUGHNESS, &[1.0, roughness]);
        images.current(NORMAL).write_u32(&[pack_unit_vector(normal); 2]).unwrap();
        images.current(VIEW_DIRECTION).write_u32(&[pack_unit_vector(ray), 1].repeat(2)).unwrap();
        let params = DenoiseParams { fake_specular: Some(least), ..DenoiseParams::default() };
        let mut recorder = Recorder::new(&device).unwrap();
        let mut frame = recorder.begin().unwrap();
        stage
            .record(&mut frame, &StageInputs::new(&images), SplitLight::unfiltered(&images), &params)
            .unwrap();
        frame.submit().unwrap();
        let out = images.current(COLOR).read_f32().unwrap();
        [out[0], out[1], out[2]].map(f64::from)
    };
    let (up, down) = (Vec3::Z, Vec3::NEG_Z);
    // Uniform radiance 1: the integral over all directions is 4 pi.
    let uniform = [0.0, 0.0, 0.0, 4.0 * std::f32::consts::PI * 0.282_094_8];
    let white = run(uniform, [0.0; 2], up, down, 0.6, 0.0);
    assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-3), "{white:?}");
    assert_eq!(run(uniform, [0.0; 2], up, down, 0.4, 0.5), [0.0; 3], "below the threshold");
    let mut largest = 0.0f64;
    for i in 0..24 {
        let v = |k: u32| ((i * 7 + k * 13) % 11) as f32 / 11.0 - 0.4;
        let normal = Vec3::new(v(0), v(1), 1.0).normalize();
        let ray = Vec3::new(v(2), v(3), -0.8).normalize();
        let direction = Vec3::new(v(4), v(5), 0.5).normalize();
        let sharpness = (i % 5) as f32 / 4.0;
        let y = 2.0 + v(6);
        let luma = (direction * 0.488_602_5 * y * sharpness).extend(0.282_094_8 * y).to_array();
        let chroma = [0.5 * v(7), 0.5 * v(8)];
        let roughness = 0.3 + 0.1 * (i % 7) as f32;
        let got = run(luma, chroma, normal, ray, roughness, 0.2);
        let rgb = {
            let [co, cg] = chroma.map(f64::from);
            let t = f64::from(y) - 0.5 * cg;
            let b = t - 0.5 * co;
            [b + co, cg + t, b]
        };
        let stored = pt_core::pack::unpack_unit_vector;
        let unit = |d: Vec3| -> DVec3 { stored(pack_unit_vector(d)).as_dvec3().normalize() };
        // 16-bit unorm.
        let roughness = (f64::from(roughness) * 65535.0).round() / 65535.0;
        let want = reflected(luma.map(f64::from), rgb, unit(normal), unit(ray), roughness);
        for k in 0..3 {
            assert!(
                (got[k] - want[k]).abs() < 1e-3 * want[k].abs().max(0.1),
                "{i}: {got:?}, oracle {want:?}"
            );
            largest = largest.max(want[k]);
        }
    }
    assert!(largest > 0.5, "something is reflected: {largest}");
}
