//! `pt replay` runs the rest of the frame on recorded frames, without a scene.

use crate::aov::{self, AovSelection};
use crate::args::values::{FrameRange, assignment, named};
use crate::frame::{FrameStage, FullFrame, Moment, Stage};
use crate::inputs::Inputs;
use crate::interrupt::{self, Interrupt};
use crate::output::Output;
use crate::params::{FrameParams, check_background, check_denoiser};
use crate::progress::Progress;
use anyhow::{Context, Result, ensure};
use clap::Args;
use pt_core::capture::folder::{CaptureFolder, RecordedFrame};
use pt_core::capture::keys;
use pt_core::capture::sidecar::from_hex;
use pt_core::console::print_warning;
use pt_core::harness::Spread;
use pt_core::settings::apply_sets;
use pt_core::{Device, DeviceOptions, Recorder};
use pt_image::image_file::{LayeredImage, OutputFormat};
use pt_shaders::channels::ChannelId;
use std::io::Write;
use std::path::PathBuf;

/// `pt replay`
#[derive(Clone, Debug, Args)]
#[command(after_help = interrupt::HELP)]
pub struct ReplayArgs {
    /// Folder that `pt capture` wrote.
    #[arg(value_name = "DIR")]
    pub capture: PathBuf,
    /// First stage to run. The output of the stages before it comes from the capture.
    #[arg(long, value_name = "STAGE", value_parser = named::<Stage>())]
    pub from: Stage,
    /// Set one knob; the others keep the values of the capture; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment)]
    pub set: Vec<String>,
    /// Frames to write: A to B - 1 [default: all]. The recorded frames before A are run too, because histories build up over them.
    #[arg(long, value_name = "A..B")]
    pub frames: Option<FrameRange>,
    /// Image to write: PNG or JPEG (tone-mapped, sRGB) or EXR (linear scene radiance before exposure); may be repeated. With a run of # in the
    /// name every frame is written, and its number replaces the #.
    #[arg(short, long, value_name = "OUT.{png,jpg,exr}")]
    pub output: Vec<PathBuf>,
    /// More images for the EXR: `all` channels, or a list of NAME (channel) and STAGE.NAME (private image of a stage).
    #[arg(long, value_name = "all|A,B")]
    pub aov: Option<AovSelection>,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
    /// Run with the Vulkan validation layers; any message is an error.
    #[arg(long)]
    pub validation: bool,
}

/// Runs the command.
///
/// # Errors
/// A capture that can't be read or does not fit, unknown knobs, a device that can't do it.
pub fn run(args: &ReplayArgs, out: &mut impl Write) -> Result<bool> {
    let outputs = args.output.iter().map(|path| Output::new(path)).collect::<Result<Vec<_>>>()?;
    aov::check_names(args.aov.as_ref())?;
    let capture = CaptureFolder::open(&args.capture)?;
    let recorded_files = std::fs::read_dir(&args.capture).into_iter().flatten().flatten();
    Inputs::default()
        .with("a file of the capture", recorded_files.map(|entry| entry.path()))
        .check(&args.output)?;
    let recorded = capture.range();
    let wanted = args.frames.clone().map_or(recorded.clone(), |range| range.0);
    ensure!(
        recorded.start <= wanted.start && wanted.end <= recorded.end,
        "{}: has the frames {}..{}, not {}..{}",
        args.capture.display(),
        recorded.start,
        recorded.end,
        wanted.start,
        wanted.end
    );
    let first = capture.frame(recorded.start)?;
    let mut params: FrameParams = serde_json::from_value(first.sidecar.params.clone())
        .with_context(|| format!("{}: knobs of the first frame", args.capture.display()))?;
    let recorded_histories = params.denoise.histories;
    apply_sets(&mut params, &args.set)?;
    let place = |name: &str| FrameStage::ALL.iter().position(|stage| stage.name() == name);
    let from = place(args.from.name());
    let stage_of = |set: &str| set.split_once('.').and_then(|(stage, _)| place(stage));
    for set in args.set.iter().filter(|set| stage_of(set).is_some_and(|stage| Some(stage) < from)) {
        print_warning(&format!("{set}: this stage does not run; what it recorded stays as it is"));
    }
    check_background(&params, capture.index.accumulate)?;
    if args.from == Stage::Denoise {
        check_denoiser(&params)?;
    }
    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: args.validation })?;
    let (size, accumulate) = (capture.index.output_size, capture.index.accumulate);
    let mut full = FullFrame::starting_at(&device, args.from, size, accumulate, &params)?;
    let frame_size = full.images().size();
    ensure!(
        frame_size == first.sidecar.size,
        "{}: was recorded with frames of {}x{}, these knobs ask for {}x{}",
        args.capture.display(),
        first.sidecar.size[0],
        first.sidecar.size[1],
        frame_size[0],
        frame_size[1]
    );
    let aovs = aov::select(args.aov.as_ref(), full.images(), full.radiance().extent())?;
    restore(&first, &mut full, recorded_histories == params.denoise.histories)?;

    let interrupt = Interrupt::listen()?;
    let mut recorder = Recorder::new(&device)?;
    let mut progress = Progress::new(wanted.end - recorded.start);
    let mut next = Some(first);
    let mut end = recorded.start;
    for number in recorded.start..wanted.end {
        let recorded_frame = match next.take() {
            Some(frame) => frame,
            None => capture.frame(number)?,
        };
        let sidecar = &recorded_frame.sidecar;
        let moment =
            Moment { record: sidecar.record(), jitter: sidecar.jitter, time_step: sidecar.time_step };
        let mut frame = recorder.begin()?;
        full.replay(&mut frame, moment, &params, |images, given| {
            Ok::<_, anyhow::Error>(recorded_frame.load(images, given)?)
        })?;
        frame.submit()?;
        end = number + 1;
        let is_last = end == wanted.end || interrupt.is_pressed();
        if wanted.contains(&number) {
            for output in &outputs {
                let Some(path) = output.of_frame(number, is_last) else { continue };
                match output.format() {
                    OutputFormat::Png | OutputFormat::Jpeg => {
                        pt_post::write_picture(&path, full.images(), params.post.encoding)?
                    }
                    OutputFormat::Exr => {
                        exr(&full, &params, &aovs, &recorded_frame, &device)?.write_exr(&path)?
                    }
                }
            }
        }
        progress.advance_to(recorder.finished());
        progress.show("");
        if is_last {
            break;
        }
    }
    let timings = recorder.finish()?;
    progress.finish();
    if let Some(messages) = device.validation().map(|log| log.messages()).filter(|m| !m.is_empty()) {
        anyhow::bail!("{} validation messages, the first: {}", messages.len(), messages[0]);
    }
    ensure!(
        end > wanted.start,
        "{}: interrupted after frame {}, before the first frame to write, {}; nothing was written",
        args.capture.display(),
        end - 1,
        wanted.start
    );
    interrupt.report(end - wanted.start, wanted.end - wanted.start, "frames");
    let ms = Spread::of(timings.iter().map(|frame| frame.gpu_ms).collect()).median_ms;
    writeln!(
        out,
        "{}: frames {}..{} from {}, {ms:.3} ms/frame, {} ({})",
        args.capture.display(),
        wanted.start,
        end,
        args.from.name(),
        device.info().name,
        device.info().driver_line(),
    )?;
    Ok(true)
}

/// Restores histories, if they have their format, and buffers before the first frame.
fn restore(first: &RecordedFrame, full: &mut FullFrame, fits: bool) -> Result<()> {
    if !fits {
        print_warning(
            "the histories were recorded with another denoise.histories: the first frame starts over",
        );
    }
    let missing = if fits { first.load_histories(full.images_mut())? } else { Vec::new() };
    if !missing.is_empty() {
        print_warning(&format!(
            "the capture holds no history of {}, which these knobs ask for: the first frame starts over",
            missing.join(", ")
        ));
    }
    for buffer in full.state() {
        let Some(text) = first.sidecar.state.get(buffer.name()) else { continue };
        let bytes = from_hex(text).filter(|bytes| bytes.len() as u64 == buffer.size());
        let bytes = bytes.with_context(|| format!("state {}: not {} bytes", buffer.name(), buffer.size()))?;
        buffer.write_through_staging(&bytes)?;
    }
    Ok(())
}

fn exr(
    full: &FullFrame,
    params: &FrameParams,
    aovs: &[ChannelId],
    recorded: &RecordedFrame,
    device: &Device,
) -> Result<LayeredImage> {
    let mut file = aov::layers(full, params, aovs)?;
    let mut put = |key: &str, value: String| file.metadata.insert(key.into(), value);
    put(keys::FRAMES, (recorded.sidecar.frame + 1).to_string());
    put(keys::PARAMS, serde_json::to_string(params)?);
    put(keys::DEVICE, device.info().name.clone());
    put(keys::DRIVER, device.info().driver_line());
    put(keys::VERSION, env!("CARGO_PKG_VERSION").into());
    Ok(file)
}
