//! GPU time and bandwidth of the composite. `cargo bench -p pt-denoise [-- WIDTHxHEIGHT]`.
//!
//! Bytes are those of the pass table: every texel of its images once.

use pt_core::harness::bench;
use pt_core::{ChannelImages, Frame};
use pt_core::{FrameSizes, SplitLight, StageInputs};
use pt_denoise::{Composite, DenoiseParams};
use pt_shaders::channels::SHADING_POSITION;
use std::process::ExitCode;

fn main() -> ExitCode {
    bench([1920, 1080], |device, size| {
        let images =
            ChannelImages::alone(device, FrameSizes::same(size), &[SplitLight::UNFILTERED, Composite::IO])?;
        let position = images.current(SHADING_POSITION);
        // A surface everywhere: the dearer branch.
        position.write(&vec![1; position.bytes() as usize])?;
        let stage = Composite::new(device)?;
        Ok(move |frame: &mut Frame<'_>| {
            let light = SplitLight::unfiltered(&images);
            stage.record(frame, &StageInputs::new(&images), light, &DenoiseParams::default())
        })
    })
}
