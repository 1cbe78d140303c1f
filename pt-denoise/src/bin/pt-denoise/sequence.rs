//! Variants of the denoiser side by side on a recorded sequence.

use crate::Args;
use anyhow::{Context, Result, bail, ensure};
use pt_core::capture::folder::CaptureFolder;
use pt_core::capture::keys;
use pt_core::harness::Spread;
use pt_core::split::to_flat;
use pt_core::{ChannelImages, Device, FramePlan, FrameSizes, Recorder, StageInputs, StageIo};
use pt_denoise::{Composite, DenoiseChain, DenoiseParams, Denoiser};
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::{ImageState, Layer, LayeredImage, LinearImage};
use pt_image::metrics::{Metric, MetricError, compare};
use pt_shaders::channels::{COLOR, ChannelId};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A line of the JSON file.
#[derive(Serialize)]
struct Row {
    variant: &'static str,
    frame: u32,
    relmse: Option<f64>,
    flip: Option<f64>,
    energy_ratio: Option<f64>,
    gpu_ms: f64,
    /// Of each pass.
    passes: BTreeMap<String, f64>,
}

/// Runs the variants and prints a line for each.
pub fn run(args: &Args, params: DenoiseParams, out: &mut impl Write) -> Result<()> {
    let folder = CaptureFolder::open(&args.replay.capture)?;
    let variants = if args.variant.is_empty() { vec![params.denoiser] } else { args.variant.clone() };
    if let Some(path) = &args.json {
        check_writable(path)?;
    }
    if let Some(path) = &args.dump {
        std::fs::create_dir_all(path).with_context(|| format!("{}", path.display()))?;
    }
    let references = references(args, &folder)?;
    let device = args.replay.stage.open_device()?;
    let mut rows = Vec::new();
    writeln!(
        out,
        "{:<12}  {:>6}  {:>10}  {:>8}  {:>8}  {:>10}",
        "variant", "frame", "relmse", "flip", "energy", "median ms"
    )?;
    for variant in variants {
        let params = DenoiseParams { denoiser: variant, ..params.clone() };
        let sequence = Sequence { device: &device, folder: &folder, references: &references };
        let of_variant = sequence.run(&params, args.dump.as_deref())?;
        let Some(last) = of_variant.last() else { continue };
        let number = |v: Option<f64>, digits: usize| v.map_or("-".into(), |v| format!("{v:.digits$}"));
        writeln!(
            out,
            "{:<12}  {:>6}  {:>10}  {:>8}  {:>8}  {:>10.4}",
            last.variant,
            last.frame,
            number(last.relmse, 6),
            number(last.flip, 4),
            number(last.energy_ratio, 4),
            Spread::of(of_variant.iter().map(|row| row.gpu_ms).collect()).median_ms,
        )?;
        rows.extend(of_variant);
    }
    if let Some(path) = &args.json {
        let lines =
            rows.iter().map(|row| Ok(serde_json::to_string(row)? + "\n")).collect::<Result<String>>()?;
        write_atomic(path, lines.as_bytes())?;
    }
    Ok(())
}

/// The ground truth of each frame, by its number; empty if none was asked for and none is there.
fn references(args: &Args, folder: &CaptureFolder) -> Result<BTreeMap<u32, PathBuf>> {
    let recorded = folder.index.frames.iter().filter_map(|f| Some((f.frame, f.reference.as_ref()?)));
    let Some(elsewhere) = &args.reference else {
        return Ok(recorded.map(|(frame, file)| (frame, args.replay.capture.join(&file.name))).collect());
    };
    let named = folder.range().map(|frame| (frame, elsewhere.join(format!("reference_{frame:06}.exr"))));
    let found: BTreeMap<_, _> = named.filter(|(_, path)| path.exists()).collect();
    ensure!(
        !found.is_empty(),
        "{}: has no reference_{:06}.exr to reference_{:06}.exr; pt capture --reference-spp writes them",
        elsewhere.display(),
        folder.range().start,
        folder.range().end - 1
    );
    Ok(found)
}

struct Sequence<'a> {
    device: &'a Device,
    folder: &'a CaptureFolder,
    references: &'a BTreeMap<u32, PathBuf>,
}

impl Sequence<'_> {
    fn run(&self, params: &DenoiseParams, dump: Option<&Path>) -> Result<Vec<Row>> {
        let first = self.folder.frame(self.folder.range().start)?;
        let size = first.sidecar.size;
        let chain = DenoiseChain::new(self.device, params)?;
        let composite = Composite::new(self.device)?;
        let stages: Vec<StageIo> = [chain.io(), &[Composite::IO]].concat();
        let mut images = ChannelImages::alone(self.device, FrameSizes::same(size), &stages)?;
        let given: Vec<ChannelId> =
            FramePlan::new(FrameSizes::same(size)).missing(&stages).into_iter().collect();
        let mut recorder = Recorder::new(self.device)?;
        let mut rows = Vec::new();
        for number in self.folder.range() {
            let recorded = self.folder.frame(number)?;
            ensure!(recorded.sidecar.size == size, "frame {number}: another size than the first frame");
            // A cut that was recorded is a cut here.
            if !recorded.sidecar.has_history {
                images.reset_history();
            }
            images.begin_frame();
            recorded.load(&images, &given)?;
            let inputs = StageInputs::new(&images);
            let mut frame = recorder.begin()?;
            let light = chain.record(&mut frame, &inputs, params)?;
            composite.record(&mut frame, &inputs, light, params)?;
            frame.submit()?;
            let radiance = radiance(&images)?;
            rows.push(self.row(params.denoiser, number, &radiance)?);
            if let Some(dump) = dump {
                write(&dump.join(format!("{}_{number:06}.exr", params.denoiser.name())), &radiance, params)?;
            }
        }
        for (row, timing) in rows.iter_mut().zip(recorder.finish()?) {
            row.gpu_ms = timing.gpu_ms;
            row.passes = timing.passes.into_iter().map(|pass| (pass.pass, pass.ms)).collect();
        }
        Ok(rows)
    }

    fn row(&self, variant: Denoiser, frame: u32, radiance: &LinearImage) -> Result<Row> {
        let mut values = [None; 3];
        if let Some(path) = self.references.get(&frame) {
            let reference = LinearImage::read(path)?;
            match compare(radiance, &reference, &[Metric::RelMse, Metric::Flip, Metric::Energy]) {
                Ok(found) => values = [0, 1, 2].map(|i| found.get(i).map(|m| m.value)),
                // Samples that are no light are what a denoiser is measured with, too.
                Err(MetricError::NonFinite { a, b: 0, .. }) if a > 0 => {}
                Err(error) => bail!("{}: {error}", path.display()),
            }
        }
        let [relmse, flip, energy_ratio] = values;
        let variant = variant.name();
        Ok(Row { variant, frame, relmse, flip, energy_ratio, gpu_ms: 0.0, passes: BTreeMap::new() })
    }
}

/// The composited radiance in flat order; surfaces that reflect in one field and refract in the other are not blended.
fn radiance(images: &ChannelImages) -> Result<LinearImage> {
    let texels = images.current(COLOR).read_f32()?;
    let pixels: Vec<[f32; 3]> = texels.chunks_exact(4).map(|c| [c[0], c[1], c[2]]).collect();
    let [width, height] = images.size();
    Ok(LinearImage {
        width,
        height,
        pixels: to_flat(&pixels, [width, height]),
        state: ImageState::SceneReferred,
    })
}

fn write(path: &Path, radiance: &LinearImage, params: &DenoiseParams) -> Result<()> {
    let mut file = LayeredImage::new(radiance.width, radiance.height)?;
    file.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, radiance.pixels.as_flattened()));
    file.metadata.insert(keys::PARAMS.into(), serde_json::to_string(params)?);
    file.metadata.insert(keys::VERSION.into(), env!("CARGO_PKG_VERSION").into());
    Ok(file.write_exr(path)?)
}
