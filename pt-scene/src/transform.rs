//! Limits on transforms.

use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};

/// Farthest that anything may be from the origin, metres: the areas that trees are built by stay far from overflow.
pub const MAX_COORDINATE: f32 = 1e12;

/// Finite, with an inverse in single precision that takes all of the world, MAX_COORDINATE to each side, to finite points.
pub fn is_invertible(transform: &Affine3A) -> bool {
    let determinant = transform.matrix3.determinant();
    let inverse = transform.inverse();
    let [x, y, z] = [inverse.x_axis, inverse.y_axis, inverse.z_axis].map(|axis| axis.abs() * MAX_COORDINATE);
    transform.is_finite() && determinant.is_normal() && (x + y + z + inverse.translation.abs()).is_finite()
}

/// What a flattened object keeps of its longest axis along the one that vanishes.
const THICKNESS: f32 = 1e-6;

/// Scale factors without the zero of a single axis, which becomes a small number of the same sign: what is flattened stays an object
/// with two sides, with normals that are the limit of those of ever smaller factors.
pub fn thicken(scale: Vec3) -> Vec3 {
    let longest = scale.abs().max_element();
    let mut factors = scale.to_array();
    if factors.iter().filter(|&&factor| factor == 0.0).count() == 1 {
        for factor in factors.iter_mut().filter(|factor| **factor == 0.0) {
            *factor = (THICKNESS * longest).copysign(*factor);
        }
    }
    factors.into()
}

/// A transform that flattens space onto a plane, with a small thickness and without mirroring; `None` for one that flattens onto a
/// line or a point, or that single precision does not hold.
pub fn thickened(transform: &Affine3A) -> Option<Affine3A> {
    let longest_cross = |a: Vec3A, b: Vec3A, c: Vec3A| {
        let crosses = [a.cross(b), b.cross(c), c.cross(a)];
        crosses.into_iter().max_by(|x, y| x.length_squared().total_cmp(&y.length_squared()))
    };
    let m = transform.matrix3;
    let longest = m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
    if !transform.is_finite() || !longest.is_normal() {
        return None;
    }
    // Of unit scale, so that squares neither vanish nor overflow.
    let m = m * longest.recip();
    let rows = m.transpose();
    let plane = longest_cross(m.x_axis, m.y_axis, m.z_axis).filter(|n| n.length() > THICKNESS)?.normalize();
    let lost = longest_cross(rows.x_axis, rows.y_axis, rows.z_axis)?.try_normalize()?;
    let with = |side: f32| {
        let thick = |column: Vec3A, lost: f32| longest * (column + side * THICKNESS * lost * plane);
        let columns = [thick(m.x_axis, lost.x), thick(m.y_axis, lost.y), thick(m.z_axis, lost.z)];
        Affine3A { matrix3: Mat3A::from_cols(columns[0], columns[1], columns[2]), ..*transform }
    };
    let thick = [with(1.0), with(-1.0)].into_iter().find(|t| t.matrix3.determinant() > 0.0)?;
    is_invertible(&thick).then_some(thick)
}

/// The nearest transform that can be inverted: what is flattened keeps a small thickness, and what is scaled to a line or a point a
/// millionth of its size.
pub fn visible(transform: Affine3A) -> Affine3A {
    if is_invertible(&transform) {
        return transform;
    }
    if let Some(thick) = thickened(&transform) {
        return thick;
    }
    let translation = Vec3::from(transform.translation);
    let translation = if translation.is_finite() { translation } else { Vec3::ZERO };
    Affine3A::from_scale_rotation_translation(Vec3::splat(1e-6), Quat::IDENTITY, translation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_vanishes_stays_invertible() {
        let line = Vec3::new(1.0, 0.0, 0.0);
        let shown = visible(Affine3A::from_scale_rotation_translation(line, Quat::IDENTITY, Vec3::Y));
        assert!(is_invertible(&shown) && shown.translation == Vec3::Y.into());
        assert!(is_invertible(&visible(Affine3A::from_scale(Vec3::splat(f32::NAN)))));
        let fine = Affine3A::from_scale(Vec3::new(2.0, -1.0, 1.0));
        assert_eq!(visible(fine), fine);
        for gone in [line, Vec3::ZERO] {
            assert_eq!(thickened(&Affine3A::from_scale(gone)), None);
        }
        // Can be inverted, but takes what is far away beyond single precision.
        assert!(!is_invertible(&Affine3A::from_scale(Vec3::new(1.0, 1.0, 1e-30))));
    }
    #[test]
    fn what_is_flattened_keeps_its_plane_and_its_normals() {
        let turn = Quat::from_rotation_x(0.7) * Quat::from_rotation_y(-0.4);
        for scale in [Vec3::new(2.0, 3.0, 0.0), Vec3::new(0.0, 1e-3, 2e-3), Vec3::new(500.0, 0.0, 1.0)] {
            let flat = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ONE);
            let Some(thick) = thickened(&flat) else { panic!("{scale} is a plane") };
            assert!(is_invertible(&thick) && thick.matrix3.determinant() > 0.0);
            let longest = scale.max_element();
            for corner in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE] {
                let moved = thick.transform_point3(corner) - flat.transform_point3(corner);
                assert!(moved.length() < 2e-6 * longest, "{corner} moves by {moved}");
            }
            // The normal of the plane that stays: that of every surface which is not seen edge-on.
            let normal = (thick.matrix3.inverse().transpose() * Vec3A::ONE).normalize();
            let lost = if scale.x == 0.0 {
                Vec3::X
            } else if scale.y == 0.0 {
                Vec3::Y
            } else {
                Vec3::Z
            };
            assert!(normal.abs_diff_eq((turn * lost).into(), 1e-2), "{normal} is not {}", turn * lost);
        }
    }

    #[test]
    fn a_lone_zero_among_scale_factors_is_replaced() {
        assert_eq!(thicken(Vec3::new(-2.0, 0.0, 1.0)), Vec3::new(-2.0, 2e-6, 1.0));
        assert_eq!(thicken(Vec3::new(1.0, 1.0, -0.0)), Vec3::new(1.0, 1.0, -1e-6));
        for kept in [Vec3::ZERO, Vec3::X, Vec3::new(1.0, -1.0, 1e-12)] {
            assert_eq!(thicken(kept), kept);
        }
    }
}
