//! `pt reference` path traces the ground truth, as a whole or in slices.

mod args;
pub mod files;

pub use args::{ReferenceArgs, SampleRange};

use crate::inputs::Inputs;
use crate::interrupt::Interrupt;
use crate::origin::Origin;
use crate::progress::Progress;
use crate::session::{Session, check_host_memory, fold_seed, open_scene};
use anyhow::{Result, bail, ensure};
use files::{check_exr, write};
use pt_core::capture::keys;
use pt_core::console::print_warning;
use pt_image::atomic_file::check_writable;
use pt_image::image_file::ImageSize;
use pt_reference::{Checkpoint, Estimate, EstimateFile, Identity, Progressive, ReferenceParams, SamplerKind};
use pt_scene::gpu::camera_record;
use pt_scene::{Camera, Projection};
use pt_shaders::records::FrameRecord;
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Memory of the host that a pixel takes: the sums, the estimate, the planes of the file, and its compressed bytes.
pub(crate) const BYTES_PER_PIXEL: u64 = 440;

/// Runs the command.
///
/// # Errors
/// Unknown names, files that can't be read or written, a checkpoint of another render, a device that can't do it.
pub fn run(args: &ReferenceArgs, out: &mut impl Write) -> Result<bool> {
    check_exr(&args.output)?;
    Inputs::of_scene(&args.scene, &args.camera, args.profile.as_deref())
        .check([&args.output].into_iter().chain(&args.checkpoint))?;
    if let Some(path) = &args.checkpoint {
        check_writable(path)?;
    }
    let params = args.params()?;
    let mut scene = open_scene(&args.scene.file, &args.scene.load_options())?;
    scene.set_time(args.scene.time, args.scene.time - 1.0 / args.scene.fps);
    for notice in &scene.notices {
        print_warning(notice);
    }
    let samples = args.sample_range(&params);
    let size = [args.size.width, args.size.height];
    check_host_memory("a reference image", size, BYTES_PER_PIXEL)?;
    let mut session = Session::open(&args.device, &args.camera, scene)?;
    let identity = Identity::default()
        .with("version", env!("CARGO_PKG_VERSION"))
        .with("scene", session.scene.fingerprint())
        .with("camera", camera_of_identity(&session.camera.at(args.scene.time)))
        .with("time", args.scene.time)
        .with("size", format!("{}x{}", size[0], size[1]))
        .with("seed", args.seed)
        .with("params", params_of_identity(&params)?);
    let record = |time: f64| camera_record(&session.camera.at(time), size);
    let frame = FrameRecord::new(
        record(args.scene.time),
        record(args.scene.time - 1.0 / args.scene.fps),
        size,
        0,
        fold_seed(args.seed),
    );
    let tile = args.tile.map(|ImageSize { width, height }| [width, height]);
    let Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights)?;
    let mut render = Progressive::new(
        &session.device,
        &session.gpu,
        &session.lights,
        frame,
        params.clone(),
        tile,
        samples.start,
    )?;
    let resumed = resume(args, &mut render, &identity, &samples)?;

    let started = Instant::now();
    let interrupt = Interrupt::listen()?;
    let (state, done) = advance(args, &mut render, &mut session, &identity, &samples, &interrupt)?;
    let seconds = started.elapsed().as_secs_f64();
    session.check_validation()?;

    let estimate = state.estimate(done.end - done.start);
    let camera = session.camera.at(args.scene.time);
    let origin = Origin::of_reference(&session.scene, &camera, &params);
    let mut metadata = BTreeMap::from([
        (keys::SCENE.to_owned(), session.scene.name.clone()),
        (keys::DEVICE.to_owned(), session.device.info().name.clone()),
        (keys::DRIVER.to_owned(), session.device.info().driver_line()),
        (keys::VERSION.to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
    ]);
    origin.describe(&mut metadata);
    if estimate.dropped > 0 {
        print_warning(&format!("{} non-finite samples dropped", estimate.dropped));
    }
    if params.clamp > 0.0 {
        print_warning("--clamp: samples were cut off, the image is biased");
    }
    let [rays, shadow_rays] = state.rays();
    let (paths, rays) =
        (estimate.pixels.len() as f64 * f64::from(done.end - resumed), (rays + shadow_rays) as f64);
    let share = f64::from(done.end - resumed) / f64::from(done.end - done.start).max(1.0);
    let file = EstimateFile { estimate, ranges: vec![done], background: params.background, identity };
    write(&args.output, &file, metadata, args.no_aov)?;
    interrupt.report(file.estimate.samples as u32, samples.end - samples.start, "samples a pixel");
    writeln!(out, "light: {}", origin.light())?;
    writeln!(
        out,
        "{}: {}x{}, {} samples a pixel, {}, {} non-finite samples dropped, {seconds:.1} s, {:.2} Mpaths/s, {:.2} Mrays/s, {}, {}",
        args.output.display(),
        size[0],
        size[1],
        file.estimate.samples,
        relative_error(&file.estimate),
        file.estimate.dropped,
        paths / seconds * 1e-6,
        rays * share / seconds * 1e-6,
        session.device_line(),
        session.gpu.backend(),
    )?;
    Ok(true)
}

/// The relative error in words: one sample says nothing about it.
pub(crate) fn relative_error(estimate: &Estimate) -> String {
    match estimate.samples {
        0 | 1 => "relative error unknown after one sample".into(),
        _ => format!("relative error {:.4}", estimate.relative_error()),
    }
}

/// The knobs that samples depend on. The number of samples does not count where a sampler has no use for it: renders of different
/// lengths are slices of one.
fn params_of_identity(params: &ReferenceParams) -> Result<String> {
    let spp = if params.sampler == SamplerKind::BlueNoise { params.spp } else { 1 };
    Ok(serde_json::to_string(&ReferenceParams { spp, ..params.clone() })?)
}

/// Where the camera is and what it shows, member by member, so that a message names the one that differs.
fn camera_of_identity(camera: &Camera) -> String {
    let axes = camera.world_from_camera;
    let projection = match camera.projection {
        Projection::Perspective { yfov } => json!({ "yfov": yfov }),
        Projection::Orthographic { ymag } => json!({ "ymag": ymag }),
    };
    json!({
        "name": camera.name,
        "position": axes.translation.to_array(),
        "direction": (-axes.matrix3.z_axis).to_array(),
        "up": axes.matrix3.y_axis.to_array(),
        "projection": projection,
        "lens_radius": camera.lens_radius,
        "focus_distance": camera.focus_distance,
    })
    .to_string()
}

/// Loads the checkpoint, if there is one to resume, and sees to it that none of another render is overwritten; returns the index of the first sample that is not traced yet.
fn resume(
    args: &ReferenceArgs,
    render: &mut Progressive,
    identity: &Identity,
    samples: &Range<u32>,
) -> Result<u32> {
    let Some(path) = args.checkpoint.as_deref().filter(|path| path.exists()) else {
        return Ok(samples.start);
    };
    let checkpoint = Checkpoint::read(path)?;
    if let Some(difference) = checkpoint.identity.difference(identity) {
        bail!(
            "{}: is the checkpoint of another render: {difference}; give another --checkpoint",
            path.display()
        );
    }
    if !args.resume {
        return Ok(samples.start);
    }
    let there = &checkpoint.samples;
    ensure!(
        there.start == samples.start && there.end <= samples.end,
        "{}: has the samples {}..{}, which are not the beginning of {}..{}",
        path.display(),
        there.start,
        there.end,
        samples.start,
        samples.end
    );
    render.resume(&checkpoint.state, there.end)?;
    Ok(there.end)
}

/// Renders until the samples or the time are used up, or the command is interrupted; the sums and the samples in them.
fn advance(
    args: &ReferenceArgs,
    render: &mut Progressive,
    session: &mut Session,
    identity: &Identity,
    samples: &Range<u32>,
    interrupt: &Interrupt,
) -> Result<(pt_reference::FilmState, Range<u32>)> {
    let started = Instant::now();
    let limit = args.time_limit.map(Duration::from_secs_f64);
    let interval = Duration::try_from_secs_f64(args.checkpoint_interval).unwrap_or(Duration::ZERO);
    let count = |next: u32| next - samples.start;
    let mut progress = Progress::resuming(count(render.next_sample()), count(samples.end), "sample");
    let mut saved = Instant::now();
    while render.next_sample() < samples.end && limit.is_none_or(|limit| started.elapsed() < limit) {
        // At least one sample, so that there is something to write.
        if interrupt.is_pressed() && render.next_sample() > samples.start {
            break;
        }
        render.step(&session.scene, &mut session.gpu, &mut session.lights, samples.end)?;
        progress.advance_to(count(render.next_sample()));
        let save = args.checkpoint.is_some() && saved.elapsed() >= interval;
        if save || progress.is_due() {
            let state = render.state()?;
            let done = samples.start..render.next_sample();
            progress.show(&format!(", {}", relative_error(&state.estimate(done.end - done.start))));
            if let Some(path) = args.checkpoint.as_deref().filter(|_| save) {
                Checkpoint { state, samples: done, identity: identity.clone() }.write(path)?;
                saved = Instant::now();
            }
        }
    }
    progress.finish();
    let (state, done) = (render.state()?, samples.start..render.next_sample());
    ensure!(!done.is_empty(), "no sample was done within the time limit");
    if let Some(path) = &args.checkpoint {
        let checkpoint = Checkpoint { state, samples: done.clone(), identity: identity.clone() };
        checkpoint.write(path)?;
        return Ok((checkpoint.state, done));
    }
    Ok((state, done))
}
