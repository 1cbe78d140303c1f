//! `temporal_lf.comp`, `lf_downsample.comp`, `lf_deflicker.comp`, `lf_atrous.comp` and `lf_upsample.comp`.

use super::antilag::{Adaptive, kept_frames};
use super::frame::{Guided, cosine, depth_weight, mean_without_brightest, neighbour, same_path};
use super::reprojection::taps;
use crate::{LfParams, TemporalParams};
use pt_core::pack::unpack_unit_vector;

/// Coefficients of indirect diffuse light: x, y, z and w of `color_lf_sh`, x and y of `color_lf_cocg`.
pub type LowFrequency = [f64; 6];

/// What a pixel carries to the next frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LfHistory {
    /// The pixel that it belongs to.
    pub pixel: Guided,
    /// Light.
    pub light: LowFrequency,
    /// Mean of its squared luma.
    pub second: f64,
    /// Frames; 0 = none.
    pub length: u32,
}

/// Limit of luma whose sums fp32 holds.
const MAX_LUMA: f64 = 1e15;

pub(super) fn is_light(light: &LowFrequency) -> bool {
    light.iter().all(|v| v.is_finite())
        && light[3] >= 0.0
        && light[..4].iter().all(|v| v.abs() <= MAX_LUMA)
        && light[4..].iter().all(|v| v.abs() <= 8.0 * MAX_LUMA)
}

/// `sum += weight * light`
fn add(sum: &mut LowFrequency, light: &LowFrequency, weight: f64) {
    sum.iter_mut().zip(light).for_each(|(sum, v)| *sum += weight * v);
}

fn scaled(light: LowFrequency, factor: f64) -> LowFrequency {
    light.map(|v| v * factor)
}

/// Accumulates a frame of flat pixels into the histories of the frame before; `None`: there is none. `adaptive`: of `asvgf`.
pub fn accumulate_lf(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[LowFrequency],
    previous: Option<&[LfHistory]>,
    params: &TemporalParams,
    adaptive: Option<Adaptive<'_>>,
) -> Vec<LfHistory> {
    let one = |i: usize| {
        let pixel = pixels[i];
        let mut now = LfHistory { pixel, ..LfHistory::default() };
        if let Some(previous) = previous {
            let was = |j: usize| &previous[j].pixel;
            let taps: Vec<_> = taps(size, i, &pixel, &was, params)
                .into_iter()
                .filter(|&(_, j)| previous[j].length > 0)
                .collect();
            let total: f64 = taps.iter().map(|(w, _)| w).sum();
            if total > 0.0 {
                taps.iter().for_each(|&(w, j)| add(&mut now.light, &previous[j].light, w / total));
                now.second = taps.iter().map(|&(w, j)| w * previous[j].second).sum::<f64>() / total;
                let length: f64 = taps.iter().map(|&(w, j)| w * f64::from(previous[j].length)).sum();
                now.length = ((length / total).round() as u32).max(1);
            }
        }
        let (mut lag, mut repeated) = (0.0, false);
        if let Some(adaptive) = adaptive {
            let is_repeated;
            (lag, is_repeated) = adaptive.indirect(size, i);
            repeated = is_repeated && now.length > 0;
            now.length = kept_frames(now.length, lag);
            if repeated && now.length == 0 {
                return now;
            }
        }
        if pixel.material != 0 && is_light(&light[i]) {
            let sample = params.firefly_lf.map_or(light[i], |firefly| {
                let around: Vec<f64> = (0..9)
                    .filter(|k| *k != 4)
                    .filter_map(|k| neighbour(size, i, [k % 3 - 1, k / 3 - 1]))
                    .filter(|j| pixels[*j].material != 0 && is_light(&light[*j]))
                    .map(|j| light[j][3])
                    .collect();
                let limit = f64::from(firefly) * mean_without_brightest(&around).max(now.light[3]);
                let bright = limit > 0.0 && light[i][3] > limit;
                if bright { scaled(light[i], limit / light[i][3]) } else { light[i] }
            });
            let mut weight = 0.0;
            if !repeated {
                now.length = (now.length + 1).min(crate::histories::MAX_LENGTH);
                weight = (1.0 / f64::from(now.length)).max(f64::from(params.alpha_lf));
            }
            weight += (1.0 - weight) * f64::from(lag);
            let before = scaled(now.light, 1.0 - weight);
            now.light = before;
            add(&mut now.light, &sample, weight);
            now.second += (sample[3].powi(2) - now.second) * weight;
        }
        now
    };
    (0..pixels.len()).map(one).collect()
}

/// A third of the resolution: index of the pixel that a tile stands for, and its light.
pub type Tile = Option<(usize, LowFrequency)>;

fn tile_counts(size: [u32; 2]) -> [usize; 2] {
    size.map(|side| side.div_ceil(3) as usize)
}

/// Place of a pixel.
fn place(size: [u32; 2], i: usize) -> [i64; 2] {
    [(i % size[0] as usize) as i64, (i / size[0] as usize) as i64]
}

fn weight(size: [u32; 2], pixels: &[Guided], i: usize, j: usize, params: &LfParams) -> f64 {
    let (p, q) = (&pixels[i], &pixels[j]);
    let [a, b] = [i, j].map(|k| place(size, k));
    let offset = [b[0] - a[0], b[1] - a[1]];
    if p.vertex_normal == 0 || q.vertex_normal == 0 || !same_path(p, q, offset) {
        return 0.0;
    }
    let distance = (offset[0] as f64).hypot(offset[1] as f64).max(1.0);
    let cosine = cosine(p.vertex_normal, q.vertex_normal).clamp(0.0, 1.0);
    depth_weight(p, q, distance, params.depth.into()) * cosine.powf(params.normal.into())
}

/// Light of pixel j as pixel i has it: its directions keep their angles with the vertex normal.
fn turned(mut light: LowFrequency, pixels: &[Guided], j: usize, i: usize) -> LowFrequency {
    let [from, to] = [j, i].map(|k| unpack_unit_vector(pixels[k].vertex_normal).as_dvec3());
    if i != j {
        let mut v = to;
        [v.x, v.y, v.z] = [light[0], light[1], light[2]];
        let (axis, cosine) = (from.cross(to), from.dot(to));
        let v = cosine * v + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine.max(0.0)));
        light[..3].copy_from_slice(&v.to_array());
    }
    light
}

/// Means over tiles of 3 x 3 pixels; `None` in `light`: there is none.
pub fn downsample(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Option<LowFrequency>],
    params: &LfParams,
) -> Vec<Tile> {
    let [across, down] = tile_counts(size);
    let tile = |t: usize| {
        let pixel = |number: usize| {
            let at = [3 * (t % across) + number % 3, 3 * (t / across) + number / 3];
            let i = at[1] * size[0] as usize + at[0];
            let inside = at[0] < size[0] as usize && at[1] < size[1] as usize;
            (inside && pixels[i].vertex_normal != 0 && light[i].is_some_and(|l| is_light(&l))).then_some(i)
        };
        let anchor = (0..9).find_map(|k| pixel((k + 4) % 9))?;
        let (mut sum, mut total) = ([0.0; 6], 0.0);
        for i in (0..9).filter_map(pixel) {
            let w = if i == anchor { 1.0 } else { weight(size, pixels, anchor, i, params) };
            add(&mut sum, &turned(light[i].unwrap_or_default(), pixels, i, anchor), w);
            total += w;
        }
        Some((anchor, scaled(sum, 1.0 / total)))
    };
    (0..across * down).map(tile).collect()
}

/// Tiles whose luma is limited to a multiple of the mean of those around.
pub fn deflicker(size: [u32; 2], tiles: &[Tile], limit: f64) -> Vec<Tile> {
    let [across, down] = tile_counts(size).map(|n| n as i64);
    let one = |t: usize| {
        let (anchor, own) = tiles[t]?;
        let around: Vec<f64> = (0..9)
            .filter(|k| *k != 4)
            .filter_map(|k| {
                let at = [t as i64 % across + k % 3 - 1, t as i64 / across + k / 3 - 1];
                let inside = (0..across).contains(&at[0]) && (0..down).contains(&at[1]);
                inside.then(|| tiles[(at[1] * across + at[0]) as usize].map(|(_, light)| light[3]))?
            })
            .collect();
        let mean = around.iter().sum::<f64>() / around.len().max(1) as f64;
        let bright = !around.is_empty() && own[3] > limit * mean;
        Some((anchor, if bright { scaled(own, limit * mean / own[3]) } else { own }))
    };
    (0..tiles.len()).map(one).collect()
}

/// Weight of a pair of which one is far brighter.
fn leak_guard(p: f64, q: f64) -> f64 {
    if p.max(q) > 0.0 { (1.5 - 0.25 * p.max(q) / p.min(q).max(1e-20)).clamp(0.0, 1.0) } else { 1.0 }
}

/// One level of the filter over tiles.
pub fn atrous_lf(
    size: [u32; 2],
    pixels: &[Guided],
    tiles: &[Tile],
    level: u32,
    params: &LfParams,
) -> Vec<Tile> {
    let [across, down] = tile_counts(size);
    let filtered = |t: usize| {
        let (anchor, own) = tiles[t]?;
        let mut sum = own;
        for [x, y] in (0..9).map(|k| [k % 3 - 1, k / 3 - 1]) {
            let at = [(t % across) as i64 + (x << level), (t / across) as i64 + (y << level)];
            if [x, y] == [0, 0] || !(0..across as i64).contains(&at[0]) || !(0..down as i64).contains(&at[1])
            {
                continue;
            }
            let Some((other, light)) = tiles[at[1] as usize * across + at[0] as usize] else { continue };
            let kernel = 0.25 / f64::from(1 << (x.abs() + y.abs()));
            let mut w = kernel * weight(size, pixels, anchor, other, params);
            if params.leak_guard && level + 1 == params.iterations {
                w *= leak_guard(own[3], light[3]);
            }
            add(&mut sum, &turned(light, pixels, other, anchor), w);
            add(&mut sum, &own, -w);
        }
        Some((anchor, sum))
    };
    (0..tiles.len()).map(filtered).collect()
}

/// From tiles to all pixels; `own`: what a pixel keeps that resembles none of the tiles around it.
pub fn upsample(
    size: [u32; 2],
    pixels: &[Guided],
    tiles: &[Tile],
    own: &[Option<LowFrequency>],
    params: &LfParams,
) -> Vec<LowFrequency> {
    let [across, down] = tile_counts(size);
    let one = |i: usize| {
        let at = place(size, i).map(|v| (v as f64 - 1.0) / 3.0);
        let (mut sum, mut total) = ([0.0; 6], 0.0);
        for [x, y] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let corner = at.map(f64::floor);
            let f = [at[0] - corner[0], at[1] - corner[1]];
            let tile = [
                (corner[0] as i64 + x).clamp(0, across as i64 - 1),
                (corner[1] as i64 + y).clamp(0, down as i64 - 1),
            ];
            let Some((anchor, light)) = tiles[tile[1] as usize * across + tile[0] as usize] else { continue };
            let bilinear: f64 =
                [x, y].iter().zip(f).map(|(o, f)| if *o == 1 { f } else { 1.0 - f }).product();
            let w = bilinear * weight(size, pixels, i, anchor, params);
            if w > 0.0 {
                add(&mut sum, &turned(light, pixels, anchor, i), w);
            }
            total += w;
        }
        if total > 1e-4 {
            return scaled(sum, 1.0 / total);
        }
        own[i].filter(|l| is_light(l) && pixels[i].vertex_normal != 0).unwrap_or_default()
    };
    (0..pixels.len()).map(one).collect()
}
