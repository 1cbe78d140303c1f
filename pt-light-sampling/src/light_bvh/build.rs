//! Which lights share a branch: top down, by the surface area orientation heuristic over bins (Conty Estevez and Kulla 2018, section 4.4).

use super::cone::Cone;
use super::summary::{self, Summary};
use super::{MAX_DEPTH, PARALLEL, both};
use crate::LightBounds;
use glam::Vec3;
use pt_shaders::constants::NONE;
use pt_shaders::records::{LIGHT_BVH_LEAF, LightBvhNode};

/// Bins per axis.
const BINS: usize = 16;

/// Lights that may become a node.
#[derive(Clone, Copy)]
struct Group {
    lower: Vec3,
    upper: Vec3,
    cone: Cone,
    cos_emission: f32,
    power: f32,
}

impl Group {
    fn of(light: &LightBounds) -> Self {
        Self {
            lower: light.bounds.min,
            upper: light.bounds.max,
            cone: Cone { axis: light.axis.normalize(), spread: light.cos_spread.clamp(-1.0, 1.0).acos() },
            cos_emission: light.cos_emission,
            power: light.power,
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
            cone: self.cone.union(other.cone),
            cos_emission: self.cos_emission.min(other.cos_emission),
            power: self.power + other.power,
        }
    }

    /// What the heuristic adds up. The area is that of the bounding sphere, by which the sampler judges a node: lights in a row have a
    /// box without area.
    fn cost(&self) -> f32 {
        let area = (self.upper - self.lower).length_squared();
        self.power * area * self.cone.orientation_measure(self.cos_emission)
    }
}

#[derive(Clone, Copy)]
struct Item {
    group: Group,
    light: u32,
}

impl Item {
    fn center(&self) -> Vec3 {
        0.5 * (self.group.lower + self.group.upper)
    }
}

/// Nodes with links alone: the root, then its block. The block of a node over n lights is its 2 n - 2 descendants: its two children, the
/// block of the first, the block of the second.
pub(super) fn topology(lights: &[LightBounds]) -> Vec<LightBvhNode> {
    let usable = (0..).zip(lights).filter(|(_, light)| Summary::of(light, 1.0).is_some());
    let mut items = Vec::with_capacity(lights.len());
    items.extend(usable.map(|(light, bounds)| Item { group: Group::of(bounds), light }));
    if items.is_empty() {
        return vec![summary::dark(NONE)];
    }
    let mut nodes = vec![summary::dark(0); 2 * items.len() - 1];
    if let [root, block @ ..] = &mut nodes[..] {
        branch(&mut items, 0, root, block, 1);
    }
    nodes
}

/// `first`: index of the first node of `block`.
fn branch(items: &mut [Item], depth: u32, node: &mut LightBvhNode, block: &mut [LightBvhNode], first: u32) {
    if let [item] = items {
        node.link = LIGHT_BVH_LEAF | item.light;
        return;
    }
    node.link = first;
    let middle = split(items, depth);
    let parallel = items.len() >= PARALLEL;
    let (left_items, right_items) = items.split_at_mut(middle);
    let ([left, right], rest) =
        block.split_first_chunk_mut().expect("a node of several lights has two children");
    let (left_block, right_block) = rest.split_at_mut(2 * middle - 2);
    let second = first + 2 + left_block.len() as u32;
    both(
        parallel,
        || branch(left_items, depth + 1, left, left_block, first + 2),
        || branch(right_items, depth + 1, right, right_block, second),
    );
}

/// Orders the items, two or more, such that the first child gets those before the returned place.
fn split(items: &mut [Item], depth: u32) -> usize {
    let centers = |items: &[Item], f: fn(Vec3, Vec3) -> Vec3| {
        items.iter().map(Item::center).reduce(f).unwrap_or_default()
    };
    let lower = centers(items, Vec3::min);
    let extent = centers(items, Vec3::max) - lower;
    // So deep that halves are the only way to stay within the limit.
    let levels = usize::BITS - (items.len() - 1).leading_zeros();
    if depth + levels < MAX_DEPTH
        && let Some(plane) = Plane::best(items, lower, extent)
    {
        return partition(items, |item| plane.is_before(item));
    }
    let axis = extent.max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.center()[axis].total_cmp(&b.center()[axis]).then(a.light.cmp(&b.light))
    });
    middle
}

fn partition(items: &mut [Item], before: impl Fn(&Item) -> bool) -> usize {
    let mut middle = 0;
    for i in 0..items.len() {
        if before(&items[i]) {
            items.swap(i, middle);
            middle += 1;
        }
    }
    middle
}

/// A border between bins.
struct Plane {
    axis: usize,
    lower: f32,
    scale: f32,
    bin: usize,
}

impl Plane {
    fn bin(item: &Item, axis: usize, lower: f32, scale: f32) -> usize {
        (((item.center()[axis] - lower) * scale) as usize).min(BINS - 1)
    }

    fn is_before(&self, item: &Item) -> bool {
        Self::bin(item, self.axis, self.lower, self.scale) <= self.bin
    }

    /// The one of least cost, the more balanced one of equals. `None` if no plane parts the centres.
    fn best(items: &[Item], lower: Vec3, extent: Vec3) -> Option<Self> {
        let size = items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, u), item| {
            (l.min(item.group.lower), u.max(item.group.upper))
        });
        let size = size.1 - size.0;
        let mut best: Option<(f32, usize, Self)> = None;
        for axis in 0..3 {
            let scale = BINS as f32 / extent[axis];
            if !scale.is_finite() {
                continue;
            }
            let mut bins: [(usize, Option<Group>); BINS] = [(0, None); BINS];
            for item in items {
                let (count, group) = &mut bins[Self::bin(item, axis, lower[axis], scale)];
                *count += 1;
                *group = join(*group, Some(item.group));
            }
            // Lights after each bin.
            let mut after = [None; BINS];
            for bin in (1..BINS).rev() {
                after[bin - 1] = join(after[bin], bins[bin].1);
            }
            let thin = size.max_element() / size[axis];
            let (mut before, mut count) = (None, 0);
            for (bin, (n, group)) in bins.into_iter().enumerate() {
                before = join(before, group);
                count += n;
                let (Some(_), Some(a), Some(b)) = (group, before, after[bin]) else { continue };
                let cost = thin * (a.cost() + b.cost());
                let unequal = count.abs_diff(items.len() - count);
                if cost.is_finite() && best.as_ref().is_none_or(|(c, u, _)| (cost, unequal) < (*c, *u)) {
                    best = Some((cost, unequal, Self { axis, lower: lower[axis], scale, bin }));
                }
            }
        }
        best.map(|(.., plane)| plane)
    }
}

fn join(a: Option<Group>, b: Option<Group>) -> Option<Group> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union(b)),
        (a, b) => a.or(b),
    }
}
