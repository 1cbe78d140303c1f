//! `gradient_pixels.comp`: the choice of gradient pixels.

use super::antilag::{GradientSample, pixel_of, strata, stratum_of};
use super::frame::{Guided, Light, cosine, luminance, usable};
use super::reflections::project;
use super::reprojection::{place_before, shows_surface};
use crate::DenoiseParams;
use pt_core::rng::pcg4d;
use pt_shaders::dimensions::DIM_GRADIENT;
use pt_shaders::glam::Vec3;
use pt_shaders::records::{CameraRecord, FLAG_PRIMARY};

/// A frame as the choice sees it.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Flat pixels.
    pub pixels: &'a [Guided],
    /// Their light.
    pub light: &'a [Light],
    /// Gradient pixels of the frame, of strata.
    pub samples: &'a [GradientSample],
    /// Lengths of the histories, frames.
    pub lengths: &'a [u32],
}

impl Seen<'_> {
    /// Whether a pixel may be taken again: it was no gradient pixel, and its history has a length that is worth it.
    fn may_repeat(&self, size: [u32; 2], side: u32, tap: usize) -> bool {
        let (stratum, number) = stratum_of(size, side, tap);
        self.samples[stratum].number != number + 1 && self.lengths[tap] >= 4
    }
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
        let was = &before.pixels[tap];
        if !before.may_repeat(size, side, tap)
            || !shows_surface(size, i, &pixels[i], place, was, 0.0, &params.temporal)
        {
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

/// What forward projection knows besides.
#[derive(Clone, Copy, Debug)]
pub struct Forward<'a> {
    /// Camera of this frame.
    pub camera: &'a CameraRecord,
    /// Where the surfaces of the last frame's flat pixels are now.
    pub positions: &'a [Vec3],
    /// Number of this frame, and the seed of the random numbers.
    pub frame: [u32; 2],
}

/// The gradient pixel of each stratum by forward projection, each candidate as likely as any: the first one, from a random stratum on, that lies in the stratum and is not hidden.
/// `pixels`: of this frame.
pub fn forward_candidates(
    size: [u32; 2],
    pixels: &[Guided],
    before: Seen<'_>,
    forward: &Forward<'_>,
    params: &DenoiseParams,
) -> Vec<GradientSample> {
    let side = params.antilag.stratum.side();
    let count = side * side;
    let [across, down] = strata(size, side);
    let [frame, seed] = forward.frame;
    let random = |stratum: usize| {
        let [x, y] = [stratum % across, stratum / across].map(|v| v as u32);
        pcg4d([x | y << 16, frame, DIM_GRADIENT, seed])[0]
    };
    // Number of the pixel of a stratum that shows what pixel `tap` of the last frame showed.
    let lands_in = |stratum: usize, tap: usize| {
        let was = &before.pixels[tap];
        if !before.may_repeat(size, side, tap) || was.material == 0 || was.flags != FLAG_PRIMARY {
            return None;
        }
        let position = forward.positions[tap].as_dvec3();
        let view = forward.camera.view_from_world.as_dmat4().transform_point3(position);
        let distance = view.length();
        let place = project(forward.camera, position);
        let at = [0, 1].map(|k| (place[k] * f64::from(size[k])).floor() as i64);
        let is_seen = view.z < 0.0 && (0..2).all(|k| (0..i64::from(size[k])).contains(&at[k]));
        let i = is_seen.then(|| at[1] as usize * size[0] as usize + at[0] as usize)?;
        let (in_stratum, number) = stratum_of(size, side, i);
        let now = &pixels[i];
        let tolerance =
            f64::from(params.temporal.depth) * distance + 2.0 / f64::from(now.motion[3]).max(1e-18);
        let shows_it = (now.material, now.flags) == (was.material, was.flags)
            && (f64::from(now.depth) - distance).abs() <= tolerance
            && cosine(now.vertex_normal, was.vertex_normal)
                >= f64::from(params.temporal.normal).to_radians().cos();
        (in_stratum == stratum && shows_it).then_some(number)
    };
    let sample = |stratum: usize| {
        let [x, y] = [stratum % across, stratum / across].map(|v| v as u32);
        let middle = [x * side + side / 2, y * side + side / 2];
        let middle = [0, 1].map(|k| middle[k].min(size[k] - 1) as usize);
        let i = middle[1] * size[0] as usize + middle[0];
        let place = place_before(size, i, &pixels[i])?.map(|v| (v + 0.5).floor() as i64);
        // Division towards zero, as the kernel's.
        let was = place.map(|v| v / i64::from(side));
        let first = random(stratum) % 9;
        (0..9).find_map(|k| {
            let k = i64::from((k + first) % 9);
            let other = [was[0] + k % 3 - 1, was[1] + k / 3 - 1];
            let inside = (0..across as i64).contains(&other[0]) && (0..down as i64).contains(&other[1]);
            let other = inside.then(|| other[1] as usize * across + other[0] as usize)?;
            let tap = pixel_of(size, side, other, (random(other) % count) as usize)?;
            let number = lands_in(stratum, tap)?;
            let [hf, spec] = usable(&before.pixels[tap], &before.light[tap])?.map(luminance);
            Some(GradientSample { number: number + 1, luminance: [hf as f32, spec as f32] })
        })
    };
    (0..across * down).map(|stratum| sample(stratum).unwrap_or_default()).collect()
}
