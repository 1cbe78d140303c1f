//! GPU time and bandwidth of the denoiser `asvgf` for direct and indirect light, with a full history. `cargo bench -p pt-denoise --bench denoise [-- WIDTHxHEIGHT]`.

use pt_core::harness::bench;
use pt_core::{ChannelImages, Frame, FrameSizes, StageInputs};
use pt_denoise::{DenoiseChain, DenoiseParams, Denoiser};
use pt_shaders::channels::{
    COLOR_HF, COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC, GRADIENT_SAMPLE, MOTION, NORMAL, SHADING_POSITION,
    VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};
use std::process::ExitCode;

fn main() -> ExitCode {
    bench([1920, 1080], |device, size| {
        let params = DenoiseParams { variant: Denoiser::Asvgf, ..DenoiseParams::default() };
        let chain = DenoiseChain::new(device, &params, true)?;
        let mut images = ChannelImages::alone(device, FrameSizes::same(size), chain.io())?;
        // A wall under noise; both copies of what the last frame is read of.
        for _ in 0..2 {
            images.begin_frame();
            let texels = images.current(VIEW_DEPTH).extent().iter().product::<u32>();
            let fill = |words: &[u32]| (0..texels).flat_map(|_| words.iter().copied()).collect::<Vec<u32>>();
            let bytes = |words: &[u32]| fill(words).iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
            let one = 1f32.to_bits();
            images.current(SHADING_POSITION).write(&bytes(&[one, one, one, 1]))?;
            images.current(VIEW_DEPTH).write(&bytes(&[3f32.to_bits()]))?;
            images.current(MOTION).write(&bytes(&[0, 0, 0, 100f32.to_bits()]))?;
            images.current(NORMAL).write_u32(&fill(&[0x8000_8000]))?;
            images.current(VERTEX_NORMAL).write_u32(&fill(&[0x8000_8000]))?;
            images.current(VIEW_DIRECTION).write_u32(&fill(&[0x8000_8000, 1]))?;
            for id in [COLOR_HF, COLOR_SPEC, COLOR_LF_SH, COLOR_LF_COCG] {
                let noise: Vec<f32> = (0..id.channel().format.components() * texels)
                    .map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32 * 1e-7)
                    .collect();
                images.current(id).write_f32(&noise)?;
            }
            // The middle of each stratum is its gradient pixel.
            let strata = images.current(GRADIENT_SAMPLE).extent().iter().product::<u32>();
            let samples: Vec<f32> = (0..strata).flat_map(|_| [5.0, 0.5, 0.5, 0.0]).collect();
            images.current(GRADIENT_SAMPLE).write_f32(&samples)?;
        }
        Ok(move |frame: &mut Frame<'_>| {
            images.begin_frame();
            chain.record(frame, &StageInputs::new(&images), &params).map(|_| ())
        })
    })
}
