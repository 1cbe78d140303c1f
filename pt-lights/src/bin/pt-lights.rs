//! Direct lighting alone, on points spread over a scene's surfaces: which lights there are, how much light each kind gives
//! and how noisy one candidate is. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use anyhow::{Result, ensure};
use clap::Parser;
use pt_core::frame::Uniforms;
use pt_core::harness::Spread;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, DeviceOptions, Recorder, console};
use pt_core::{FrameSizes, StageInputs};
use pt_import::LoadOptions;
use pt_light_sampling::LightTables;
use pt_lights::{DirectLighting, DirectParams, synthetic};
use pt_scene::gpu::GpuScene;
use pt_scene::{BadTexels, Scene};
use pt_shaders::channels::COLOR_HF;
use pt_shaders::records::FrameRecord;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Lights points on a scene's surfaces and reports light and noise of every kind of light.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// glTF file or built-in scene.
    scene: String,
    /// Lat-long environment, .hdr or .exr.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long, requires = "env")]
    env_clamp: bool,
    /// Number of surface points, as the side of a square.
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=4096))]
    side: u32,
    /// Light samples for each point and kind of light.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=65536))]
    frames: u32,
    /// Trace backend: auto, compute, ray-query or rt-pipeline.
    #[arg(long, default_value = "auto")]
    backend: TraceBackend,
    /// Device, by index or part of its name [default: the best].
    #[arg(long)]
    device: Option<String>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u32,
}

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let options = LoadOptions {
        environment: args.env.clone(),
        bad_texels: BadTexels::clamp_if(args.env_clamp),
        ..LoadOptions::default()
    };
    let scene = pt_import::open(&args.scene, &options)?;
    scene.notices.iter().for_each(|notice| console::print_warning(notice));
    let device = Device::open(&DeviceOptions { device: args.device.clone(), ..DeviceOptions::default() })?;
    let started = Instant::now();
    let mut lights = LightTables::new(&device, &scene)?;
    report_lists(&lights, started.elapsed().as_secs_f64() * 1e3, out)?;

    let mut gpu = GpuScene::new(&device, &scene, args.backend)?;
    lights.attach(&mut gpu);
    let stage = DirectLighting::new(&device, gpu.variant(), &DirectParams::default())?;
    let off = DirectParams {
        sun: false,
        positional: false,
        emissive: false,
        environment: false,
        ..DirectParams::default()
    };
    let kinds = [
        ("sun", DirectParams { sun: true, ..off.clone() }),
        ("positional", DirectParams { positional: true, ..off.clone() }),
        ("emissive", DirectParams { emissive: true, ..off.clone() }),
        ("environment", DirectParams { environment: true, ..off }),
        ("all", DirectParams::default()),
    ];
    writeln!(out, "{}, {}", device.info().name, device.info().driver_line())?;
    writeln!(out, "backend {}, {} points", gpu.backend(), args.side * args.side)?;
    writeln!(out, "{:<12} {:>14} {:>16} {:>12}", "kind", "radiosity / pi", "noise of 1", "ms per pass")?;
    for (name, params) in kinds {
        let estimate = estimate(args, &device, &scene, (&mut gpu, &mut lights), &stage, &params)?;
        let Estimate { mean, noise, ms } = estimate;
        writeln!(out, "{name:<12} {mean:>14.6} {:>15.1}% {ms:>12.3}", 100.0 * noise)?;
    }
    Ok(())
}

fn report_lists(lights: &LightTables, ms: f64, out: &mut impl Write) -> Result<()> {
    let lists = lights.lists();
    let [width, height] = lists.environment_size;
    let environment = match lists.environment_alias {
        Some(_) => format!("environment of {width}x{height} texels"),
        None => "no environment".into(),
    };
    writeln!(
        out,
        "{} directional lights, {} positional lights, {} emissive triangles, {environment}; listed in {ms:.1} ms",
        lists.sun_count,
        lists.lights.len() - lists.sun_count as usize,
        lists.emissives.len(),
    )?;
    Ok(())
}

struct Estimate {
    /// Mean over the points of the diffuse light, luminance.
    mean: f64,
    /// Root mean square over the points of one candidate's standard deviation, relative to `mean`.
    noise: f64,
    /// Median GPU time of the pass.
    ms: f64,
}

fn estimate(
    args: &Args,
    device: &Device,
    scene: &Scene,
    (gpu, lights): (&mut GpuScene, &mut LightTables),
    stage: &DirectLighting,
    params: &DirectParams,
) -> Result<Estimate> {
    let size = [args.side; 2];
    let images = ChannelImages::alone(device, FrameSizes::same(size), &[DirectLighting::IO])?;
    synthetic::fill_surfaces(&images, scene, gpu.clusters())?;
    let uniforms = Uniforms::<FrameRecord>::new(device, "frame_uniforms")?;
    let mut recorder = Recorder::new(device)?;
    let mut sums: Vec<(f64, f64)> = Vec::new();
    let mut times = Vec::new();
    for index in 0..args.frames {
        synthetic::fill_seeds(&images, index)?;
        let mut frame = recorder.begin()?;
        lights.update(&mut frame, scene, gpu)?;
        uniforms.upload(&mut frame, &FrameRecord { seed: args.seed, ..bytemuck::Zeroable::zeroed() })?;
        let inputs = StageInputs { scene: Some(&*gpu), uniforms: Some(&uniforms), images: &images };
        stage.record(&mut frame, &inputs, params, 0.0)?;
        frame.submit()?;
        let timings = recorder.finish()?;
        times.extend(timings.iter().filter_map(|t| t.passes.last()).map(|pass| pass.ms));
        let texels = images.current(COLOR_HF).read_f32()?;
        sums.resize(texels.len() / 4, (0.0, 0.0));
        for (sum, c) in sums.iter_mut().zip(texels.chunks_exact(4)) {
            let y = f64::from(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]);
            *sum = (sum.0 + y, sum.1 + y * y);
        }
    }
    ensure!(sums.iter().all(|s| s.0.is_finite()), "the pass returned values that are not finite");
    let n = f64::from(args.frames);
    let points = sums.len() as f64;
    let mean = sums.iter().map(|s| s.0 / n).sum::<f64>() / points;
    let variance = sums.iter().map(|s| (s.1 - s.0 * s.0 / n).max(0.0) / (n - 1.0)).sum::<f64>() / points;
    let ms = Spread::of(times).median_ms;
    Ok(Estimate { mean, noise: if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }, ms })
}
