use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use rayon::prelude::*;
use serde::Deserialize;

use crate::deformation;
use crate::document::Document;
use crate::notices::{Notices, Remark};
use crate::tangents;
use pt_scene::MAX_COORDINATE;
use pt_scene::{Material, Mesh, Scene, SceneError};

/// What became of a glTF mesh.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Material of the whole, where the geometry is shared with meshes of other materials.
    pub material: Option<u32>,
}

/// Reads every glTF mesh; `None` where it has no triangles. Meshes that differ in their material only become one.
/// `variant` chooses among the materials of KHR_materials_variants.
pub(crate) fn read(
    document: &Document,
    scene: &mut Scene,
    variant: Option<usize>,
    notices: &mut Notices,
) -> Result<Vec<Option<Shape>>, SceneError> {
    let mut work = Vec::new();
    let mut bytes = 0u64;
    // From what a mesh is made of to the first mesh that is, and its material.
    let mut known: BTreeMap<Ingredients, usize> = BTreeMap::new();
    let mut twins = vec![None; document.root.meshes.len()];
    for (m, mesh) in document.root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("meshes[{m}].primitives[{p}]");
            let Some(mode) = triangle_mode(document, primitive, &at, notices)? else { continue };
            let material = material(document, primitive, variant, &at)?;
            if mesh.primitives.len() == 1
                && let Some(ingredients) = ingredients(primitive, &scene.materials[material])
            {
                let first = *known.entry(ingredients).or_insert(m);
                if first != m {
                    twins[m] = Some((first, material as u32));
                    continue;
                }
            }
            bytes = bytes.saturating_add(size(document, primitive, &scene.materials[material], &at)?);
            if bytes > document.max_geometry_bytes {
                let limit = document.max_geometry_bytes;
                let what = format!("more than {limit} bytes of geometry; see --max-geometry-bytes");
                return Err(document.invalid(at, what));
            }
            work.push(Work { mesh: m, primitive, mode, material, at });
        }
    }
    let materials = &scene.materials;
    let parts: Vec<_> = work.par_iter().map(|work| work.read(document, materials)).collect();
    let descriptions = document.root.meshes.iter().enumerate();
    let mut meshes: Vec<Mesh> = descriptions
        .map(|(m, mesh)| Mesh {
            name: mesh.name.clone().unwrap_or_else(|| format!("meshes[{m}]")),
            ..Mesh::default()
        })
        .collect();
    for (work, part) in work.iter().zip(parts) {
        let (part, remarks) = part?;
        notices.extend(remarks);
        let mesh = &mut meshes[work.mesh];
        if mesh.vertex_count() + part.vertex_count() > u32::MAX as usize {
            return Err(document.invalid(&work.at, "the mesh has more than 2^32 vertices"));
        }
        if mesh.vertex_count() == 0 {
            *mesh = Mesh { name: std::mem::take(&mut mesh.name), ..part };
        } else {
            mesh.append(&part);
        }
    }
    let mut shapes: Vec<Option<Shape>> = Vec::new();
    for (m, (mut mesh, twin)) in meshes.into_iter().zip(twins).enumerate() {
        if let Some((first, material)) = twin {
            shapes.push(shapes[first].map(|shape| Shape { material: Some(material), ..shape }));
        } else if mesh.triangle_count() > 0 {
            shapes.push(Some(Shape { mesh: scene.meshes.len() as u32, material: None }));
            mesh.sort_by_opacity(&scene.materials);
            scene.meshes.push(mesh);
        } else {
            shapes.push(None);
            notices.add(format!("meshes[{m}]"), "has no triangles; left out");
        }
    }
    Ok(shapes)
}

/// Attributes by name, indices, mode, and the set of texture coordinates that tangents follow.
type Ingredients = (Vec<(String, usize)>, Option<usize>, u32, Option<u32>);

/// What the geometry of a rigid primitive without alpha is made of.
fn ingredients(primitive: &Primitive, material: &Material) -> Option<Ingredients> {
    let Checked::Valid(mode) = primitive.mode else { return None };
    if material.is_masked() || primitive.targets.is_some() {
        return None;
    }
    let attributes = primitive.attributes.iter().map(|(name, index)| (name.to_string(), index.value()));
    let indices = primitive.indices.map(|index| index.value());
    Some((attributes.collect(), indices, mode.as_gl_enum(), tangents::needed(material)))
}

/// The mode of a primitive that has triangles.
fn triangle_mode(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    notices: &mut Notices,
) -> Result<Option<Mode>, SceneError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(document.invalid(format!("{at}.mode"), "unknown mode"));
    };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        notices.add(at, "points or lines, left out; only triangles are rendered");
        return Ok(None);
    }
    if !primitive.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
        notices.add(at, "left out, it has no positions");
        return Ok(None);
    }
    Ok(Some(mode))
}

#[derive(Deserialize)]
struct Variants {
    mappings: Vec<VariantMapping>,
}

#[derive(Deserialize)]
struct VariantMapping {
    material: u32,
    variants: Vec<usize>,
}

/// Index into [`Scene::materials`], where the default material follows those of the file.
fn material(
    document: &Document,
    primitive: &Primitive,
    variant: Option<usize>,
    at: &str,
) -> Result<usize, SceneError> {
    const VARIANTS: &str = "KHR_materials_variants";
    let others = primitive.extensions.as_ref().map(|e| &e.others);
    let mappings = document.extension::<Variants>(others, VARIANTS, at)?.map_or(Vec::new(), |v| v.mappings);
    for mapping in &mappings {
        let at = format!("{at}.extensions.{VARIANTS}.mappings");
        document.get(gltf::json::Index::<gltf::json::Material>::new(mapping.material), &at)?;
    }
    let chosen = variant.and_then(|v| mappings.iter().find(|m| m.variants.contains(&v)));
    match (chosen, primitive.material) {
        (Some(mapping), _) => Ok(mapping.material as usize),
        (None, Some(index)) => document.get(index, &format!("{at}.material")).map(|_| index.value()),
        (None, None) => Ok(document.root.materials.len()),
    }
}

fn accessor(primitive: &Primitive, semantic: Semantic) -> Option<gltf::json::Index<gltf::json::Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// Upper bound of the bytes that the primitive takes as a [`Mesh`].
fn size(
    document: &Document,
    primitive: &Primitive,
    material: &Material,
    at: &str,
) -> Result<u64, SceneError> {
    const VERTEX: u64 = (4 * size_of::<Vec3>() + 2 * size_of::<Vec4>()) as u64;
    const TRIANGLE: u64 = size_of::<[u32; 4]>() as u64;
    let count = |index| document.count(index, at).map(|n| n as u64);
    let vertices = accessor(primitive, Semantic::Positions).map_or(Ok(0), count)?;
    let corners = primitive.indices.map_or(Ok(vertices), count)?;
    // Strips and fans have nearly a triangle for each index.
    let triangles = if primitive.mode == Checked::Valid(Mode::Triangles) { corners / 3 } else { corners };
    let splits = accessor(primitive, Semantic::Normals).is_none()
        || (accessor(primitive, Semantic::Tangents).is_none() && tangents::needed(material).is_some());
    let vertices = if splits { vertices.max(3 * triangles) } else { vertices };
    let vertex = VERTEX.saturating_add(deformation::bytes_per_vertex(primitive));
    Ok(vertices.saturating_mul(vertex).saturating_add(triangles.saturating_mul(TRIANGLE)))
}

/// A primitive that is to be read.
struct Work<'a> {
    mesh: usize,
    primitive: &'a Primitive,
    mode: Mode,
    material: usize,
    at: String,
}

impl Work<'_> {
    fn read(&self, document: &Document, materials: &[Material]) -> Result<(Mesh, Vec<Remark>), SceneError> {
        let mut remarks = Vec::new();
        let positions = self.positions(document)?;
        let vertices = positions.len();
        let list = match self.primitive.indices {
            Some(index) => document.integers(index, &format!("{}.indices", self.at))?,
            None => (0..vertices as u32).collect(),
        };
        if let Some(i) = list.iter().position(|&v| v as usize >= vertices) {
            let what = format!("element {i} is vertex {}, there are {vertices}", list[i]);
            return Err(document.invalid(format!("{}.indices", self.at), what));
        }
        let (indices, left_over) = triangles(self.mode, &list);
        drop(list);
        if left_over {
            remarks.push((self.at.clone(), "the last indices do not make a triangle; left out".into()));
        }
        let mut mesh = Mesh {
            uv0: self.uv(document, 0, vertices, &mut remarks)?,
            uv1: self.uv(document, 1, vertices, &mut remarks)?,
            colors: self.colors(document, vertices, &mut remarks)?,
            triangle_materials: vec![self.material as u32; indices.len()],
            indices,
            positions,
            ..Mesh::default()
        };
        deformation::read_vertices(document, self.primitive, &self.at, &mut mesh)?;
        let tangent_set = tangents::needed(&materials[self.material]);
        let normals = self.attribute::<3>(document, Semantic::Normals, vertices)?;
        let no_direction: Vec<usize> = (normals.iter().flatten().enumerate())
            .filter(|(_, n)| {
                !(Vec3::from_array(**n).abs().max_element() > 0.0 && Vec3::from_array(**n).is_finite())
            })
            .map(|(vertex, _)| vertex)
            .collect();
        if !no_direction.is_empty() {
            let what = format!(
                "{} normals that are zero or not finite; replaced by those of the faces",
                no_direction.len()
            );
            remarks.push((self.at.clone(), what));
        }
        let Some(normals) = normals.filter(|_| no_direction.len() < vertices) else {
            // glTF: without normals, flat ones, and tangents in the file are not to be used.
            mesh.flat_shade();
            tangents::compute(&mut mesh, tangent_set);
            return Ok((mesh, remarks));
        };
        mesh.normals = self.unit(normals, "normals", &mut remarks);
        if !no_direction.is_empty() {
            let of_faces = mesh.vertex_normals();
            no_direction.into_iter().for_each(|v| mesh.normals[v] = of_faces[v]);
        }
        match self.attribute::<4>(document, Semantic::Tangents, vertices)? {
            Some(tangents) => {
                let directions = tangents.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
                let directions = self.unit(directions, "tangents", &mut remarks);
                let sign = |w: f32| if w < 0.0 { -1.0 } else { 1.0 };
                mesh.tangents = directions.iter().zip(tangents).map(|(d, t)| d.extend(sign(t[3]))).collect();
            }
            None => tangents::compute(&mut mesh, tangent_set),
        }
        Ok((mesh, remarks))
    }

    fn positions(&self, document: &Document) -> Result<Vec<Vec3>, SceneError> {
        let at = format!("{}.attributes.POSITION", self.at);
        let Some(index) = accessor(self.primitive, Semantic::Positions) else {
            return Err(document.invalid(at, "is missing"));
        };
        let positions: Vec<_> = document.floats::<3>(index, &at)?.into_iter().map(Vec3::from_array).collect();
        match positions.iter().position(|p| !p.is_finite() || p.abs().max_element() > MAX_COORDINATE) {
            Some(i) if positions[i].is_finite() => {
                Err(document.invalid(at, format!("vertex {i} is farther out than {MAX_COORDINATE:e}")))
            }
            Some(i) => Err(document.invalid(at, format!("vertex {i} is not finite: {}", positions[i]))),
            None => Ok(positions),
        }
    }

    /// An attribute with one element for each vertex; `None` where the primitive lacks it.
    fn attribute<const N: usize>(
        &self,
        document: &Document,
        semantic: Semantic,
        vertices: usize,
    ) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        let at = format!("{}.attributes.{}", self.at, semantic.to_string());
        let Some(index) = accessor(self.primitive, semantic) else { return Ok(None) };
        let count = document.count(index, &at)?;
        if count != vertices {
            return Err(document.invalid(at, format!("has {count} elements, POSITION has {vertices}")));
        }
        document.floats::<N>(index, &at).map(Some)
    }

    fn uv(
        &self,
        document: &Document,
        set: u32,
        vertices: usize,
        remarks: &mut Vec<Remark>,
    ) -> Result<Vec<Vec2>, SceneError> {
        let Some(values) = self.attribute::<2>(document, Semantic::TexCoords(set), vertices)? else {
            return Ok(vec![Vec2::ZERO; vertices]);
        };
        let mut broken = false;
        let finite = |v: [f32; 2]| {
            let v = Vec2::from_array(v);
            broken |= !v.is_finite();
            if v.is_finite() { v } else { Vec2::ZERO }
        };
        let values = values.into_iter().map(finite).collect();
        if broken {
            remarks.push((self.at.clone(), "texture coordinates that are not finite; set to 0".into()));
        }
        Ok(values)
    }

    /// Colours are clamped to 0..1, as the specification asks for.
    fn colors(
        &self,
        document: &Document,
        vertices: usize,
        remarks: &mut Vec<Remark>,
    ) -> Result<Vec<Vec4>, SceneError> {
        let Some(index) = accessor(self.primitive, Semantic::Colors(0)) else {
            return Ok(vec![Vec4::ONE; vertices]);
        };
        let mut broken = false;
        let mut clamped = |c: Vec4| {
            broken |= !c.is_finite();
            if c.is_finite() { c.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::ONE }
        };
        let opaque = |c| Vec3::from_array(c).extend(1.0);
        let colors = match document.components(index, &self.at)? {
            3 => {
                let rgb = self.attribute::<3>(document, Semantic::Colors(0), vertices)?.unwrap_or_default();
                rgb.into_iter().map(|c| clamped(opaque(c))).collect()
            }
            _ => {
                let rgba = self.attribute::<4>(document, Semantic::Colors(0), vertices)?.unwrap_or_default();
                rgba.into_iter().map(|c| clamped(Vec4::from_array(c))).collect()
            }
        };
        if broken {
            remarks.push((self.at.clone(), "vertex colours that are not finite; set to white".into()));
        }
        Ok(colors)
    }

    /// Directions of unit length. Quantised ones may be off by a hundredth; more is remarked on.
    fn unit(&self, directions: Vec<[f32; 3]>, name: &str, remarks: &mut Vec<Remark>) -> Vec<Vec3> {
        let mut off = 0;
        let unit = |v: [f32; 3]| {
            let v = Vec3::from_array(v);
            off += usize::from(v.is_finite() && v != Vec3::ZERO && !(0.98..=1.02).contains(&v.length()));
            // Scaled first, so that neither tiny nor huge vectors lose their length.
            (v / v.abs().max_element()).try_normalize().unwrap_or(Vec3::Y)
        };
        let out = directions.into_iter().map(unit).collect();
        if off > 0 {
            remarks.push((self.at.clone(), format!("{name} that are not of unit length; normalised")));
        }
        out
    }
}

/// Triangles of a list, strip or fan, all with the winding of the first (glTF 2.0, section 3.7.2.1), and whether some of
/// the list was left over.
fn triangles(mode: Mode, list: &[u32]) -> (Vec<[u32; 3]>, bool) {
    let mut left_over = list.len() < 3 && !list.is_empty();
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
        _ => {
            left_over |= !list.len().is_multiple_of(3);
            list.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
        }
    };
    // Strips are joined by triangles that use a vertex twice; nothing of them can be seen.
    out.retain(|[a, b, c]| a != b && b != c && a != c);
    (out, left_over)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_the_winding() {
        let of = |mode, list: &[u32]| triangles(mode, list).0;
        assert_eq!(of(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(of(Mode::TriangleStrip, &[0, 1, 2, 2, 3]), [[0, 1, 2]]);
        assert_eq!(of(Mode::TriangleFan, &[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(of(Mode::TriangleFan, &[]), [[0u32; 3]; 0]);
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3]), (vec![[0, 1, 2]], true));
    }
}
