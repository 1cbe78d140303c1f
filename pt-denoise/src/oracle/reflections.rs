//! `virtual_motion.glsl`: the history of specular light along the motion of mirror images.

use super::antilag::kept_frames;
use super::frame::{Guided, History, Rgb};
use super::reprojection::{place_before, taps, taps_at};
use crate::{SpecularMotion, TemporalParams};
use pt_shaders::glam::{DVec3, Vec3};
use pt_shaders::records::{CameraRecord, FLAG_PRIMARY, FrameRecord};

/// What says where mirror images are.
#[derive(Clone, Copy, Debug)]
pub struct Reflections<'a> {
    /// Cameras of both frames.
    pub frame: &'a FrameRecord,
    /// Positions of the surfaces, flat pixels.
    pub positions: &'a [Vec3],
    /// Hit distances of specular light; 0 = none.
    pub hits: &'a [f32],
    /// The same of the last frame.
    pub hits_before: &'a [f32],
}

/// Specular light that a pixel continues.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SpecularHistory {
    pub light: Rgb,
    pub moments: [f64; 2],
    pub length: u32,
}

/// Farther is infinitely far.
const FARTHEST_HIT: f32 = 1e6;
/// Greatest difference of hit distances along with the distance of the surface, of one image.
const HIT_TOLERANCE: f32 = 0.1;

/// Where a point is in the picture, UV.
pub(super) fn project(camera: &CameraRecord, position: DVec3) -> [f64; 2] {
    let view = camera.view_from_world.as_dmat4().transform_point3(position);
    let plane = [0, 1].map(|k| view[k] / -view.z / f64::from(camera.half_extent[k]));
    [0.5 + 0.5 * plane[0], 0.5 - 0.5 * plane[1]]
}

/// How much farther than its surface the mirror image of pixel `i` has moved, pixels.
fn parallax(size: [u32; 2], i: usize, pixel: &Guided, hit: f32, r: &Reflections<'_>) -> [f64; 2] {
    if pixel.flags != FLAG_PRIMARY || hit <= 0.0 || r.frame.camera.projection != 0 {
        return [0.0; 2];
    }
    let alpha = f64::from(pixel.roughness).powi(2);
    let share = (1.0 - alpha) * ((1.0 - alpha).sqrt() + alpha);
    let position = r.positions[i].as_dvec3();
    let eye = r.frame.camera.world_from_view.w_axis.truncate().as_dvec3();
    let image = position + (position - eye).normalize() * f64::from(hit.min(FARTHEST_HIT)) * share;
    let [a, b] = [image, position].map(|p| project(&r.frame.camera_prev, p));
    [0, 1].map(|k| (a[k] - b[k]) * f64::from(size[k]))
}

/// Its own hit distance or the least one around.
fn hit_distance(size: [u32; 2], i: usize, hits: &[f32]) -> f32 {
    let around = (0..9).filter_map(|k| super::frame::neighbour(size, i, [k % 3 - 1, k / 3 - 1]));
    let least = around.map(|j| hits[j]).filter(|h| *h > 0.0).fold(f32::INFINITY, f32::min);
    let found = if hits[i] > 0.0 { hits[i] } else { least };
    if found.is_finite() { found.min(FARTHEST_HIT) } else { 0.0 }
}

/// The history that pixel `i` continues.
pub(super) fn specular_history(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    previous: &[History],
    params: &TemporalParams,
    r: &Reflections<'_>,
) -> SpecularHistory {
    let was = |j: usize| &previous[j].pixel;
    let Some(place) = place_before(size, i, pixel) else { return SpecularHistory::default() };
    let hit = hit_distance(size, i, r.hits);
    let moved = parallax(size, i, pixel, hit, r);
    let of_surface = mean(previous, &taps(size, i, pixel, &was, params));
    let length = moved[0].hypot(moved[1]);
    if params.specular != SpecularMotion::Surface && length > 0.0 {
        let place = [0, 1].map(|k| place[k] + moved[k] as f32);
        let more = length as f32 / pixel.motion[3].max(1e-18);
        let mut found = taps_at(size, i, pixel, place, more, &was, params);
        let compare = params.specular == SpecularMotion::Better;
        if compare {
            found.retain(|&(_, j)| {
                let before = r.hits_before[j].min(FARTHEST_HIT);
                (before - hit).abs() <= HIT_TOLERANCE * (pixel.depth.abs() + before.min(hit))
            });
        }
        let of_image = mean(previous, &found);
        if of_image.length > 0 || !compare {
            return of_image;
        }
    }
    let turned = params.parallax.map_or(0.0, |lobes| {
        let lobe = f64::from(lobes) * f64::from(pixel.roughness).powi(2).max(1e-4);
        (length * f64::from(pixel.pixel_angle) / lobe).clamp(0.0, 1.0)
    });
    SpecularHistory { length: kept_frames(of_surface.length, turned as f32), ..of_surface }
}

fn mean(previous: &[History], taps: &[(f64, usize)]) -> SpecularHistory {
    let known: Vec<_> = taps.iter().filter(|(_, j)| previous[*j].spec_length > 0).collect();
    let total: f64 = known.iter().map(|(w, _)| w).sum();
    if total == 0.0 {
        return SpecularHistory::default();
    }
    let of = |value: &dyn Fn(&History) -> f64| {
        known.iter().map(|(w, j)| w * value(&previous[*j])).sum::<f64>() / total
    };
    SpecularHistory {
        light: [0, 1, 2].map(|k| of(&|h| h.spec[k])),
        moments: [2, 3].map(|k| of(&|h| h.moments[k])),
        length: (of(&|h| h.spec_length.into()).round() as u32).max(1),
    }
}
