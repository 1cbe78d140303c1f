use pt_scene::{Texture, Wrap};

/// Longest side of the summed grid; larger textures are summed in blocks.
const MAX_CELLS: u32 = 1024;

/// Means of a texture over rectangles of UV in constant time: summed-area table (Crow 1984) of its linear RGB.
pub(crate) struct TextureMeans {
    cells: [usize; 2],
    wrap: [Wrap; 2],
    /// (cells + 1) x (cells + 1) sums of everything above and to the left; a cell holds the mean of its texels.
    sums: Vec<[f64; 3]>,
}

impl TextureMeans {
    pub(crate) fn new(texture: &Texture) -> Self {
        let texture = &*texture.decoded();
        let size = [texture.width, texture.height];
        let block = size.map(|side| side.div_ceil(MAX_CELLS));
        let cells = std::array::from_fn(|i| size[i].div_ceil(block[i]) as usize);
        let row = cells[0] + 1;
        let mut sums = vec![[0.0; 3]; row * (cells[1] + 1)];
        for y in 0..cells[1] {
            let mut line = [0.0; 3];
            for x in 0..cells[0] {
                let mean = block_mean(texture, [x as u32 * block[0], y as u32 * block[1]], block);
                for c in 0..3 {
                    line[c] += mean[c];
                    sums[(y + 1) * row + x + 1][c] = sums[y * row + x + 1][c] + line[c];
                }
            }
        }
        Self { cells, wrap: [texture.sampler.wrap_u, texture.sampler.wrap_v], sums }
    }

    /// Mean over the cells that bilinear lookups between the two corners can touch. Zero only if all of these are black.
    pub(crate) fn mean(&self, min: [f32; 2], max: [f32; 2]) -> [f64; 3] {
        let [across, down] = [0, 1].map(|i| spans(min[i], max[i], self.cells[i], self.wrap[i]));
        let (mut sum, mut area) = ([0.0; 3], 0.0);
        for &(x0, x1) in &across {
            for &(y0, y1) in &down {
                let at = |x: usize, y: usize| self.sums[y * (self.cells[0] + 1) + x];
                area += ((x1 - x0) * (y1 - y0)) as f64;
                for (c, sum) in sum.iter_mut().enumerate() {
                    *sum += at(x1, y1)[c] - at(x0, y1)[c] - at(x1, y0)[c] + at(x0, y0)[c];
                }
            }
        }
        // The darkest texel that is not black stands far above the rounding of the sums.
        sum.map(|s| (s / area).max(0.0))
    }
}

fn block_mean(texture: &Texture, start: [u32; 2], block: [u32; 2]) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for y in start[1]..(start[1] + block[1]).min(texture.height) {
        for x in start[0]..(start[0] + block[0]).min(texture.width) {
            let texel = texture.texel(x, y);
            count += 1.0;
            for (sum, channel) in sum.iter_mut().zip(texel) {
                *sum += f64::from(channel);
            }
        }
    }
    sum.map(|s| s / count)
}

/// Ranges of cells that UV in `min..=max` reads, one cell of margin for the filter.
fn spans(min: f32, max: f32, cells: usize, wrap: Wrap) -> Vec<(usize, usize)> {
    let n = cells as f64;
    let (low, high) = ((f64::from(min) * n).floor() - 1.0, (f64::from(max) * n).floor() + 2.0);
    let inside = low >= 0.0 && high <= n;
    // Also taken for coordinates that are not finite.
    let everything = vec![(0, cells)];
    match wrap {
        _ if inside => vec![(low as usize, high as usize)],
        Wrap::ClampToEdge => {
            let low = low.clamp(0.0, n - 1.0);
            vec![(low as usize, high.clamp(low + 1.0, n) as usize)]
        }
        Wrap::Repeat if high - low < n => {
            let start = low.rem_euclid(n) as usize;
            let end = start + (high - low) as usize;
            if end <= cells { vec![(start, end)] } else { vec![(start, cells), (0, end - cells)] }
        }
        Wrap::Repeat | Wrap::MirroredRepeat => everything,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_scene::TextureUsage;

    fn checkered(width: u32, height: u32, white: impl Fn(u32, u32) -> bool) -> Texture {
        let texels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .flat_map(|(x, y)| [255 * u8::from(white(x, y)); 4]);
        Texture::rgba8("test", [width, height], TextureUsage::Color, texels.collect())
    }

    #[test]
    fn rectangles_have_their_mean() {
        let half = TextureMeans::new(&checkered(64, 32, |x, _| x >= 32));
        assert_eq!(half.mean([0.1, 0.1], [0.4, 0.9]), [0.0; 3]);
        assert!((half.mean([0.6, 0.1], [0.9, 0.9])[1] - 1.0).abs() < 1e-12);
        assert!((half.mean([0.0, 0.0], [1.0, 1.0])[2] - 0.5).abs() < 1e-12);
        // Round the seam: one cell of white in a range of black.
        assert!(half.mean([-0.01, 0.5], [0.2, 0.5])[0] > 0.0);
        assert!(half.mean([0.0, 0.5], [0.2, 0.5])[0] > 0.0, "the filter at u = 0 reads the last column");
    }

    #[test]
    fn large_textures_are_summed_in_blocks() {
        let texture = checkered(3000, 2, |x, _| x == 1500);
        let means = TextureMeans::new(&texture);
        assert_eq!(means.cells, [1000, 2]);
        assert!(means.mean([0.5, 0.5], [0.5, 0.5])[0] > 0.0);
        assert!((means.mean([0.0, 0.0], [1.0, 1.0])[0] * 3000.0 - 1.0).abs() < 1e-6);
    }
}
