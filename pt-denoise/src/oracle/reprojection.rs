//! `reprojection.glsl`: the pixels of the last frame that show the surface of a pixel.

use super::frame::{Guided, cosine};
use crate::TemporalParams;

/// Where the surface of a pixel was in the last frame, flat pixels, and its distance there.
pub(super) fn place_before(size: [u32; 2], i: usize, pixel: &Guided) -> Option<[f32; 2]> {
    let [mx, my, mz, _] = pixel.motion;
    let moves = pixel.material != 0 && mx.is_finite() && my.is_finite() && mz.is_finite();
    let own = [i % size[0] as usize, i / size[0] as usize];
    // In the precision of the kernel, which decides about pixels on a border.
    moves.then(|| [0, 1].map(|k| own[k] as f32 + [mx, my][k] * size[k] as f32))
}

/// Whether pixel `was`, at `at` in the last frame, shows the surface of pixel `i`; `more`: further tolerance of the distance.
pub(super) fn shows_surface(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    at: [i64; 2],
    was: &Guided,
    more: f32,
    params: &TemporalParams,
) -> bool {
    let own = [i % size[0] as usize, i / size[0] as usize];
    let depth = pixel.depth + pixel.motion[2];
    let tolerance = params.depth * depth.abs() + 2.0 / pixel.motion[3].max(1e-18) + more;
    let other_field = (at[0] + at[1] + own[0] as i64 + own[1] as i64) % 2 != 0;
    (was.material, was.flags) == (pixel.material, pixel.flags)
        && !(pixel.has_two_paths() && other_field)
        && (was.depth - depth).abs() <= tolerance
        && cosine(was.vertex_normal, pixel.vertex_normal) >= f64::from(params.normal).to_radians().cos()
}

/// The pixels of the last frame that show the surface of pixel `i`, with their bilinear weights. `previous`: pixels of the last frame.
pub(super) fn taps<'a>(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    previous: &dyn Fn(usize) -> &'a Guided,
    params: &TemporalParams,
) -> Vec<(f64, usize)> {
    let Some(place) = place_before(size, i, pixel) else { return Vec::new() };
    taps_at(size, i, pixel, place, 0.0, previous, params)
}

/// The same around another place; `more`: further tolerance of the distance, metres.
pub(super) fn taps_at<'a>(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    place: [f32; 2],
    more: f32,
    previous: &dyn Fn(usize) -> &'a Guided,
    params: &TemporalParams,
) -> Vec<(f64, usize)> {
    let corner = place.map(f32::floor);
    let f = [0, 1].map(|k| place[k] - corner[k]);
    let mut found = Vec::new();
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let weight = (if dx == 1 { f[0] } else { 1.0 - f[0] }) * (if dy == 1 { f[1] } else { 1.0 - f[1] });
        let at = [corner[0] as i64 + dx, corner[1] as i64 + dy];
        if f64::from(weight) < 1e-3 || !(0..2).all(|k| (0..i64::from(size[k])).contains(&at[k])) {
            continue;
        }
        let tap = (at[1] * i64::from(size[0]) + at[0]) as usize;
        if shows_surface(size, i, pixel, at, previous(tap), more, params) {
            found.push((f64::from(weight), tap));
        }
    }
    found
}
