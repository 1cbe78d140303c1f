use std::collections::BTreeMap;

use gltf::json::accessor::{Accessor, ComponentType as C, Type as T};
use gltf::json::buffer::Target;
use gltf::json::mesh::{Mesh, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, texture};

use crate::accessor::{component_name, type_name};
use crate::document::Document;
use crate::notices::Notices;
use pt_scene::SceneError;

/// First use of each buffer view: for what, and by which accessor.
type Uses = BTreeMap<usize, (Target, usize)>;

/// Attributes and indices exist, are of types that can be read, and agree in number.
pub(crate) fn check(document: &Document, notices: &mut Notices) -> Result<(), SceneError> {
    let mut uses = Uses::new();
    for (m, mesh) in document.root.meshes.iter().enumerate() {
        let at = format!("meshes[{m}]");
        targets(document, mesh, &at, notices)?;
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("{at}.primitives[{p}]");
            attributes(document, primitive, &at, &mut uses, notices)?;
            indices(document, primitive, &at, &mut uses, notices)?;
            if let Some(material) = primitive.material {
                document.get(material, &format!("{at}.material"))?;
                texture_coordinates(document, primitive, material.value(), &at, notices);
            }
        }
    }
    Ok(())
}

fn format(accessor: &Accessor) -> Option<(C, T)> {
    match (accessor.component_type, accessor.type_) {
        (Checked::Valid(component), Checked::Valid(kind)) => Some((component.0, kind)),
        _ => None,
    }
}

/// Core formats (table of section 3.7.2.1) and those of KHR_mesh_quantization; more lenient with normalisation.
fn readable(semantic: &Semantic, component: C, kind: T) -> bool {
    match semantic {
        Semantic::Positions | Semantic::Normals => kind == T::Vec3 && component != C::U32,
        Semantic::Tangents => kind == T::Vec4 && component != C::U32,
        Semantic::TexCoords(_) => kind == T::Vec2 && component != C::U32,
        Semantic::Colors(_) => matches!(kind, T::Vec3 | T::Vec4),
        Semantic::Joints(_) => kind == T::Vec4 && matches!(component, C::U8 | C::U16),
        Semantic::Weights(_) => kind == T::Vec4 && matches!(component, C::U8 | C::U16 | C::F32),
        Semantic::Extras(_) => true,
    }
}

fn attributes(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    uses: &mut Uses,
    notices: &mut Notices,
) -> Result<(), SceneError> {
    let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    let vertices = position.map(|&p| document.get(p, &format!("{at}.attributes.POSITION"))).transpose()?;
    for (semantic, &index) in &primitive.attributes {
        let at = format!("{at}.attributes.{}", semantic.to_string());
        let accessor = document.get(index, &at)?;
        let Checked::Valid(semantic) = semantic else { continue };
        check_attribute(document, accessor, semantic, vertices, &at, notices)?;
        view_use(document, index, Target::ArrayBuffer, &at, uses, notices);
        if *semantic == Semantic::Positions && (accessor.min.is_none() || accessor.max.is_none()) {
            notices.add(&at, "its accessor has no min and max");
        }
        let partner = match semantic {
            Semantic::Joints(n) => Semantic::Weights(*n),
            Semantic::Weights(n) => Semantic::Joints(*n),
            _ => continue,
        };
        if !primitive.attributes.contains_key(&Checked::Valid(partner)) {
            notices.add(&at, "joints and weights come in pairs; left out");
        }
    }
    for (t, target) in primitive.targets.iter().flatten().enumerate() {
        let displaced = [
            (Semantic::Positions, target.positions),
            (Semantic::Normals, target.normals),
            (Semantic::Tangents, target.tangents),
        ];
        for (semantic, index) in displaced {
            let Some(index) = index else { continue };
            let at = format!("{at}.targets[{t}].{}", semantic.to_string());
            let accessor = document.get(index, &at)?;
            // Displacements of tangents have no fourth component.
            check_attribute(document, accessor, &Semantic::Positions, vertices, &at, notices)?;
            view_use(document, index, Target::ArrayBuffer, &at, uses, notices);
            if semantic == Semantic::Positions && (accessor.min.is_none() || accessor.max.is_none()) {
                notices.add(&at, "its accessor has no min and max");
            }
            if !primitive.attributes.contains_key(&Checked::Valid(semantic)) {
                notices.add(at, "displaces an attribute that is not there; left out");
            }
        }
    }
    Ok(())
}

fn check_attribute(
    document: &Document,
    accessor: &Accessor,
    semantic: &Semantic,
    vertices: Option<&Accessor>,
    at: &str,
    notices: &mut Notices,
) -> Result<(), SceneError> {
    let Some((component, kind)) = format(accessor) else {
        return Err(document.invalid(at, "the type or component type of its accessor is unknown"));
    };
    if !readable(semantic, component, kind) {
        return Err(
            document.invalid(at, format!("cannot be {} of {}", type_name(kind), component_name(component)))
        );
    }
    if let Some(vertices) = vertices
        && vertices.count.0 != accessor.count.0
    {
        let what = format!("has {} elements, POSITION has {}", accessor.count.0, vertices.count.0);
        return Err(document.invalid(at, what));
    }
    if matches!(semantic, Semantic::Extras(_)) && component == C::U32 {
        notices.add(at, "attributes cannot be 32-bit integers; left out");
    }
    let stride = accessor.buffer_view.and_then(|v| document.root.buffer_views.get(v.value())?.byte_stride);
    let element = kind.multiplicity() * component.size();
    let offset = accessor.byte_offset.map_or(0, |o| o.0);
    if !offset.is_multiple_of(4) || (stride.is_none() && !element.is_multiple_of(4)) {
        notices.add(at, "vertices are not aligned to 4 bytes");
    }
    Ok(())
}

/// Remembers the first use of each buffer view and remarks on others that do not go with it.
fn view_use(
    document: &Document,
    index: Index<Accessor>,
    target: Target,
    at: &str,
    uses: &mut Uses,
    notices: &mut Notices,
) {
    let view = document.root.get(index).and_then(|accessor| accessor.buffer_view);
    let Some((number, view)) = view.and_then(|v| Some((v.value(), document.root.get(v)?))) else { return };
    if matches!(view.target, Some(Checked::Valid(other)) if other != target) {
        notices.add(at, "the target of its buffer view is that of another use");
    }
    let (first_target, first) = *uses.entry(number).or_insert((target, index.value()));
    if first_target != target {
        notices.add(at, "its buffer view holds vertices and indices");
    } else if first != index.value() && target == Target::ArrayBuffer && view.byte_stride.is_none() {
        notices.add(at, "shares its buffer view with other attributes, and no byteStride is given");
    }
}

fn indices(
    document: &Document,
    primitive: &Primitive,
    at: &str,
    uses: &mut Uses,
    notices: &mut Notices,
) -> Result<(), SceneError> {
    let Some(index) = primitive.indices else { return Ok(()) };
    let at = format!("{at}.indices");
    let accessor = document.get(index, &at)?;
    match format(accessor) {
        Some((C::U8 | C::U16 | C::U32, T::Scalar)) => {}
        Some((component, kind)) => {
            let what = format!("cannot be {} of {}", type_name(kind), component_name(component));
            return Err(document.invalid(at, what));
        }
        None => return Err(document.invalid(at, "the type or component type of its accessor is unknown")),
    }
    let view = accessor.buffer_view.and_then(|v| document.root.get(v));
    if view.is_some_and(|v| v.byte_stride.is_some()) {
        notices.add(&at, "its buffer view has a byteStride");
    }
    view_use(document, index, Target::ElementArrayBuffer, &at, uses, notices);
    Ok(())
}

/// All primitives of a mesh have the same morph targets; as many weights.
fn targets(document: &Document, mesh: &Mesh, at: &str, notices: &mut Notices) -> Result<(), SceneError> {
    if mesh.primitives.is_empty() {
        notices.add(at, "has no primitives");
    }
    let count = |p: &Primitive| p.targets.as_ref().map_or(0, Vec::len);
    let first = mesh.primitives.first().map_or(0, count);
    if let Some(p) = mesh.primitives.iter().position(|p| count(p) != first) {
        let what = format!("{} morph targets, the first primitive has {first}", count(&mesh.primitives[p]));
        return Err(document.invalid(format!("{at}.primitives[{p}].targets"), what));
    }
    if mesh.weights.as_ref().is_some_and(|w| w.len() != first) {
        notices.add(format!("{at}.weights"), "differ in number from the morph targets");
    }
    Ok(())
}

fn texture_coordinates(
    document: &Document,
    primitive: &Primitive,
    material: usize,
    at: &str,
    notices: &mut Notices,
) {
    let material = &document.root.materials[material];
    let pbr = &material.pbr_metallic_roughness;
    let info = |i: &Option<texture::Info>| i.as_ref().map(|i| i.tex_coord);
    let sets = [
        info(&pbr.base_color_texture),
        info(&pbr.metallic_roughness_texture),
        info(&material.emissive_texture),
        material.normal_texture.as_ref().map(|t| t.tex_coord),
        material.occlusion_texture.as_ref().map(|t| t.tex_coord),
    ];
    let missing = |&set: &u32| !primitive.attributes.contains_key(&Checked::Valid(Semantic::TexCoords(set)));
    if sets.into_iter().flatten().any(|set| missing(&set)) {
        notices.add(at, "its material has textures, but it lacks their texture coordinates");
    }
}
