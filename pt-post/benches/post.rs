//! GPU time and bandwidth of the whole chain, once at the native resolution and once upscaled by 1.5. `cargo bench -p pt-post [--
//! WIDTHxHEIGHT]`; the size is that of the frame.
//!
//! Bytes are those of the pass table: every texel of its images and every byte of its buffers once (twice if updated).

use pt_core::harness::bench;
use pt_core::{ChannelImages, Frame};
use pt_post::{
    Accumulate, Bloom, BloomMode, BloomParams, Encoding, Exposure, Fsr, PostParams, Taa, ToneMap, Upscale,
};
use pt_shaders::channels::{DISPLAY, FLAT_COLOR, FLAT_MOTION};
use std::process::ExitCode;

fn main() -> ExitCode {
    bench([1920, 1080], |device, size| {
        let output_size = size.map(|side| side * 3 / 2);
        let channels = [Accumulate::READS, Accumulate::WRITES, &[FLAT_MOTION, DISPLAY]].concat();
        let images = ChannelImages::with_output(device, size, output_size, channels)?;
        // Luminance over six orders of magnitude, neighbours apart: the histogram's atomics are spread as in a noisy frame.
        let pixels = size[0] as usize * size[1] as usize;
        let texels: Vec<[f32; 4]> = (0..pixels)
            .map(|i| [10f32.powf(((i * 7919) % 6007) as f32 / 1000.0 - 3.0), 0.5, 0.25, 1.0])
            .collect();
        images.current(FLAT_COLOR).write_f32(texels.as_flattened())?;
        let accumulate = Accumulate::new(device, size)?;
        let mut taa = Taa::new(device, size)?;
        let bloom = Bloom::new(device, size)?;
        let mut exposure = Exposure::new(device)?;
        let tone_map = ToneMap::new(device)?;
        let fsr = Fsr::new(device, size, output_size)?;
        let params = PostParams {
            upscale: Upscale::Fsr1,
            bloom: BloomParams { mode: BloomMode::Gaussian, ..BloomParams::default() },
            ..PostParams::default()
        };
        Ok(move |frame: &mut Frame<'_>| {
            accumulate.record(frame, &images, frame.index() == 0)?;
            let (color, motion) = (images.current(FLAT_COLOR), images.current(FLAT_MOTION));
            taa.record(frame, color, motion, [0.0; 2], &params.taa)?;
            let bloomed = bloom.record(frame, taa.resolved(), &params.bloom)?;
            exposure.record(frame, taa.resolved(), None, &params)?;
            tone_map.record(frame, bloomed, &exposure, fsr.codes(), Encoding::Srgb, &params)?;
            fsr.record(frame, images.current(DISPLAY), &params)
        })
    })
}
