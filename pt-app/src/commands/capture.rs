//! `pt capture` records frames of a scene, so that stages can be run on them.

use crate::args::FrameArgs;
use crate::args::values::FrameRange;
use crate::frame::{FullFrame, Moment};
use crate::frame_capture::FrameCapture;
use crate::interrupt::{self, Interrupt};
use crate::output::check_folder;
use crate::params::check_one_plane;
use crate::progress::Progress;
use crate::session::{Session, fold_seed, open_scene};
use anyhow::{Context, Result, ensure};
use clap::Args;
use pt_core::Recorder;
use pt_core::console::print_warning;
use pt_gbuffer::hidden_lobes;
use pt_image::image_file::encode_exr_parts;
use pt_reference::records::PathLights;
use pt_reference::{EstimateFile, Identity, Progressive, ReferenceParams};
use std::io::Write;
use std::path::PathBuf;

/// `pt capture`
#[derive(Clone, Debug, Args)]
#[command(after_help = interrupt::HELP)]
pub struct CaptureArgs {
    /// Folder for the frames; created if missing; must not contain a capture yet.
    #[arg(short, long, value_name = "DIR", help_heading = "Output")]
    pub output: PathBuf,
    /// Frames to record: A to B - 1. The frames before A are rendered too, because histories build up over them.
    #[arg(long, value_name = "A..B", default_value = "0..1", help_heading = "Output")]
    pub frames: FrameRange,
    /// Also path trace the ground truth of every recorded frame, with this many samples per pixel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Output")]
    pub reference_spp: Option<u32>,
    /// Paths of the ground truth scatter at most this many times after the first hit; frames have one bounce by default [default: no limit]
    #[arg(long, value_name = "B", requires = "reference_spp", help_heading = "Output")]
    pub reference_bounces: Option<u32>,
    /// Scene, camera, size, knobs and device.
    #[command(flatten)]
    pub frame: FrameArgs,
}

/// Runs the command.
///
/// # Errors
/// Unknown names, files that can't be read or written, a device that can't do it. Frames that were recorded stay.
pub fn run(args: &CaptureArgs, out: &mut impl Write) -> Result<bool> {
    check_folder(&args.output)?;
    let params = args.frame.params()?;
    let range = &args.frames.0;
    let scene = open_scene(&args.frame.scene.file, &args.frame.scene.load_options())?;
    for notice in scene.notices.iter().chain(&hidden_lobes(&scene, &params.gbuffer)) {
        print_warning(notice);
    }
    check_one_plane(&params, &scene, "pt capture")?;
    let (size, accumulate) = (args.frame.output_size(), args.frame.accumulate);
    let mut capture = FrameCapture::create(&args.output, &scene.name, size, accumulate)?;
    let mut session = Session::open(&args.frame.device, &args.frame.camera, scene)?;
    let mut full = FullFrame::new(&mut session, size, accumulate, &params)?;

    let interrupt = Interrupt::listen()?;
    let seed = fold_seed(args.frame.seed);
    let mut recorder = Recorder::new(&session.device)?;
    let mut progress = Progress::new(range.end);
    let mut previous = args.frame.time(0);
    let mut end = 0;
    for number in 0..range.end {
        if number == range.start {
            capture.begin(&full)?;
        }
        let has_history = full.images().has_frame();
        let time = args.frame.time(number);
        let mut frame = recorder.begin()?;
        session.update(&mut frame, time, previous)?;
        let camera = session.camera.at(time);
        full.record(&mut frame, &session.gpu, &camera, seed, args.frame.time_step(), &params)?;
        frame.submit()?;
        if number >= range.start {
            let moment = *full.moment().context("a frame was recorded")?;
            let reference = match args.reference_spp {
                Some(spp) => {
                    let max_bounces = args.reference_bounces;
                    let background = params.denoise.background;
                    let medium = params.medium();
                    // The tables of lights are those of the frame and stay so.
                    let truth = ReferenceParams {
                        spp,
                        max_bounces,
                        background,
                        medium,
                        lights: PathLights::PerKind,
                        ..ReferenceParams::default()
                    };
                    Some(reference(&mut session, moment, truth)?)
                }
                None => None,
            };
            capture.add(&session, &full, &params, has_history, time, reference.as_deref())?;
        }
        previous = time;
        progress.advance_to(recorder.finished());
        progress.show("");
        end = number + 1;
        if interrupt.is_pressed() {
            break;
        }
    }
    recorder.finish()?;
    progress.finish();
    session.check_validation()?;
    ensure!(
        end > range.start,
        "{}: interrupted after frame {}, before the first frame to record, {}; nothing was recorded",
        args.output.display(),
        end - 1,
        range.start
    );
    interrupt.report(end - range.start, range.end - range.start, "frames");
    let [width, height] = size;
    writeln!(
        out,
        "{}: frames {}..{} of {}, {width}x{height}, {}, {}",
        args.output.display(),
        range.start,
        end,
        session.scene.name,
        session.device_line(),
        session.gpu.backend(),
    )?;
    Ok(true)
}

/// Path traces the scene at its current time; returns the bytes of an EXR.
fn reference(session: &mut Session, moment: Moment, params: ReferenceParams) -> Result<Vec<u8>> {
    let Session { device, scene, gpu, lights, .. } = session;
    let ReferenceParams { spp, background, .. } = params;
    let identity = Identity::default().with("scene", &scene.name).with("frame", moment.record.frame_index);
    let mut render = Progressive::new(device, gpu, lights, moment.record, params, None, 0)?;
    while render.next_sample() < spp {
        render.step(scene, gpu, lights, spp)?;
    }
    let estimate = render.state()?.estimate(spp);
    let ranges = std::iter::once(0..spp).collect();
    let image = EstimateFile { estimate, ranges, background, identity }.to_image()?;
    encode_exr_parts(&[(String::new(), image)]).map_err(anyhow::Error::msg)
}
