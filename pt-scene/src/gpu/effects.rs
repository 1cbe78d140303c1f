//! The effects on the device: records in the order of a tree over their bounding boxes, which is made anew whenever something has moved.
//!
//! Effects have no closest hit: a ray blends all of them. The tree is thus not that of a trace backend, whose shaders would be called for each
//! hit in an order of their own; one traversal in GLSL (`effects.glsl`) gives the same bits with all backends.

use crate::{Bounds, Effects};
use glam::Vec3;
use pt_core::frame::Pass;
use pt_core::{Buffer, Device, Frame, Location, Result};
use pt_shaders::records::{
    EFFECT_COUNT_BITS, EffectNode, EffectRecord, FogRecord, MAX_FOG_VOLUMES, NONE, SceneRecord,
};

/// Effects of a leaf at most.
const LEAF: usize = 4;
const _: () = assert!(LEAF < 1 << EFFECT_COUNT_BITS);

/// Buffers of the effects.
pub(super) struct EffectBuffers {
    effects: Buffer,
    nodes: Buffer,
    fog: Buffer,
    /// The times that they hold.
    uploaded: Option<[f64; 2]>,
}

impl EffectBuffers {
    /// Buffers for as many as there are; `None` without effects.
    pub(super) fn new(device: &Device, effects: &Effects) -> Result<Option<Self>> {
        if effects.is_empty() {
            return Ok(None);
        }
        let buffer = |name: &str, bytes: usize| Buffer::new(device, name, bytes as u64, Location::Device);
        let count = effects.count().max(1);
        Ok(Some(Self {
            effects: buffer("effects", count * size_of::<EffectRecord>())?,
            nodes: buffer("effect nodes", 2 * count * size_of::<EffectNode>())?,
            fog: buffer("fog", MAX_FOG_VOLUMES as usize * size_of::<FogRecord>())?,
            uploaded: None,
        }))
    }

    /// Brings the device up to date; without change it records nothing.
    pub(super) fn update(
        &mut self,
        frame: &mut Frame<'_>,
        effects: &Effects,
        scene: &mut SceneRecord,
    ) -> Result<()> {
        let times = [effects.time, effects.time_prev];
        let moved = self.uploaded != Some(times) && effects.is_animated();
        if self.uploaded.is_some() && !moved {
            return Ok(());
        }
        self.uploaded = Some(times);
        let (records, nodes) = effect_tree(effect_records(effects));
        let fog = fog_records(effects);
        frame.upload(&self.effects, bytemuck::cast_slice(&records))?;
        frame.upload(&self.nodes, bytemuck::cast_slice(&nodes))?;
        frame.upload(&self.fog, bytemuck::cast_slice(&fog))?;
        scene.effects = self.effects.address();
        scene.effect_nodes = self.nodes.address();
        scene.fog = self.fog.address();
        scene.effect_node_count = nodes.len() as u32;
        scene.fog_count = fog.len() as u32;
        Ok(())
    }

    /// Declares what kernels reach through addresses.
    pub(super) fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        pass.addresses(&self.effects).addresses(&self.nodes).addresses(&self.fog)
    }
}

/// Of all that have a finite place at their time: particles, sprites, beams.
pub fn effect_records(effects: &Effects) -> Vec<EffectRecord> {
    // What starts again in this frame counts as if it had come from before its start.
    let step = (effects.time_prev - effects.time) as f32;
    let sprite_free = |position, radius, axis, look: &crate::Look, drift: &crate::Drift| EffectRecord {
        position: position + drift.at(effects.time),
        radius,
        axis,
        opacity: look.opacity,
        half_height: Vec3::ZERO,
        texture: NONE,
        radiance: look.radiance,
        displacement: drift.velocity * step,
    };
    let particles =
        effects.particles.iter().map(|e| sprite_free(e.position, e.radius, Vec3::ZERO, &e.look, &e.drift));
    let sprites = effects.sprites.iter().map(|e| EffectRecord {
        half_height: e.half_sides[1],
        texture: e.texture.unwrap_or(NONE),
        ..sprite_free(e.position, 0.0, e.half_sides[0], &e.look, &e.drift)
    });
    let beams = effects
        .beams
        .iter()
        .map(|e| sprite_free(e.ends[0], e.radius, e.ends[1] - e.ends[0], &e.look, &e.drift));
    particles.chain(sprites).chain(beams).filter(|e| e.position.is_finite()).collect()
}

/// Fog where it is at its time.
pub fn fog_records(effects: &Effects) -> Vec<FogRecord> {
    let placed = effects.fog.iter().map(|e| {
        let moved = e.drift.at(effects.time);
        FogRecord {
            min: e.corners[0] + moved,
            density: e.density,
            max: e.corners[1] + moved,
            gradient: e.gradient,
            radiance: e.radiance,
        }
    });
    placed.filter(|e| e.min.is_finite() && e.max.is_finite()).collect()
}

fn bounds(e: &EffectRecord) -> Bounds {
    if e.radius > 0.0 {
        let other = e.position + e.axis;
        Bounds { min: e.position.min(other) - e.radius, max: e.position.max(other) + e.radius }
    } else {
        let reach = e.axis.abs() + e.half_height.abs();
        Bounds { min: e.position - reach, max: e.position + reach }
    }
}

/// The tree over `effects`, which it brings into leaf order: by the bits of Morton codes (Lauterbach et al. 2009, "Fast BVH Construction on GPUs"),
/// with links that skip a node (Smits 1998, "Efficiency Issues for Ray Tracing").
pub fn effect_tree(effects: Vec<EffectRecord>) -> (Vec<EffectRecord>, Vec<EffectNode>) {
    if effects.is_empty() {
        return (effects, Vec::new());
    }
    let boxes: Vec<Bounds> = effects.iter().map(bounds).collect();
    let all = boxes.iter().skip(1).fold(boxes[0], |all, b| all.union(b));
    let scale = CELLS / (all.max - all.min).max(Vec3::splat(f32::MIN_POSITIVE));
    // The index makes the order of equal codes that of the scene.
    let mut order: Vec<Entry> = boxes
        .iter()
        .zip(0..)
        .map(|(b, i)| {
            let cell = ((0.5 * (b.min + b.max) - all.min) * scale).clamp(Vec3::ZERO, Vec3::splat(CELLS));
            let [x, y, z] = cell.to_array().map(|c| spread(c as u64));
            (x << 2 | y << 1 | z, i)
        })
        .collect();
    order.sort_unstable();
    let mut nodes = Vec::with_capacity(effects.len());
    build(&boxes, &order, 0, &mut nodes);
    (order.iter().map(|&(_, i)| effects[i as usize]).collect(), nodes)
}

/// Morton code and number of an effect.
type Entry = (u64, u32);

/// Cells of the codes on an axis, less one: so many that a cell is small even where one effect is far from all others.
const CELLS: f32 = ((1 << 21) - 1) as f32;

/// Adds the subtree over `order`, whose first entry is number `first` in leaf order.
fn build(boxes: &[Bounds], order: &[Entry], first: usize, nodes: &mut Vec<EffectNode>) -> Bounds {
    let own = nodes.len();
    nodes.push(EffectNode { min: Vec3::ZERO, skip: 0, max: Vec3::ZERO, effects: 0 });
    let of = |entry: &Entry| &boxes[entry.1 as usize];
    let (b, effects) = if order.len() <= LEAF {
        let b = order[1..].iter().fold(*of(&order[0]), |b, entry| b.union(of(entry)));
        (b, (first as u32) << EFFECT_COUNT_BITS | order.len() as u32)
    } else {
        let (lower, upper) = order.split_at(split(order));
        let b = build(boxes, lower, first, nodes);
        (b.union(&build(boxes, upper, first + lower.len(), nodes)), 0)
    };
    nodes[own] = EffectNode { min: b.min, skip: nodes.len() as u32, max: b.max, effects };
    b
}

/// Where the highest bit changes in which codes differ; the middle where all are equal.
fn split(order: &[Entry]) -> usize {
    match (order[0].0 ^ order[order.len() - 1].0).checked_ilog2() {
        Some(bit) => order.partition_point(|entry| entry.0 >> bit & 1 == 0),
        None => order.len() / 2,
    }
}

/// Two zero bits before each of the lower 21.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::hash;

    /// Effects that a traversal finds which enters the nodes that `met` says; and the nodes that it looks at.
    fn found(nodes: &[EffectNode], met: impl Fn(&EffectNode) -> bool) -> (Vec<usize>, usize) {
        let (mut effects, mut looked, mut node) = (Vec::new(), 0, 0);
        while node < nodes.len() {
            let n = &nodes[node];
            looked += 1;
            let count = n.effects & ((1 << EFFECT_COUNT_BITS) - 1);
            let inside = met(n);
            if inside {
                let first = (n.effects >> EFFECT_COUNT_BITS) as usize;
                effects.extend(first..first + count as usize);
            }
            node = if inside && count == 0 { node + 1 } else { n.skip as usize };
        }
        (effects, looked)
    }

    #[test]
    fn codes_interleave_bits() {
        for x in [0, 1, 2, 3, 0x15_5555, 0x0a_aaaa, 0x1f_ffff_u64] {
            let right = (0..21).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit));
            assert_eq!(spread(x), right);
        }
    }

    #[test]
    fn the_tree_finds_what_is_there_and_skips_the_rest() {
        for count in [0, 1, 4, 5, 1000] {
            let mut scattered: Vec<_> = (0..count)
                .map(|i| EffectRecord {
                    position: 10.0 * Vec3::new(hash(i, 0, 1), hash(i, 1, 1), hash(i, 2, 1)),
                    // Every third one is a sprite.
                    radius: if i % 3 == 0 { 0.0 } else { 0.1 },
                    axis: Vec3::new(0.3, 0.0, 0.2 * hash(i, 3, 1)),
                    half_height: Vec3::new(0.0, 0.2, 0.0),
                    ..bytemuck::Zeroable::zeroed()
                })
                .collect();
            // Ten of them at one place, and one far from all others.
            (2..12).for_each(|i| {
                if count == 1000 {
                    scattered[i].position = scattered[1].position
                }
            });
            scattered.iter_mut().take(1).for_each(|e| e.position.x = 1e5);
            let (records, nodes) = effect_tree(scattered.clone());
            let sorted = |list: &[EffectRecord]| {
                let mut keys: Vec<_> = list.iter().map(|e| e.position.to_array().map(f32::to_bits)).collect();
                keys.sort_unstable();
                keys
            };
            assert_eq!(sorted(&records), sorted(&scattered));
            let (all, _) = found(&nodes, |_| true);
            assert_eq!(all, (0..count as usize).collect::<Vec<_>>());
            assert_eq!(found(&nodes, |_| false).1, usize::from(count > 0));
            // A box finds at least the effects whose boxes it meets.
            let wanted = Bounds { min: Vec3::splat(4.0), max: Vec3::splat(6.0) };
            let meets = |min: Vec3, max: Vec3| min.cmple(wanted.max).all() && wanted.min.cmple(max).all();
            let (some, looked) = found(&nodes, |n| meets(n.min, n.max));
            for (i, e) in records.iter().enumerate() {
                let b = bounds(e);
                assert!(!meets(b.min, b.max) || some.contains(&i));
            }
            assert!(count < 1000 || looked < nodes.len() / 4, "{looked} of {} nodes", nodes.len());
        }
    }
}
