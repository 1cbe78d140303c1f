use crate::bvh::Triangle;
use crate::direct::double;
use crate::oracle::interior::{Boundary, InteriorList, Solid};
use glam::{DVec3, Vec3};
use pt_scene::{Material, Scene, media};

/// Solids that a point is inside of, for paths that begin there: what a ray to infinity leaves without having entered it. Deforming meshes
/// count in the pose that they were loaded in.
pub(crate) fn interior_at(scene: &Scene, point: Vec3) -> InteriorList {
    let mut inside = InteriorList::default();
    if !scene.materials.iter().any(Material::is_solid) {
        return inside;
    }
    let mut walked = InteriorList::default();
    for (boundary, entering) in boundaries(scene, point.as_dvec3()) {
        let left = if entering { boundary.front } else { Some(boundary.behind) };
        if let Some(unknown) = left.filter(|solid| !walked.holds(solid)) {
            inside.add(unknown);
        }
        walked.cross(&boundary, entering);
    }
    inside
}

/// Boundaries of solids along a ray, the nearest first, and whether it enters there.
fn boundaries(scene: &Scene, origin: DVec3) -> impl Iterator<Item = (Boundary, bool)> {
    // Aslant to whatever is built along axes.
    let direction = DVec3::new(0.3561, 0.7927, 0.4948).normalize();
    let media = media(&scene.materials);
    let solid = |material: u32| {
        let medium = media[material as usize];
        let m = &scene.materials[medium as usize];
        Solid { material: medium, priority: m.priority, ior: m.ior }
    };
    let mut hits = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let world_from_object = double(&instance.world_from_object);
        let mirrored = world_from_object.matrix3.determinant() < 0.0;
        for t in 0..mesh.triangle_count() {
            let index = instance.material_at(mesh, t);
            let material = &scene.materials[index as usize];
            if !material.is_solid() {
                continue;
            }
            let corners = mesh.triangle(t).map(|p| world_from_object.transform_point3(p.as_dvec3()));
            let triangle = Triangle::new(corners);
            let Some((distance, _)) = triangle.intersect(origin, direction).filter(|&(t, _)| t > 0.0) else {
                continue;
            };
            let [e1, e2] = triangle.edges;
            let entering = (e1.cross(e2).dot(direction) < 0.0) != mirrored;
            hits.push((
                distance,
                Boundary { behind: solid(index), front: material.exterior.map(solid) },
                entering,
            ));
        }
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    hits.into_iter().map(|(_, boundary, entering)| (boundary, entering))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_scene::builtin;

    /// Indices of refraction of what is at a point.
    fn iors(scene: &Scene, point: [f32; 3]) -> Vec<f32> {
        let mut list: Vec<f32> =
            interior_at(scene, point.into()).solids().iter().map(|solid| solid.ior).collect();
        list.sort_by(f32::total_cmp);
        list
    }

    #[test]
    fn points_in_and_out_of_a_glass() {
        let (overlapping, gapless) = (builtin("glass").unwrap(), builtin("glass-gapless").unwrap());
        let water = 1.333;
        for (point, over, gap) in [
            ([0.0, 0.3, 0.0], vec![], vec![]),
            ([0.0, 0.09, 0.0], vec![], vec![]),
            ([0.02, 0.02, 0.0], vec![water], vec![water]),
            ([0.0, 0.005, 0.0], vec![1.5], vec![1.5]),
            // Ice under water; where the water reaches into the wall.
            ([0.003, 0.038, 0.002], vec![1.31, water], vec![1.31]),
            ([0.0315, 0.03, 0.0], vec![water, 1.5], vec![1.5]),
        ] {
            assert_eq!(iors(&overlapping, point), over, "{point:?}");
            assert_eq!(iors(&gapless, point), gap, "{point:?}, gapless");
        }
    }
}
