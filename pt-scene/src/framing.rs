use glam::Vec3;
use pt_core::trace::{BvhQuality, NativeScene};
use pt_shaders::records::Ray;

use crate::gpu::{mesh_geometry, placements};
use crate::{Bounds, Camera, Scene};

/// Vertical field of view of automatic cameras, radians (exterior and interior).
const EXTERIOR_YFOV: f32 = 0.7;
const INTERIOR_YFOV: f32 = 1.05;

/// A camera for a scene that has none.
///
/// From the centre of the bounding box, rays go out to all sides. If at least 90 % of those within 30 degrees of the horizon
/// and at least 80 % of those further down see the *front* of a surface, and the surfaces are on average further
/// away than a fifth of the mean horizontal half extent, the scene is a room seen from within
/// (inside a solid object rays meet backs). Then the camera stands towards one end of the room's longest horizontal
/// axis, as far out as there is clear space around it, at eye height (1.65 m over the floor under the centre, kept within 10 to 40 % of the room's height), and looks along that
/// axis to the other end.
///
/// Otherwise the camera looks at the centre from the front, right and above, from so far away that the bounding sphere
/// is in view for any aspect of at least 1. An empty scene is looked at as if it were a unit box.
pub fn automatic_camera(scene: &Scene) -> Camera {
    let Some(bounds) = scene.bounds().filter(|b| b.size().is_finite()) else {
        return exterior(&Bounds { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) });
    };
    match Rays::new(scene).filter(|rays| rays.are_inside_a_room(&bounds)) {
        Some(rays) => rays.interior(&bounds),
        None => exterior(&bounds),
    }
}

fn exterior(bounds: &Bounds) -> Camera {
    let radius = match 0.5 * bounds.size().length() {
        // A single point, whatever it may be.
        0.0 => 0.5,
        radius => radius,
    };
    let distance = radius / (0.5 * EXTERIOR_YFOV).sin();
    let from = Vec3::new(0.55, 0.35, 1.0).normalize();
    Camera::look_at("automatic", bounds.center() + distance * from, bounds.center(), EXTERIOR_YFOV)
}

/// A scene ready for rays.
struct Rays<'a> {
    scene: &'a Scene,
    native: NativeScene,
}

impl<'a> Rays<'a> {
    /// `None` for geometry that makes trees too deep to be traced.
    fn new(scene: &'a Scene) -> Option<Self> {
        let native = NativeScene::new(&mesh_geometry(scene), &placements(scene), BvhQuality::Fast).ok()?;
        Some(Self { scene, native })
    }

    /// Distance to the first surface, and whether its front is seen.
    fn trace(&self, origin: Vec3, direction: Vec3) -> Option<(f32, bool)> {
        self.trace_beyond(0.0, origin, direction)
    }

    /// The same for surfaces further away than `t_min`.
    fn trace_beyond(&self, t_min: f32, origin: Vec3, direction: Vec3) -> Option<(f32, bool)> {
        // Adding zero turns -0 into 0: the traversal loses hits of rays with a component of -0.
        let ray = Ray { origin, t_min, direction: direction + Vec3::ZERO, t_max: f32::INFINITY };
        let hit = self.native.closest(&ray, u32::MAX, None);
        let instance = self.scene.instances.get(hit.instance as usize)?;
        let corners = self.scene.meshes[instance.mesh as usize].triangle(hit.triangle as usize);
        let [v0, v1, v2] = corners.map(|p| instance.world_from_object.transform_point3(p));
        // A mirroring transform turns fronts into backs; glTF keeps the front the front.
        let mirrored = instance.world_from_object.matrix3.determinant() < 0.0;
        let normal = (v1 - v0).cross(v2 - v0);
        Some((hit.t, (normal.dot(direction) < 0.0) != mirrored))
    }

    fn are_inside_a_room(&self, bounds: &Bounds) -> bool {
        let (mut level, mut level_seen, mut down, mut down_seen) = (0, 0, 0, 0);
        let mut distance = 0.0;
        // Solids are often built outwards from the origin, so that the centre lies in a face of theirs.
        let off_the_centre = 1e-5 * bounds.size().length();
        for direction in sphere_directions(512) {
            let hit = self.trace_beyond(off_the_centre, bounds.center(), direction);
            let front = hit.filter(|&(_, front)| front);
            distance += front.map_or(0.0, |(t, _)| t);
            if direction.y < -0.5 {
                down += 1;
                down_seen += usize::from(front.is_some());
            } else if direction.y <= 0.5 {
                level += 1;
                level_seen += usize::from(front.is_some());
            }
        }
        let (share_level, share_down) = (level_seen as f32 / level as f32, down_seen as f32 / down as f32);
        let seen = (level_seen + down_seen).max(1) as f32;
        let half_extent = 0.25 * (bounds.size().x + bounds.size().z);
        share_level >= 0.9 && share_down >= 0.8 && distance / seen >= 0.2 * half_extent
    }

    fn interior(&self, bounds: &Bounds) -> Camera {
        let (center, size) = (bounds.center(), bounds.size());
        let floor = self.trace(center, Vec3::NEG_Y).map_or(bounds.min.y, |(t, _)| center.y - t);
        let height = bounds.max.y - floor;
        let eye_level = center.with_y(floor + 1.65f32.clamp(0.1 * height, 0.4 * height));
        let axis = if size.x >= size.z { Vec3::X } else { Vec3::Z };
        let (ahead, behind) = (self.depth(eye_level, -axis), self.depth(eye_level, axis));
        // Stand at the end that is further away, so that more of the room lies ahead.
        let (axis, behind, ahead) =
            if behind >= ahead { (axis, behind, ahead) } else { (-axis, ahead, behind) };
        let clear = 0.03 * size.dot(axis).abs();
        let place = |step: u32| eye_level + axis * (behind * (0.85 - 0.05 * step as f32));
        let eye = (0..12).map(place).find(|&p| self.clearance(p) > clear).unwrap_or(eye_level);
        Camera::look_at("automatic", eye, eye_level - axis * ahead, INTERIOR_YFOV)
    }

    /// How far a room reaches from a point along an axis: the median over a narrow cone, because a single ray may slip through a
    /// door or end at a column. Rays that leave the scene do not count.
    fn depth(&self, from: Vec3, axis: Vec3) -> f32 {
        let cone = sphere_directions(4096).filter(|d| d.dot(axis) > 0.96);
        let mut depths: Vec<f32> =
            cone.filter_map(|d| self.trace(from, d).map(|(t, _)| t * d.dot(axis))).collect();
        depths.sort_by(f32::total_cmp);
        depths.get(depths.len() / 2).copied().unwrap_or(0.0)
    }

    /// Distance to the nearest surface, as far as 256 rays tell.
    fn clearance(&self, from: Vec3) -> f32 {
        let distances = sphere_directions(256).filter_map(|d| self.trace(from, d).map(|(t, _)| t));
        distances.fold(f32::INFINITY, f32::min)
    }
}

/// A spherical Fibonacci lattice (Gonzalez 2010): `n` directions spread evenly.
fn sphere_directions(n: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    (0..n).map(move |i| {
        let y = 1.0 - (2 * i + 1) as f32 / n as f32;
        let (sin, cos) = (golden * i as f32).sin_cos();
        let r = (1.0 - y * y).sqrt();
        Vec3::new(r * cos, y, r * sin)
    })
}

impl Scene {
    /// The first camera of the scene, or one that frames it by the rule of [`crate::automatic_camera`].
    pub fn default_camera(&self) -> Camera {
        self.cameras.first().cloned().unwrap_or_else(|| automatic_camera(self))
    }
}
