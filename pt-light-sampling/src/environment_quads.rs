//! The environment as local lights: quads of a quad-tree over its map.
//!
//! The map is the picture itself, latitude and longitude, divided into *cells*: its texels, or equal parts of them where the picture is
//! small. A quad is a rectangle of cells. From the whole sphere on, the quad of the largest power is divided into four of about the same
//! solid angle, as far as its borders are those of cells, until there are [`EnvironmentQuads::MOST`]. A black part is no quad.
//!
//! Inside a quad a direction is drawn like one of the whole environment: a cell by alias table in proportion to its power, then uniformly in
//! the solid angle of the cell. A lookup is bilinear, and the power of a cell is that of all that lookups in it return, so every direction with
//! radiance is in a quad and has a density.

use crate::AliasTable;
use crate::environment::texel_solid_angle;
use crate::light_bounds::LightBounds;
use crate::luminance;
use glam::{DVec3, Quat, UVec2, Vec3};
use pt_scene::{Bounds, Environment};
use pt_shaders::records::{
    AliasRecord, ENVIRONMENT_QUAD_LEAF, EnvironmentQuadNode, EnvironmentQuadRecord, NONE,
};
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

/// Fewest columns and rows of cells.
const LEAST_CELLS: [u32; 2] = [128, 64];
/// What is added to the half angle of a quad's cone, radians: single precision has no more digits for the cosine of a small angle.
const CONE_MARGIN: f64 = 1e-3;

/// The quads of an environment. They do not depend on its rotation and intensity.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentQuads {
    grid: [u32; 2],
    nodes: Vec<EnvironmentQuadNode>,
    quads: Vec<EnvironmentQuadRecord>,
    cells: Vec<AliasRecord>,
}

impl EnvironmentQuads {
    /// Most quads that an environment is divided into. An environment of one colour has as many, and they have the same power but for what
    /// the borders of cells take away.
    pub const MOST: usize = 64;

    /// Divides an environment. No quad if it is black or has texels that are no radiance.
    pub fn new(environment: &Environment) -> Self {
        let map = Map::new(environment);
        let mut tree = Tree::new(&map);
        tree.divide(&map, Self::MOST);
        let Tree { mut nodes, rects, powers } = tree;
        let mut built = Self { grid: map.grid, nodes: Vec::new(), quads: Vec::new(), cells: Vec::new() };
        for (node, (rect, power)) in nodes.iter_mut().zip(rects.iter().zip(&powers)) {
            if node.link != NONE {
                continue;
            }
            let weights: Vec<f64> = rect.cells().map(|(x, y)| map.weight(x, y)).collect();
            let Some(table) = AliasTable::new(&weights) else { continue };
            let (axis, cos_spread) = map.cone(rect);
            node.link = ENVIRONMENT_QUAD_LEAF | built.quads.len() as u32;
            built.quads.push(EnvironmentQuadRecord {
                axis,
                cos_spread,
                corner: UVec2::from_array(rect.min),
                size: UVec2::new(rect.max[0] - rect.min[0], rect.max[1] - rect.min[1]),
                first: built.cells.len() as u32,
                irradiance: power.min(f64::from(f32::MAX)) as f32,
            });
            built.cells.extend_from_slice(table.entries());
        }
        built.nodes = nodes;
        built
    }

    /// Columns and rows of cells.
    pub fn grid(&self) -> [u32; 2] {
        self.grid
    }

    /// The nodes of the tree, the root first.
    pub fn nodes(&self) -> &[EnvironmentQuadNode] {
        &self.nodes
    }

    /// The quads. Their order is that of their indices as local lights.
    pub fn quads(&self) -> &[EnvironmentQuadRecord] {
        &self.quads
    }

    /// For each quad an alias table over its cells, row by row.
    pub fn cells(&self) -> &[AliasRecord] {
        &self.cells
    }

    /// The quad of a cell, `None`: it is black.
    pub fn find(&self, cell: [u32; 2]) -> Option<usize> {
        let mut node = self.nodes.first()?;
        while node.link & ENVIRONMENT_QUAD_LEAF == 0 {
            let far = |axis: usize| u32::from(cell[axis] >= node.split[axis]);
            node = &self.nodes[(node.link + far(0) + 2 * far(1)) as usize];
        }
        (node.link != NONE).then_some((node.link & !ENVIRONMENT_QUAD_LEAF) as usize)
    }

    /// Solid angle of a cell of row `y`, steradians.
    pub fn cell_solid_angle(&self, y: u32) -> f64 {
        texel_solid_angle(self.grid[0] as usize, self.grid[1] as usize, y as usize)
    }

    /// Solid angle of a quad, steradians.
    pub fn solid_angle(&self, quad: usize) -> f64 {
        let EnvironmentQuadRecord { corner, size, .. } = self.quads[quad];
        (corner.y..corner.y + size.y).map(|y| f64::from(size.x) * self.cell_solid_angle(y)).sum()
    }

    /// A quad as a local light. `disc`: area of the disc that the scene's bounding sphere shows to the light, square metres.
    pub fn light(&self, quad: usize, environment: &Environment, disc: f64) -> LightBounds {
        let EnvironmentQuadRecord { axis, cos_spread, irradiance, .. } = self.quads[quad];
        let irradiance = (irradiance * environment.intensity).clamp(0.0, f32::MAX);
        let power = f64::from(irradiance) * disc;
        LightBounds {
            bounds: Bounds { min: Vec3::ZERO, max: Vec3::ZERO },
            axis: Quat::from_rotation_y(environment.rotation) * axis,
            cos_spread,
            cos_emission: 0.0,
            power: if irradiance > 0.0 {
                power.clamp(f32::MIN_POSITIVE.into(), f32::MAX.into()) as f32
            } else {
                0.0
            },
            irradiance,
        }
    }
}

/// Cells from `min` up to, but without, `max`.
#[derive(Clone, Copy, Debug)]
struct Rect {
    min: [u32; 2],
    max: [u32; 2],
}

impl Rect {
    fn cells(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let Self { min, max } = *self;
        (min[1]..max[1]).flat_map(move |y| (min[0]..max[0]).map(move |x| (x, y)))
    }

    fn is_cell(&self) -> bool {
        self.max[0] - self.min[0] <= 1 && self.max[1] - self.min[1] <= 1
    }

    /// The four parts in the order of the links; parts may be empty.
    fn parts(&self, split: [u32; 2]) -> [Self; 4] {
        std::array::from_fn(|i| {
            let mut part = *self;
            for (axis, split) in split.into_iter().enumerate() {
                if i >> axis & 1 == 0 {
                    part.max[axis] = split;
                } else {
                    part.min[axis] = split;
                }
            }
            part
        })
    }
}

/// The power of every cell.
struct Map {
    grid: [u32; 2],
    weights: Vec<f64>,
}

impl Map {
    fn new(environment: &Environment) -> Self {
        let image = &environment.image;
        let size = [image.width, image.height];
        let parts = |axis: usize| {
            let least = LEAST_CELLS[axis].div_ceil(size[axis]);
            least.next_power_of_two()
        };
        let (parts_x, parts_y) = (parts(0), parts(1));
        let grid = [size[0] * parts_x, size[1] * parts_y];
        let (width, height) = (i64::from(size[0]), i64::from(size[1]));
        let columns = filters(size[0], parts_x, |x| x.rem_euclid(width));
        let rows = filters(size[1], parts_y, |y| y.clamp(0, height - 1));
        let texel = |x: usize, y: usize| luminance(image.texels[y * image.width as usize + x]);
        let mut weights = Vec::with_capacity(grid[0] as usize * grid[1] as usize);
        for (y, row) in rows.iter().enumerate() {
            let solid_angle = texel_solid_angle(grid[0] as usize, grid[1] as usize, y);
            let along: Vec<f64> = (0..size[0] as usize)
                .map(|x| row.iter().map(|&(y, share)| share * texel(x, y)).sum())
                .collect();
            let mean = |column: &Filter| column.iter().map(|&(x, share)| share * along[x]).sum::<f64>();
            weights.extend(columns.iter().map(|column| solid_angle * mean(column)));
        }
        // As with the alias table over all texels, none of them is light if any is no radiance.
        if !weights.iter().all(|w| *w >= 0.0 && w.is_finite()) {
            weights.fill(0.0);
        }
        Self { grid, weights }
    }

    fn weight(&self, x: u32, y: u32) -> f64 {
        self.weights[y as usize * self.grid[0] as usize + x as usize]
    }

    fn power(&self, rect: &Rect) -> f64 {
        rect.cells().map(|(x, y)| self.weight(x, y)).sum()
    }

    fn angles(&self, y: u32) -> f64 {
        PI * f64::from(y) / f64::from(self.grid[1])
    }

    fn solid_angle(&self, rect: &Rect) -> f64 {
        let width = TAU * f64::from(rect.max[0] - rect.min[0]) / f64::from(self.grid[0]);
        width * (self.angles(rect.min[1]).cos() - self.angles(rect.max[1]).cos())
    }

    /// Halves of the columns and of the solid angle. One column or row is not divided: it is all on the near side.
    fn split(&self, rect: &Rect) -> [u32; 2] {
        let Rect { min, max } = *rect;
        let within = |axis: usize, at: u32| {
            if max[axis] - min[axis] > 1 { at.clamp(min[axis] + 1, max[axis] - 1) } else { max[axis] }
        };
        let middle = 0.5 * (self.angles(min[1]).cos() + self.angles(max[1]).cos());
        let row = (middle.clamp(-1.0, 1.0).acos() / PI * f64::from(self.grid[1])).round() as u32;
        [within(0, (min[0] + max[0]) / 2), within(1, row)]
    }

    /// A cone with all directions of a quad: its mean direction, and the cosine of the largest angle to it.
    fn cone(&self, rect: &Rect) -> (Vec3, f32) {
        let azimuth = |x: f64| TAU * (x / f64::from(self.grid[0]) - 0.5);
        let [from, to] = [rect.min[0], rect.max[0]].map(|x| azimuth(x.into()));
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let [top, bottom] = [rect.min[1], rect.max[1]].map(|y| self.angles(y));
        // Integrals of the direction over the solid angle.
        let across =
            half.sin() * (0.5 * (bottom - top) - 0.25 * ((2.0 * bottom).sin() - (2.0 * top).sin())) * 2.0;
        let up = half * 0.5 * (bottom.sin().powi(2) - top.sin().powi(2)) * 2.0;
        let polar = across.max(0.0).atan2(up);
        let axis = DVec3::new(polar.sin() * middle.cos(), polar.cos(), polar.sin() * middle.sin());
        // On the edges of constant azimuth the cosine of the angle to the axis is a sinusoid of the polar angle; the edges are farthest away.
        let (a, b) = (polar.cos(), polar.sin() * half.cos());
        let (length, peak) = (a.hypot(b), b.atan2(a));
        let lowest = [peak + PI, peak - PI].into_iter().any(|at| (top..=bottom).contains(&at));
        let ends = (length * (top - peak).cos()).min(length * (bottom - peak).cos());
        let cos = if lowest { -length } else { ends };
        let spread = (cos.clamp(-1.0, 1.0).acos() + CONE_MARGIN).min(PI);
        (axis.as_vec3(), spread.cos() as f32)
    }
}

/// Which texels of a row or column a cell's mean depends on, and how much.
type Filter = Vec<(usize, f64)>;

/// Of every cell along an axis of `length` texels of `parts` cells each: 1, or an even number. Between texel centres a lookup is linear, so
/// the mean is the value in the middle of a cell; a whole texel has the mean of two halves.
fn filters(length: u32, parts: u32, texel: impl Fn(i64) -> i64) -> Vec<Filter> {
    let cell = |cell: u32| -> Filter {
        let near = |at: i64| texel(at) as usize;
        if parts == 1 {
            let at = i64::from(cell);
            return vec![(near(at - 1), 0.125), (near(at), 0.75), (near(at + 1), 0.125)];
        }
        let at = (f64::from(cell) + 0.5) / f64::from(parts) - 0.5;
        let (first, share) = (at.floor() as i64, at - at.floor());
        vec![(near(first), 1.0 - share), (near(first + 1), share)]
    };
    (0..length * parts).map(cell).collect()
}

/// A quad that may be divided: that of the largest power first, then that of the largest solid angle, then the first one.
#[derive(Debug, PartialEq)]
struct Candidate {
    power: f64,
    solid_angle: f64,
    node: usize,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_power = self.power.total_cmp(&other.power);
        by_power.then(self.solid_angle.total_cmp(&other.solid_angle)).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Nodes with their rectangles and powers; the link of a leaf is [`NONE`].
struct Tree {
    nodes: Vec<EnvironmentQuadNode>,
    rects: Vec<Rect>,
    powers: Vec<f64>,
}

impl Tree {
    fn new(map: &Map) -> Self {
        let mut tree = Self { nodes: Vec::new(), rects: Vec::new(), powers: Vec::new() };
        tree.push(map, Rect { min: [0; 2], max: map.grid });
        tree
    }

    fn push(&mut self, map: &Map, rect: Rect) -> Candidate {
        let (power, node) = (map.power(&rect), self.nodes.len());
        self.nodes.push(EnvironmentQuadNode { split: UVec2::ZERO, link: NONE });
        self.rects.push(rect);
        self.powers.push(power);
        Candidate { power, solid_angle: map.solid_angle(&rect), node }
    }

    fn divide(&mut self, map: &Map, most: usize) {
        let root = Candidate { power: self.powers[0], solid_angle: 4.0 * PI, node: 0 };
        if root.power <= 0.0 {
            return;
        }
        let mut open = BinaryHeap::from([root]);
        let mut quads = 1;
        while let Some(Candidate { node, .. }) = open.pop() {
            let rect = self.rects[node];
            if rect.is_cell() {
                continue;
            }
            let split = map.split(&rect);
            let parts = rect.parts(split);
            let lit = parts.iter().filter(|part| map.power(part) > 0.0).count();
            if quads + lit - 1 > most {
                break;
            }
            quads += lit - 1;
            self.nodes[node] = EnvironmentQuadNode { split: split.into(), link: self.nodes.len() as u32 };
            for part in parts {
                let part = self.push(map, part);
                if part.power > 0.0 {
                    open.push(part);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
