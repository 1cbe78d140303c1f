//! GPU time and bandwidth of accumulation, metering and tone mapping. `cargo bench -p pt-post [-- WIDTHxHEIGHT]`.
//!
//! Bytes are those of the pass table: every texel of its images and every byte of its buffers once (twice if updated).

use pt_core::harness::bench;
use pt_core::{ChannelImages, Frame};
use pt_post::{Accumulate, PostParams, Radiance, ToneMap};
use pt_shaders::channels::FLAT_COLOR;
use std::process::ExitCode;

fn main() -> ExitCode {
    bench([1920, 1080], |device, size| {
        let channels = [Accumulate::READS, Accumulate::WRITES, ToneMap::WRITES].concat();
        let images = ChannelImages::new(device, size, channels)?;
        // Luminance over six orders of magnitude, neighbours apart: the histogram's atomics are spread as in a noisy frame.
        let pixels = size[0] as usize * size[1] as usize;
        let texels: Vec<[f32; 4]> = (0..pixels)
            .map(|i| [10f32.powf(((i * 7919) % 6007) as f32 / 1000.0 - 3.0), 0.5, 0.25, 1.0])
            .collect();
        images.current(FLAT_COLOR).write_f32(texels.as_flattened())?;
        let accumulate = Accumulate::new(device, size)?;
        let tone_map = ToneMap::new(device)?;
        Ok(move |frame: &mut Frame<'_>| {
            accumulate.record(frame, &images, frame.index() == 0)?;
            tone_map.record(frame, &images, Radiance::Accumulated, &PostParams::default())
        })
    })
}
