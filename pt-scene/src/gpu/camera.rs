//! A camera as the kernels see it.

use crate::{Camera, Projection};
use glam::{Mat4, Vec2};
use pt_shaders::records::CameraRecord;

/// The record of `camera` for a surface that shows its view: 16:9, a pinhole.
pub(super) fn view_record(camera: &Camera) -> CameraRecord {
    CameraRecord { lens_radius: 0.0, ..camera_record(camera, [16, 9]) }
}

/// The record of `camera` for an image of `size` pixels; the vertical extent is kept, the width follows the aspect.
pub fn camera_record(camera: &Camera, size: [u32; 2]) -> CameraRecord {
    let (projection, half_height) = match camera.projection {
        Projection::Perspective { yfov } => (0, (0.5 * yfov).tan()),
        Projection::Orthographic { ymag } => (1, ymag),
    };
    let aspect = size[0] as f32 / size[1] as f32;
    let world_from_view = Mat4::from(camera.world_from_camera);
    CameraRecord {
        view_from_world: world_from_view.inverse(),
        world_from_view,
        half_extent: Vec2::new(half_height * aspect, half_height),
        lens_radius: camera.lens_radius,
        focus_distance: camera.focus_distance,
        projection,
        pad: [0; 3],
    }
}
