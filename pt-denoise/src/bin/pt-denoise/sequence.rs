//! Variants of the denoiser side by side on a recorded sequence.

use crate::Args;
use crate::measure::{Row, Seen};
use crate::oidn::{self, Oidn};
use anyhow::{Context, Result, ensure};
use pt_core::capture::folder::CaptureFolder;
use pt_core::capture::{keys, read_layer};
use pt_core::frame::Uniforms;
use pt_core::harness::Spread;
use pt_core::split::to_flat;
use pt_core::{ChannelImages, Device, FramePlan, FrameSizes, Recorder, StageInputs, StageIo};
use pt_denoise::{Composite, DenoiseChain, DenoiseParams, Denoiser};
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::{ImageState, Layer, LayeredImage, LinearImage, Samples};
use pt_shaders::channels::{COLOR, COLOR_LF_SH, ChannelId, ExtentClass};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Runs the variants and prints a line for each.
pub fn run(args: &Args, params: DenoiseParams, out: &mut impl Write) -> Result<()> {
    let folder = CaptureFolder::open(&args.replay.capture)?;
    let variants = if args.variant.is_empty() { vec![params.variant] } else { args.variant.clone() };
    if let Some(path) = &args.json {
        check_writable(path)?;
    }
    if let Some(path) = &args.dump {
        std::fs::create_dir_all(path).with_context(|| format!("{}", path.display()))?;
    }
    let references = references(args, &folder)?;
    if variants.contains(&Denoiser::Oidn) {
        Oidn::new()?;
    }
    let device = args.replay.stage.open_device()?.with_formats(params.histories.others());
    let mut rows = Vec::new();
    writeln!(
        out,
        "{:<12}  {:>6}  {:>10}  {:>8}  {:>10}  {:>8}  {:>8}  {:>10}",
        "variant", "frame", "relmse", "flip", "temporal", "detail", "energy", "median ms"
    )?;
    for variant in variants {
        let params = DenoiseParams { variant, ..params.clone() };
        let sequence = Sequence { device: &device, folder: &folder, references: &references };
        let of_variant = sequence.run(&params, args.dump.as_deref())?;
        let Some(last) = of_variant.last() else { continue };
        let number = |v: Option<f64>, digits: usize| v.map_or("-".into(), |v| format!("{v:.digits$}"));
        writeln!(
            out,
            "{:<12}  {:>6}  {:>10}  {:>8}  {:>10}  {:>8}  {:>8}  {:>10.4}",
            last.variant,
            last.frame,
            number(last.relmse, 6),
            number(last.flip, 4),
            number(last.temporal_pixel, 6),
            number(last.detail_ratio, 4),
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
        let indirect = first.has_layer(COLOR_LF_SH);
        // Open Image Denoise filters the composited radiance.
        let by_oidn = params.variant == Denoiser::Oidn;
        let passes =
            if by_oidn { DenoiseParams { variant: Denoiser::Off, ..params.clone() } } else { params.clone() };
        let chain = DenoiseChain::new(self.device, &passes, indirect)?;
        let composite = Composite::for_light(self.device, indirect)?;
        let measured = if self.references.is_empty() { &[][..] } else { &[Seen::IO] };
        let oidn = by_oidn.then(Oidn::new).transpose()?;
        let guides = if by_oidn { &[oidn::GUIDES][..] } else { &[] };
        let stages: Vec<StageIo> = [chain.io(), &[Composite::io_for(indirect)], measured, guides].concat();
        let mut images = ChannelImages::alone(self.device, FrameSizes::same(size), &stages)?;
        let given: Vec<ChannelId> =
            FramePlan::new(FrameSizes::same(size)).missing(&stages).into_iter().collect();
        let mut recorder = Recorder::new(self.device)?;
        let uniforms = Uniforms::new(self.device, "frame_uniforms")?;
        let mut rows = Vec::new();
        let mut oidn_ms = Vec::new();
        let mut before: Option<Seen> = None;
        for number in self.folder.range() {
            let recorded = self.folder.frame(number)?;
            ensure!(recorded.sidecar.size == size, "frame {number}: another size than the first frame");
            // A cut that was recorded is a cut here.
            if !recorded.sidecar.has_history {
                images.reset_history();
                before = None;
            }
            images.begin_frame();
            recorded.load(&images, &given)?;
            let inputs = StageInputs { uniforms: Some(&uniforms), ..StageInputs::new(&images) };
            let mut frame = recorder.begin()?;
            uniforms.upload(&mut frame, &recorded.sidecar.record())?;
            let light = chain.record(&mut frame, &inputs, &passes)?;
            composite.record(&mut frame, &inputs, light, &passes)?;
            frame.submit()?;
            let mut radiance = radiance(&images)?;
            if let Some(oidn) = &oidn {
                oidn_ms.push(oidn.denoise(&images, &mut radiance, params.oidn_quality)?);
            }
            let mut row = Row { variant: params.variant.name(), frame: number, ..Row::default() };
            let seen = match self.references.get(&number) {
                Some(path) => {
                    let seen = Seen::of(&images, radiance.clone(), LinearImage::read(path)?)?;
                    seen.measure(before.as_ref(), &mut row).with_context(|| path.display().to_string())?;
                    Some(seen)
                }
                None => None,
            };
            before = seen;
            rows.push(row);
            if let Some(dump) = dump {
                let path = dump.join(format!("{}_{number:06}.exr", params.variant.name()));
                write(&path, &images, chain.io(), &radiance, params)?;
            }
        }
        for (row, timing) in rows.iter_mut().zip(recorder.finish()?) {
            row.gpu_ms = timing.gpu_ms;
            row.passes = timing.passes.into_iter().map(|pass| (pass.pass, pass.ms)).collect();
        }
        // Of the host's clock.
        for (row, ms) in rows.iter_mut().zip(oidn_ms) {
            row.gpu_ms += ms;
            row.passes.insert("oidn".into(), ms);
        }
        Ok(rows)
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

/// The radiance as the main layer, and every image that the passes write as a layer of its name.
fn write(
    path: &Path,
    images: &ChannelImages,
    passes: &[StageIo],
    radiance: &LinearImage,
    params: &DenoiseParams,
) -> Result<()> {
    let mut file = LayeredImage::new(radiance.width, radiance.height)?;
    file.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, radiance.pixels.as_flattened()));
    let written: BTreeSet<ChannelId> = passes.iter().flat_map(|io| io.writes).copied().collect();
    for id in written {
        let (mut layer, size) = read_layer(images, id)?;
        if id.channel().extent != ExtentClass::Split {
            // Strata, or tiles of indirect light.
            let is_of_strata = ["gradients", "sums"].iter().any(|name| id.channel().name.starts_with(name));
            let side = if is_of_strata { params.antilag.stratum.side() } else { 3 };
            layer
                .channels
                .iter_mut()
                .for_each(|c| repeat(&mut c.samples, size[0], side, [file.width, file.height]));
        }
        file.layers.push(layer);
    }
    file.metadata.insert(keys::PARAMS.into(), serde_json::to_string(params)?);
    file.metadata.insert(keys::VERSION.into(), env!("CARGO_PKG_VERSION").into());
    Ok(file.write_exr(path)?)
}

/// Texels of an image of `row` columns that stand for `side` x `side` pixels each, once for every pixel.
fn repeat(samples: &mut Samples, row: u32, side: u32, size: [u32; 2]) {
    let texels =
        || (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| (y / side * row + x / side) as usize));
    match samples {
        Samples::F32(v) => *v = texels().map(|i| v[i]).collect(),
        Samples::U32(v) => *v = texels().map(|i| v[i]).collect(),
        Samples::F16(v) => *v = texels().map(|i| v[i]).collect(),
    }
}
