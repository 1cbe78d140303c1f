//! `pt render` renders frames of a scene and writes the last one, each one, or their mean.

mod args;

pub use args::RenderArgs;

use crate::aov;
use crate::frame::FullFrame;
use crate::output::Output;
use crate::params::FrameParams;
use crate::progress::Progress;
use crate::session::{Session, fold_seed};
use anyhow::{Context, Result};
use pt_core::Recorder;
use pt_core::capture::keys;
use pt_core::console::print_warning;
use pt_core::frame::FrameTiming;
use pt_core::harness::Spread;
use pt_image::atomic_file::write_atomic;
use pt_image::image_file::{LayeredImage, OutputFormat};
use pt_shaders::channels::ChannelId;
use serde_json::json;
use std::io::Write;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// Unknown names, files that can't be read or written, a device that can't do it.
pub fn run(args: &RenderArgs, out: &mut impl Write) -> Result<bool> {
    let outputs = args.check_outputs()?;
    let params = args.frame.params()?;
    let encoding = params.post.encoding;
    for path in args.output.iter().filter(|path| holds_picture(path, &params)) {
        encoding.check_file(path)?;
    }
    let scene = pt_import::open(&args.frame.scene.file, &args.frame.scene.load_options())?;
    for notice in &scene.notices {
        print_warning(notice);
    }
    let mut session = Session::open(&args.frame.device, &args.frame.camera, scene)?;
    let size = args.frame.output_size();
    let mut full = FullFrame::new(&session.device, &session.gpu, size, args.frame.accumulate, &params)?;
    session.load.mark("kernels and images");
    let aovs = aov::select(args.aov.as_ref(), full.images(), full.radiance().extent())?;

    let images = Images { outputs, args, params: &params, aovs };
    let timings = render(&images, &mut session, &mut full)?;
    session.check_validation()?;
    images.write(args.frames - 1, &session, &full)?;
    if let Some(path) = &args.timings {
        write_timings(path, &timings, args, &session)?;
        writeln!(out, "{}", load_line(&session))?;
    }
    summary(&timings, &session, size, full.images().size(), out)
}

/// All frames; those before the last are written where they were asked for.
fn render(images: &Images<'_>, session: &mut Session, full: &mut FullFrame) -> Result<Vec<FrameTiming>> {
    let Images { args, params, .. } = images;
    let seed = fold_seed(args.frame.seed);
    let time_step = args.frame.time_step();
    let mut recorder = Recorder::new(&session.device)?;
    let mut progress = Progress::new(args.frames);
    let mut previous = args.frame.scene.time;
    for index in 0..args.frames {
        let time = args.frame.time(index);
        let mut frame = recorder.begin()?;
        session.update(&mut frame, time, previous)?;
        full.record(&mut frame, &session.gpu, &session.camera.at(time), seed, time_step, params)?;
        frame.submit()?;
        if index == 0 && args.timings.is_some() {
            session.device.wait_idle()?;
            session.load.mark("first frame");
        }
        if index + 1 < args.frames {
            images.write(index, session, full)?;
        }
        previous = time;
        progress.step();
    }
    let timings = recorder.finish()?;
    progress.finish();
    Ok(timings)
}

/// Whether a file holds display values: always for a PNG, for an EXR with `post.output=display`.
fn holds_picture(path: &Path, params: &FrameParams) -> bool {
    params.post.output == pt_post::Output::Display
        || OutputFormat::of(path).is_ok_and(|f| f == OutputFormat::Png)
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
    fn write(&self, index: u32, session: &Session, full: &FullFrame) -> Result<()> {
        for output in &self.outputs {
            let Some(path) = output.of_frame(index, self.args.frames - 1) else { continue };
            match output.format() {
                OutputFormat::Png => {
                    pt_post::write_picture(&path, full.images(), self.params.post.encoding)?;
                }
                OutputFormat::Exr => self.exr(index, session, full)?.write_exr(&path)?,
            }
        }
        Ok(())
    }

    fn exr(&self, index: u32, session: &Session, full: &FullFrame) -> Result<LayeredImage> {
        let Self { args, params, aovs, .. } = self;
        let mut file = aov::layers(full, params, aovs)?;
        let mut put = |key: &str, value: String| file.metadata.insert(key.into(), value);
        put(keys::SCENE, session.scene.name.clone());
        put(keys::CAMERA, format!("{:?}", session.camera));
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

/// Frames whose times count: the first two compile kernels and fill caches.
fn warm(timings: &[FrameTiming]) -> &[FrameTiming] {
    if timings.len() > 2 { &timings[2..] } else { timings }
}

fn write_timings(path: &Path, timings: &[FrameTiming], args: &RenderArgs, session: &Session) -> Result<()> {
    let counted = warm(timings);
    let passes: Vec<_> = counted.first().map_or(Vec::new(), |frame| {
        (0..frame.passes.len())
            .map(|i| {
                let name = &frame.passes[i].pass;
                let times: Vec<_> = counted
                    .iter()
                    .filter_map(|f| f.passes.get(i).filter(|p| p.pass == *name).map(|p| p.ms))
                    .collect();
                let Spread { median_ms, p95_ms } = Spread::of(times);
                json!({ "pass": name, "median_ms": median_ms, "p95_ms": p95_ms })
            })
            .collect()
    });
    let frame = Spread::of(counted.iter().map(|f| f.gpu_ms).collect());
    let info = session.device.info();
    let document = json!({
        "scene": session.scene.name,
        "size": args.frame.output_size(),
        "device": info.name,
        "driver": info.driver_line(),
        "backend": session.gpu.backend().to_string(),
        "load": {
            "phases": session.load.list(),
            "total_ms": session.load.total_ms(),
            "texture_bytes": session.gpu.texture_bytes(),
            "texture_bytes_uncompressed": session.uncompressed_texture_bytes(),
            "peak_memory_bytes": peak_memory(),
        },
        "warm_up_frames": timings.len() - counted.len(),
        "frame": frame,
        "passes": passes,
        "frames": timings,
    });
    let text = serde_json::to_string_pretty(&document)?;
    write_atomic(path, text.as_bytes()).with_context(|| "cannot write the timings".to_owned())
}

/// Where the time before the first picture went.
fn load_line(session: &Session) -> String {
    let load = &session.load;
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let phases: Vec<_> = load.list().iter().map(|p| format!("{} {:.0} ms", p.name, p.ms)).collect();
    let peak = peak_memory().map_or(String::new(), |bytes| format!("; peak memory {:.0} MiB", mib(bytes)));
    format!(
        "loaded in {:.2} s: {}; textures {:.1} MiB ({:.1} MiB without compression){peak}",
        load.total_ms() * 1e-3,
        phases.join(", "),
        mib(session.gpu.texture_bytes()),
        mib(session.uncompressed_texture_bytes()),
    )
}

/// Peak memory of this process, if the system reports it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? << 10)
}

fn summary(
    timings: &[FrameTiming],
    session: &Session,
    size: [u32; 2],
    frame_size: [u32; 2],
    out: &mut impl Write,
) -> Result<bool> {
    let counted = warm(timings);
    let frame_ms = Spread::of(counted.iter().map(|f| f.gpu_ms).collect()).median_ms;
    let primary =
        counted.iter().flat_map(|f| &f.passes).filter(|p| p.pass == "primary rays").map(|p| p.ms).collect();
    let rays = f64::from(2 * pt_core::channels::field_width(frame_size[0])) * f64::from(frame_size[1]);
    let mrays = rays / Spread::of(primary).median_ms.max(1e-9) * 1e-3;
    writeln!(
        out,
        "{}x{}, {} frames: {frame_ms:.3} ms/frame, {mrays:.1} Mrays/s (primary), {}, {}",
        size[0],
        size[1],
        timings.len(),
        session.device_line(),
        session.gpu.backend(),
    )?;
    Ok(true)
}
