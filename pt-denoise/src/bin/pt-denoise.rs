//! Runs the composite alone on recorded channels. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use clap::Parser;
use pt_core::harness::{HarnessError, ReplayArgs, replay};
use pt_core::{ChannelImages, Frame, console};
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
        replay(
            &args.replay,
            Composite::READS,
            Composite::WRITES,
            out,
            |device, _, params: DenoiseParams| {
                let stage = Composite::new(device)?;
                Ok(move |frame: &mut Frame<'_>, images: &ChannelImages| stage.record(frame, images, &params))
            },
        )?;
        Ok::<_, HarnessError>(true)
    })
}
