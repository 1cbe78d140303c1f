//! Joints and morph targets of vertices.

use glam::Vec3;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use crate::document::Document;
use pt_scene::animation::{Influence, MorphDelta, VertexLists};
use pt_scene::{Mesh, SceneError};

/// Most influences and displacements of a mesh: more would overflow the offsets on the GPU.
const MAX_ITEMS: usize = 1 << 31;

/// Upper bound of the bytes that joints and morph targets take for each vertex.
pub(crate) fn bytes_per_vertex(primitive: &Primitive) -> u64 {
    let sets =
        primitive.attributes.keys().filter(|a| matches!(a, Checked::Valid(Semantic::Joints(_)))).count();
    let targets = primitive.targets.as_ref().map_or(0, Vec::len);
    (4 * sets * size_of::<Influence>() + targets * size_of::<MorphDelta>()) as u64
}

/// Joints and morph targets of a primitive's vertices, into `mesh`.
pub(crate) fn read_vertices(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    mesh: &mut Mesh,
) -> Result<(), SceneError> {
    mesh.influences = influences(document, primitive, at, mesh.vertex_count())?;
    mesh.morphs = morphs(document, primitive, at, mesh.vertex_count())?;
    Ok(())
}

fn same_length(document: &Document, at: &str, length: usize, vertices: usize) -> Result<(), SceneError> {
    if length == vertices {
        Ok(())
    } else {
        Err(document.invalid(at, format!("has {length} elements, POSITION has {vertices}")))
    }
}

/// Every JOINTS_n with its WEIGHTS_n; shares that do not sum up to 1 are scaled to.
fn influences(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    vertices: usize,
) -> Result<VertexLists<Influence>, SceneError> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let mut sets = Vec::new();
    while let (Some(joints), Some(weights)) =
        (attribute(Semantic::Joints(sets.len() as u32)), attribute(Semantic::Weights(sets.len() as u32)))
    {
        let at_joints = format!("{at}.attributes.JOINTS_{}", sets.len());
        let at_weights = format!("{at}.attributes.WEIGHTS_{}", sets.len());
        let joints = document.unsigned::<4>(joints, &at_joints)?;
        let weights = document.floats::<4>(weights, &at_weights)?;
        same_length(document, &at_joints, joints.len(), vertices)?;
        same_length(document, &at_weights, weights.len(), vertices)?;
        if !weights.iter().flatten().all(|w| w.is_finite() && *w >= 0.0) {
            return Err(document.invalid(at_weights, "a weight is negative or not finite"));
        }
        sets.push((joints, weights));
    }
    let mut lists = VertexLists::default();
    if sets.is_empty() {
        return Ok(lists);
    }
    for v in 0..vertices {
        let pairs = sets.iter().flat_map(|(joints, weights)| joints[v].into_iter().zip(weights[v]));
        let sum: f32 = pairs.clone().map(|(_, weight)| weight).sum();
        if sum > 0.0 {
            let share = |(joint, weight): (u32, f32)| Influence { joint, weight: weight / sum };
            lists.push(pairs.filter(|&(_, weight)| weight > 0.0).map(share));
        } else {
            lists.push([Influence { joint: sets[0].0[v][0], weight: 1.0 }]);
        }
    }
    Ok(lists)
}

fn morphs(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    vertices: usize,
) -> Result<VertexLists<MorphDelta>, SceneError> {
    let mut targets = Vec::new();
    for (t, target) in primitive.targets.iter().flatten().enumerate() {
        let read = |accessor, name: &str| -> Result<Option<Vec<[f32; 3]>>, SceneError> {
            let Some(accessor) = accessor else { return Ok(None) };
            let at = format!("{at}.targets[{t}].{name}");
            let values = document.floats::<3>(accessor, &at)?;
            same_length(document, &at, values.len(), vertices)?;
            if !values.iter().flatten().all(|v| v.is_finite()) {
                return Err(document.invalid(at, "a displacement is not finite"));
            }
            Ok(Some(values))
        };
        targets.push([
            read(target.positions, "POSITION")?,
            read(target.normals, "NORMAL")?,
            read(target.tangents, "TANGENT")?,
        ]);
    }
    let mut lists = VertexLists::default();
    if targets.is_empty() {
        return Ok(lists);
    }
    if targets.len().saturating_mul(vertices) > MAX_ITEMS {
        return Err(document.invalid(format!("{at}.targets"), "there are too many morph targets"));
    }
    for v in 0..vertices {
        let deltas = (0..).zip(&targets).filter_map(|(target, parts)| {
            let [position, normal, tangent] =
                parts.each_ref().map(|part| part.as_ref().map_or(Vec3::ZERO, |values| values[v].into()));
            let moves = position != Vec3::ZERO || normal != Vec3::ZERO || tangent != Vec3::ZERO;
            moves.then_some(MorphDelta { target, position, normal, tangent })
        });
        lists.push(deltas);
    }
    Ok(lists)
}
