//! The effects of a scene: what is seen, but neither lights anything nor stops light.

use crate::gpu_struct;
use glam::Vec3;

gpu_struct! {
    /// A particle, a beam or a sprite, world space.
    pub struct EffectRecord {
        /// One end of the axis of a particle or beam; centre of a sprite.
        pub position: Vec3,
        /// Of a particle or beam, metres; 0: a sprite.
        pub radius: f32,
        /// To the other end of a beam, 0 for a particle; half the width of a sprite.
        pub axis: Vec3,
        /// Share of the light behind it that it stops where it is densest.
        pub opacity: f32,
        /// Half the height of a sprite.
        pub half_height: Vec3,
        /// Bindless index of the texture of a sprite, or [`NONE`](super::NONE).
        pub texture: u32,
        /// Emitted radiance where it is densest.
        pub radiance: Vec3,
        /// Where it was in the last frame, relative to where it is now, metres.
        pub displacement: Vec3,
    }
}

gpu_struct! {
    /// A node of the binary tree over the effects. Nodes stand in the order of a depth-first traversal: the first child of a node that has
    /// children follows it.
    pub struct EffectNode {
        /// Bounding box, world space.
        pub min: Vec3,
        /// The node that follows when nothing in this one is met.
        pub skip: u32,
        /// Bounding box, world space.
        pub max: Vec3,
        /// The lowest `EFFECT_COUNT_BITS` bits: number of effects, 0 for a node with children. Above: the first of them.
        pub effects: u32,
    }
}

gpu_struct! {
    /// A box of fog whose density is a linear function of the position.
    pub struct FogRecord {
        /// Corner, world space.
        pub min: Vec3,
        /// Extinction there, 1/m.
        pub density: f32,
        /// Opposite corner.
        pub max: Vec3,
        /// How the extinction changes, 1/m^2.
        pub gradient: Vec3,
        /// Radiance of fog that nothing shines through.
        pub radiance: Vec3,
    }
}
