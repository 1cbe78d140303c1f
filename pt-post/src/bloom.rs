//! Bloom: the light that a lens scatters.

use crate::images::{
    BLOOM_1, BLOOM_2, BLOOM_3, BLOOM_4, BLOOM_5, BLOOM_6, BLOOM_7, BLOOM_8, BLOOM_9, BLOOM_10, BLOOM_BLUR,
    BLOOM_QUARTER, BLOOMED,
};
use crate::kernels;
use crate::records::{BLUR_MAX_RADIUS, BLUR_OUTPUTS, BlurPush, MixPush};
use pt_core::{ChannelImages, Device, Frame, Image, Kernel, Result, StageIo, knobs};
use pt_shaders::channels::ChannelId;
use pt_shaders::named_enum;

named_enum! {
    /// How the light is spread.
    pub enum BloomMode {
        /// No bloom.
        Off = "off",
        /// One Gaussian, at a quarter of the resolution.
        Gaussian = "gaussian",
        /// A chain of ever smaller images (dual filter): narrow core, wide tail.
        Chain = "chain",
    }
}

knobs! {
    /// Knobs of the bloom.
    pub struct BloomParams {
        /// How the light is spread.
        pub mode: BloomMode = BloomMode::Off => structural;
        /// Share of the light that spreads.
        pub intensity: f32 = 0.002, in 0.0..=1.0;
        /// Gaussian: standard deviation in heights of the image.
        pub sigma: f32 = 0.037, in 0.0..=0.5, unit "heights";
        /// Chain: number of halvings; fewer for small images.
        pub levels: u32 = 6, in 1..=MAX_LEVELS, source "Bjorge 2015";
        /// Chain: share that each level takes from the next smaller one; greater is wider.
        pub spread: f32 = 0.7, in 0.0..=1.0, source "Bjorge 2015";
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

/// Levels of the chain, each half as large as the one before.
const CHAIN: [ChannelId; MAX_LEVELS as usize] =
    [BLOOM_1, BLOOM_2, BLOOM_3, BLOOM_4, BLOOM_5, BLOOM_6, BLOOM_7, BLOOM_8, BLOOM_9, BLOOM_10];

/// Spreads a share of the light of every pixel over its surroundings. Weights sum to 1, so that the sum over the image is preserved
/// away from the border.
pub struct Bloom {
    quarter_kernel: Kernel,
    blur_kernel: Kernel,
    down_kernel: Kernel,
    up_kernel: Kernel,
}

impl Bloom {
    /// The images that it accesses besides its source, for the largest number of levels.
    pub fn io(mode: BloomMode) -> StageIo {
        let writes: &[ChannelId] = match mode {
            BloomMode::Off => &[],
            BloomMode::Gaussian => &[BLOOM_QUARTER, BLOOM_BLUR],
            BloomMode::Chain => const { &CHAIN },
        };
        StageIo { writes, ..StageIo::of("bloom") }
    }

    /// Creates the kernels.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            quarter_kernel: Kernel::compute::<()>(device, &kernels::BLOOM_QUARTER, &[])?,
            blur_kernel: Kernel::compute::<BlurPush>(device, &kernels::BLOOM_BLUR, &[])?,
            down_kernel: Kernel::compute::<()>(device, &kernels::BLOOM_DOWN, &[])?,
            up_kernel: Kernel::compute::<MixPush>(device, &kernels::BLOOM_UP, &[])?,
        })
    }

    /// Adds its passes to the frame. Returns `source`, which has the resolved size, together with its bloom.
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        images: &'a ChannelImages,
        source: &'a Image,
        params: &BloomParams,
    ) -> Result<Bloomed<'a>> {
        let glow = match params.mode {
            BloomMode::Off => return Ok(source.into()),
            BloomMode::Gaussian => self.gaussian(frame, images, source, params)?,
            BloomMode::Chain => self.chain(frame, images, source, params)?,
        };
        Ok(Bloomed { radiance: source, glow, share: params.intensity })
    }

    fn gaussian<'a>(
        &self,
        frame: &mut Frame<'_>,
        images: &'a ChannelImages,
        source: &Image,
        params: &BloomParams,
    ) -> Result<&'a Image> {
        let [quarter, between] = [BLOOM_QUARTER, BLOOM_BLUR].map(|id| images.current(id));
        frame
            .pass("bloom quarter", &self.quarter_kernel)
            .sample("source", source)
            .write("target", quarter)
            .dispatch(threads(quarter))?;
        let sigma = quarter_sigma(params.sigma, source.extent()[1]);
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

    fn chain<'a>(
        &self,
        frame: &mut Frame<'_>,
        images: &'a ChannelImages,
        source: &Image,
        params: &BloomParams,
    ) -> Result<&'a Image> {
        let count = chain_sizes(source.extent(), params.levels).len();
        let level = |index: usize| images.current(CHAIN[index]);
        let mut from = source;
        for index in 0..count {
            let level = level(index);
            frame
                .pass(&format!("bloom down {}", index + 1), &self.down_kernel)
                .sample("source", from)
                .write("target", level)
                .dispatch(threads(level))?;
            from = level;
        }
        for index in (0..count - 1).rev() {
            frame
                .pass(&format!("bloom up {}", index + 1), &self.up_kernel)
                .sample("lower", level(index + 1))
                .update("level", level(index))
                .push(&MixPush { share: params.spread })
                .dispatch(threads(level(index)))?;
        }
        Ok(level(0))
    }
}

/// Writes a frame with its bloom to an image, for consumers that cannot take [`Bloomed`].
pub struct BloomMix {
    kernel: Kernel,
}

impl BloomMix {
    /// The images that it accesses besides its source.
    pub const IO: StageIo = StageIo { writes: &[BLOOMED], ..StageIo::of("bloom mix") };

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self { kernel: Kernel::compute::<MixPush>(device, &kernels::BLOOM_MIX, &[])? })
    }

    /// Adds its pass to the frame.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(&self, frame: &mut Frame<'_>, images: &ChannelImages, source: Bloomed<'_>) -> Result<()> {
        let target = images.current(BLOOMED);
        frame
            .pass("bloom mix", &self.kernel)
            .sample("radiance", source.radiance)
            .sample("glow", source.glow)
            .write("target", target)
            .push(&MixPush { share: source.share })
            .dispatch(threads(target))
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
