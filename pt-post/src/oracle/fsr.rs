//! `easu.comp` and `rcas.comp`.

use super::{Image, Rgb, add, scaled, zip};

fn luma([r, g, b]: Rgb) -> f64 {
    g + 0.5 * (r + b)
}

/// Gradient along one axis, and how much of an edge it is: 1 on a slope, 0 on a thin line.
fn axis(before: f64, here: f64, after: f64) -> (f64, f64) {
    let change = after - before;
    let steepest = (after - here).abs().max((here - before).abs());
    let edge = if steepest > 0.0 { (change.abs() / steepest).min(1.0) } else { 0.0 };
    (change, edge * edge)
}

/// Edge-adaptive upsampling of display codes to `size`, not smaller than the input.
pub fn easu(source: &Image, size: [u32; 2]) -> Image {
    let ratio = [0, 1].map(|i| f64::from(source.size[i]) / f64::from(size[i]));
    Image::from_fn(size, |x, y| {
        let px = (f64::from(x) + 0.5) * ratio[0] - 0.5;
        let py = (f64::from(y) + 0.5) * ratio[1] - 0.5;
        let (left, top) = (px.floor(), py.floor());
        let (fx, fy) = (px - left, py - top);
        let tap = |dx: i64, dy: i64| source.at(left as i64 + dx, top as i64 + dy);

        let (mut gx, mut gy, mut strength) = (0.0, 0.0, 0.0);
        for (dx, dy, weight) in [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ] {
            let here = luma(tap(dx, dy));
            let (change_x, edge_x) = axis(luma(tap(dx - 1, dy)), here, luma(tap(dx + 1, dy)));
            let (change_y, edge_y) = axis(luma(tap(dx, dy - 1)), here, luma(tap(dx, dy + 1)));
            gx += weight * change_x;
            gy += weight * change_y;
            strength += weight * (edge_x + edge_y);
        }
        let squared = gx * gx + gy * gy;
        let (ax, ay) =
            if squared < 1.0 / 32768.0 { (1.0, 0.0) } else { (gx / squared.sqrt(), gy / squared.sqrt()) };
        let strength = 0.25 * strength * strength;
        let diagonal = 1.0 / ax.abs().max(ay.abs());
        let squeeze_across = 1.0 + (diagonal - 1.0) * strength;
        let squeeze_along = 1.0 - 0.5 * strength;
        let lobe = 0.5 + (0.21 - 0.5) * strength;

        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for dy in -1..=2i64 {
            for dx in -1..=2i64 {
                if (dx == -1 || dx == 2) && (dy == -1 || dy == 2) {
                    continue;
                }
                let (rx, ry) = (dx as f64 - fx, dy as f64 - fy);
                let across = (rx * ax + ry * ay) * squeeze_across;
                let along = (ry * ax - rx * ay) * squeeze_along;
                let r = (across * across + along * along).min(1.0 / lobe);
                let window = 25.0 / 16.0 * (0.4 * r - 1.0).powi(2) - 9.0 / 16.0;
                let weight = window * (lobe * r - 1.0).powi(2);
                add(&mut sum, weight, tap(dx, dy));
                weights += weight;
            }
        }
        let nearest = [tap(0, 0), tap(1, 0), tap(0, 1), tap(1, 1)];
        let low = nearest.into_iter().reduce(|a, b| zip(a, b, f64::min)).unwrap_or_default();
        let high = nearest.into_iter().reduce(|a, b| zip(a, b, f64::max)).unwrap_or_default();
        zip(zip(scaled(sum, 1.0 / weights), low, f64::max), high, f64::min)
    })
}

/// Contrast-adaptive sharpening of display codes; `strength` 0 to 1.
pub fn rcas(source: &Image, strength: f64, denoise: bool) -> Image {
    Image::from_fn(source.size, |x, y| {
        let (x, y) = (i64::from(x), i64::from(y));
        let tap = |dx, dy| source.at(x + dx, y + dy).map(|v| v.clamp(0.0, 1.0));
        let e = tap(0, 0);
        let ring = [tap(0, -1), tap(-1, 0), tap(1, 0), tap(0, 1)];
        let mut room = 0.25f64 - 1.0 / 16.0;
        for channel in 0..3 {
            let low = ring.iter().map(|c| c[channel]).fold(1.0, f64::min);
            let high = ring.iter().map(|c| c[channel]).fold(0.0, f64::max);
            let to_black = low.min(e[channel]) / (4.0 * high).max(1e-6);
            let to_white = (1.0 - high.max(e[channel])) / (4.0 - 4.0 * low).max(1e-6);
            room = room.min(to_black).min(to_white);
        }
        let mut w = -room.max(0.0) * strength;
        if denoise {
            let mean = ring.iter().map(|&c| luma(c)).sum::<f64>() / 4.0;
            let all = || ring.iter().chain([&e]).map(|&c| luma(c));
            let range = all().fold(0.0, f64::max) - all().fold(2.0, f64::min);
            w *= 1.0 - 0.5 * ((mean - luma(e)).abs() / range.max(1e-6)).min(1.0);
        }
        let mut sum = e;
        ring.into_iter().for_each(|c| add(&mut sum, w, c));
        scaled(sum, 1.0 / (1.0 + 4.0 * w)).map(|v| v.clamp(0.0, 1.0))
    })
}
