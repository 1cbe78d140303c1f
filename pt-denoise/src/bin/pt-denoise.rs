//! Runs the composite alone on recorded channels. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use clap::Parser;
use pt_core::harness::{HarnessError, ReplayArgs, replay};
use pt_core::{Frame, SplitLight, StageInputs, console};
use pt_denoise::{Composite, DenoiseParams};
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
        let stages = [SplitLight::UNFILTERED, Composite::IO];
        replay(&args.replay, &stages, out, |device, _, params: DenoiseParams| {
            let stage = Composite::new(device)?;
            Ok(move |frame: &mut Frame<'_>, inputs: &StageInputs<'_>| {
                stage.record(frame, inputs, SplitLight::unfiltered(inputs.images), &params)
            })
        })?;
        Ok::<_, HarnessError>(true)
    })
}
