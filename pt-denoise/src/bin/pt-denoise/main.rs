//! Runs denoiser and composite alone on recorded channels: of one frame, or variants of the denoiser side by side on a sequence. Exit codes:
//! 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

mod measure;
mod oidn;
mod sequence;

use anyhow::{Result, ensure};
use clap::Parser;
use pt_core::harness::{ReplayArgs, read_capture, replay};
use pt_core::{Frame, StageInputs, StageIo, console};
use pt_denoise::{Composite, DenoiseChain, DenoiseParams, Denoiser, HistoryFormat, SpecularMotion};
use pt_shaders::NamedEnum;
use pt_shaders::channels::COLOR_LF_SH;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Denoises and composites recorded light channels.
#[derive(Parser)]
#[command(version)]
struct Args {
    #[command(flatten)]
    replay: ReplayArgs,
    /// Variants of the denoiser, each of which runs over all frames of a folder; the others of --set stay the same.
    #[arg(long, value_name = "V,...", value_delimiter = ',', value_parser = Denoiser::from_name)]
    variant: Vec<Denoiser>,
    /// Folder with the ground truth of the frames, reference_000000.exr and so on, as pt capture --reference-spp writes it [default: the
    /// captured folder, if it has them]
    #[arg(long, value_name = "DIR")]
    reference: Option<PathBuf>,
    /// JSON lines to write: for each variant and frame its errors and times.
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
    /// Folder to write each variant and frame into, as VARIANT_000000.exr: the radiance, and the output of every pass as a layer.
    #[arg(long, value_name = "OUT")]
    dump: Option<PathBuf>,
}

impl Args {
    fn runs_sequence(&self) -> bool {
        !self.variant.is_empty() || self.reference.is_some() || self.json.is_some() || self.dump.is_some()
    }
}

fn main() -> ExitCode {
    console::program(|args: &Args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let params: DenoiseParams = args.replay.stage.params()?;
    if args.runs_sequence() {
        ensure!(
            args.replay.capture.is_dir(),
            "{}: --variant, --reference, --json and --dump need a folder of pt capture",
            args.replay.capture.display()
        );
        ensure!(
            args.replay.output.is_none(),
            "--output is of one frame; use --dump for the frames of a sequence"
        );
        return sequence::run(args, params, out);
    }
    let recorded = read_capture(&args.replay.capture)?;
    let indirect = recorded.layer(COLOR_LF_SH.channel().name).is_some();
    drop(recorded);
    // The composite first: its output is what the file shows.
    let stages: Vec<StageIo> =
        [vec![Composite::io_for(indirect)], of_one_frame(params).passes(indirect)].concat();
    replay(&args.replay, &stages, out, |device, _, params: DenoiseParams| {
        let params = of_one_frame(params);
        let denoise = DenoiseChain::new(device, &params, indirect)?;
        let composite = Composite::for_light(device, indirect)?;
        Ok(move |frame: &mut Frame<'_>, inputs: &StageInputs<'_>| {
            let light = denoise.record(frame, inputs, &params)?;
            composite.record(frame, inputs, light, &params)
        })
    })?;
    Ok(())
}

/// A frame that is repeated has the same camera each time: mirror images move as their surfaces do. It has no number by which histories could be rounded.
fn of_one_frame(mut params: DenoiseParams) -> DenoiseParams {
    (params.temporal.specular, params.temporal.parallax) = (SpecularMotion::Surface, None);
    params.histories = HistoryFormat::Full;
    params
}
