//! Opacity tables: which parts of an alpha-tested triangle are opaque or transparent whatever the ray, so that traversal can leave out the
//! alpha test there. What opacity micromaps do (Gruen, Benthin and Woop 2020, "Sub-Triangle Opacity Masks for Faster Ray Tracing of
//! Transparent Objects").

use crate::texture::Wrap;
use crate::{AlphaMode, Mesh, Scene, Texture, TextureRef};
use glam::{DVec2, Vec2};
use pt_shaders::records::{OPACITY_OPAQUE, OPACITY_SIDE, OPACITY_TRANSPARENT, OPACITY_UNKNOWN};
use rayon::prelude::*;
use std::collections::HashMap;

/// States (`OPACITY_*`) of a triangle's micro-triangles, two bits each; opacity.glsl has their order.
pub(crate) type TriangleOpacity = [u32; 4];

/// Alpha this close to a cutoff is looked up: filtering and compressed formats round, by less than two codes of 8 bits.
const MARGIN: f32 = 2.0 / 255.0;
/// Farther from the origin, texels, coordinates are too coarse to tell texels apart.
const FARTHEST_TEXEL: f64 = 4e6;

/// Which alpha values of a texture mean what, for a factor on them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Thresholds {
    transparent_to: f32,
    opaque_from: f32,
}

impl Thresholds {
    /// `factor`: what alpha is multiplied by, above 0.
    fn new(mode: AlphaMode, factor: f32) -> Self {
        let [transparent_to, opaque_from] = match mode {
            AlphaMode::Mask { cutoff } => [cutoff - MARGIN, cutoff + MARGIN],
            _ => [0.0, 1.0],
        };
        Self { transparent_to: transparent_to / factor, opaque_from: opaque_from / factor }
    }

    fn state(self, alpha: f32) -> u32 {
        if alpha >= self.opaque_from {
            OPACITY_OPAQUE
        } else if alpha <= self.transparent_to {
            OPACITY_TRANSPARENT
        } else {
            OPACITY_UNKNOWN
        }
    }

    fn key(self, texture: u32) -> [u32; 3] {
        [texture, self.transparent_to.to_bits(), self.opaque_from.to_bits()]
    }
}

/// The states that texels have, as sets (bit `1 << state`), with a pyramid over them: a cell has those of the 2 x 2 below it.
struct StatePyramid {
    size: [i64; 2],
    wrap: [Wrap; 2],
    levels: Vec<(usize, Vec<u8>)>,
}

impl StatePyramid {
    fn new(texture: &Texture, thresholds: Thresholds) -> Self {
        let decoded = texture.decoded();
        let (mut width, mut height) = (texture.width as usize, texture.height as usize);
        let state = |i: usize| {
            let alpha = decoded.texel((i % width) as u32, (i / width) as u32)[3];
            1 << thresholds.state(alpha)
        };
        let finest: Vec<u8> = (0..width * height).into_par_iter().map(state).collect();
        let mut levels = vec![(width, finest)];
        while width.max(height) > 1 {
            let (across, below) = levels.last().expect("there is the finest level");
            let [w, h] = [width.div_ceil(2), height.div_ceil(2)];
            let cell = |i: usize| {
                let (x, y) = (2 * (i % w), 2 * (i / w));
                let [right, under] = [(x + 1).min(width - 1), (y + 1).min(height - 1)];
                [[x, y], [right, y], [x, under], [right, under]]
                    .iter()
                    .fold(0, |set, at| set | below[at[1] * across + at[0]])
            };
            let above = (0..w * h).map(cell).collect();
            levels.push((w, above));
            (width, height) = (w, h);
        }
        Self {
            size: [i64::from(texture.width), i64::from(texture.height)],
            wrap: [texture.sampler.wrap_u, texture.sampler.wrap_v],
            levels,
        }
    }

    /// The one state of all texels that linear filtering reads at coordinates between `low` and `high`, texels from the corner of texel 0.
    fn state_between(&self, low: DVec2, high: DVec2) -> u32 {
        if !(low.min_element() > -FARTHEST_TEXEL && high.max_element() < FARTHEST_TEXEL) {
            return OPACITY_UNKNOWN;
        }
        let first = (low - 0.5).floor();
        let last = (high - 0.5).floor() + 1.0;
        let mut set = 0;
        for y in wrapped(first.y as i64, last.y as i64, self.size[1], self.wrap[1]) {
            for x in wrapped(first.x as i64, last.x as i64, self.size[0], self.wrap[0]) {
                self.collect(self.levels.len() - 1, [0, 0], [x, y], &mut set);
            }
        }
        if set.count_ones() == 1 { set.trailing_zeros() } else { OPACITY_UNKNOWN }
    }

    /// Adds the states of texels from `rectangle[axis][0]` to `rectangle[axis][1]` that are below a cell.
    fn collect(&self, level: usize, cell: [i64; 2], rectangle: [[i64; 2]; 2], set: &mut u8) {
        let (across, sets) = &self.levels[level];
        let span = [0, 1].map(|axis| {
            let first = cell[axis] << level;
            [first, (first + (1 << level)).min(self.size[axis]) - 1]
        });
        let outside = [0, 1].iter().any(|&a| span[a][0] > rectangle[a][1] || span[a][1] < rectangle[a][0]);
        if outside || span.iter().any(|s| s[0] > s[1]) || set.count_ones() > 1 {
            return;
        }
        let found = sets[cell[1] as usize * across + cell[0] as usize];
        let inside = [0, 1].iter().all(|&a| span[a][0] >= rectangle[a][0] && span[a][1] <= rectangle[a][1]);
        if inside || found.count_ones() == 1 {
            *set |= found;
            return;
        }
        for [x, y] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            self.collect(level - 1, [2 * cell[0] + x, 2 * cell[1] + y], rectangle, set);
        }
    }
}

/// Ranges within 0..`size` of the texels that `first` to `last` address.
fn wrapped(first: i64, last: i64, size: i64, wrap: Wrap) -> impl Iterator<Item = [i64; 2]> {
    let tiled = |period: i64| {
        if last - first + 1 >= period {
            return [Some([0, period - 1]), None];
        }
        let low = first.rem_euclid(period);
        let high = low + last - first;
        if high < period {
            [Some([low, high]), None]
        } else {
            [Some([low, period - 1]), Some([0, high - period])]
        }
    };
    let ranges = match wrap {
        Wrap::ClampToEdge => [Some([first.clamp(0, size - 1), last.clamp(0, size - 1)]), None, None, None],
        Wrap::Repeat => {
            let [a, b] = tiled(size);
            [a, b, None, None]
        }
        Wrap::MirroredRepeat => {
            let [a, b] = tiled(2 * size);
            let plain = |r: [i64; 2]| (r[0] < size).then(|| [r[0], r[1].min(size - 1)]);
            let mirrored =
                |r: [i64; 2]| (r[1] >= size).then(|| [2 * size - 1 - r[1], 2 * size - 1 - r[0].max(size)]);
            [a.and_then(plain), a.and_then(mirrored), b.and_then(plain), b.and_then(mirrored)]
        }
    };
    ranges.into_iter().flatten()
}

/// What decides over a triangle: the same state everywhere, or a texture.
enum Alpha {
    Constant(u32),
    Textured(TextureRef, Thresholds),
}

fn alpha_of(scene: &Scene, mesh: &Mesh, triangle: usize) -> Alpha {
    let material = &scene.materials[mesh.triangle_materials[triangle] as usize];
    let [a, b, c] = mesh.indices[triangle].map(|v| mesh.colors[v as usize].w);
    // Alpha that changes over the triangle is left to the test.
    if a != b || a != c {
        return Alpha::Constant(OPACITY_UNKNOWN);
    }
    let factor = material.base_color.w * a;
    match material.base_color_texture {
        _ if factor <= 0.0 => Alpha::Constant(Thresholds::new(material.alpha_mode, 1.0).state(factor)),
        None => Alpha::Constant(Thresholds::new(material.alpha_mode, factor).state(1.0)),
        Some(texture) => Alpha::Textured(texture, Thresholds::new(material.alpha_mode, factor)),
    }
}

/// A triangle's texture coordinates, texels: at its first corner, and along the edges from there.
struct TexelTriangle {
    corner: DVec2,
    edges: [DVec2; 2],
}

impl TexelTriangle {
    /// `corners`: u and v of each.
    fn new(corners: [f32; 6], size: [i64; 2]) -> Self {
        let size = DVec2::new(size[0] as f64, size[1] as f64);
        let at = |i: usize| Vec2::new(corners[i], corners[i + 1]).as_dvec2() * size;
        let [a, b, c] = [0, 2, 4].map(at);
        Self { corner: a, edges: [b - a, c - a] }
    }

    /// The state between three points, given in steps of 1 / OPACITY_SIDE along the edges.
    fn state(&self, points: [[u32; 2]; 3], pyramid: &StatePyramid) -> u32 {
        let step = 1.0 / f64::from(OPACITY_SIDE);
        let at = |[u, v]: [u32; 2]| {
            self.corner + step * (f64::from(u) * self.edges[0] + f64::from(v) * self.edges[1])
        };
        let [a, b, c] = points.map(at);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Hits lie up to 1e-6 outside of the triangle; the device computes coordinates in fp32 and filters with 8 bits of a texel.
        let pad = 1.0 / 64.0
            + 1e-6 * low.abs().max(high.abs())
            + 2e-5 * (self.edges[0].abs() + self.edges[1].abs());
        pyramid.state_between(low - pad, high + pad)
    }

    fn opacity(&self, pyramid: &StatePyramid) -> TriangleOpacity {
        let whole = self.state([[0, 0], [OPACITY_SIDE, 0], [0, OPACITY_SIDE]], pyramid);
        if whole != OPACITY_UNKNOWN {
            return uniform(whole);
        }
        let mut words = [0; 4];
        for v in 0..OPACITY_SIDE {
            for u in 0..OPACITY_SIDE - v {
                let first = v * (2 * OPACITY_SIDE - v) + 2 * u;
                let mut set = |index: u32, state: u32| {
                    words[(index / 16) as usize] |= state << (2 * (index % 16));
                };
                let (right, above) = ([u + 1, v], [u, v + 1]);
                set(first, self.state([[u, v], right, above], pyramid));
                if u + v + 1 < OPACITY_SIDE {
                    set(first + 1, self.state([[u + 1, v + 1], right, above], pyramid));
                }
            }
        }
        words
    }
}

fn uniform(state: u32) -> TriangleOpacity {
    [(0..16).fold(0, |word, i| word | state << (2 * i)); 4]
}

/// Triangles of which one look at the texture serves all: their texture, its thresholds, and the bits of their coordinates.
type Kind = ([u32; 3], [u32; 6]);

fn kind_of(mesh: &Mesh, triangle: usize, texture: TextureRef, thresholds: Thresholds) -> Kind {
    let set = if texture.uv_set == 0 { &mesh.uv0 } else { &mesh.uv1 };
    let [a, b, c] = mesh.indices[triangle].map(|v| texture.transform.transform_point2(set[v as usize]));
    (thresholds.key(texture.texture), [a.x, a.y, b.x, b.y, c.x, c.y].map(f32::to_bits))
}

/// For each mesh the states of its triangles from [`Mesh::first_masked`] on.
pub(crate) fn opacity_tables(scene: &Scene) -> Vec<Vec<TriangleOpacity>> {
    let masked = |mesh: &Mesh| mesh.first_masked..mesh.triangle_count();
    let mut pyramids: HashMap<[u32; 3], StatePyramid> = HashMap::new();
    // Cards of leaves are alike by the thousand.
    let mut kinds: HashMap<Kind, TriangleOpacity> = HashMap::new();
    for mesh in &scene.meshes {
        for triangle in masked(mesh) {
            if let Alpha::Textured(texture, thresholds) = alpha_of(scene, mesh, triangle) {
                let image = &scene.textures[texture.texture as usize];
                pyramids
                    .entry(thresholds.key(texture.texture))
                    .or_insert_with(|| StatePyramid::new(image, thresholds));
                kinds.insert(kind_of(mesh, triangle, texture, thresholds), uniform(OPACITY_UNKNOWN));
            }
        }
    }
    kinds.par_iter_mut().for_each(|((key, corners), opacity)| {
        let pyramid = &pyramids[key];
        *opacity = TexelTriangle::new(corners.map(f32::from_bits), pyramid.size).opacity(pyramid);
    });
    let opacity = |mesh: &Mesh, triangle: usize| match alpha_of(scene, mesh, triangle) {
        Alpha::Constant(state) => uniform(state),
        Alpha::Textured(texture, thresholds) => kinds[&kind_of(mesh, triangle, texture, thresholds)],
    };
    let table = |mesh: &Mesh| masked(mesh).map(|t| opacity(mesh, t)).collect();
    scene.meshes.iter().map(table).collect()
}

#[cfg(test)]
mod tests;
