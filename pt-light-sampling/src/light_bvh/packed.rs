//! The digits of a node, as the device reads them (`LightBvhNode`).

use glam::{Vec2, Vec3};
use pt_core::pack::{octahedral_decode, octahedral_encode};
use pt_shaders::records::LightBvhNode;

/// A unit vector in 2 x `bits` bits.
pub(super) fn pack_direction(direction: Vec3, bits: u32) -> u32 {
    let most = ((1 << bits) - 1) as f32;
    let place = octahedral_encode(direction).clamp(Vec2::NEG_ONE, Vec2::ONE);
    let q = ((0.5 * place + 0.5) * most).round();
    q.x as u32 | (q.y as u32) << bits
}

pub(super) fn unpack_direction(code: u32, bits: u32) -> Vec3 {
    let mask = (1 << bits) - 1;
    let place = Vec2::new((code & mask) as f32, (code >> bits & mask) as f32);
    octahedral_decode(2.0 * place / mask as f32 - 1.0)
}

/// Half of the size of a box about `center` that holds `lower` and `upper`.
pub(super) fn pack_extent(center: Vec3, lower: Vec3, upper: Vec3) -> u32 {
    let (center, lower, upper) = (center.as_dvec3(), lower.as_dvec3(), upper.as_dvec3());
    let extent = (upper - center).max(center - lower);
    let most = extent.max_element();
    if most <= 0.0 {
        return 0;
    }
    // A little more than needed, so that no rounding of the logarithm takes a step away.
    let exponent = (most * (1.0 + 1e-12) / 255.0).log2().ceil().clamp(-126.0, 126.0);
    let [x, y, z] = extent.to_array().map(|e| (e / exponent.exp2()).ceil().min(255.0) as u32);
    x | y << 8 | z << 16 | ((exponent as i32 + 128) as u32) << 24
}

pub(super) fn unpack_extent(code: u32) -> Vec3 {
    if code == 0 {
        return Vec3::ZERO;
    }
    let scale = ((code >> 24) as f32 - 128.0).exp2();
    Vec3::from([code, code >> 8, code >> 16].map(|c| (c & 255) as f32)) * scale
}

/// A share of 0 to 1 in 8 bits.
pub(super) fn pack_share(share: f32) -> u32 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u32
}

/// A positive number: the upper half of its bits, rounded, not 0.
pub(super) fn pack_power(power: f32) -> u32 {
    (power.clamp(f32::MIN_POSITIVE, 1e38).to_bits() + 0x8000) & 0xffff_0000
}

/// What a node knows of its lights, for the twins of kernels and for tests.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unpacked {
    pub center: Vec3,
    pub extent: Vec3,
    pub power: f32,
    pub axis: Vec3,
    /// Sines of half of the cone's half angle, and of half of the angle up to which points emit.
    pub half_sines: [f32; 2],
    /// Mean position, -1 to 1 within the box, and standard deviation over half the diagonal.
    pub mean: Vec3,
    pub deviation: f32,
    /// Mean direction of the emission, and its length.
    pub lobe: Vec3,
    pub lobe_length: f32,
}

impl Unpacked {
    pub fn of(node: &LightBvhNode) -> Self {
        let share = |word: u32, shift: u32| (word >> shift & 255) as f32 / 255.0;
        Self {
            center: node.center,
            extent: unpack_extent(node.extent),
            power: f32::from_bits(node.lobe & 0xffff_0000),
            axis: unpack_direction(node.cone & 0xffff, 8),
            half_sines: [share(node.cone, 16), share(node.cone, 24)],
            mean: 2.0 * Vec3::from([0, 8, 16].map(|shift| share(node.mean, shift))) - 1.0,
            deviation: share(node.mean, 24),
            lobe: unpack_direction(node.lobe & 1023, 5),
            lobe_length: (node.lobe >> 10 & 63) as f32 / 63.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Boxes hold what they stand for, and are at most a hundredth larger.
        #[test]
        fn boxes_are_conservative(
            lower in prop::array::uniform3(-1e3..1e3f32),
            size in prop::array::uniform3(prop_oneof![Just(0.0f32), 1e-6..1e2f32]),
        ) {
            let lower = Vec3::from(lower);
            let upper = lower + Vec3::from(size);
            let center = 0.5 * (lower + upper);
            let extent = unpack_extent(pack_extent(center, lower, upper)).as_dvec3();
            let center = center.as_dvec3();
            prop_assert!((center - extent).cmple(lower.as_dvec3()).all(), "{center} {extent}");
            prop_assert!((center + extent).cmpge(upper.as_dvec3()).all(), "{center} {extent}");
            let needed = (upper.as_dvec3() - center).max(center - lower.as_dvec3());
            prop_assert!((extent - needed).max_element() <= 0.01 * needed.max_element(), "{extent} {needed}");
        }

        #[test]
        fn directions_come_back(v in prop::array::uniform3(-1.0..1.0f32)) {
            let direction = Vec3::from(v).normalize_or(Vec3::X);
            for (bits, error) in [(8, 0.02), (5, 0.2)] {
                let found = unpack_direction(pack_direction(direction, bits), bits);
                prop_assert!(found.angle_between(direction) < error, "{direction} {found}");
            }
        }
    }

    #[test]
    fn powers_keep_two_digits_and_never_vanish() {
        for power in [1.0f32, 0.3, 1e-20, f32::MIN_POSITIVE] {
            let found = f32::from_bits(pack_power(power));
            assert!((found - power).abs() <= 4e-3 * power, "{power} {found}");
        }
        assert!(f32::from_bits(pack_power(1e-45)) > 0.0);
    }
}
