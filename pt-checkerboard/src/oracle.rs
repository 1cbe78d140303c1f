//! The interleave on the CPU: what `interleave.comp` is tested against.

use pt_core::channels::field_width;
use pt_core::split::flat_to_split;

/// Flat colour and motion of a frame of `size`, from its split colour and motion in scan-line order.
pub fn interleave(
    color: &[[f32; 4]],
    motion: &[[f32; 4]],
    size: [u32; 2],
    blend_split: bool,
) -> (Vec<[f32; 4]>, Vec<[f32; 2]>) {
    let [width, height] = size;
    let half = field_width(width);
    let index = |x: u32, y: u32| {
        let [x, y] = flat_to_split([x, y], half);
        (y * 2 * half + x) as usize
    };
    let mut flat_color = Vec::new();
    let mut flat_motion = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let own = index(x, y);
            let (mut c, mut m) = (color[own], motion[own]);
            let neighbours: Vec<usize> = [(-1, 0), (1, 0), (0, -1), (0, 1)]
                .into_iter()
                .filter_map(|(dx, dy)| Some((x.checked_add_signed(dx)?, y.checked_add_signed(dy)?)))
                .filter(|&(x, y)| x < width && y < height)
                .map(|(x, y)| index(x, y))
                .collect();
            if blend_split && (c[3] as u32).count_ones() > 1 && !neighbours.is_empty() {
                let mut other = [0.0; 3];
                for &n in &neighbours {
                    for (sum, value) in other.iter_mut().zip(color[n]) {
                        *sum += value / neighbours.len() as f32;
                    }
                }
                if luminance(other) > luminance([c[0], c[1], c[2]]) {
                    let brightness = |n: usize| luminance([color[n][0], color[n][1], color[n][2]]);
                    let mut brightest = neighbours[0];
                    for &n in &neighbours[1..] {
                        if brightness(n) > brightness(brightest) {
                            brightest = n;
                        }
                    }
                    m = motion[brightest];
                }
                for (own, other) in c.iter_mut().zip(other) {
                    *own = 0.5 * (*own + other);
                }
            }
            flat_color.push(c);
            flat_motion.push([m[0], m[1]]);
        }
    }
    (flat_color, flat_motion)
}

/// Rec. 709 luminance of linear RGB.
fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
