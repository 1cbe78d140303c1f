//! The stages of a chain, put together.

use crate::Input;
use crate::chain::Chain;
use anyhow::Result;
use pt_core::capture::keys;
use pt_image::image_file::{Layer, LayeredImage, OutputFormat};
use pt_core::{ChannelImages, Device, Frame, Image, Recorder};
use pt_post::{
    Accumulate, Bloom, BloomMix, Exposure, Fsr, PostParams, Taa, ToneMap, picture_layers, radiance,
    write_picture,
};
use pt_shaders::channels::{ACCUMULATED, FLAT_COLOR, FLAT_MOTION};
use std::path::Path;

pub struct Pipeline {
    params: PostParams,
    device: Device,
    images: ChannelImages,
    jitter: [f32; 2],
    frames: u32,
    accumulate: Option<Accumulate>,
    taa: Option<Taa>,
    bloom: Option<Bloom>,
    /// Only when the bloomed image itself is the result.
    bloom_mix: Option<BloomMix>,
    tone_map: Option<ToneMap>,
    exposure: Exposure,
    fsr: Option<Fsr>,
}

impl Pipeline {
    /// For images of `size`.
    pub fn new(device: &Device, size: [u32; 2], chain: &Chain, params: PostParams) -> Result<Self> {
        let output_size = size.map(|side| (side as f32 * chain.factor()).round() as u32);
        // Everything up to the tone map has the size of the frame, or of the picture after temporal upscaling.
        let working_size = if chain.fsr.is_some() { size } else { output_size };
        let fsr = (chain.fsr.is_some() || chain.sharpen).then(|| Fsr::new(device, working_size, output_size));
        let mut channels = vec![FLAT_COLOR, FLAT_MOTION];
        channels.extend(chain.tonemap.map(|_| params.encoding.channel()));
        if chain.accumulate {
            channels.push(ACCUMULATED);
        }
        let codes = if fsr.is_some() { Fsr::input_encoding(params.encoding) } else { params.encoding };
        Ok(Self {
            device: device.clone(),
            images: ChannelImages::with_output(device, size, output_size, channels)?,
            jitter: [0.0; 2],
            frames: 0,
            accumulate: chain.accumulate.then(|| Accumulate::new(device, size)).transpose()?,
            taa: chain.taa.map(|_| Taa::new(device, working_size)).transpose()?,
            bloom: chain.bloom.map(|_| Bloom::new(device, working_size)).transpose()?,
            bloom_mix: (chain.bloom.is_some() && chain.tonemap.is_none())
                .then(|| BloomMix::new(device, working_size))
                .transpose()?,
            tone_map: chain.tonemap.map(|_| ToneMap::new(device, params.tonemap, codes)).transpose()?,
            exposure: Exposure::new(device)?,
            fsr: fsr.transpose()?,
            params,
        })
    }

    /// Takes the next image.
    pub fn load(&mut self, input: &Input) -> Result<()> {
        self.images.current(FLAT_COLOR).write_f32(input.color.as_flattened())?;
        self.images.current(FLAT_MOTION).write_f32(input.motion.as_flattened())?;
        self.jitter = input.jitter;
        Ok(())
    }

    /// Runs the chain once.
    pub fn run(&mut self, dt: Option<f32>) -> Result<()> {
        let mut recorder = Recorder::new(&self.device)?;
        let mut frame = recorder.begin()?;
        self.record(&mut frame, dt)?;
        Ok(frame.submit()?)
    }

    /// Records the chain.
    pub fn record(&mut self, frame: &mut Frame<'_>, dt: Option<f32>) -> pt_core::Result<()> {
        let Self { params, images, .. } = self;
        if let Some(accumulate) = &self.accumulate {
            accumulate.record(frame, images, self.frames == 0)?;
        }
        self.frames += 1;
        if let Some(taa) = &mut self.taa {
            let (color, motion) = (images.current(FLAT_COLOR), images.current(FLAT_MOTION));
            taa.record(frame, color, motion, self.jitter, &params.taa)?;
        }
        let source = radiance(images, self.accumulate.as_ref(), self.taa.as_ref());
        let bloomed = match &self.bloom {
            Some(bloom) => bloom.record(frame, source, &params.bloom)?,
            None => source.into(),
        };
        if let Some(mix) = &self.bloom_mix {
            mix.record(frame, bloomed)?;
        }
        let Some(tone_map) = &self.tone_map else { return Ok(()) };
        self.exposure.record(frame, bloomed.radiance, dt, params)?;
        let picture = images.current(params.encoding.channel());
        match &self.fsr {
            None => tone_map.record(frame, bloomed, &self.exposure, picture, params),
            Some(fsr) => {
                tone_map.record(frame, bloomed, &self.exposure, fsr.codes(), params)?;
                fsr.record(frame, picture, params)
            }
        }
    }

    /// Writes the last image's result.
    pub fn write(&self, path: &Path) -> Result<()> {
        if self.tone_map.is_some() && OutputFormat::of(path)? == OutputFormat::Png {
            return Ok(write_picture(path, &self.images, self.params.encoding)?);
        }
        let file = if self.tone_map.is_some() {
            picture_layers(&self.images, self.params.encoding)?
        } else {
            let image = self.result();
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
        if self.tone_map.is_none() {
            let [width, height] = self.result().extent();
            return Ok(format!("{width}x{height}, linear"));
        }
        let [width, height] = self.images.output_size();
        let exposure = self.exposure.read()?;
        Ok(format!(
            "{width}x{height}, EV100 {:.3}, radiance x {:.5}, {:.0} pixels metered",
            exposure.ev100, exposure.scale, exposure.metered_pixels
        ))
    }

    /// The last image before the tone map.
    fn result(&self) -> &Image {
        match &self.bloom_mix {
            Some(mix) => mix.bloomed(),
            None => radiance(&self.images, self.accumulate.as_ref(), self.taa.as_ref()),
        }
    }
}
