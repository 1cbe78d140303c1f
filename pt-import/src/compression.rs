//! Compressed geometry: EXT_meshopt_compression (KHR_meshopt_compression) for buffer views, KHR_draco_mesh_compression for
//! primitives. Both are decoded once, in front of everything that reads accessors.

use std::collections::{BTreeMap, BTreeSet};

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use gltf::json::accessor::{Accessor, ComponentType};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};
use meshopt::ffi;
use rayon::prelude::*;
use serde::Deserialize;

use crate::document::{Decoded, Document};
use pt_scene::SceneError;

/// The extension and the name under which it was ratified; the latter adds a filter and a codec version, which the decoder
/// tells apart itself.
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
const DRACO: &str = "KHR_draco_mesh_compression";

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct MeshoptView {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: usize,
    count: usize,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

/// Whether a buffer only stands in for compressed data.
pub(crate) fn is_fallback(buffer: &buffer::Buffer) -> bool {
    let others = buffer.extensions.as_ref().map(|e| &e.others);
    MESHOPT.iter().any(|name| others.and_then(|o| o.get(*name)?.get("fallback")?.as_bool()).unwrap_or(false))
}

/// Decodes all compressed buffer views.
pub(crate) fn decode_views(document: &mut Document) -> Result<(), SceneError> {
    let mut work = Vec::new();
    let mut total = 0u64;
    for (i, view) in document.root.buffer_views.iter().enumerate() {
        let others = view.extensions.as_ref().map(|e| &e.others);
        for name in MESHOPT {
            let at = format!("bufferViews[{i}]");
            let Some(stream) = document.extension::<MeshoptView>(others, name, &at)? else { continue };
            let at = format!("{at}.extensions.{name}");
            let size = (stream.count as u64).saturating_mul(stream.byte_stride as u64);
            total = total.saturating_add(size);
            if size != view.byte_length.0 {
                let what = format!("count x byteStride is {size}, byteLength is {}", view.byte_length.0);
                return Err(document.invalid(at, what));
            }
            if total > document.max_geometry_bytes {
                return Err(document.invalid(at, too_much(document)));
            }
            work.push((i, stream, at));
            break;
        }
    }
    let shared = &*document;
    let decode = |(i, stream, at): (usize, MeshoptView, String)| {
        let encoded = shared.range(stream.buffer, stream.byte_offset, stream.byte_length, &at)?;
        let bytes = decode_view(&stream, encoded).map_err(|what| shared.invalid(&at, what))?;
        Ok((i, bytes))
    };
    let views: Result<BTreeMap<_, _>, SceneError> = work.into_par_iter().map(decode).collect();
    document.views = views?;
    Ok(())
}

fn too_much(document: &Document) -> String {
    format!("more than {} bytes of geometry; see --max-geometry-bytes", document.max_geometry_bytes)
}

/// The strides, counts and filters that the decoder demands are checked first: it trusts its caller with them.
fn decode_view(v: &MeshoptView, encoded: &[u8]) -> Result<Vec<u8>, String> {
    let fits = match v.mode.as_str() {
        "ATTRIBUTES" => v.byte_stride.is_multiple_of(4) && (4..=256).contains(&v.byte_stride),
        "TRIANGLES" => matches!(v.byte_stride, 2 | 4) && v.count.is_multiple_of(3),
        "INDICES" => matches!(v.byte_stride, 2 | 4),
        other => return Err(format!("unknown mode {other}")),
    };
    let filter = v.filter.as_deref().unwrap_or("NONE");
    let filter_fits = match filter {
        "NONE" => true,
        "OCTAHEDRAL" | "COLOR" => v.mode == "ATTRIBUTES" && matches!(v.byte_stride, 4 | 8),
        "QUATERNION" => v.mode == "ATTRIBUTES" && v.byte_stride == 8,
        "EXPONENTIAL" => v.mode == "ATTRIBUTES",
        other => return Err(format!("unknown filter {other}")),
    };
    if !fits || !filter_fits {
        let MeshoptView { byte_stride, count, mode, .. } = v;
        return Err(format!(
            "{mode} with filter {filter}: byteStride {byte_stride} or count {count} is wrong"
        ));
    }
    // 32-bit words, so that the filters see aligned memory.
    let mut words = vec![0u32; (v.count * v.byte_stride).div_ceil(4)];
    let out = words.as_mut_ptr().cast();
    let (data, length) = (encoded.as_ptr(), encoded.len());
    // SAFETY: `words` has room for `count` elements of `byte_stride` bytes, both in the ranges that the functions document;
    // they read no further than `length` and are made for input that nobody vouches for.
    let code = unsafe {
        match v.mode.as_str() {
            "ATTRIBUTES" => ffi::meshopt_decodeVertexBuffer(out, v.count, v.byte_stride, data, length),
            "TRIANGLES" => ffi::meshopt_decodeIndexBuffer(out, v.count, v.byte_stride, data, length),
            _ => ffi::meshopt_decodeIndexSequence(out, v.count, v.byte_stride, data, length),
        }
    };
    if code != 0 {
        return Err(format!("the compressed {} are broken (code {code})", v.mode.to_lowercase()));
    }
    // SAFETY: as above; the filters work in place on whole elements.
    unsafe {
        match filter {
            "OCTAHEDRAL" => ffi::meshopt_decodeFilterOct(out, v.count, v.byte_stride),
            "QUATERNION" => ffi::meshopt_decodeFilterQuat(out, v.count, v.byte_stride),
            "EXPONENTIAL" => ffi::meshopt_decodeFilterExp(out, v.count, v.byte_stride),
            "COLOR" => ffi::meshopt_decodeFilterColor(out, v.count, v.byte_stride),
            _ => {}
        }
    }
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    Ok(bytes[..v.count * v.byte_stride].to_vec())
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct DracoPrimitive {
    buffer_view: u32,
    attributes: BTreeMap<String, u32>,
}

/// Decodes all compressed primitives; their accessors are filled with what comes out.
pub(crate) fn decode_primitives(document: &mut Document) -> Result<(), SceneError> {
    let mut work = Vec::new();
    for (m, mesh) in document.root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("meshes[{m}].primitives[{p}]");
            let others = primitive.extensions.as_ref().map(|e| &e.others);
            if let Some(stream) = document.extension::<DracoPrimitive>(others, DRACO, &at)? {
                work.push((primitive, stream, at));
            }
        }
    }
    // Several primitives may use the same stream through the same accessors.
    let mut seen = BTreeSet::new();
    work.retain(|(primitive, stream, _)| {
        let accessors: Vec<_> =
            primitive.attributes.values().chain(&primitive.indices).map(Index::value).collect();
        seen.insert((stream.buffer_view, accessors))
    });
    let shared = &*document;
    let decode = |(primitive, stream, at): (&Primitive, DracoPrimitive, String)| {
        decode_primitive(shared, primitive, &stream, &at)
    };
    let parts: Result<Vec<_>, SceneError> = work.into_par_iter().map(decode).collect();
    document.decoded = parts?.into_iter().flatten().collect();
    Ok(())
}

fn decode_primitive(
    document: &Document,
    primitive: &Primitive,
    stream: &DracoPrimitive,
    at: &str,
) -> Result<Vec<(usize, Decoded)>, SceneError> {
    let at = format!("{at}.extensions.{DRACO}");
    let mut used = Vec::new();
    let mut bytes = 1 << 16;
    let mut limit = |index: Index<Accessor>| -> Result<u64, SceneError> {
        let count = document.count(index, &at)? as u64;
        // Up to 4 components of 4 bytes; twice, for exporters that count vertices before seams split them.
        bytes += 2 * 16 * count;
        Ok(count)
    };
    let faces = primitive.indices.map(&mut limit).transpose()?.unwrap_or(0) / 3;
    for (semantic, &accessor) in &primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        if let Some(&id) = stream.attributes.get(&semantic.to_string()) {
            limit(accessor)?;
            used.push((semantic, accessor, id));
        }
    }
    if bytes > document.max_geometry_bytes {
        return Err(document.invalid(at, too_much(document)));
    }
    let (encoded, _) = document.view(Index::new(stream.buffer_view), &format!("{at}.bufferView"))?;
    let limits = DecodeLimits::default().with_max_faces(2 * faces + 64).with_max_decoded_bytes(bytes);
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(encoded).with_limits(limits), &mut mesh)
        .map_err(|e| document.invalid(&at, format!("the Draco stream cannot be decoded: {e}")))?;
    let points = mesh.num_points();
    let mut out = Vec::new();
    if let Some(indices) = primitive.indices {
        let corners = mesh.faces().iter().flatten();
        let bytes = corners.flat_map(|point| point.0.to_le_bytes()).collect();
        let decoded = Decoded { component: ComponentType::U32, count: 3 * mesh.num_faces(), bytes };
        out.push((indices.value(), decoded));
    }
    for (semantic, accessor, id) in used {
        let components = document.components(accessor, &at)?;
        let attribute = mesh.attribute_by_unique_id(id).ok_or_else(|| {
            let what = format!("the Draco stream has no attribute {id}");
            document.invalid(format!("{at}.attributes.{}", Semantic::to_string(semantic)), what)
        })?;
        let component = component(document, accessor, &at)?;
        let bytes = pack(&attribute.read_f32s(points, components), component);
        out.push((accessor.value(), Decoded { component, count: points, bytes }));
    }
    Ok(out)
}

fn component(document: &Document, index: Index<Accessor>, at: &str) -> Result<ComponentType, SceneError> {
    match document.get(index, at)?.component_type {
        Checked::Valid(component) => Ok(component.0),
        Checked::Invalid => {
            Err(document.invalid(format!("accessors[{}].componentType", index.value()), "unknown type"))
        }
    }
}

/// Values of a stream in the component type of their accessor; small integers pass through `f32` unchanged.
fn pack(values: &[f32], component: ComponentType) -> Vec<u8> {
    match component {
        ComponentType::I8 => values.iter().map(|&v| v as i8 as u8).collect(),
        ComponentType::U8 => values.iter().map(|&v| v as u8).collect(),
        ComponentType::I16 => values.iter().flat_map(|&v| (v as i16).to_le_bytes()).collect(),
        ComponentType::U16 => values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
        ComponentType::U32 => values.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect(),
        ComponentType::F32 => values.iter().flat_map(|&v| v.to_le_bytes()).collect(),
    }
}
