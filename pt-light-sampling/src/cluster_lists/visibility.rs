//! A few rays that decide whether a cluster sees a light: the stand-in for a precomputed potentially visible set.

use super::ClusterBox;
use crate::{EmissiveTriangle, light_bounds};
use glam::{Affine3A, UVec3, Vec3};
use pt_core::trace::{BvhQuality, InstancePlacement, MeshGeometry, NativeScene, TraceError};
use pt_scene::{Clusters, LightKind, Mesh, Scene};
use pt_shaders::records::Ray;

/// Rays from a cluster to a light before it counts as hidden.
pub(super) const RAYS: usize = 16;
/// Surface points that are drawn per cluster, on average, and that are kept of one, at most.
const DRAWN: usize = 64;
const KEPT: usize = 32;
/// Points in the empty space of a cluster, where objects may move.
const IN_SPACE: usize = 8;
/// Distance of the ends of rays to the surfaces that they are on, in sizes of the scene.
const OFFSET: f32 = 1e-5;

/// Where light may arrive in a cluster; without a normal in empty space.
#[derive(Clone, Copy)]
struct Receiver {
    position: Vec3,
    normal: Vec3,
}

enum Shape {
    /// Corners, normal, and whether both sides emit.
    Triangle([Vec3; 3], Vec3, bool),
    Sphere(Vec3, f32),
}

/// Decides by rays whether lights may be seen from clusters.
///
/// A light counts as hidden if 16 rays between points of the cluster and points of the light are all blocked. Points of a cluster are on
/// its surfaces, on the side of the light, and in its whole box if something in the scene moves or the cluster has no surface.
/// Only opaque triangles that stand still block rays: not those of materials that transmit light, are masked or blended.
///
/// A visible pair costs a few rays, a hidden one 16: for many lights and clusters this takes far longer than all other tests.
pub struct VisibilityEstimate {
    /// `None`: nothing blocks.
    blockers: Option<NativeScene>,
    receivers: Vec<Vec<Receiver>>,
    shapes: Vec<Shape>,
    offset: f32,
}

impl VisibilityEstimate {
    /// Prepares the rays: `boxes` are those of [`super::cluster_boxes`], `emissives` those that the lights were made from.
    ///
    /// # Errors
    /// As [`NativeScene::new`].
    pub fn new(
        scene: &Scene,
        clusters: &Clusters,
        boxes: &[ClusterBox],
        emissives: &[EmissiveTriangle],
    ) -> Result<Self, TraceError> {
        let size = scene.bounds().map_or(0.0, |b| b.size().length());
        Ok(Self {
            blockers: blockers(scene)?,
            receivers: receivers(scene, clusters, boxes),
            shapes: shapes(scene, emissives),
            offset: OFFSET * size,
        })
    }

    /// Whether any of the rays between a cluster and a light, an index in [`crate::local_lights`], gets through.
    pub fn visible(&self, cluster: u32, light: u32) -> bool {
        let (Some(blockers), Some(receivers), Some(shape)) =
            (&self.blockers, self.receivers.get(cluster as usize), self.shapes.get(light as usize))
        else {
            return true;
        };
        let count = receivers.len();
        (0..RAYS).any(|i| {
            // Spread over the points, which are in the order of the triangles; other lights begin with other points.
            let Some(receiver) = receivers.get((i * count / RAYS + light as usize) % count.max(1)) else {
                return true;
            };
            let Some(to) = shape.point(i, receiver.position, self.offset) else { return false };
            let side = (to - receiver.position).dot(receiver.normal).signum();
            let origin = receiver.position + self.offset * side * receiver.normal;
            // Adding zero turns -0 into 0: the traversal loses hits of rays with a component of -0.
            let ray = Ray { origin, t_min: 0.0, direction: to - origin + Vec3::ZERO, t_max: 1.0 };
            !blockers.occluded(&ray, u32::MAX, None)
        })
    }
}

impl Shape {
    /// The `i`-th point, just outside of the surface; `None` if it does not emit towards `receiver`.
    fn point(&self, i: usize, receiver: Vec3, offset: f32) -> Option<Vec3> {
        match *self {
            Self::Triangle(corners, normal, both_sides) => {
                let point = on_triangle(corners, i);
                let facing = (receiver - point).dot(normal);
                (both_sides || facing > 0.0).then(|| point + offset * facing.signum() * normal)
            }
            Self::Sphere(center, radius) => {
                let [x, y, z] = sequence(i);
                let direction = (2.0 * Vec3::new(x, y, z) - 1.0).normalize_or(Vec3::Y);
                let side = (receiver - center).dot(direction).signum();
                Some(center + radius * side * direction)
            }
        }
    }
}

/// The R3 sequence (Roberts 2018).
fn sequence(i: usize) -> [f32; 3] {
    [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2]
        .map(|step: f64| (0.5 + step * i as f64).fract() as f32)
}

/// A point of the R2 sequence, folded into the triangle.
fn on_triangle([a, b, c]: [Vec3; 3], i: usize) -> Vec3 {
    let [x, y] =
        [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|step: f64| (0.5 + step * i as f64).fract());
    let (x, y) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
    a + x as f32 * (b - a) + y as f32 * (c - a)
}

/// In the order of [`crate::local_lights`].
fn shapes(scene: &Scene, emissives: &[EmissiveTriangle]) -> Vec<Shape> {
    let triangles = emissives.iter().map(|t| {
        let instance = &scene.instances[t.instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let bounds = light_bounds::triangle(scene, t);
        let corners = mesh.triangle(t.triangle as usize);
        let corners = corners.map(|p| instance.world_from_object.transform_point3(p));
        Shape::Triangle(corners, bounds.axis, bounds.cos_spread < 1.0)
    });
    let punctual = scene.lights.iter().filter(|light| light.kind != LightKind::Directional);
    triangles.chain(punctual.map(|light| Shape::Sphere(light.position, light.radius))).collect()
}

/// The opaque triangles that stand still.
fn blockers(scene: &Scene) -> Result<Option<NativeScene>, TraceError> {
    let opaque = |mesh: &Mesh| -> Vec<UVec3> {
        let triangles = 0..mesh.first_masked.min(mesh.triangle_count());
        let blocks = |&t: &usize| !scene.materials[mesh.triangle_materials[t] as usize].transmits();
        triangles.filter(blocks).map(|t| mesh.indices[t].into()).collect()
    };
    let indices: Vec<Vec<UVec3>> = scene.meshes.iter().map(opaque).collect();
    let mut used = vec![None; indices.len()];
    let (mut geometry, mut placed) = (Vec::new(), Vec::new());
    for instance in &scene.instances {
        let (of, mesh) = (instance.mesh as usize, &scene.meshes[instance.mesh as usize]);
        if !instance.is_static(mesh) || instance.transmits(mesh, &scene.materials) || indices[of].is_empty() {
            continue;
        }
        let mesh = *used[of].get_or_insert_with(|| {
            geometry.push(MeshGeometry {
                positions: &mesh.positions,
                indices: &indices[of],
                first_masked: indices[of].len() as u32,
                deforms: false,
            });
            geometry.len() as u32 - 1
        });
        placed.push(InstancePlacement {
            mesh,
            mask: u32::MAX,
            world_from_object: instance.world_from_object,
        });
    }
    if placed.is_empty() {
        return Ok(None);
    }
    NativeScene::new(&geometry, &placed, BvhQuality::Fast).map(Some)
}

/// Points of a cluster, thinned out evenly whenever there are too many.
#[derive(Default)]
struct Thinned {
    points: Vec<Receiver>,
    seen: usize,
    skipped: u32,
}

impl Thinned {
    fn push(&mut self, point: Receiver) {
        if self.seen.is_multiple_of(1 << self.skipped) {
            if self.points.len() == KEPT {
                let mut index = 0;
                self.points.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.skipped += 1;
            }
            // The point itself goes too if it is one of those that are skipped from now on.
            if self.seen.is_multiple_of(1 << self.skipped) {
                self.points.push(point);
            }
        }
        self.seen += 1;
    }
}

fn receivers(scene: &Scene, clusters: &Clusters, boxes: &[ClusterBox]) -> Vec<Vec<Receiver>> {
    let still = scene.instances.iter().filter(|i| i.is_static(&scene.meshes[i.mesh as usize]));
    let moves = still.clone().count() < scene.instances.len();
    let triangles = still.flat_map(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let place: Affine3A = instance.world_from_object;
        (0..mesh.triangle_count()).map(move |t| mesh.triangle(t).map(|p| place.transform_point3(p)))
    });
    let area_vector = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(c - a);
    let total: f64 = triangles.clone().map(|t| f64::from(area_vector(t).length())).sum();
    let density = if total > 0.0 { (DRAWN * clusters.count()) as f64 / total } else { 0.0 };
    let mut drawn: Vec<Thinned> = (0..clusters.count()).map(|_| Thinned::default()).collect();
    for corners in triangles {
        let vector = area_vector(corners);
        let normal = vector.normalize_or_zero();
        // At least one point of each triangle: details light up too.
        for i in 0..1 + (density * f64::from(vector.length())) as usize {
            let position = on_triangle(corners, i);
            drawn[clusters.find(position) as usize].push(Receiver { position, normal });
        }
    }
    let in_space = |of: &ClusterBox| {
        let (min, size) = (of.bounds.min, of.bounds.size());
        (0..IN_SPACE)
            .map(move |i| Receiver { position: min + size * Vec3::from(sequence(i)), normal: Vec3::ZERO })
    };
    let all = drawn.into_iter().zip(boxes).map(|(drawn, of)| {
        let mut points = drawn.points;
        if moves || points.is_empty() {
            points.extend(in_space(of));
        }
        points
    });
    all.collect()
}
