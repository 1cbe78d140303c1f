//! Runs the primary rays, reflection and refraction alone: a scene to its G-buffer. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

mod sheet;

use anyhow::{Result, ensure};
use clap::Parser;
use pt_core::capture::keys;
use pt_core::frame::Uniforms;
use pt_core::harness::{StageArgs, check_output, save};
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Frame, console};
use pt_core::{FrameSizes, StageInputs};
use pt_gbuffer::{Decomposition, Effects, GbufferParams, PrimaryRays, ReflectRefract};
use pt_image::image_file::{ImageSize, OutputFormat, PixelLayout, write_png};
use pt_import::LoadOptions;
use pt_scene::BadTexels;
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::records::FrameRecord;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Traces the primary rays of a scene, follows mirrors and glass, and writes the G-buffer.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// glTF or GLB file, or the name of a built-in scene.
    scene: String,
    /// The G-buffer of the last frame: an EXR with a layer for each channel.
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,
    /// A contact sheet: every channel in false colour, in the order that the program prints.
    #[arg(long, value_name = "OUT.png")]
    sheet: Option<PathBuf>,
    /// Image size in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: ImageSize,
    /// Environment: a lat-long .hdr or .exr image.
    #[arg(long, value_name = "F")]
    env: Option<PathBuf>,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long, requires = "env")]
    env_clamp: bool,
    /// Seed of the random numbers.
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u32,
    /// Trace backend: auto (measures), compute, ray-query, rt-pipeline or rt-reorder.
    #[arg(long, value_name = "B", default_value_t = TraceBackend::Auto)]
    backend: TraceBackend,
    #[command(flatten)]
    stage: StageArgs,
}

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let params: GbufferParams = args.stage.params()?;
    ensure!(
        !params.godrays.is_on(),
        "godrays.density is {}: this program loads no lights that a medium could scatter; use pt render",
        params.godrays.density
    );
    ensure!(
        params.decomposition == Decomposition::Replacement,
        "gbuffer.decomposition=planes: this program makes one G-buffer; pt render runs a frame for each plane"
    );
    if let Some(path) = &args.output {
        check_output(path)?;
    }
    if let Some(path) = &args.sheet {
        let format = pt_image::image_file::check_output(path)?;
        ensure!(format == OutputFormat::Png, "{}: the contact sheet is a png", path.display());
    }
    let options = LoadOptions {
        environment: args.env.clone(),
        bad_texels: BadTexels::clamp_if(args.env_clamp),
        ..LoadOptions::default()
    };
    let scene = pt_import::open(&args.scene, &options)?;
    for notice in &scene.notices {
        console::print_warning(notice);
    }
    let size: [u32; 2] = args.size.into();
    let view = scene.default_camera();
    let camera = params.with_lens(camera_record(&view, size));

    let device = args.stage.open_device()?.with_formats(params.format.others());
    let mut gpu = GpuScene::new(&device, &scene, args.backend)?;
    let variant = params.variant(gpu.variant());
    let primary = PrimaryRays::new(&device, variant)?;
    let reflect_refract = ReflectRefract::new(&device, variant, false, params.effect_layers)?;
    let effects = Effects::are_in(variant.scene_features)
        .then(|| Effects::new(&device, variant, params.effect_layers))
        .transpose()?;
    let stages = [Some(PrimaryRays::IO), effects.as_ref().map(|_| Effects::BLEND)];
    let stages: Vec<_> = stages.into_iter().flatten().collect();
    let images = ChannelImages::alone(&device, FrameSizes::same(size), &stages)?;
    let uniforms = Uniforms::new(&device, "frame_uniforms")?;
    let times = args.stage.measure(&device, size, |frame: &mut Frame<'_>| {
        gpu.update(frame, &scene)?;
        let record = FrameRecord::new(camera, camera, size, frame.index(), args.seed);
        uniforms.upload(frame, &record)?;
        let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
        primary.record(frame, &inputs, &params)?;
        effects.iter().try_for_each(|effects| effects.record(frame, &inputs, &params))?;
        (0..params.reflect_refract)
            // The light lists that highlights need are not part of the program.
            .try_for_each(|bounce| reflect_refract.record(frame, &inputs, &params, 0, bounce, 0))
    })?;
    write!(out, "{times}")?;
    let rate = times.pass("primary rays").and_then(|pass| pass.mthreads_per_s()).unwrap_or(0.0);
    let triangles = scene.statistics().instanced_triangles;
    writeln!(out, "{}: {triangles} triangles, {rate:.1} Mrays/s (primary), {}", scene.name, gpu.backend())?;

    if let Some(path) = &args.sheet {
        let sheet = sheet::contact_sheet(&images, PrimaryRays::IO.writes)?;
        write_png(path, sheet.width, sheet.height, PixelLayout::Rgb, &sheet.pixels)?;
        for (number, row) in (1..).zip(&sheet.rows) {
            writeln!(out, "sheet, row {number}: {}", row.join(", "))?;
        }
    }
    if let Some(path) = &args.output {
        let metadata = [
            (keys::SCENE, scene.name.clone()),
            (keys::CAMERA, format!("{view:?}")),
            (keys::FRAMES, (times.warm_up + times.frames).to_string()),
            (keys::SEED, args.seed.to_string()),
            (keys::PARAMS, serde_json::to_string(&params)?),
            (keys::BACKEND, gpu.backend().to_string()),
            (keys::VERSION, env!("CARGO_PKG_VERSION").into()),
        ];
        let metadata = metadata.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        save(path, &device, &images, PrimaryRays::IO.writes, metadata)?;
    }
    Ok(())
}
