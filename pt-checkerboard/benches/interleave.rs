//! GPU time and bandwidth of the interleave. `cargo bench -p pt-checkerboard [-- WIDTHxHEIGHT]`.
//!
//! Bytes are those of the pass table: every texel of its images once. The frame has no split surfaces.

use pt_checkerboard::{CheckerboardParams, Interleave};
use pt_core::harness::bench;
use pt_core::{ChannelImages, Frame};
use pt_core::{FrameSizes, StageInputs};
use std::process::ExitCode;

fn main() -> ExitCode {
    bench([1920, 1080], |device, size| {
        let images = ChannelImages::alone(device, FrameSizes::same(size), &[Interleave::IO])?;
        let stage = Interleave::new(device)?;
        Ok(move |frame: &mut Frame<'_>| {
            stage.record(frame, &StageInputs::new(&images), &CheckerboardParams::default())
        })
    })
}
