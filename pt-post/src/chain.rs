//! The stages of pt-post composed into one chain, which `pt render`, `pt replay`, `pt bench post` and `pt-post` record.

use crate::accumulate::Accumulate;
use crate::bloom::{Bloom, BloomMix, BloomMode, Bloomed};
use crate::exposure::Exposure;
use crate::fsr::Fsr;
use crate::images::{BLOOMED, DISPLAY_CODES, MATTE, RESOLVED};
use crate::matte::Matte;
use crate::params::PostParams;
use crate::taa::Taa;
use crate::tone_map::ToneMap;
use pt_core::{Buffer, ChannelImages, Device, Frame, Image, Result, StageInputs, StageIo};
use pt_shaders::channels::{ACCUMULATED, ChannelId, FLAT_COLOR, FLAT_MOTION};

/// Parts of the chain that do not depend on knobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainParts {
    /// The frames are averaged (the photo mode), instead of temporal anti-aliasing.
    pub accumulate: bool,
    /// The chain ends with a picture: exposed, tone-mapped, encoded. Otherwise it ends with linear radiance.
    pub picture: bool,
    /// The background is transparent: the picture gets an alpha channel. Without temporal anti-aliasing, bloom, FSR 1 and HDR codes.
    pub alpha: bool,
}

/// What a stage of the chain has just written.
#[derive(Clone, Copy)]
pub enum Written<'a> {
    /// What temporal anti-aliasing resolved.
    Resolved(&'a Image),
    /// The exposure and the noise-aware curve that the tone map will read.
    Exposure(&'a Exposure),
}

/// The stages of pt-post that the knobs ask for, in the order of the frame: running mean or temporal anti-aliasing, bloom,
/// exposure, tone map, FSR 1.
pub struct PostChain {
    parts: ChainParts,
    picture: ChannelId,
    accumulate: Option<Accumulate>,
    taa: Option<Taa>,
    matte: Option<Matte>,
    bloom: Option<(BloomMode, Bloom)>,
    /// Only where the bloomed image itself is the result.
    bloom_mix: Option<BloomMix>,
    exposure: Exposure,
    tone_map: Option<ToneMap>,
    fsr: Option<Fsr>,
    upscales_codes: bool,
}

impl PostChain {
    /// Creates the stages' kernels.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, parts: ChainParts, params: &PostParams) -> Result<Self> {
        let ChainParts { accumulate, picture, alpha } = parts;
        let blooms = params.bloom.mode != BloomMode::Off;
        let uses_fsr = picture && params.uses_fsr();
        let codes = if uses_fsr { Fsr::input_encoding(params.encoding) } else { params.encoding };
        Ok(Self {
            parts,
            picture: params.encoding.channel(),
            accumulate: accumulate.then(|| Accumulate::new(device)).transpose()?,
            taa: (params.uses_taa() && !accumulate).then(|| Taa::new(device)).transpose()?,
            matte: alpha.then(|| Matte::new(device)).transpose()?,
            bloom: blooms
                .then(|| Ok::<_, pt_core::Error>((params.bloom.mode, Bloom::new(device)?)))
                .transpose()?,
            bloom_mix: (blooms && !picture).then(|| BloomMix::new(device)).transpose()?,
            exposure: Exposure::new(device)?,
            tone_map: picture.then(|| ToneMap::new(device, params.tonemap, codes, alpha)).transpose()?,
            fsr: uses_fsr.then(|| Fsr::new(device)).transpose()?,
            upscales_codes: params.upscales_codes(),
        })
    }

    /// The declarations of the stages, in order.
    pub fn io(&self) -> Vec<StageIo> {
        let mut stages = Vec::new();
        stages.extend(self.accumulate.as_ref().map(|_| Accumulate::IO));
        if self.taa.is_some() {
            stages.push(StageIo { reads: &[FLAT_COLOR, FLAT_MOTION], ..StageIo::of("taa") });
            stages.push(Taa::IO);
        } else {
            stages.push(StageIo { reads: &[FLAT_COLOR], ..StageIo::of("bloom and exposure") });
        }
        stages.extend(self.matte.as_ref().map(|_| Matte::IO));
        stages.extend(self.bloom.as_ref().map(|(mode, _)| Bloom::io(*mode)));
        stages.extend(self.bloom_mix.as_ref().map(|_| BloomMix::IO));
        stages.extend(self.fsr.as_ref().map(|_| Fsr::io(self.upscales_codes)));
        stages.extend(self.tone_map.as_ref().map(|_| self.picture_io()));
        stages
    }

    fn picture_io(&self) -> StageIo {
        use pt_shaders::channels::{DISPLAY, DISPLAY_HDR};
        let writes: &[ChannelId] = if self.picture == DISPLAY { &[DISPLAY] } else { &[DISPLAY_HDR] };
        StageIo { writes, ..StageIo::of("picture") }
    }

    /// Records the stages for one frame. `time_step`: seconds since the last frame, for eye adaptation; `None`: no adaptation.
    /// `jitter`: where in its pixels the frame was sampled, from the centre, pixels.
    ///
    /// # Errors
    /// When the passes do not fit into the frame, or a structural knob is not the one that the chain was made with.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        time_step: Option<f32>,
        jitter: [f32; 2],
        params: &PostParams,
    ) -> Result<()> {
        self.record_with(frame, inputs, time_step, jitter, params, |_, _| Ok(()))
    }

    /// As [`PostChain::record`]; `after` is called with what some stages wrote, so that it can be replaced.
    ///
    /// # Errors
    /// Those of `after`, else as [`PostChain::record`].
    pub fn record_with(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        time_step: Option<f32>,
        jitter: [f32; 2],
        params: &PostParams,
        after: impl Fn(&mut Frame<'_>, Written<'_>) -> Result<()>,
    ) -> Result<()> {
        let images = inputs.images;
        if let Some(accumulate) = &self.accumulate {
            accumulate.record(frame, inputs)?;
        }
        if let Some(taa) = &self.taa {
            let (color, motion) = (images.current(FLAT_COLOR), images.current(FLAT_MOTION));
            taa.record(frame, inputs, color, motion, jitter, &params.taa)?;
            after(frame, Written::Resolved(self.resolved(images)))?;
        }
        let source = self.resolved(images);
        if let Some(matte) = &self.matte {
            matte.record(frame, inputs, source, self.accumulate.is_some())?;
        }
        let bloomed = match &self.bloom {
            Some((_, bloom)) => bloom.record(frame, images, source, &params.bloom)?,
            None => Bloomed::from(self.matte(images).unwrap_or(source)),
        };
        if let Some(mix) = &self.bloom_mix {
            mix.record(frame, images, bloomed)?;
        }
        let Some(tone_map) = &self.tone_map else { return Ok(()) };
        let time_step = time_step.filter(|_| images.has_history());
        self.exposure.record(frame, source, time_step, params)?;
        after(frame, Written::Exposure(&self.exposure))?;
        let picture = images.current(self.picture);
        let Some(fsr) = &self.fsr else {
            return tone_map.record(frame, bloomed, &self.exposure, picture, params);
        };
        tone_map.record(frame, bloomed, &self.exposure, images.current(DISPLAY_CODES), params)?;
        fsr.record(frame, images, picture, params)
    }

    /// The frame as linear radiance before bloom and exposure: what TAA resolved, else the running mean, else the flat frame.
    pub fn resolved<'a>(&self, images: &'a ChannelImages) -> &'a Image {
        images.current(match (&self.taa, &self.accumulate) {
            (Some(_), _) => RESOLVED,
            (None, Some(_)) => ACCUMULATED,
            (None, None) => FLAT_COLOR,
        })
    }

    /// With a transparent background: straight radiance and alpha of [`PostChain::resolved`], which is premultiplied.
    pub fn matte<'a>(&self, images: &'a ChannelImages) -> Option<&'a Image> {
        self.matte.as_ref().map(|_| images.current(MATTE))
    }

    /// The last image before the tone map: [`PostChain::resolved`] with bloom, where no picture is made.
    pub fn radiance<'a>(&self, images: &'a ChannelImages) -> &'a Image {
        if self.bloom_mix.is_some() { images.current(BLOOMED) } else { self.resolved(images) }
    }

    /// Exposure, the eye's adaptation and the noise-aware curve.
    pub fn exposure(&self) -> &Exposure {
        &self.exposure
    }

    /// Buffers that carry state to the next frame, besides the images. A capture records them with the histories.
    pub fn state(&self) -> Vec<&Buffer> {
        if self.parts.picture { self.exposure.state().to_vec() } else { Vec::new() }
    }

    /// Which parts it was made with.
    pub fn parts(&self) -> ChainParts {
        self.parts
    }
}
