//! `recurrent_preblur.comp`, `recurrent_blur.comp` and `history_fix.comp`.

use super::frame::{Guided, Rgb, cosine, depth_weight, neighbour, same_path};
use crate::DenoiseParams;

/// Light of both channels, diffuse and specular, with its hit distances; `None`: missing.
pub type Lit = [Option<(Rgb, f64)>; 2];

const GOLDEN_ANGLE: f64 = 2.399_963_23;

/// Weights of a tap in diffuse and in specular light, of the surfaces alone.
fn surface_weights(p: &Guided, q: &Guided, pixels: f64, params: &DenoiseParams) -> [f64; 2] {
    let knobs = &params.atrous;
    let depth = depth_weight(p, q, pixels.max(1.0), knobs.depth.into());
    let cosine = cosine(p.normal, q.normal).clamp(0.0, 1.0);
    let [rough_p, rough_q] = [p.roughness, q.roughness].map(f64::from);
    let alpha = rough_p.min(rough_q).powi(2).max(1e-4);
    let power = (8.0 / (f64::from(knobs.lobe) * alpha).powi(2)).clamp(knobs.normal.into(), 1e4);
    let alike = (1.0 - 10.0 * (rough_p - rough_q).abs()).max(0.0);
    [depth * cosine.powf(knobs.normal.into()), depth * alike * cosine.powf(power)]
}

/// Weighted mean; the pixel keeps its own hit distance.
fn mean(taps: &[(f64, (Rgb, f64))], own: Option<(Rgb, f64)>) -> Option<(Rgb, f64)> {
    let total: f64 = taps.iter().map(|(w, _)| w).sum();
    if total <= 1e-12 {
        return own;
    }
    let of = |value: &dyn Fn(&(Rgb, f64)) -> f64| {
        taps.iter().map(|(w, light)| w * value(light)).sum::<f64>() / total
    };
    Some(([0, 1, 2].map(|k| of(&|l| l.0[k])), own.map_or(of(&|l| l.1), |own| own.1)))
}

/// A blur of `radius` pixels; `frames`: lengths of the histories of both channels, `None` for light without.
pub fn blur(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Lit],
    frames: Option<&[[u32; 2]]>,
    radius: f32,
    params: &DenoiseParams,
) -> Vec<Lit> {
    let one = |i: usize| {
        let (p, own) = (&pixels[i], &light[i]);
        if p.normal == 0 {
            return *own;
        }
        let [x, y] = [i % size[0] as usize, i / size[0] as usize];
        let turn = frames.map_or(0, |frames| frames[i][0] & 63);
        let start = GOLDEN_ANGLE * (((x & 3) * 5 + (y & 3) * 7) as u32 % 16 + turn) as f64;
        [0, 1].map(|c| {
            let n = f64::from(frames.map_or(1, |frames| frames[i][c]).max(1));
            let share = match own[c] {
                Some((_, hit)) if hit > 0.0 => hit / (hit + f64::from(p.depth.abs()).max(1e-6)),
                _ => 1.0,
            };
            let mut radius = f64::from(radius) / n.sqrt() * share;
            if c == 1 {
                let lobe = f64::from(params.atrous.lobe) * f64::from(p.roughness).powi(2);
                radius = radius.min(lobe * share / f64::from(p.pixel_angle).max(1e-6));
            }
            let mut taps: Vec<_> = own[c].iter().map(|light| (1.0, *light)).collect();
            for k in 0..8 {
                let out = (f64::from(k) + 0.5) / 8.0;
                let angle = start + GOLDEN_ANGLE * f64::from(k);
                let offset = [angle.cos(), angle.sin()].map(|v| (out.sqrt() * v * radius).round() as i64);
                let Some(j) = neighbour(size, i, offset).filter(|_| offset != [0, 0]) else { continue };
                let q = &pixels[j];
                if q.normal == 0 || !same_path(p, q, offset) {
                    continue;
                }
                let distance = (offset[0] as f64).hypot(offset[1] as f64);
                let w = (-2.0 * out).exp() * surface_weights(p, q, distance, params)[c];
                taps.extend(light[j][c].map(|light| (w, light)));
            }
            mean(&taps, own[c])
        })
    };
    (0..pixels.len()).map(one).collect()
}

/// Short histories replaced by wide means.
pub fn fix_history(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Lit],
    frames: &[[u32; 2]],
    params: &DenoiseParams,
) -> Vec<Lit> {
    const KERNEL: [f64; 3] = [0.375, 0.25, 0.0625];
    let one = |i: usize| {
        let (p, own) = (&pixels[i], &light[i]);
        let lack = 1.0 - frames[i][0] as f32 / params.recurrent.fix_frames as f32;
        let step = (0.5 * params.recurrent.fix_radius * lack).ceil() as i64;
        if p.normal == 0 || step < 1 {
            return *own;
        }
        let reach = f64::from(params.atrous.lobe) * f64::from(p.roughness).powi(2)
            / f64::from(p.pixel_angle).max(1e-6);
        let mut taps: [Vec<_>; 2] = Default::default();
        for [x, y] in (0..25).map(|k| [k % 5 - 2, k / 5 - 2]) {
            let offset = [x * step, y * step];
            let Some(j) = neighbour(size, i, offset) else { continue };
            let q = &pixels[j];
            if q.normal == 0 || !same_path(p, q, offset) {
                continue;
            }
            let distance = (offset[0] as f64).hypot(offset[1] as f64);
            let weights = if j == i { [1.0; 2] } else { surface_weights(p, q, distance, params) };
            let spline = KERNEL[x.unsigned_abs() as usize] * KERNEL[y.unsigned_abs() as usize];
            let lobe = (-(distance / reach.max(1e-6)).powi(2)).exp();
            for c in 0..2 {
                let w = spline * weights[c] * if c == 1 { lobe } else { 1.0 };
                taps[c].extend(light[j][c].map(|light| (w, light)));
            }
        }
        [0, 1].map(|c| mean(&taps[c], own[c]))
    };
    (0..pixels.len()).map(one).collect()
}
