//! The stage on a recorded G-buffer, with its scene.

use super::Args;
use anyhow::{Context, Result, ensure};
use pt_core::capture::folder::CaptureFolder;
use pt_core::capture::keys;
use pt_core::frame::Uniforms;
use pt_core::harness::{check_output, save};
use pt_core::settings::apply_sets;
use pt_core::{ChannelImages, Frame, FramePlan, FrameSizes, StageInputs, console};
use pt_import::LoadOptions;
use pt_indirect::{BounceLights, IndirectLighting, IndirectParams};
use pt_light_sampling::{LightTables, SamplerChoice};
use pt_scene::BadTexels;
use pt_scene::gpu::GpuScene;
use pt_shaders::channels::COLOR_SPEC;
use pt_shaders::records::FrameRecord;
use std::collections::BTreeMap;
use std::io::Write;

/// Lights the frame, prints the table of times and writes the indirect light.
pub fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    if let Some(path) = &args.output {
        check_output(path)?;
    }
    let capture = CaptureFolder::open(&args.input)?;
    let range = capture.range();
    let number = args.frame.unwrap_or(range.start);
    ensure!(
        range.contains(&number),
        "{}: has the frames {}..{}, not {number}",
        args.input.display(),
        range.start,
        range.end
    );
    let recorded = capture.frame(number)?;
    let sidecar = &recorded.sidecar;
    let mut params = IndirectParams::default();
    if let Some(knobs) = sidecar.params.get("indirect") {
        params = serde_json::from_value(knobs.clone())
            .with_context(|| format!("{}: knobs of frame {number}", args.input.display()))?;
    }
    apply_sets(&mut params, &args.stage.set)?;
    ensure!(params.is_on(), "bounces=0: there is no indirect light; give --set bounces=1 or more");

    let name = args.scene_file.as_ref().unwrap_or(&capture.index.scene);
    let options = LoadOptions {
        environment: args.env.clone(),
        bad_texels: BadTexels::clamp_if(args.env_clamp),
        ..LoadOptions::default()
    };
    let mut scene = pt_import::open(name, &options).context("the capture's scene; --scene-file names it")?;
    scene.notices.iter().for_each(|notice| console::print_warning(notice));
    scene.set_time(sidecar.time, sidecar.time);

    let layers = sidecar.params.pointer("/gbuffer/effect_layers").and_then(serde_json::Value::as_u64);
    // A capture of a program without the knob: its default.
    let layers = layers.map_or(4, |layers| layers.clamp(1, 16) as u32);
    let device = args.stage.open_device()?;
    let mut gpu = GpuScene::new(&device, &scene, args.backend)?;
    let mut tables = LightTables::new(&device, &scene)?;
    tables.prepare(&device, &scene, &mut gpu, Some(SamplerChoice::from(args.sampler)))?;
    let stage =
        IndirectLighting::new(&device, gpu.variant(), BounceLights::all(args.sampler), &params, layers)?;
    let record: FrameRecord = sidecar.record();
    let size = record.size.to_array();
    let stages = IndirectLighting::io(&params);
    let images = ChannelImages::alone(&device, FrameSizes::same(size), &stages)?;
    let given: Vec<_> = FramePlan::new(FrameSizes::same(size)).missing(&stages).into_iter().collect();
    recorded.load(&images, &given)?;
    // The recorded specular light has the direct light too.
    let spec = images.current(COLOR_SPEC);
    let black = vec![0u8; spec.bytes() as usize];
    let uniforms = Uniforms::new(&device, "frame_uniforms")?;
    let times = args.stage.measure(&device, size, |frame: &mut Frame<'_>| {
        tables.update(frame, &scene, &mut gpu)?;
        spec.write(&black)?;
        uniforms.upload(frame, &record)?;
        let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
        stage.record(frame, &inputs, &params, 0.0)
    })?;
    write!(out, "{times}")?;
    let passes = || times.passes.iter().skip_while(|row| row.pass != IndirectLighting::FIRST_PASS);
    let paths = passes().next().map_or(0, |row| row.threads);
    let rate = paths as f64 * 1e-3 / passes().map(|row| row.time.median_ms).sum::<f64>();
    writeln!(out, "{}: bounces {}, {rate:.1} Mpaths/s, {}", scene.name, params.bounces, gpu.backend())?;
    if let Some(path) = &args.output {
        let metadata: BTreeMap<String, String> = [
            (keys::SCENE, scene.name.clone()),
            (keys::PARAMS, serde_json::to_string(&params)?),
            (keys::SEED, record.seed.to_string()),
            (keys::BACKEND, gpu.backend().to_string()),
            (keys::VERSION, env!("CARGO_PKG_VERSION").into()),
        ]
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect();
        let written: Vec<_> = [IndirectLighting::IO.updates, IndirectLighting::IO.writes].concat();
        save(path, &device, &images, &written, metadata)?;
    }
    Ok(())
}
