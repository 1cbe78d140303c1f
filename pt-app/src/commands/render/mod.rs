//! `pt render` renders frames of a scene and writes the last one, each one, or their mean.

mod args;
mod report;

pub use args::RenderArgs;

use crate::aov;
use crate::frame::{FrameTime, FullFrame, Oracles};
use crate::ground_truth::{TruthOf, path_trace, radiance};
use crate::interrupt::Interrupt;
use crate::origin::Origin;
use crate::output::Output;
use crate::params::{FrameParams, check_one_plane};
use crate::progress::Progress;
use crate::session::{Session, check_host_memory, fold_seed, open_scene};
use anyhow::Result;
use pt_core::capture::keys;
use pt_core::console::print_warning;
use pt_core::frame::FrameTiming;
use pt_core::harness::raise_clock;
use pt_core::{Kept, Recorder};
use pt_gbuffer::hidden_lobes;
use pt_image::image_file::{LayeredImage, OutputFormat};
use pt_post::Upscale;
use pt_reference::ReferenceParams;
use pt_shaders::channels::ChannelId;
use std::io::Write;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// Unknown names, files that can't be read or written, a device that can't do it.
pub fn run(args: &RenderArgs, out: &mut impl Write) -> Result<bool> {
    let outputs = args.check_outputs()?;
    args.inputs().check(args.output.iter().chain(&args.timings))?;
    let params = args.frame.params()?;
    args.check_alpha(&params)?;
    aov::check_names(args.aov.as_ref())?;
    let encoding = params.post.encoding;
    for path in args.output.iter().filter(|path| holds_picture(path, &params)) {
        encoding.check_file(path)?;
    }
    let scene = open_scene(&args.frame.scene.file, &args.frame.scene.load_options())?;
    for notice in scene.notices.iter().chain(&hidden_lobes(&scene, &params.gbuffer)) {
        print_warning(notice);
    }
    if args.aov.is_some() {
        check_one_plane(&params, &scene, "--aov")?;
    }
    let mut session = Session::open(&args.frame.device, &args.frame.camera, scene)?;
    let size = args.frame.output_size();
    let reads_all = args.aov.is_some() || !args.oracle.is_empty();
    let kept = if reads_all { Kept::All } else { Kept::Outputs };
    let mut full = FullFrame::keeping(kept, &mut session, size, args.frame.accumulate, &params)?;
    session.load.mark("kernels and images");
    if !args.oracle.is_empty() {
        let oracles = Oracles::new(&session.device, &full, &args.oracle, args.oracle_spp)?;
        full.feed(Some(oracles));
    }
    let aovs = aov::select(args.aov.as_ref(), full.images(), full.radiance().extent())?;

    // Texels, the planes of the file, and its compressed bytes.
    let per_pixel = 64 + 48 * aovs.len() as u64;
    check_host_memory("an image", size, per_pixel)?;
    let images = Images { outputs, args, params: &params, aovs };
    images.say_other_size(&full, size);
    let interrupt = Interrupt::listen()?;
    let Rendered { frames, timings } = render(&images, &mut session, &mut full, &interrupt)?;
    session.check_validation()?;
    images.write(frames - 1, true, &session, &full)?;
    interrupt.report(frames, args.frames, "frames");
    if let Some(path) = &args.timings {
        report::write_timings(path, frames, &timings, args, &session)?;
        writeln!(out, "{}", report::load_line(&session))?;
    }
    writeln!(
        out,
        "light: {} (pt reference traces all bounces)",
        images.origin(frames - 1, &session).light()
    )?;
    report::summary(frames, &timings, &session, size, full.images().size(), out)
}

/// What was rendered: all frames, or those before the command was interrupted.
struct Rendered {
    frames: u32,
    timings: Vec<FrameTiming>,
}

/// The frames one after the other. Those before the last are written where they were asked for.
fn render(
    images: &Images<'_>,
    session: &mut Session,
    full: &mut FullFrame,
    interrupt: &Interrupt,
) -> Result<Rendered> {
    let Images { args, params, .. } = images;
    let seed = fold_seed(args.frame.seed);
    let time_step = args.frame.time_step();
    let mut recorder = Recorder::new(&session.device)?;
    let mut progress = Progress::new(args.frames);
    let mut previous = args.frame.scene.time;
    let mut index = 0;
    loop {
        let time = args.frame.time(index);
        if let Some(oracles) = full.oracles().filter(|oracles| oracles.needs_truth()) {
            let record = FullFrame::view(&session.camera.at(time), args.frame.output_size(), params);
            let view = TruthOf { scene: &session.scene, camera: &args.frame.camera, time, record };
            let (spp, medium) = (args.oracle_spp, params.medium());
            let knobs = ReferenceParams { spp, medium, ..ReferenceParams::default() };
            let truth = path_trace(&session.device, session.gpu.backend(), &view, &knobs)?;
            oracles.set_truth(&radiance(&truth.file.estimate), time_step)?;
        }
        full.render(&mut recorder, session, FrameTime { time, previous, seed, time_step }, params)?;
        if index == 0 && args.timings.is_some() {
            session.device.wait_idle()?;
            session.load.mark("first frame");
            raise_clock(&session.device)?;
        }
        previous = time;
        // Frames that are fed take several submissions.
        progress.advance_to(if args.oracle.is_empty() { recorder.finished() } else { index });
        progress.show("");
        index += 1;
        if index == args.frames || interrupt.is_pressed() {
            break;
        }
        images.write(index - 1, false, session, full)?;
    }
    let timings = recorder.finish()?;
    progress.finish();
    Ok(Rendered { frames: index, timings })
}

/// Whether a file holds display values: always for a PNG and a JPEG, for an EXR with `post.output=display`.
fn holds_picture(path: &Path, params: &FrameParams) -> bool {
    params.post.output == pt_post::Output::Display
        || OutputFormat::of(path).is_ok_and(|format| format != OutputFormat::Exr)
}

/// What is written of the frames.
struct Images<'a> {
    outputs: Vec<Output>,
    args: &'a RenderArgs,
    params: &'a FrameParams,
    aovs: Vec<ChannelId>,
}

impl Images<'_> {
    /// Writes the files of frame `index`, which is the one that was rendered last; waits for it if there are any.
    fn write(&self, index: u32, is_last: bool, session: &Session, full: &FullFrame) -> Result<()> {
        for output in &self.outputs {
            let Some(path) = output.of_frame(index, is_last) else { continue };
            match output.format() {
                OutputFormat::Png | OutputFormat::Jpeg => {
                    pt_post::write_picture(&path, full.images(), self.params.post.encoding)?;
                }
                OutputFormat::Exr => self.exr(index, session, full)?.write_exr(&path)?,
            }
        }
        Ok(())
    }

    /// Says why an EXR has not the size that was asked for: FSR 1 upscales the picture, not its linear radiance.
    fn say_other_size(&self, full: &FullFrame, size: [u32; 2]) {
        let [width, height] = full.radiance().extent();
        let is_linear = |output: &&Output| {
            output.format() == OutputFormat::Exr && self.params.post.output == pt_post::Output::Linear
        };
        if [width, height] != size && self.outputs.iter().any(|output| is_linear(&output)) {
            print_warning(&format!(
                "the EXR has {width}x{height} pixels, not {}x{}: {} upscales the tone-mapped picture, and the EXR holds linear radiance; \
                 --set post.output=display writes the upscaled picture, --upscale {} upscales radiance",
                size[0],
                size[1],
                self.params.post.upscale.name(),
                Upscale::Taau.name()
            ));
        }
    }

    fn origin(&self, index: u32, session: &Session) -> Origin {
        let camera = session.camera.at(self.args.frame.time(index));
        Origin::of_frame(&session.scene, &camera, self.params)
    }

    fn exr(&self, index: u32, session: &Session, full: &FullFrame) -> Result<LayeredImage> {
        let Self { args, params, aovs, .. } = self;
        let mut file = aov::layers(full, params, aovs)?;
        self.origin(index, session).describe(&mut file.metadata);
        let mut put = |key: &str, value: String| file.metadata.insert(key.into(), value);
        put(keys::SCENE, session.scene.name.clone());
        put(keys::TIME, args.frame.scene.time.to_string());
        put(keys::FRAMES, (index + 1).to_string());
        put(keys::ACCUMULATE, args.frame.accumulate.to_string());
        put(keys::SEED, args.frame.seed.to_string());
        put(keys::PARAMS, serde_json::to_string(params)?);
        let exposure = full.exposure()?;
        put(keys::EV100, exposure.ev100.to_string());
        put(keys::EXPOSURE, exposure.scale.to_string());
        let [x, y] = full.moment().map_or([0.0; 2], |moment| moment.jitter);
        put(keys::JITTER, format!("{x},{y}"));
        put(keys::DEVICE, session.device.info().name.clone());
        put(keys::DRIVER, session.device.info().driver_line());
        // As asked for: the pixels do not depend on what `auto` measured, so the file must not either.
        put(keys::BACKEND, args.frame.device.backend.to_string());
        put(keys::VERSION, env!("CARGO_PKG_VERSION").into());
        Ok(file)
    }
}
