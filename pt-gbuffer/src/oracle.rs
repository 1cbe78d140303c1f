//! The stages on the CPU, plain: what the kernels are tested against. Materials stay out of it: textures need the GPU's
//! filter.

pub mod dielectric;
pub mod effects;
pub mod godrays;

use glam::{DMat4, DVec2, DVec3, Vec3};
use pt_core::trace::NativeScene;
use pt_scene::Scene;
use pt_shaders::records::{CameraRecord, NONE, Ray, SKY_DISTANCE};

/// The hit of a pixel's ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Instance index.
    pub instance: u32,
    /// Triangle of its mesh.
    pub triangle: u32,
    /// World space.
    pub position: DVec3,
    /// Interpolated vertex normal on the viewer's side, world space.
    pub vertex_normal: DVec3,
    /// Distance from the camera.
    pub view_depth: f64,
    /// xy: previous minus current UV, z: previous minus current distance.
    pub motion: DVec3,
}

/// Ray through UV `uv` of a pinhole or orthographic camera.
pub fn camera_ray(camera: &CameraRecord, uv: DVec2) -> (DVec3, DVec3) {
    let world_from_view = DMat4::from_cols_array(&camera.world_from_view.to_cols_array().map(f64::from));
    let plane = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y) * camera.half_extent.as_dvec2();
    let (origin, direction) = match camera.projection {
        0 => (DVec3::ZERO, plane.extend(-1.0)),
        _ => (plane.extend(0.0), DVec3::NEG_Z),
    };
    (world_from_view.transform_point3(origin), world_from_view.transform_vector3(direction).normalize())
}

/// UV and distance of a world position.
pub fn project(camera: &CameraRecord, position: DVec3) -> DVec3 {
    let view_from_world = DMat4::from_cols_array(&camera.view_from_world.to_cols_array().map(f64::from));
    let view = view_from_world.transform_point3(position);
    let (scale, distance) = match camera.projection {
        0 => (1.0 / -view.z, view.length()),
        _ => (1.0, -view.z),
    };
    let plane = view.truncate() * scale / camera.half_extent.as_dvec2();
    DVec3::new(0.5 + 0.5 * plane.x, 0.5 - 0.5 * plane.y, distance)
}

/// The first surface behind UV `uv`; `None`: the environment. `before` is the scene with its meshes in the previous pose; the same as
/// `scene` where none deforms.
pub fn primary(
    scene: &Scene,
    before: &Scene,
    native: &NativeScene,
    camera: &CameraRecord,
    camera_prev: &CameraRecord,
    uv: DVec2,
) -> Option<Surface> {
    let (origin, direction) = camera_ray(camera, uv);
    let ray =
        Ray { origin: origin.as_vec3(), t_min: 0.0, direction: direction.as_vec3(), t_max: SKY_DISTANCE };
    let hit = native.closest(&ray, u32::MAX, None);
    if hit.instance == NONE {
        return None;
    }
    let instance = &scene.instances[hit.instance as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    let corners = mesh.indices[hit.triangle as usize].map(|i| i as usize);
    let weights = [1.0 - hit.barycentrics.x - hit.barycentrics.y, hit.barycentrics.x, hit.barycentrics.y];
    let blend = |values: &[Vec3]| (0..3).map(|k| values[corners[k]] * weights[k]).sum::<Vec3>();
    let local = blend(&mesh.positions);
    let position = instance.world_from_object.transform_point3(local).as_dvec3();
    let local_before = blend(&before.meshes[instance.mesh as usize].positions);
    let before = instance.world_from_object_prev.transform_point3(local_before).as_dvec3();

    let to_world = instance.world_from_object.matrix3.inverse().transpose();
    let [a, b, c] = corners.map(|i| mesh.positions[i]);
    let flat = to_world * glam::Vec3A::from((b - a).cross(c - a));
    let normal = Vec3::from(to_world * glam::Vec3A::from(blend(&mesh.normals))).normalize().as_dvec3();
    let face = Vec3::from(flat).as_dvec3().normalize();
    let facing = face.dot(direction) < 0.0;
    let (now, then) = (project(camera, position), project(camera_prev, before));
    Some(Surface {
        instance: hit.instance,
        triangle: hit.triangle,
        position,
        vertex_normal: {
            let (normal, face) = if facing { (normal, face) } else { (-normal, -face) };
            // One that points into the surface is worth nothing.
            if normal.dot(face) <= 0.0 { face } else { normal }
        },
        view_depth: now.z,
        motion: then - now,
    })
}
