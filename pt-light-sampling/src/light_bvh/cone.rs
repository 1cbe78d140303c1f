use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI};

/// What rounding may take from the half angle of a union, radians.
const ROUNDING: f32 = 1e-6;

/// A cone of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// Unit length.
    pub axis: Vec3,
    /// Half angle in radians, 0 to pi.
    pub spread: f32,
}

impl Cone {
    /// The narrowest cone about both (Conty Estevez and Kulla 2018, algorithm 1).
    pub fn union(self, other: Self) -> Self {
        let (wide, narrow) = if self.spread >= other.spread { (self, other) } else { (other, self) };
        let between = angle(wide.axis, narrow.axis);
        if (between + narrow.spread).min(PI) <= wide.spread {
            return wide;
        }
        let spread = 0.5 * (wide.spread + between + narrow.spread) + ROUNDING;
        if spread >= PI {
            return Self { axis: wide.axis, spread: PI };
        }
        let turn = spread - wide.spread;
        let across = narrow.axis - wide.axis * wide.axis.dot(narrow.axis);
        let across = across.try_normalize().unwrap_or_else(|| wide.axis.any_orthonormal_vector());
        Self { axis: (wide.axis * turn.cos() + across * turn.sin()).normalize(), spread }
    }

    /// Measure of the directions that light leaves in, each normal weighted by the cosine: M_Omega of the same paper, section 4.1.
    pub fn orientation_measure(&self, cos_emission: f32) -> f32 {
        let reach = (self.spread + cos_emission.clamp(-1.0, 1.0).acos()).min(PI);
        let (sin, cos) = self.spread.sin_cos();
        let ring = 2.0 * reach * sin - (self.spread - 2.0 * reach).cos() - 2.0 * self.spread * sin + cos;
        2.0 * PI * (1.0 - cos) + FRAC_PI_2 * ring
    }
}

/// Angle between unit vectors, precise for small and large angles too.
pub(super) fn angle(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cone() -> impl Strategy<Value = Cone> {
        let axis = prop_oneof![
            (-1.0..1.0f32, -1.0..1.0f32, -1.0..1.0f32)
                .prop_map(|(x, y, z)| Vec3::new(x, y, z).normalize_or(Vec3::X)),
            prop_oneof![Just(Vec3::X), Just(Vec3::NEG_X), Just(Vec3::Y)],
        ];
        (axis, prop_oneof![Just(0.0), 0.0..PI, Just(PI)]).prop_map(|(axis, spread)| Cone { axis, spread })
    }

    proptest! {
        /// A union contains both cones, and is no wider than half of their angles and the angle between them.
        #[test]
        fn unions_contain_both(a in cone(), b in cone()) {
            let union = a.union(b);
            prop_assert!((union.axis.length() - 1.0).abs() < 1e-5);
            for cone in [a, b] {
                let farthest = (angle(union.axis, cone.axis) + cone.spread).min(PI);
                prop_assert!(farthest <= union.spread + 2e-6, "{a:?} {b:?} {union:?}");
            }
            let tight = 0.5 * (a.spread + b.spread + angle(a.axis, b.axis));
            prop_assert!(union.spread <= tight.max(a.spread).max(b.spread) + 2e-6);
        }
    }

    /// A flat emitter: pi. All directions: 4 pi, whatever the emission.
    #[test]
    fn orientation_measures_of_known_cones() {
        let flat = Cone { axis: Vec3::Y, spread: 0.0 };
        assert!((flat.orientation_measure(0.0) - PI).abs() < 1e-5);
        assert!(flat.orientation_measure(1.0).abs() < 1e-5);
        let all = Cone { axis: Vec3::Y, spread: PI };
        assert!((all.orientation_measure(0.0) - 4.0 * PI).abs() < 1e-4);
    }
}
