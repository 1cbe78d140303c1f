//! GPU time and bandwidth of accumulation, metering and tone mapping. `cargo bench -p pt-post [-- WIDTHxHEIGHT]`.
//!
//! Bytes are those of the pass table: every texel of its images and every byte of its buffers once (twice if updated).

use pt_core::{ChannelImages, Device, DeviceOptions, Recorder, Result};
use pt_post::{Accumulate, PostParams, Radiance, ToneMap};
use pt_shaders::channels::FLAT_COLOR;

const WARM_UP: usize = 4;
const FRAMES: usize = 32;

fn main() -> Result<()> {
    let size = std::env::args().find_map(|a| {
        let (width, height) = a.split_once('x')?;
        Some([width.parse().ok()?, height.parse().ok()?])
    });
    let size: [u32; 2] = size.unwrap_or([1920, 1080]);
    let device = Device::open(&DeviceOptions::default())?;
    let channels = [Accumulate::READS, Accumulate::WRITES, ToneMap::WRITES].concat();
    let images = ChannelImages::new(&device, size, channels)?;
    // Luminance over six orders of magnitude, neighbours apart: the histogram's atomics are spread as in a noisy frame.
    let pixels = size[0] as usize * size[1] as usize;
    let texels: Vec<[f32; 4]> = (0..pixels)
        .map(|i| [10f32.powf(((i * 7919) % 6007) as f32 / 1000.0 - 3.0), 0.5, 0.25, 1.0])
        .collect();
    images.current(FLAT_COLOR).write(bytemuck::cast_slice(&texels))?;
    let accumulate = Accumulate::new(&device, size)?;
    let tone_map = ToneMap::new(&device)?;
    let mut recorder = Recorder::new(&device)?;
    for index in 0..WARM_UP + FRAMES {
        let mut frame = recorder.begin()?;
        accumulate.record(&mut frame, &images, index == 0)?;
        tone_map.record(&mut frame, &images, Radiance::Accumulated, &PostParams::default())?;
        frame.submit()?;
    }
    let timings = recorder.finish()?;
    println!("{}, {}x{}, {FRAMES} frames", device.info().name, size[0], size[1]);
    for (index, pass) in recorder.pass_table().iter().enumerate() {
        let mut ms: Vec<f64> = timings[WARM_UP..].iter().map(|t| t.passes[index].ms).collect();
        ms.sort_by(f64::total_cmp);
        let (median, p95) = (ms[ms.len() / 2], ms[ms.len() * 95 / 100]);
        let rate = pass.bytes as f64 / median * 1e-6;
        println!("{:<20} median {median:.4} ms, p95 {p95:.4} ms, {rate:.1} GB/s", pass.name);
    }
    Ok(())
}
