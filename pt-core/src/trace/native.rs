//! Two-level traversal on all cores of the CPU: the baseline of `pt bench trace` and the oracle of the GPU backends.
//!
//! Plain `obvhs` closest-hit and any-hit queries over the trees that the compute backend reads on CPU devices.

use super::{BvhQuality, InstancePlacement, Leaf, MeshBvh, MeshGeometry, TopLevel, TraceError};
use glam::{Affine3A, Vec2, Vec3A};
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;
use pt_shaders::records::{Hit, NONE, Ray};
use rayon::prelude::*;

/// Rays a task takes from the queue.
const CHUNK: usize = 1024;

struct NativeMesh {
    tree: MeshBvh,
    /// In leaf order, with the normal precomputed.
    triangles: Vec<RtTriangle>,
    first_masked: u32,
}

struct NativeInstance {
    mesh: u32,
    mask: u32,
    object_from_world: Affine3A,
}

/// Decides whether a hit on a masked triangle counts: (instance, triangle, barycentrics) -> covered.
pub type Coverage<'a> = dyn Fn(u32, u32, Vec2) -> bool + Sync + 'a;

/// A scene ready to be traced on the CPU.
pub struct NativeScene {
    meshes: Vec<NativeMesh>,
    instances: Vec<NativeInstance>,
    top: TopLevel,
}

impl NativeScene {
    /// Builds the trees of `meshes` and the one over `instances`.
    ///
    /// # Errors
    /// As [`MeshBvh::build`] and [`TopLevel::rebuild`], and [`TraceError::UnknownMesh`] for an instance of a mesh that is not there.
    pub fn new(
        meshes: &[MeshGeometry],
        instances: &[InstancePlacement],
        quality: BvhQuality,
    ) -> Result<Self, TraceError> {
        let meshes = meshes
            .iter()
            .map(|m| {
                let tree = MeshBvh::build(m.positions, m.indices, quality, Leaf::Triangle)?;
                let corner = |i: u32| Vec3A::from(m.positions[i as usize]);
                let triangle = |&i: &u32| {
                    let index = m.indices[i as usize];
                    RtTriangle::new(corner(index.x), corner(index.y), corner(index.z))
                };
                let triangles = tree.bvh.primitive_indices.iter().map(triangle).collect();
                Ok(NativeMesh { tree, triangles, first_masked: m.first_masked })
            })
            .collect::<Result<_, TraceError>>()?;
        let mut scene = Self { meshes, instances: Vec::new(), top: TopLevel::default() };
        scene.place(instances)?;
        Ok(scene)
    }

    /// Replaces the instances.
    ///
    /// # Errors
    /// [`TraceError::UnknownMesh`], and as [`TopLevel::rebuild`].
    pub fn place(&mut self, instances: &[InstancePlacement]) -> Result<(), TraceError> {
        super::check_instances(instances, self.meshes.len())?;
        self.top.rebuild(
            instances.iter().map(|i| (self.meshes[i.mesh as usize].tree.bounds(), i.world_from_object)),
        )?;
        self.instances = instances
            .iter()
            .map(|i| NativeInstance {
                mesh: i.mesh,
                mask: i.mask,
                object_from_world: i.world_from_object.inverse(),
            })
            .collect();
        Ok(())
    }

    /// World-space bounds of all instances as (min, max); `None` for an empty scene.
    pub fn bounds(&self) -> Option<(glam::Vec3, glam::Vec3)> {
        let bounds = &self.top.bvh.total_aabb;
        (!self.top.bvh.nodes.is_empty()).then(|| (bounds.min.into(), bounds.max.into()))
    }

    /// Closest hit in `[t_min, t_max]` among the instances that `mask` selects; `coverage` is asked about masked triangles.
    pub fn closest(&self, ray: &Ray, mask: u32, coverage: Option<&Coverage>) -> Hit {
        let mut best = Hit { instance: NONE, triangle: NONE, barycentrics: Vec2::ZERO, t: ray.t_max };
        if let [_] = self.instances[..] {
            self.closest_in_instance(0, ray, mask, coverage, &mut best);
        } else {
            let world = obvhs_ray(ray);
            self.top.bvh.ray_traverse(world, &mut RayHit::none(), |_, leaf| {
                let instance = self.top.bvh.primitive_indices[leaf];
                self.closest_in_instance(instance, ray, mask, coverage, &mut best)
            });
        }
        best
    }

    /// Whether anything is hit in `[t_min, t_max]`.
    pub fn occluded(&self, ray: &Ray, mask: u32, coverage: Option<&Coverage>) -> bool {
        if let [_] = self.instances[..] {
            return self.occluded_by_instance(0, ray, mask, coverage);
        }
        let miss = self.top.bvh.ray_traverse_miss(obvhs_ray(ray), |_, leaf| {
            let instance = self.top.bvh.primitive_indices[leaf];
            // Any t in the ray's interval ends the traversal.
            if self.occluded_by_instance(instance, ray, mask, coverage) { ray.t_min } else { f32::INFINITY }
        });
        !miss
    }

    /// [`Self::closest`] for many rays, on all cores.
    pub fn closest_all(&self, rays: &[Ray], mask: u32, coverage: Option<&Coverage>, hits: &mut [Hit]) {
        hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each(|(hits, rays)| {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = self.closest(ray, mask, coverage);
            }
        });
    }

    /// [`Self::occluded`] for many rays, on all cores; the number of rays that are.
    pub fn occluded_all(&self, rays: &[Ray], mask: u32, coverage: Option<&Coverage>) -> usize {
        let count = |rays: &[Ray]| rays.iter().filter(|ray| self.occluded(ray, mask, coverage)).count();
        rays.par_chunks(CHUNK).map(count).sum()
    }

    /// Returns t of the hit when it is closer than `best`, else infinity.
    #[inline]
    fn closest_in_instance(
        &self,
        index: u32,
        ray: &Ray,
        mask: u32,
        coverage: Option<&Coverage>,
        best: &mut Hit,
    ) -> f32 {
        let instance = &self.instances[index as usize];
        let mesh = &self.meshes[instance.mesh as usize];
        if instance.mask & mask == 0 {
            return f32::INFINITY;
        }
        let mut local = obvhs_ray_in(ray, &instance.object_from_world);
        local.tmax = best.t;
        let mut found = RayHit::none();
        let hit = mesh.tree.bvh.ray_traverse(local, &mut found, |ray, leaf| {
            let t = mesh.triangles[leaf].intersect(ray);
            if t < ray.tmax && mesh.covered(index, leaf, ray, coverage) { t } else { f32::INFINITY }
        });
        if !hit {
            return f32::INFINITY;
        }
        let leaf = found.primitive_id as usize;
        *best = Hit {
            instance: index,
            triangle: mesh.tree.triangles[leaf].triangle,
            barycentrics: mesh.barycentrics(leaf, &local),
            t: found.t,
        };
        found.t
    }

    #[inline]
    fn occluded_by_instance(&self, index: u32, ray: &Ray, mask: u32, coverage: Option<&Coverage>) -> bool {
        let instance = &self.instances[index as usize];
        let mesh = &self.meshes[instance.mesh as usize];
        if instance.mask & mask == 0 {
            return false;
        }
        let local = obvhs_ray_in(ray, &instance.object_from_world);
        !mesh.tree.bvh.ray_traverse_miss(local, |ray, leaf| {
            let t = mesh.triangles[leaf].intersect(ray);
            if t < ray.tmax && mesh.covered(index, leaf, ray, coverage) { t } else { f32::INFINITY }
        })
    }
}

impl NativeMesh {
    #[inline]
    fn covered(
        &self,
        instance: u32,
        leaf: usize,
        ray: &obvhs::ray::Ray,
        coverage: Option<&Coverage>,
    ) -> bool {
        let Some(coverage) = coverage else { return true };
        let triangle = self.tree.triangles[leaf].triangle;
        triangle < self.first_masked || coverage(instance, triangle, self.barycentrics(leaf, ray))
    }

    fn barycentrics(&self, leaf: usize, ray: &obvhs::ray::Ray) -> Vec2 {
        self.triangles[leaf].compute_barycentric(ray)
    }
}

#[inline]
fn obvhs_ray(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max)
}

/// In object space, with the direction's length kept so that t is the same in both spaces.
#[inline]
fn obvhs_ray_in(ray: &Ray, object_from_world: &Affine3A) -> obvhs::ray::Ray {
    let origin = object_from_world.transform_point3a(ray.origin.into());
    let direction = object_from_world.transform_vector3a(ray.direction.into());
    obvhs::ray::Ray::new(origin, direction, ray.t_min, ray.t_max)
}
