//! Local transforms of nodes.

use glam::{Affine3A, Mat4, Quat, Vec3, Vec3A};
use gltf::json::scene::Node;
use pt_scene::animation::Trs;
use pt_scene::thickened;

/// The rotation of a quaternion of any length; the identity when it has none.
pub(crate) fn unit_quaternion(q: [f32; 4]) -> Quat {
    let q = Quat::from_array(q);
    if q.length_squared().is_normal() { q.normalize() } else { Quat::IDENTITY }
}

/// Volume of the parallelepiped of a matrix's axes, scaled to unit length, below which they lie in a plane but for rounding.
const FLAT: f32 = 1e-6;

/// The transform of a node in its parent; a flat one keeps a small thickness, see [`thickened`].
pub(crate) fn local_transform(node: &Node) -> Affine3A {
    if let Some(matrix) = &node.matrix {
        let transform = Affine3A::from_mat4(Mat4::from_cols_array(matrix));
        let [x, y, z] = [Vec3A::X, Vec3A::Y, Vec3A::Z]
            .map(|axis| (transform.matrix3 * axis).try_normalize().unwrap_or(Vec3A::ZERO));
        let is_flat = x.cross(y).dot(z).abs() < FLAT;
        return if is_flat { thickened(&transform).unwrap_or(transform) } else { transform };
    }
    local_trs(node).into()
}

/// Translation, rotation and scale of a node that has no matrix.
pub(crate) fn local_trs(node: &Node) -> Trs {
    Trs {
        translation: Vec3::from_array(node.translation.unwrap_or_default()),
        rotation: node.rotation.map_or(Quat::IDENTITY, |q| unit_quaternion(q.0)),
        scale: Vec3::from_array(node.scale.unwrap_or([1.0; 3])),
    }
}
