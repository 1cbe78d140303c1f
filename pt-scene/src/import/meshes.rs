use glam::{Vec2, Vec3, Vec4};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::animation;
use super::document::Document;
use crate::{Mesh, Scene, SceneError};

/// Reads every glTF mesh. The result tells for each which [`Scene::meshes`] entry it became; `None` where it has no
/// triangles.
pub(super) fn read(document: &Document, scene: &mut Scene) -> Result<Vec<Option<u32>>, SceneError> {
    let mut indices = Vec::new();
    for (i, description) in document.root.meshes.iter().enumerate() {
        let at = format!("meshes[{i}]");
        let mut mesh =
            Mesh { name: description.name.clone().unwrap_or_else(|| at.clone()), ..Mesh::default() };
        for (p, primitive) in description.primitives.iter().enumerate() {
            let at = format!("{at}.primitives[{p}]");
            if let Some(part) = read_primitive(document, primitive, &at, scene)? {
                if mesh.vertex_count() + part.vertex_count() > u32::MAX as usize {
                    return Err(document.invalid(at, "the mesh has more than 2^32 vertices"));
                }
                mesh.append(&part);
            }
        }
        indices.push((mesh.triangle_count() > 0).then_some(scene.meshes.len() as u32));
        if mesh.triangle_count() > 0 {
            mesh.sort_by_opacity(&scene.materials);
            scene.meshes.push(mesh);
        }
    }
    Ok(indices)
}

/// The triangles of a primitive; `None` for points and lines.
fn read_primitive(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    scene: &mut Scene,
) -> Result<Option<Mesh>, SceneError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(document.invalid(format!("{at}.mode"), "unknown mode"));
    };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        scene.notices.push(format!("{at}: {mode:?} left out, only triangles are rendered"));
        return Ok(None);
    }
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(position) = attribute(Semantic::Positions) else {
        scene.notices.push(format!("{at}: left out, it has no positions"));
        return Ok(None);
    };
    let positions = document.floats::<3>(position, &format!("{at}.attributes.POSITION"))?;
    let vertices = positions.len();
    let list = match primitive.indices {
        Some(index) => document.integers(index, &format!("{at}.indices"))?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(wrong) = list.iter().find(|&&v| v as usize >= vertices) {
        return Err(document.invalid(format!("{at}.indices"), format!("vertex {wrong} is past {vertices}")));
    }
    let material = match primitive.material {
        Some(index) => document.get(index, &format!("{at}.material")).map(|_| index.value())?,
        None => document.root.materials.len(),
    };
    let same_length = |name: &str, length: usize| {
        let what = || format!("has {length} elements, POSITION has {vertices}");
        if length == vertices {
            Ok(())
        } else {
            Err(document.invalid(format!("{at}.attributes.{name}"), what()))
        }
    };
    let uv = |set: u32| -> Result<Vec<Vec2>, SceneError> {
        let Some(index) = attribute(Semantic::TexCoords(set)) else { return Ok(vec![Vec2::ZERO; vertices]) };
        let name = format!("TEXCOORD_{set}");
        let values = document.floats::<2>(index, &format!("{at}.attributes.{name}"))?;
        same_length(&name, values.len())?;
        Ok(values.into_iter().map(Vec2::from_array).collect())
    };
    let indices = triangles(mode, &list);
    let mut mesh = Mesh {
        positions: positions.into_iter().map(Vec3::from_array).collect(),
        uv0: uv(0)?,
        uv1: uv(1)?,
        colors: colors(document, primitive, vertices, at)?,
        triangle_materials: vec![material as u32; indices.len()],
        indices,
        ..Mesh::default()
    };
    same_length("COLOR_0", mesh.colors.len())?;
    animation::read_vertices(document, primitive, at, &mut mesh)?;
    let second_uv_set = scene.materials[material].normal_texture.is_some_and(|texture| texture.uv_set == 1);
    let Some(index) = attribute(Semantic::Normals) else {
        // glTF: without normals, flat ones, and tangents in the file are not to be used.
        mesh.tangents = vec![Vec4::X; vertices];
        mesh.flat_shade();
        mesh.compute_tangents(second_uv_set);
        return Ok(Some(mesh));
    };
    let normals = document.floats::<3>(index, &format!("{at}.attributes.NORMAL"))?;
    same_length("NORMAL", normals.len())?;
    mesh.normals = normals.into_iter().map(|n| Vec3::from_array(n).normalize_or(Vec3::Y)).collect();
    match attribute(Semantic::Tangents) {
        Some(index) => {
            let tangents = document.floats::<4>(index, &format!("{at}.attributes.TANGENT"))?;
            same_length("TANGENT", tangents.len())?;
            let unit = |(t, n): ([f32; 4], &Vec3)| {
                let direction =
                    Vec3::new(t[0], t[1], t[2]).try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
                direction.extend(if t[3] < 0.0 { -1.0 } else { 1.0 })
            };
            mesh.tangents = tangents.into_iter().zip(&mesh.normals).map(unit).collect();
        }
        None => mesh.compute_tangents(second_uv_set),
    }
    Ok(Some(mesh))
}

fn colors(
    document: &Document,
    primitive: &Primitive,
    vertices: usize,
    at: &str,
) -> Result<Vec<Vec4>, SceneError> {
    let Some(&index) = primitive.attributes.get(&Checked::Valid(Semantic::Colors(0))) else {
        return Ok(vec![Vec4::ONE; vertices]);
    };
    let at = format!("{at}.attributes.COLOR_0");
    // Interpolated quantised colours may leave 0..1 by rounding; the specification asks for a clamp.
    let clamped = |c: Vec4| c.clamp(Vec4::ZERO, Vec4::ONE);
    if document.components(index, &at)? == 3 {
        let rgb = document.floats::<3>(index, &at)?;
        return Ok(rgb.into_iter().map(|c| clamped(Vec3::from_array(c).extend(1.0))).collect());
    }
    Ok(document.floats::<4>(index, &at)?.into_iter().map(|c| clamped(Vec4::from_array(c))).collect())
}

/// Triangles of a list, strip or fan, all with the winding of the first (glTF 2.0, section 3.7.2.1).
fn triangles(mode: Mode, list: &[u32]) -> Vec<[u32; 3]> {
    let mut out: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => list
            .windows(3)
            .enumerate()
            .map(|(i, v)| if i % 2 == 0 { [v[0], v[1], v[2]] } else { [v[0], v[2], v[1]] })
            .collect(),
        Mode::TriangleFan => match list.split_first() {
            Some((&hub, rim)) => rim.windows(2).map(|v| [v[0], v[1], hub]).collect(),
            None => Vec::new(),
        },
        _ => list.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect(),
    };
    // Strips are joined by triangles that use a vertex twice; nothing of them can be seen.
    out.retain(|[a, b, c]| a != b && b != c && a != c);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_the_winding() {
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 2, 3]), [[0, 1, 2]]);
        assert_eq!(triangles(Mode::TriangleFan, &[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(triangles(Mode::TriangleFan, &[]), [[0u32; 3]; 0]);
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3]), [[0, 1, 2]]);
    }
}
