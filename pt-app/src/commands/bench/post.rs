//! `pt bench post` measures every pass from the interleave to the picture on a synthetic frame.

use crate::session::check_host_memory;
use anyhow::{Result, ensure};
use clap::Args;
use pt_checkerboard::{CheckerboardParams, Interleave};
use pt_core::harness::{PassRow, StageTimes, WARM_UP, copy_bandwidth, measure};
use pt_core::{ChannelImages, Device, DeviceOptions, StageInputs};
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::ImageSize;
use pt_post::oracle::{self, TaaFrame, TaaOracle};
use pt_post::{BloomMode, BloomParams, ChainParts, Encoding, Fsr, PostChain, PostParams, Tonemap, Upscale};
use pt_shaders::channels::{COLOR, DISPLAY, FLAT_COLOR};
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;

/// `pt bench post`
#[derive(Clone, Debug, Args)]
pub struct BenchPostArgs {
    /// Also write the rows to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Size of the picture.
    #[arg(long, value_name = "WxH", default_value = "3840x2160")]
    pub size: ImageSize,
    /// Number of timed frames.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// Memory of the host that a pixel takes, a CPU device included.
const BYTES_PER_PIXEL: u64 = 160;

/// Size at which results are checked against the oracles before anything is timed.
const CHECK_SIZE: [u32; 2] = [96, 54];

/// A synthetic frame and its post-processing chain.
struct Chain {
    name: &'static str,
    /// Side of the picture over side of the frame.
    factor: f32,
    params: PostParams,
}

fn chains() -> [Chain; 3] {
    let bloom = BloomParams { mode: BloomMode::Gaussian, ..BloomParams::default() };
    let params = PostParams { bloom, ..PostParams::default() };
    let upscaled =
        |upscale, factor: f32| PostParams { upscale, render_scale: 1.0 / factor, ..params.clone() };
    let mut native = params.clone();
    (native.taa.enabled, native.fsr.sharpen) = (true, true);
    let mut fsr = upscaled(Upscale::Fsr1, 1.5);
    (fsr.taa.enabled, fsr.tonemap) = (true, Tonemap::NoiseAware);
    [
        Chain { name: "native: TAA, bloom, ACES, RCAS", factor: 1.0, params: native },
        Chain { name: "FSR 1 x1.5: TAA, bloom, noise-aware, EASU, RCAS", factor: 1.5, params: fsr },
        Chain { name: "TAAU x2: bloom, ACES", factor: 2.0, params: upscaled(Upscale::Taau, 2.0) },
    ]
}

/// The interleave and a chain on images of their own.
struct Stages {
    images: ChannelImages,
    interleave: Interleave,
    post: PostChain,
    params: PostParams,
}

impl Stages {
    fn new(device: &Device, output_size: [u32; 2], chain: &Chain) -> Result<Self> {
        let params = chain.params.clone();
        let post =
            PostChain::new(device, ChainParts { accumulate: false, picture: true, alpha: false }, &params)?;
        let stages = [vec![Interleave::IO], post.io()].concat();
        let images = ChannelImages::alone(device, params.sizes(output_size), &stages)?;
        // Luminance over six orders of magnitude, neighbours apart: the histogram's atomics are spread as in a noisy frame.
        let split = images.current(COLOR);
        let [width, height] = split.extent();
        let texels: Vec<[f32; 4]> = (0..width as usize * height as usize)
            .map(|i| [10f32.powf(((i * 7919) % 6007) as f32 / 1000.0 - 3.0), 0.5, 0.25, 1.0])
            .collect();
        split.write_f32(texels.as_flattened())?;
        Ok(Self { images, interleave: Interleave::new(device)?, post, params })
    }

    fn measure(&mut self, device: &Device, warm_up: u32, frames: u32) -> Result<StageTimes> {
        let Self { images, interleave, post, params } = self;
        let size = images.size();
        Ok(measure(device, size, warm_up, frames, |frame| {
            images.begin_frame();
            let inputs = StageInputs::new(images);
            interleave.record(frame, &inputs, &CheckerboardParams::default())?;
            post.record(frame, &inputs, Some(1.0 / 60.0), [0.125, -0.25], params)
        })?)
    }

    /// Difference of the picture from the oracles' one, after one frame.
    fn check(&mut self, device: &Device) -> Result<Difference> {
        // One frame: history, adaptation and curve are then those of the frame itself.
        self.params.dither = false;
        self.measure(device, 0, 1)?;
        let rgb = |values: Vec<f32>| -> Vec<[f64; 3]> {
            values.chunks_exact(4).map(|c| [c[0], c[1], c[2]].map(f64::from)).collect()
        };
        let flat = self.images.current(FLAT_COLOR);
        let color = oracle::Image { size: flat.extent(), pixels: rgb(flat.read_f32()?) };
        let pixels = color.pixels.len();
        let resolved = TaaOracle::new(self.post.resolved(&self.images).extent()).next(
            &TaaFrame {
                color: &color,
                flags: &vec![1; pixels],
                motion: &vec![[0.0; 2]; pixels],
                jitter: [0.125, -0.25],
            },
            &self.params.taa,
        );
        let bloomed = oracle::bloom(&resolved, &self.params.bloom);
        let exposed = oracle::Exposed {
            scale: self.post.exposure().read()?.scale.into(),
            shift: 0.0,
            curve: self.post.exposure().read_curve()?.into_iter().map(f64::from).collect(),
        };
        let code = |c: &[f64; 3]| oracle::codes(c.map(|v| v as f32), &exposed, Encoding::Srgb, &self.params);
        let codes = oracle::Image { size: bloomed.size, pixels: bloomed.pixels.iter().map(code).collect() };
        let output_size = self.images.output_size();
        let strength = (-f64::from(self.params.fsr.sharpness)).exp2();
        let sharpened = match (self.params.uses_fsr(), codes.size == output_size) {
            (false, _) => codes,
            (true, true) => oracle::rcas(&codes, strength, false),
            (true, false) => oracle::rcas(&oracle::easu(&codes, output_size), strength, false),
        };
        let shown = self.images.current(DISPLAY).read_f32()?;
        let pairs = rgb(shown).into_iter().flatten().zip(sharpened.pixels.into_iter().flatten());
        let codes: Vec<f64> = pairs.map(|(a, b)| 255.0 * (a - b).abs()).collect();
        let squares: f64 = codes.iter().map(|c| c * c).sum();
        Ok(Difference {
            largest: codes.iter().copied().fold(0.0, f64::max),
            rms: (squares / codes.len() as f64).sqrt(),
        })
    }
}

/// Difference of two pictures, in codes of 0 to 255.
struct Difference {
    largest: f64,
    rms: f64,
}

/// Most that a picture may differ from the oracles', codes: half a code of rounding, and what half floats between the passes
/// make of random neighbours after sharpening.
const CHECK_LIMIT: f64 = 2.5;
/// Most root mean square that it may differ where EASU computes in half floats: in noise, edges whose gradients cancel turn.
const HALF_CHECK_LIMIT: f64 = 0.8;

/// Runs the command.
///
/// # Errors
/// Unknown device, a result that is not the oracles', a file that can't be written.
pub fn run(args: &BenchPostArgs, out: &mut impl Write) -> Result<bool> {
    args.json.as_deref().map_or(Ok(()), check_writable)?;
    let size: [u32; 2] = args.size.into();
    check_host_memory("a frame", size, BYTES_PER_PIXEL)?;
    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
    let copy = copy_bandwidth(&device, size, args.frames)?;
    writeln!(out, "{}, {}", device.info().name, device.info().driver_line())?;
    writeln!(
        out,
        "picture {}x{}, {} frames after {WARM_UP} to warm up; copying: {:.1} GB/s ({})",
        size[0], size[1], args.frames, copy.gb_per_s, copy.fastest
    )?;
    let mut documents = Vec::new();
    for chain in chains() {
        let difference = Stages::new(&device, CHECK_SIZE, &chain)?.check(&device)?;
        let half = chain.params.upscale == Upscale::Fsr1 && Fsr::computes_in_half_floats(&device);
        ensure!(
            if half { difference.rms <= HALF_CHECK_LIMIT } else { difference.largest <= CHECK_LIMIT },
            "{}: the picture differs from the oracles' by {:.2} codes, rms {:.2}",
            chain.name,
            difference.largest,
            difference.rms
        );
        let mut stages = Stages::new(&device, size, &chain)?;
        let times = stages.measure(&device, WARM_UP, args.frames)?;
        let frame_size = stages.images.size();
        writeln!(
            out,
            "\n{} (frame {}x{}); checked at {}x{}: {:.2} codes from the oracles, rms {:.2}",
            chain.name,
            frame_size[0],
            frame_size[1],
            CHECK_SIZE[0],
            CHECK_SIZE[1],
            difference.largest,
            difference.rms
        )?;
        writeln!(
            out,
            "{:<14}  {:>10}  {:>10}  {:>10}  {:>8}  {:>7}",
            "pass", "median ms", "p95 ms", "MiB", "GB/s", "of copy"
        )?;
        let share = |row: &PassRow| row.gb_per_s().map(|rate| rate / copy.gb_per_s);
        for row in &times.passes {
            writeln!(
                out,
                "{:<14}  {:>10.4}  {:>10.4}  {:>10}  {:>8}  {:>7}",
                row.pass,
                row.time.median_ms,
                row.time.p95_ms,
                row.mebibytes(),
                row.gb_per_s().map_or("-".into(), |rate| format!("{rate:.1}")),
                share(row).map_or("-".into(), |share| format!("{:.0} %", 100.0 * share)),
            )?;
        }
        writeln!(out, "{:<14}  {:>10.4}  {:>10.4}", "all", times.frame.median_ms, times.frame.p95_ms)?;
        let rows: Vec<_> = times
            .passes
            .iter()
            .map(|row| json!({ "pass": row, "gb_per_s": row.gb_per_s(), "share_of_copy": share(row) }))
            .collect();
        documents.push(json!({
            "chain": chain.name, "factor": chain.factor, "frame_size": frame_size,
            "largest_difference_codes": difference.largest, "rms_difference_codes": difference.rms, "frame": times.frame, "passes": rows,
        }));
    }
    if let Some(path) = &args.json {
        let document = json!({
            "device": device.info().name, "driver": device.info().driver_line(), "size": size,
            "frames": args.frames, "copy_gb_per_s": copy.gb_per_s, "copy": copy.fastest, "chains": documents,
        });
        write_atomic(path, serde_json::to_string_pretty(&document)?.as_bytes())?;
    }
    Ok(true)
}
