//! Runs the composite alone on recorded channels. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use clap::Parser;
use pt_core::harness::{HarnessError, ReplayArgs, read_capture, replay};
use pt_core::{Frame, SplitLight, StageInputs, console};
use pt_denoise::{Composite, DenoiseParams};
use pt_shaders::channels::COLOR_LF_SH;
use std::process::ExitCode;

/// Composites recorded light channels.
#[derive(Parser)]
#[command(version)]
struct Args {
    #[command(flatten)]
    replay: ReplayArgs,
}

fn main() -> ExitCode {
    console::program(|args: &Args, out| {
        let recorded = read_capture(&args.replay.capture)?;
        let is_indirect = recorded.layer(COLOR_LF_SH.channel().name).is_some();
        let stages = match is_indirect {
            true => [SplitLight::UNFILTERED_INDIRECT, Composite::IO_INDIRECT],
            false => [SplitLight::UNFILTERED, Composite::IO],
        };
        drop(recorded);
        replay(&args.replay, &stages, out, |device, _, params: DenoiseParams| {
            let stage = if is_indirect { Composite::with_indirect(device)? } else { Composite::new(device)? };
            Ok(move |frame: &mut Frame<'_>, inputs: &StageInputs<'_>| {
                stage.record(frame, inputs, SplitLight::unfiltered(inputs.images), &params)
            })
        })?;
        Ok::<_, HarnessError>(true)
    })
}
