//! GPU time and bandwidth of the composite. `cargo bench -p pt-denoise [-- WIDTHxHEIGHT]`.
//!
//! Bytes are those of the pass table: every texel of its images once.

use pt_core::{ChannelImages, Device, DeviceOptions, Recorder, Result};
use pt_denoise::{Composite, DenoiseParams};
use pt_shaders::channels::SHADING_POSITION;

const WARM_UP: usize = 4;
const FRAMES: usize = 32;

fn main() -> Result<()> {
    let size = std::env::args().find_map(|a| {
        let (width, height) = a.split_once('x')?;
        Some([width.parse().ok()?, height.parse().ok()?])
    });
    let size = size.unwrap_or([1920, 1080]);
    let device = Device::open(&DeviceOptions::default())?;
    let images = ChannelImages::new(&device, size, [Composite::READS, Composite::WRITES].concat())?;
    let position = images.current(SHADING_POSITION);
    // A surface everywhere: the dearer branch.
    position.write(&vec![1; position.bytes() as usize])?;
    let stage = Composite::new(&device)?;
    let mut recorder = Recorder::new(&device)?;
    for _ in 0..WARM_UP + FRAMES {
        let mut frame = recorder.begin()?;
        stage.record(&mut frame, &images, &DenoiseParams::default())?;
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
