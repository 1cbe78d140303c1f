//! The rays that the benchmarks trace, and the CPU tracing them.

use super::ray_list::Query;
use super::{BvhQuality, InstancePlacement, MeshGeometry, NativeScene};
use crate::error::Result;
use crate::rng::random4;
use glam::{Vec2, Vec3};
use pt_shaders::records::{CameraRecord, Hit, NONE, Ray};
use std::time::Instant;

/// All instances.
pub(super) const ALL: u32 = 0xff;
/// Secondary rays start this far from their surface, relative to the scene's diagonal.
const OFFSET: f32 = 1e-5;

/// Rays a renderer shoots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayKind {
    /// From the camera through the pixel centres.
    Primary,
    /// Cosine-distributed from the primary hits.
    Bounce,
    /// From the primary hits to random points of the scene's bounds, any hit.
    Shadow,
    /// The same from where the bounce rays hit.
    BounceShadow,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Bounce, Self::Shadow, Self::BounceShadow];

    /// Its name, as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
            Self::BounceShadow => "bounce-shadow",
        }
    }

    pub(super) fn query(self) -> Query {
        match self {
            Self::Primary | Self::Bounce => Query::Closest,
            Self::Shadow | Self::BounceShadow => Query::Occluded,
        }
    }
}

/// Rays of one kind.
pub(super) struct RayList {
    pub(super) kind: RayKind,
    pub(super) rays: Vec<Ray>,
    /// Of the native traversal.
    pub(super) hits: Vec<Hit>,
}

/// Rays of every kind, traced on all cores of the CPU as the baseline.
pub struct NativeRays {
    pub(super) scene: NativeScene,
    pub(super) lists: Vec<RayList>,
}

impl NativeRays {
    /// As many rays of each kind as an image of `size` has pixels; `seed`: of the random directions.
    ///
    /// # Errors
    /// When the geometry makes no tree.
    pub fn new(
        meshes: &[MeshGeometry],
        instances: &[InstancePlacement],
        camera: &CameraRecord,
        size: [u32; 2],
        seed: u32,
    ) -> Result<Self> {
        let scene = NativeScene::new(meshes, instances, BvhQuality::for_loading(meshes))?;
        let lists = ray_lists(&scene, meshes, instances, camera, size, seed);
        Ok(Self { scene, lists })
    }

    /// Million rays a second of `kind` while `count` > 0 rays are traced, the list again and again. 0: there are none of this kind.
    pub fn mrays_per_s(&self, kind: RayKind, count: usize) -> f64 {
        let Some(list) = self.lists.iter().find(|list| list.kind == kind) else { return 0.0 };
        let mut hits = list.hits.clone();
        let start = Instant::now();
        let mut left = count;
        while left > 0 {
            let rays = &list.rays[..left.min(list.rays.len())];
            match kind.query() {
                Query::Closest => self.scene.closest_all(rays, ALL, None, &mut hits),
                Query::Occluded => {
                    std::hint::black_box(self.scene.occluded_all(rays, ALL, None));
                }
            }
            left -= rays.len();
        }
        std::hint::black_box(&hits);
        count as f64 / start.elapsed().as_secs_f64() * 1e-6
    }
}

fn ray_lists(
    native: &NativeScene,
    meshes: &[MeshGeometry],
    instances: &[InstancePlacement],
    camera: &CameraRecord,
    size: [u32; 2],
    seed: u32,
) -> Vec<RayList> {
    let [width, height] = size;
    let primary: Vec<_> = (0..width * height)
        .map(|i| {
            let uv = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5)
                / Vec2::new(width as f32, height as f32);
            camera_ray(camera, uv)
        })
        .collect();
    let (low, high) = native.bounds().unwrap_or_default();
    let offset = OFFSET * (high - low).length();
    // Origins on the surfaces that rays have hit, with the normals there, as many as there are pixels.
    let surfaces = |RayList { rays, hits, .. }: &RayList| -> Vec<(Vec3, Vec3)> {
        let seen: Vec<_> = rays.iter().zip(hits).filter(|(_, hit)| hit.instance != NONE).collect();
        let surface = |&(ray, hit): &(&Ray, &Hit)| {
            let normal = face_normal(meshes, instances, hit);
            let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
            (ray.origin + ray.direction * hit.t + normal * offset, normal)
        };
        seen.iter().cycle().take((width * height) as usize).map(surface).collect()
    };
    let random = |number: usize, dimension| random4([number as u32, 0], 0, dimension, seed);
    let shadow_ray = |(number, (origin, _)): (usize, (Vec3, Vec3)), dimension| {
        let target = low + (high - low) * Vec3::from_slice(&random(number, dimension));
        let distance = (target - origin).length().max(f32::MIN_POSITIVE);
        Ray { origin, t_min: 0.0, direction: (target - origin) / distance, t_max: distance }
    };
    let bounce_ray = |(number, (origin, normal)): (usize, (Vec3, Vec3))| {
        let [r0, r1, ..] = random(number, 0);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let (sin, cos) = (r0 * std::f32::consts::TAU).sin_cos();
        let direction = (tangent * cos + bitangent * sin) * r1.sqrt() + normal * (1.0 - r1).sqrt();
        Ray { origin, t_min: 0.0, direction: direction.normalize(), t_max: f32::MAX }
    };
    let trace = |kind: RayKind, rays: Vec<Ray>| {
        let missed = Hit { instance: NONE, triangle: NONE, barycentrics: Vec2::ZERO, t: 0.0 };
        let mut hits = vec![missed; rays.len()];
        native.closest_all(&rays, ALL, None, &mut hits);
        RayList { kind, rays, hits }
    };
    let primary = trace(RayKind::Primary, primary);
    let first = surfaces(&primary);
    let bounce = trace(RayKind::Bounce, first.iter().copied().enumerate().map(bounce_ray).collect());
    let second = surfaces(&bounce);
    let shadow_rays = |surfaces: Vec<_>, dimension| -> Vec<Ray> {
        surfaces.into_iter().enumerate().map(|surface| shadow_ray(surface, dimension)).collect()
    };
    let shadow = trace(RayKind::Shadow, shadow_rays(first, 1));
    let bounce_shadow = trace(RayKind::BounceShadow, shadow_rays(second, 2));
    let lists = [primary, bounce, shadow, bounce_shadow];
    lists.into_iter().filter(|list| !list.rays.is_empty()).collect()
}

/// As camera_ray() of camera.glsl, through the lens's centre.
fn camera_ray(camera: &CameraRecord, uv: Vec2) -> Ray {
    let plane = Vec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y) * camera.half_extent;
    let perspective = camera.projection == 0;
    let origin = if perspective { Vec3::ZERO } else { plane.extend(0.0) };
    let direction = if perspective { plane.extend(-1.0) } else { Vec3::NEG_Z };
    Ray {
        origin: camera.world_from_view.transform_point3(origin),
        t_min: 0.0,
        direction: camera.world_from_view.transform_vector3(direction).normalize(),
        t_max: f32::MAX,
    }
}

fn face_normal(meshes: &[MeshGeometry], instances: &[InstancePlacement], hit: &Hit) -> Vec3 {
    let instance = &instances[hit.instance as usize];
    let mesh = &meshes[instance.mesh as usize];
    let index = mesh.indices[hit.triangle as usize];
    let corner = |i: u32| instance.world_from_object.transform_point3(mesh.positions[i as usize]);
    let (a, b, c) = (corner(index.x), corner(index.y), corner(index.z));
    (b - a).cross(c - a).normalize_or(Vec3::Y)
}
