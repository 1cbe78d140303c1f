//! Bloom: the light that a lens scatters.

use crate::kernels;
use crate::records::{BLUR_MAX_RADIUS, BLUR_OUTPUTS, BlurPush, MixPush};
use pt_core::settings::{InvalidValue, Validate, check_range};
use pt_core::{Device, Frame, Image, Kernel, Result};
use pt_shaders::channels::Format;
use serde::{Deserialize, Serialize};

/// How the light is spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BloomMode {
    /// No bloom.
    Off,
    /// One Gaussian, at a quarter of the resolution.
    Gaussian,
    /// A chain of ever smaller images (dual filter): narrow core, wide tail.
    Chain,
}

/// Knobs of the bloom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BloomParams {
    /// `off`, `gaussian` or `chain`. Default `off`.
    pub mode: BloomMode,
    /// Share of the light that spreads, 0 to 1. Default 0.002.
    pub intensity: f32,
    /// Gaussian: standard deviation in heights of the image, 0 to 0.5. Default 0.037.
    pub sigma: f32,
    /// Chain: number of halvings, 1 to 10; fewer for small images. Default 6.
    pub levels: u32,
    /// Chain: share that each level takes from the next smaller one, 0 to 1: greater is wider. Default 0.7.
    pub spread: f32,
}

impl Default for BloomParams {
    fn default() -> Self {
        Self { mode: BloomMode::Off, intensity: 0.002, sigma: 0.037, levels: 6, spread: 0.7 }
    }
}

impl Validate for BloomParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        check_range("intensity", self.intensity, 0.0..=1.0, "")?;
        check_range("sigma", self.sigma, 0.0..=0.5, "heights")?;
        check_range("levels", self.levels, 1..=MAX_LEVELS, "")?;
        check_range("spread", self.spread, 0.0..=1.0, "")
    }
}

/// Largest [`BloomParams::levels`].
pub const MAX_LEVELS: u32 = 10;

/// Standard deviation in texels of the quarter-resolution image, 1 to 100, for a frame of `height`.
pub(crate) fn quarter_sigma(sigma: f32, height: u32) -> f32 {
    (sigma * 0.25 * height as f32).clamp(1.0, 100.0)
}

/// Taps on either side: out to four standard deviations.
pub(crate) fn radius(sigma: f32) -> u32 {
    ((4.0 * sigma).ceil() as u32).min(BLUR_MAX_RADIUS)
}

/// Sizes of the chain's images for a frame of `size`: each half of the last, until nothing is left to halve.
pub(crate) fn chain_sizes(size: [u32; 2], levels: u32) -> Vec<[u32; 2]> {
    let mut sizes = Vec::new();
    let mut last = size;
    while (sizes.len() as u32) < levels.min(MAX_LEVELS) && (sizes.is_empty() || last[0].max(last[1]) > 1) {
        last = last.map(|side| side.div_ceil(2));
        sizes.push(last);
    }
    sizes
}

/// A frame and the bloom that is to be mixed into it: `mix(radiance, glow, share)`. What reads it mixes by itself, so that the
/// sum need not go through memory; [`BloomMix`] makes an image of it.
#[derive(Clone, Copy)]
pub struct Bloomed<'a> {
    /// Linear radiance without bloom.
    pub radiance: &'a Image,
    /// The blurred frame, of any size.
    pub glow: &'a Image,
    /// Share of the light that is spread, 0 (no bloom) to 1.
    pub share: f32,
}

impl<'a> From<&'a Image> for Bloomed<'a> {
    /// Without bloom.
    fn from(radiance: &'a Image) -> Self {
        Self { radiance, glow: radiance, share: 0.0 }
    }
}

/// Spreads a share of the light of every pixel over its surroundings. Weights sum to 1: away from the border the sum over the
/// image stays what it was.
pub struct Bloom {
    quarter_kernel: Kernel,
    blur_kernel: Kernel,
    down_kernel: Kernel,
    up_kernel: Kernel,
    /// Quarter-resolution image and the one between the blurs.
    quarter: [Image; 2],
    chain: Vec<Image>,
    height: u32,
}

impl Bloom {
    /// Creates kernels and images for frames of `size`.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        let image = |name: &str, size| Image::new(device, name, Format::Rgba16F, size);
        let quarter = size.map(|side| side.div_ceil(4));
        let chain: Result<Vec<_>> = (1..)
            .zip(chain_sizes(size, MAX_LEVELS))
            .map(|(level, size)| image(&format!("bloom_{level}"), size))
            .collect();
        Ok(Self {
            quarter_kernel: Kernel::compute::<()>(device, &kernels::BLOOM_QUARTER, &[])?,
            blur_kernel: Kernel::compute::<BlurPush>(device, &kernels::BLOOM_BLUR, &[])?,
            down_kernel: Kernel::compute::<()>(device, &kernels::BLOOM_DOWN, &[])?,
            up_kernel: Kernel::compute::<MixPush>(device, &kernels::BLOOM_UP, &[])?,
            quarter: [image("bloom_quarter", quarter)?, image("bloom_blur", quarter)?],
            chain: chain?,
            height: size[1],
        })
    }

    /// Adds its passes to the frame and returns `source` with what they make of it.
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame<'_>,
        source: &'a Image,
        params: &BloomParams,
    ) -> Result<Bloomed<'a>> {
        let glow = match params.mode {
            BloomMode::Off => return Ok(source.into()),
            BloomMode::Gaussian => self.gaussian(frame, source, params)?,
            BloomMode::Chain => self.chain(frame, source, params)?,
        };
        Ok(Bloomed { radiance: source, glow, share: params.intensity })
    }

    fn gaussian(&self, frame: &mut Frame<'_>, source: &Image, params: &BloomParams) -> Result<&Image> {
        let [quarter, between] = &self.quarter;
        frame
            .pass("bloom quarter", &self.quarter_kernel)
            .sample("source", source)
            .write("target", quarter)
            .dispatch(threads(quarter))?;
        let sigma = quarter_sigma(params.sigma, self.height);
        for (name, vertical, from, to) in
            [("bloom blur x", 0, quarter, between), ("bloom blur y", 1, between, quarter)]
        {
            let [along, across] = if vertical == 1 { [1, 0] } else { [0, 1] }.map(|axis| to.extent()[axis]);
            frame
                .pass(name, &self.blur_kernel)
                .sample("source", from)
                .write("target", to)
                .push(&BlurPush { vertical, sigma, radius: radius(sigma) })
                .dispatch([along.div_ceil(BLUR_OUTPUTS), across, 1])?;
        }
        Ok(quarter)
    }

    fn chain(&self, frame: &mut Frame<'_>, source: &Image, params: &BloomParams) -> Result<&Image> {
        let levels = &self.chain[..self.chain.len().min(params.levels as usize)];
        let mut from = source;
        for (number, level) in (1..).zip(levels) {
            frame
                .pass(&format!("bloom down {number}"), &self.down_kernel)
                .sample("source", from)
                .write("target", level)
                .dispatch(threads(level))?;
            from = level;
        }
        for (level, pair) in levels.windows(2).enumerate().rev() {
            frame
                .pass(&format!("bloom up {}", level + 1), &self.up_kernel)
                .sample("lower", &pair[1])
                .update("level", &pair[0])
                .push(&MixPush { share: params.spread })
                .dispatch(threads(&pair[0]))?;
        }
        Ok(&levels[0])
    }
}

/// A frame with its bloom as an image, for what cannot take [`Bloomed`].
pub struct BloomMix {
    kernel: Kernel,
    bloomed: Image,
}

impl BloomMix {
    /// Creates the kernel and the image for frames of `size`.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        Ok(Self {
            kernel: Kernel::compute::<MixPush>(device, &kernels::BLOOM_MIX, &[])?,
            bloomed: Image::new(device, "bloomed", Format::Rgba16F, size)?,
        })
    }

    /// Adds its pass to the frame.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(&self, frame: &mut Frame<'_>, source: Bloomed<'_>) -> Result<()> {
        frame
            .pass("bloom mix", &self.kernel)
            .sample("radiance", source.radiance)
            .sample("glow", source.glow)
            .write("target", &self.bloomed)
            .push(&MixPush { share: source.share })
            .dispatch(threads(&self.bloomed))
    }

    /// Where the result is.
    pub fn bloomed(&self) -> &Image {
        &self.bloomed
    }
}

fn threads(image: &Image) -> [u32; 3] {
    let [width, height] = image.extent();
    [width, height, 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_end_at_one_texel() {
        assert_eq!(chain_sizes([5, 3], 10), [[3, 2], [2, 1], [1, 1]]);
        assert_eq!(chain_sizes([1, 1], 10), [[1, 1]]);
        assert_eq!(chain_sizes([3840, 2160], 2), [[1920, 1080], [960, 540]]);
    }

    #[test]
    fn blur_follows_the_height() {
        assert!((quarter_sigma(0.037, 2160) - 19.98).abs() < 1e-4);
        assert_eq!(quarter_sigma(0.037, 10), 1.0);
        assert_eq!(quarter_sigma(0.5, 16384), 100.0);
        assert_eq!(radius(1.0), 4);
        assert_eq!(radius(1.1), 5);
        assert_eq!(radius(quarter_sigma(0.5, 16384)), BLUR_MAX_RADIUS);
    }
}
