//! Local transforms of nodes.

use glam::{Affine3A, Mat4, Quat, Vec3};
use gltf::json::scene::Node;

/// The rotation of a quaternion of any length; the identity when it has none.
pub(crate) fn unit_quaternion(q: [f32; 4]) -> Quat {
    let q = Quat::from_array(q);
    if q.length_squared().is_normal() { q.normalize() } else { Quat::IDENTITY }
}

/// The transform of a node in its parent.
pub(crate) fn local_transform(node: &Node) -> Affine3A {
    if let Some(matrix) = &node.matrix {
        return Affine3A::from_mat4(Mat4::from_cols_array(matrix));
    }
    Affine3A::from_scale_rotation_translation(
        Vec3::from_array(node.scale.unwrap_or([1.0; 3])),
        node.rotation.map_or(Quat::IDENTITY, |q| unit_quaternion(q.0)),
        Vec3::from_array(node.translation.unwrap_or_default()),
    )
}
