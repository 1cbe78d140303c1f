//! The kernel against its oracle and against what the interleave promises.

use pt_checkerboard::{CheckerboardParams, Interleave, oracle};
use pt_core::split::{split_size, to_split};
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, Recorder};
use pt_core::{FrameSizes, StageInputs};
use pt_shaders::channels::{COLOR, FLAT_COLOR, FLAT_MOTION, MOTION};

type Texels = Vec<[f32; 4]>;

const SIZES: [[u32; 2]; 7] = [[1, 1], [2, 1], [1, 2], [3, 3], [17, 5], [64, 33], [37, 40]];

fn run(
    device: &TestDevice,
    size: [u32; 2],
    color: &[[f32; 4]],
    motion: &[[f32; 4]],
    params: &CheckerboardParams,
) -> (Texels, Vec<[f32; 2]>) {
    let images = ChannelImages::alone(device, FrameSizes::same(size), &[Interleave::IO]).unwrap();
    images.current(COLOR).write(bytemuck::cast_slice(color)).unwrap();
    images.current(MOTION).write(bytemuck::cast_slice(motion)).unwrap();
    let stage = Interleave::new(device).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    stage.record(&mut frame, &StageInputs::new(&images), params).unwrap();
    frame.submit().unwrap();
    let read = |id| images.current(id).read_f32().unwrap();
    (read(FLAT_COLOR).as_chunks().0.to_vec(), read(FLAT_MOTION).as_chunks().0.to_vec())
}

/// Uniform in [0, 1), a function of its arguments alone.
fn random(index: usize, dimension: u32) -> f32 {
    let mut h = (index as u32).wrapping_mul(0x9e37_79b9) ^ dimension.wrapping_mul(0x85eb_ca6b);
    for multiplier in [0x7feb_352d, 0x846c_a68b] {
        h = (h ^ (h >> 16)).wrapping_mul(multiplier);
    }
    (h >> 8) as f32 / (1u32 << 24) as f32
}

/// HDR colours from 1e-4 to 1e4 with the given flags, and arbitrary motion.
fn random_frame(pixels: usize, flags: impl Fn(usize) -> f32) -> (Texels, Texels) {
    let hdr = |i, d| 10f32.powf(8.0 * random(i, d) - 4.0);
    let color = (0..pixels).map(|i| [hdr(i, 0), hdr(i, 1), hdr(i, 2), flags(i)]).collect();
    let motion = (0..pixels).map(|i| std::array::from_fn(|d| random(i, 4 + d as u32) - 0.5)).collect();
    (color, motion)
}

#[test]
fn regular_surfaces_come_back_bit_by_bit() {
    let device = TestDevice::open();
    for size in SIZES {
        let (color, motion) = random_frame((size[0] * size[1]) as usize, |i| [1.0, 2.0, 4.0][i % 3]);
        // What has no flat pixel must not show up anywhere.
        let fill = [f32::NAN; 4];
        let (split_color, split_motion) = (to_split(&color, size, fill), to_split(&motion, size, fill));
        let flat = run(&device, size, &split_color, &split_motion, &CheckerboardParams::default());
        let motion = motion.iter().map(|m| [m[0], m[1]]).collect();
        assert_eq!(flat, (color, motion), "{size:?}");
    }
}

#[test]
fn split_surfaces_agree_with_the_oracle() {
    let device = TestDevice::open();
    for size in SIZES {
        let [width, height] = split_size(size);
        let flags = |i: usize| [1.0, 2.0, 4.0, 6.0, 3.0, 7.0][(random(i, 9) * 6.0) as usize];
        let (color, motion) = random_frame((width * height) as usize, flags);
        for blend_split in [true, false] {
            let (gpu_color, gpu_motion) =
                run(&device, size, &color, &motion, &CheckerboardParams { blend_split });
            let (cpu_color, cpu_motion) = oracle::interleave(&color, &motion, size, blend_split);
            assert_eq!(gpu_motion, cpu_motion, "{size:?}");
            for (gpu, cpu) in gpu_color.iter().zip(&cpu_color) {
                for (g, c) in gpu.iter().zip(cpu) {
                    // Five roundings of positive numbers, in another order.
                    assert!((g - c).abs() <= 1e-6 * c.abs(), "{size:?}: {gpu:?}, oracle {cpu:?}");
                }
            }
        }
    }
}

/// Reflection 8 in one field, refraction 2 in the other: everywhere 5, and the motion of the brighter one.
#[test]
fn halves_of_a_split_surface_are_averaged() {
    let device = TestDevice::open();
    let size = [33, 18];
    let [width, height] = split_size(size);
    let even = |i: usize| i % (width as usize) < width as usize / 2;
    let pixels = (width * height) as usize;
    let color: Texels =
        (0..pixels).map(|i| if even(i) { [8.0, 8.0, 8.0, 6.0] } else { [2.0, 2.0, 2.0, 6.0] }).collect();
    let motion: Texels = (0..pixels).map(|i| if even(i) { [0.25; 4] } else { [-0.5; 4] }).collect();
    let (flat_color, flat_motion) = run(&device, size, &color, &motion, &CheckerboardParams::default());
    assert!(flat_color.iter().all(|c| c[..3].iter().all(|v| (v - 5.0).abs() < 1e-5) && c[3] == 6.0));
    assert!(flat_motion.iter().all(|&m| m == [0.25; 2]));
    let copied = run(&device, size, &color, &motion, &CheckerboardParams { blend_split: false });
    assert_eq!(to_split(&copied.0, size, [2.0, 2.0, 2.0, 6.0])[0], color[0]);
    assert!(copied.0.iter().all(|c| c[0] == 8.0 || c[0] == 2.0));
}
