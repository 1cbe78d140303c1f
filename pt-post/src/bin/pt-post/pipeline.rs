//! The chain on images from files.

use crate::chain::Chain;
use crate::input::Input;
use anyhow::Result;
use pt_core::capture::keys;
use pt_core::{ChannelImages, Device, Frame, FrameSizes, Recorder, StageInputs};
use pt_image::image_file::{Layer, LayeredImage, OutputFormat};
use pt_post::{ChainParts, PostChain, PostParams, Upscale, picture_layers, write_picture};
use pt_shaders::channels::FLAT_MOTION;
use std::path::Path;

pub struct Pipeline {
    params: PostParams,
    device: Device,
    images: ChannelImages,
    jitter: [f32; 2],
    chain: PostChain,
}

impl Pipeline {
    /// For images of `size`.
    pub fn new(device: &Device, size: [u32; 2], chain: &Chain, params: PostParams) -> Result<Self> {
        let output = size.map(|side| (side as f32 * chain.factor()).round() as u32);
        let resolved = if params.upscale == Upscale::Taau { output } else { size };
        let parts =
            ChainParts { accumulate: chain.accumulate, picture: chain.tonemap.is_some(), alpha: false };
        let chain = PostChain::new(device, parts, &params)?;
        // Motion is loaded whether a stage reads it or not.
        let mut stages = chain.io();
        stages.push(pt_core::StageIo { reads: &[FLAT_MOTION], ..pt_core::StageIo::of("input") });
        let images = ChannelImages::alone(device, FrameSizes { frame: size, resolved, output }, &stages)?;
        Ok(Self { device: device.clone(), images, jitter: [0.0; 2], chain, params })
    }

    /// Takes the next image.
    pub fn load(&mut self, input: &Input) -> Result<()> {
        input.load(&self.images)?;
        self.jitter = input.jitter();
        Ok(())
    }

    /// Runs the chain once.
    pub fn run(&mut self, time_step: Option<f32>) -> Result<()> {
        let mut recorder = Recorder::new(&self.device)?;
        let mut frame = recorder.begin()?;
        self.record(&mut frame, time_step)?;
        Ok(frame.submit()?)
    }

    /// Records the chain.
    pub fn record(&mut self, frame: &mut Frame<'_>, time_step: Option<f32>) -> pt_core::Result<()> {
        self.images.begin_frame();
        let inputs = StageInputs::new(&self.images);
        self.chain.record(frame, &inputs, time_step, self.jitter, &self.params)
    }

    /// Writes the last image's result.
    pub fn write(&self, path: &Path) -> Result<()> {
        let picture = self.chain.parts().picture;
        if picture && OutputFormat::of(path)? == OutputFormat::Png {
            return Ok(write_picture(path, &self.images, self.params.encoding)?);
        }
        let file = if picture {
            picture_layers(&self.images, self.params.encoding)?
        } else {
            let image = self.chain.radiance(&self.images);
            let [width, height] = image.extent();
            let mut file = LayeredImage::new(width, height)?;
            file.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 4, &image.read_f32()?));
            file.metadata.insert(keys::VERSION.into(), env!("CARGO_PKG_VERSION").into());
            file
        };
        Ok(file.write_exr(path)?)
    }

    /// Size and exposure, for people.
    pub fn describe(&self) -> Result<String> {
        if !self.chain.parts().picture {
            let [width, height] = self.chain.radiance(&self.images).extent();
            return Ok(format!("{width}x{height}, linear"));
        }
        let [width, height] = self.images.output_size();
        let exposure = self.chain.exposure().read()?;
        Ok(format!(
            "{width}x{height}, EV100 {:.3}, radiance x {:.5}, {:.0} pixels metered",
            exposure.ev100, exposure.scale, exposure.metered_pixels
        ))
    }
}
