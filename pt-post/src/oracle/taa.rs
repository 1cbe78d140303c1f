//! `taa.comp`.

use super::tone_map::{pq_decode, pq_encode};
use super::{Image, Rgb, add, is_finite, mix, scaled, zip};
use crate::records::{ClipSpace, Rectify};
use crate::taa::TaaParams;
use pt_shaders::records::SPLIT_FLAGS;

/// One frame's input.
#[derive(Clone, Debug)]
pub struct TaaFrame<'a> {
    /// Linear radiance.
    pub color: &'a Image,
    /// Checkerboard flags of each pixel.
    pub flags: &'a [u32],
    /// Previous minus current position in UV of each pixel.
    pub motion: &'a [[f64; 2]],
    /// Where in its pixels the frame was sampled, from the centre.
    pub jitter: [f64; 2],
}

/// Temporal anti-aliasing with its history.
#[derive(Clone, Debug)]
pub struct TaaOracle {
    size: [u32; 2],
    /// PQ codes, and for each pixel the weight of what it holds over the greatest and the deviation of its samples; `None` before
    /// the first frame.
    history: Option<(Image, Vec<[f64; 2]>)>,
}

impl TaaOracle {
    /// Without history, for an output of `size`.
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, history: None }
    }

    /// Replaces the history by the texels of the image that the kernel keeps it in.
    pub fn set_history(&mut self, texels: &[f32]) {
        let pixels = texels.chunks_exact(4).map(|c| [c[0], c[1], c[2]].map(f64::from)).collect();
        let state = |a: f32| {
            let word = (a * 65535.0).round() as u32;
            [f64::from(word >> 8) / 255.0, (f64::from(word & 255) / 255.0).powi(2)]
        };
        let states = texels.chunks_exact(4).map(|c| state(c[3])).collect();
        self.history = Some((Image { size: self.size, pixels }, states));
    }

    /// The next anti-aliased frame.
    pub fn next(&mut self, frame: &TaaFrame<'_>, params: &TaaParams) -> Image {
        let pq = f64::from(params.pq_scale);
        let most = 10_000.0 / pq;
        let encode = |c: Rgb| c.map(|v| pq_encode((v / most).clamp(0.0, 1.0)));
        let decode = |c: Rgb| c.map(|v| pq_decode(v) * most);
        let linear = params.space == ClipSpace::Rgb;
        let [moving, still] = [params.blend, params.blend_still].map(|blend| 1.0 / f64::from(blend));
        let greatest = moving.max(still);
        let [width, height] = frame.color.size.map(i64::from);
        let scale = [0, 1].map(|i| f64::from(frame.color.size[i]) / f64::from(self.size[i]));

        let mut codes = Vec::new();
        let mut states = Vec::new();
        let resolved = Image::from_fn(self.size, |x, y| {
            let at = [x, y];
            let position = [0, 1].map(|i| (f64::from(at[i]) + 0.5) * scale[i] - 0.5);
            let [sx, sy] = [0, 1].map(|i| (position[i] - frame.jitter[i] + 0.5).floor() as i64);
            let index = |dx: i64, dy: i64| {
                ((sy + dy).clamp(0, height - 1) * width + (sx + dx).clamp(0, width - 1)) as usize
            };
            let texel = |dx, dy| {
                let c = frame.color.pixels[index(dx, dy)];
                is_finite(c).then(|| if linear { c.map(|v| v.clamp(0.0, most)) } else { encode(c) })
            };

            let mut longest = [0.0f64; 2];
            let mut around = Vec::new();
            for (dx, dy) in (0..9).map(|i| (i % 3 - 1, i / 3 - 1)) {
                let m = frame.motion[index(dx, dy)];
                if m[0] * m[0] + m[1] * m[1] > longest[0] * longest[0] + longest[1] * longest[1] {
                    longest = m;
                }
                if (dx, dy) != (0, 0) {
                    around.extend(texel(dx, dy));
                }
            }
            let mut centre = texel(0, 0);
            if !around.is_empty() {
                let mut mean = [0.0; 3];
                around.iter().for_each(|&c| add(&mut mean, 1.0 / around.len() as f64, c));
                let limit = f64::from(params.sparkle_limit());
                let limited = |c: Rgb| if limit > 0.0 { zip(c, scaled(mean, limit), f64::min) } else { c };
                centre = Some(limited(centre.unwrap_or(mean)));
            }
            let flags = if texel(0, 0).is_some() { frame.flags[index(0, 0)] } else { 0 };
            let centre = centre.unwrap_or_default();

            let clip_space = |c: Rgb| to_clip_space(c, params.space);
            let samples: Vec<Rgb> = std::iter::once(centre).chain(around).map(clip_space).collect();
            let n = samples.len() as f64;
            let (mut mean, mut squares) = ([0.0; 3], [0.0; 3]);
            for &c in &samples {
                add(&mut mean, 1.0 / n, c);
                add(&mut squares, 1.0 / n, c.map(|v| v * v));
            }
            let deviation = zip(squares, mean, |s, m| (s - m * m).max(0.0).sqrt());
            let sigma = f64::from(params.sigma * if flags == SPLIT_FLAGS { params.split_sigma } else { 1.0 });

            let moved = [0, 1].map(|i| longest[i] * f64::from(self.size[i]));
            let previous = [0, 1].map(|i| f64::from(at[i]) + 0.5 + moved[i]);
            let inside = (0..2).all(|i| previous[i] > 0.0 && previous[i] < f64::from(self.size[i]));
            let (past, [held, spread]) = match &self.history {
                Some((image, states)) if inside => {
                    let [column, row] = previous.map(|v| v as usize);
                    (catmull_rom(image, previous), states[row * self.size[0] as usize + column])
                }
                _ => ([0.0; 3], [0.0; 2]),
            };
            let past = clip_space(if linear { decode(past) } else { past });
            let temporal = f64::from(params.temporal) * spread;
            let widened = match params.space {
                ClipSpace::Pq => [temporal; 3],
                ClipSpace::Ycocg => [temporal, 0.5 * temporal, 0.5 * temporal],
                ClipSpace::Rgb => [0.0; 3],
            };
            let extent = zip(scaled(deviation, sigma), widened, f64::max);
            let past = from_clip_space(rectify(past, mean, extent, params.rectify), params.space);
            let luma = |c: Rgb| 0.25 * c[0] + 0.5 * c[1] + 0.25 * c[2];
            let change = if linear { 0.0 } else { (luma(centre) - luma(past)).abs() };

            let sampled = [sx.clamp(0, width - 1) as f64, sy.clamp(0, height - 1) as f64];
            let offset = [0, 1].map(|i| (sampled[i] + frame.jitter[i] - position[i]) / scale[i]);
            let t = moved[0].hypot(moved[1]).clamp(0.0, 1.0);
            let near = 2.0 - 2.0 * offset[0].abs().max(offset[1].abs());
            let smooth = t * t * (3.0 - 2.0 * t);
            let weight = smooth.max(near).clamp(0.02, 1.0);
            let total = (held * greatest + weight).min(still + (moving - still) * smooth);
            let as_codes = !linear && !params.blend_linear;
            let light = |c: Rgb| if linear || as_codes { c } else { decode(c.map(|v| v.clamp(0.0, 1.0))) };
            let share = (weight / total).min(1.0);
            let blended = mix(light(past), light(centre), share).map(|v| v.max(0.0));
            let code = if as_codes { blended.map(|v| v.min(1.0)) } else { encode(blended) };
            codes.push(code);
            states.push([
                total / greatest,
                if held > 0.0 { (1.0 - smooth) * (spread + (change - spread) * share) } else { 0.0 },
            ]);
            if as_codes { decode(code) } else { blended }
        });
        self.history = Some((Image { size: self.size, pixels: codes }, states));
        resolved
    }
}

fn to_clip_space([r, g, b]: Rgb, space: ClipSpace) -> Rgb {
    match space {
        ClipSpace::Ycocg => [0.25 * r + 0.5 * g + 0.25 * b, 0.5 * (r - b), -0.25 * r + 0.5 * g - 0.25 * b],
        ClipSpace::Pq | ClipSpace::Rgb => [r, g, b],
    }
}

fn from_clip_space(c: Rgb, space: ClipSpace) -> Rgb {
    match space {
        ClipSpace::Ycocg => [c[0] - c[2] + c[1], c[0] + c[2], c[0] - c[2] - c[1]],
        ClipSpace::Pq | ClipSpace::Rgb => c,
    }
}

fn rectify(c: Rgb, mean: Rgb, extent: Rgb, how: Rectify) -> Rgb {
    let offset = zip(c, mean, |c, m| c - m);
    match how {
        Rectify::Off => c,
        Rectify::Clamp => zip(mean, zip(offset, extent, |o, e| o.clamp(-e, e)), |m, o| m + o),
        Rectify::Clip => {
            let outside = zip(offset, extent, |o, e| o.abs() / e.max(1e-7));
            let shrink = outside[0].max(outside[1]).max(outside[2]).max(1.0);
            zip(mean, offset, |m, o| m + o / shrink)
        }
    }
}

/// Catmull-Rom interpolation at a place in pixels, centres at halves.
fn catmull_rom(image: &Image, [x, y]: [f64; 2]) -> Rgb {
    let cubic = |f: f64| {
        [
            f * (-0.5 + f * (1.0 - 0.5 * f)),
            1.0 + f * f * (-2.5 + 1.5 * f),
            f * (0.5 + f * (2.0 - 1.5 * f)),
            f * f * (-0.5 + 0.5 * f),
        ]
    };
    let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (wx, wy) = (cubic(x - 0.5 - left), cubic(y - 0.5 - top));
    let mut sum = [0.0; 3];
    for (row, wy) in (-1..).zip(wy) {
        for (column, wx) in (-1..).zip(wx) {
            add(&mut sum, wx * wy, image.at(left as i64 + column, top as i64 + row));
        }
    }
    sum.map(|v| v.clamp(0.0, 1.0))
}
