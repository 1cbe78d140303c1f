//! Every kernel from the flat frame to the picture under Criterion, timed by the GPU's own clock. `cargo bench -p pt-post [--
//! FILTER]`; `POST_SIZE=WIDTHxHEIGHT` chooses the picture [default: 1920x1080]. Bytes a second are those of the pass table: every texel of
//! its images and every byte of its buffers once (twice if updated).
//!
//! `pt bench post` gives the same passes in one table, beside the copy bandwidth.

use criterion::{BenchmarkId, Criterion, Throughput};
use pt_core::{ChannelImages, Device, DeviceOptions, Frame, Recorder, StageInputs, StageIo};
use pt_image::image_file::ImageSize;
use pt_post::images::DISPLAY_CODES;
use pt_post::{
    Accumulate, Bloom, BloomMix, BloomMode, BloomParams, Encoding, Exposure, Fsr, PostParams, Taa, ToneMap,
    Tonemap, Upscale,
};
use pt_shaders::channels::{DISPLAY, FLAT_COLOR, FLAT_MOTION};
use std::error::Error;
use std::time::Duration;

/// The stages on images of their own, for a picture of `output_size` from a frame of two thirds of its sides.
struct Stages {
    images: ChannelImages,
    accumulate: Accumulate,
    taa: Taa,
    bloom: Bloom,
    mix: BloomMix,
    exposure: Exposure,
    tone_map: ToneMap,
    fsr: Fsr,
    params: PostParams,
}

impl Stages {
    fn new(device: &Device, output_size: [u32; 2]) -> pt_core::Result<Self> {
        let params = PostParams { upscale: Upscale::Fsr1, render_scale: 1.0 / 1.5, ..PostParams::default() };
        let sizes = params.sizes(output_size);
        let size = sizes.frame;
        let motion = StageIo { reads: &[FLAT_MOTION], writes: &[DISPLAY], ..StageIo::of("frame") };
        let blooms = [BloomMode::Gaussian, BloomMode::Chain].map(Bloom::io);
        let stages = [
            motion,
            Accumulate::IO,
            Taa::IO,
            blooms[0],
            blooms[1],
            BloomMix::IO,
            Fsr::io(size != output_size),
        ];
        let images = ChannelImages::alone(device, sizes, &stages)?;
        // Luminance over six orders of magnitude, neighbours apart: the histogram's atomics are spread as in a noisy frame.
        let pixels = size[0] as usize * size[1] as usize;
        let texels: Vec<[f32; 4]> = (0..pixels)
            .map(|i| [10f32.powf(((i * 7919) % 6007) as f32 / 1000.0 - 3.0), 0.5, 0.25, 1.0])
            .collect();
        images.current(FLAT_COLOR).write_f32(texels.as_flattened())?;
        let params = PostParams { tonemap: Tonemap::NoiseAware, ..params };
        Ok(Self {
            images,
            accumulate: Accumulate::new(device)?,
            taa: Taa::new(device)?,
            bloom: Bloom::new(device)?,
            mix: BloomMix::new(device)?,
            exposure: Exposure::new(device)?,
            tone_map: ToneMap::new(device, params.tonemap, Encoding::Srgb, false)?,
            fsr: Fsr::new(device)?,
            params,
        })
    }

    fn record(&mut self, frame: &mut Frame<'_>) -> pt_core::Result<()> {
        self.images.begin_frame();
        let Self { images, params, .. } = self;
        let inputs = StageInputs::new(images);
        self.accumulate.record(frame, &inputs)?;
        let (color, motion) = (images.current(FLAT_COLOR), images.current(FLAT_MOTION));
        let source = self.taa.record(frame, &inputs, color, motion, [0.125, -0.25], &params.taa)?;
        for mode in [BloomMode::Gaussian, BloomMode::Chain] {
            let bloom_params = BloomParams { mode, ..BloomParams::default() };
            let bloomed = self.bloom.record(frame, images, source, &bloom_params)?;
            self.mix.record(frame, images, bloomed)?;
        }
        self.exposure.record(frame, source, None, params)?;
        self.tone_map.record(frame, source, &self.exposure, images.current(DISPLAY_CODES), params)?;
        self.fsr.record(frame, images, images.current(DISPLAY), params)
    }
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    // `cargo test --benches` only wants to know that it works.
    let measured = std::env::args().any(|argument| argument == "--bench");
    let size = match std::env::var("POST_SIZE") {
        Ok(text) => text.parse::<ImageSize>()?.into(),
        Err(_) if measured => [1920, 1080],
        Err(_) => [96, 54],
    };
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let device = Device::open(&DeviceOptions::default())?;
    let mut stages = Stages::new(&device, size)?;
    let mut recorder = Recorder::new(&device)?;
    let mut run = |frames: u64| -> pt_core::Result<_> {
        for _ in 0..frames {
            let mut frame = recorder.begin()?;
            stages.record(&mut frame)?;
            frame.submit()?;
        }
        Ok((recorder.finish()?, recorder.pass_table().to_vec()))
    };
    let (_, passes) = run(1)?;

    let mut group = criterion.benchmark_group(format!("post {}x{}", size[0], size[1]));
    for (index, pass) in passes.iter().enumerate().filter(|(_, pass)| pass.extent != [0; 3]) {
        group.throughput(Throughput::Bytes(pass.bytes));
        // Passes of the second bloom have the names of the first one.
        let name = BenchmarkId::new(&pass.name, index);
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|frames| match run(frames) {
                Ok((timings, _)) => {
                    let ms: f64 = timings.iter().map(|frame| frame.passes[index].ms).sum();
                    Duration::from_secs_f64(ms / 1000.0)
                }
                Err(error) => panic!("{error}"),
            });
        });
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
