//! Limits on transforms.

use glam::{Affine3A, Quat, Vec3};

/// Farthest that anything may be from the origin, metres: the areas that trees are built by stay far from overflow.
pub const MAX_COORDINATE: f32 = 1e12;

/// Finite, with an inverse in single precision that takes all of the world, MAX_COORDINATE to each side, to finite points.
pub fn is_invertible(transform: &Affine3A) -> bool {
    let determinant = transform.matrix3.determinant();
    let inverse = transform.inverse();
    let [x, y, z] = [inverse.x_axis, inverse.y_axis, inverse.z_axis].map(|axis| axis.abs() * MAX_COORDINATE);
    transform.is_finite() && determinant.is_normal() && (x + y + z + inverse.translation.abs()).is_finite()
}

/// The nearest transform that can be inverted: what is scaled to nothing keeps a millionth of its size.
pub fn visible(transform: Affine3A) -> Affine3A {
    if is_invertible(&transform) {
        return transform;
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
        let shown = visible(Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 0.0, 1.0),
            Quat::IDENTITY,
            Vec3::Y,
        ));
        assert!(is_invertible(&shown) && shown.translation == Vec3::Y.into());
        assert!(is_invertible(&visible(Affine3A::from_scale(Vec3::splat(f32::NAN)))));
        let fine = Affine3A::from_scale(Vec3::new(2.0, -1.0, 1.0));
        assert_eq!(visible(fine), fine);
        // Can be inverted, but takes what is far away beyond single precision.
        assert!(!is_invertible(&Affine3A::from_scale(Vec3::new(1.0, 1.0, 1e-30))));
    }
}
