//! `gradient_pixels.comp`, backward projection: the choice of gradient pixels.

use super::frame::{Guided, Light, luminance, usable};
use super::gradients::{GradientSample, pixel_of, strata, stratum_of};
use super::temporal::{place_before, shows_surface};
use crate::DenoiseParams;

/// A frame as the choice sees it.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Flat pixels.
    pub pixels: &'a [Guided],
    /// Their light.
    pub light: &'a [Light],
    /// Gradient pixels of the frame, of strata.
    pub samples: &'a [GradientSample],
}

/// The brightest candidate of each stratum in the last frame, and how much brighter it is than the next one. `pixels`: of this frame.
pub fn brightest_candidates(
    size: [u32; 2],
    pixels: &[Guided],
    before: Seen<'_>,
    params: &DenoiseParams,
) -> Vec<(GradientSample, f64)> {
    let side = params.antilag.stratum.side();
    let [across, down] = strata(size, side);
    let candidate = |stratum: usize, number: usize| {
        let i = pixel_of(size, side, stratum, number)?;
        let place = place_before(size, i, &pixels[i])?.map(|v| (v + 0.5).floor() as i64);
        let inside = (0..2).all(|k| (0..i64::from(size[k])).contains(&place[k]));
        let tap = inside.then(|| (place[1] * i64::from(size[0]) + place[0]) as usize)?;
        let (was_stratum, was_number) = stratum_of(size, side, tap);
        let is_old = before.samples[was_stratum].number == was_number + 1;
        if is_old || !shows_surface(size, i, &pixels[i], place, &before.pixels[tap], 0.0, &params.temporal) {
            return None;
        }
        let [hf, spec] = usable(&before.pixels[tap], &before.light[tap])?.map(luminance);
        let sample = GradientSample { number: number as u32 + 1, luminance: [hf as f32, spec as f32] };
        Some((hf + spec, sample))
    };
    let brightest = |stratum: usize| {
        let mut all: Vec<_> =
            (0..(side * side) as usize).filter_map(|number| candidate(stratum, number)).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        match all.as_slice() {
            [] => (GradientSample::default(), f64::INFINITY),
            [(_, only)] => (*only, f64::INFINITY),
            [(best, sample), (next, _), ..] => (*sample, best - next),
        }
    };
    (0..across * down).map(brightest).collect()
}
