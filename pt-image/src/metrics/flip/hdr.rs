//! HDR FLIP: the largest LDR FLIP over all exposures at which the reference may be looked at.

use rayon::prelude::*;

use super::{LdrFlip, PIXELS_PER_DEGREE};

/// Smallest median luminance that sets an exposure (2^-23, as in the authors' tool): a reference that is black in most
/// places would otherwise ask for infinite exposure.
pub const EXPOSURE_LUMINANCE_FLOOR: f64 = f32::EPSILON as f64;

/// Display value to which the brightest (first exposure) and the median luminance (last exposure) are brought: t of FLIP
/// 2021, section 3.1.
const EXPOSED_LEVEL: f64 = 0.85;

/// Coefficients of the tone mapper `(k0 x^2 + k1 x + k2) / (k3 x^2 + k4 x + k5)`: Narkowicz 2015, "ACES Filmic Tone Mapping
/// Curve", the default of FLIP 2021, whose input is scaled by 0.6 as that article proposes.
const TONE_MAPPER: [f64; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// The exposures at which the images are compared, in stops: an image is multiplied by two to this power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The darkest: brings the largest luminance of the reference to 0.85 of the display.
    pub start: f64,
    /// The brightest: brings the median luminance of the reference there.
    pub stop: f64,
    /// How many from start to stop, both included, at equal distances of about a stop; 2 or more.
    pub count: u32,
}

impl Exposures {
    /// The exposures that suit a reference (linear RGB, Rec. 709 primaries; negative values count as 0). Of an even number
    /// of pixels the median is the upper one of the middle two.
    ///
    /// # Panics
    /// Without pixels.
    pub fn of(reference: &[[f32; 3]]) -> Self {
        let mut luminances: Vec<f64> = reference.iter().map(luminance).collect();
        let middle = luminances.len() / 2;
        let (_, &mut median, above) = luminances.select_nth_unstable_by(middle, f64::total_cmp);
        let median = median.max(EXPOSURE_LUMINANCE_FLOOR);
        let largest = above.iter().copied().fold(median, f64::max);
        let exposed = tone_mapper_inverse(EXPOSED_LEVEL);
        let (start, stop) = ((exposed / largest).log2(), (exposed / median).log2());
        Self { start, stop, count: ((stop - start).ceil() as u32).max(2) }
    }

    /// All exposures, darkest first.
    pub fn stops(self) -> impl Iterator<Item = f64> {
        let step = (self.stop - self.start) / f64::from(self.count - 1);
        (0..self.count).map(move |index| self.start + f64::from(index) * step)
    }
}

/// What [`hdr_flip`] finds.
#[derive(Clone, Debug, PartialEq)]
pub struct HdrFlip {
    /// The exposures that were compared.
    pub exposures: Exposures,
    /// The largest LDR FLIP of each pixel, 0 to 1.
    pub map: Vec<f32>,
}

/// HDR FLIP of two images in rows of `width` pixels: finite linear RGB, negative values count as 0. Exposures are those of
/// the reference, so swapping the images may change the result.
///
/// # Panics
/// When the images differ in length, are no whole rows or empty.
pub fn hdr_flip(width: usize, reference: &[[f32; 3]], test: &[[f32; 3]]) -> HdrFlip {
    let exposures = Exposures::of(reference);
    let flip = LdrFlip::new(PIXELS_PER_DEGREE);
    let mut map = vec![0.0f32; reference.len()];
    for stop in exposures.stops() {
        let scale = stop.exp2();
        let displayed = flip.map(width, &displayed(reference, scale), &displayed(test, scale));
        map.par_iter_mut().zip(displayed).for_each(|(largest, value)| *largest = largest.max(value));
    }
    HdrFlip { exposures, map }
}

/// Linear values of the display: exposed, tone mapped, clamped.
fn displayed(pixels: &[[f32; 3]], scale: f64) -> Vec<[f32; 3]> {
    let display = |value: f32| tone_map(f64::from(value.max(0.0)) * scale).min(1.0) as f32;
    pixels.par_iter().map(|pixel| pixel.map(display)).collect()
}

fn tone_map(x: f64) -> f64 {
    let [k0, k1, k2, k3, k4, k5] = TONE_MAPPER;
    (k0 * x * x + k1 * x + k2) / (k3 * x * x + k4 * x + k5)
}

/// The x >= 0 that the tone mapper brings to `level`.
fn tone_mapper_inverse(level: f64) -> f64 {
    let [k0, k1, k2, k3, k4, k5] = TONE_MAPPER;
    let (a, b, c) = (k0 - level * k3, k1 - level * k4, k2 - level * k5);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// Rec. 709 weights, negative values as 0.
fn luminance(pixel: &[f32; 3]) -> f64 {
    let [r, g, b] = pixel.map(|value| f64::from(value.max(0.0)));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_the_tone_mapper() {
        for level in [1e-6, 0.18, EXPOSED_LEVEL, 0.999] {
            assert!((tone_map(tone_mapper_inverse(level)) - level).abs() < 1e-12);
        }
        // Root of (0.36 * 2.51 - 0.85 * 0.36 * 2.43) x^2 + (0.018 - 0.85 * 0.354) x - 0.119 = 0.16002 x^2 - 0.2829 x - 0.119.
        let root = (0.2829 + (0.2829f64 * 0.2829 + 4.0 * 0.16002 * 0.119).sqrt()) / 0.32004;
        assert!((tone_mapper_inverse(EXPOSED_LEVEL) - root).abs() < 1e-12, "{root}");
        assert!((root - 2.118_872).abs() < 1e-6);
    }
}
