//! Checked reading of accessors: any component type, normalisation, strides, sparse substitution.

use std::borrow::Cow;
use std::sync::atomic::Ordering;

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use crate::document::Document;
use pt_scene::SceneError;

/// More elements than a 32-bit vertex index can name are a mistake, and no reason to allocate.
const MAX_COUNT: u64 = 1 << 31;

/// Elements of an accessor in memory that has been checked to hold them all.
struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    /// Bytes from one element to the next, >= `size`.
    stride: usize,
    /// Bytes of one element.
    size: usize,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl Elements<'_> {
    fn map<T>(&self, decode: impl Fn(&[u8]) -> T) -> Vec<T> {
        (0..self.count).map(|i| decode(&self.bytes[i * self.stride..][..self.size])).collect()
    }
}

impl Document {
    /// Vectors (or, for 9 and 16, column-major matrices) of `N` floats; integers are normalised where the accessor
    /// says so.
    pub fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        at: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let elements = self.elements(index, at, N)?;
        let size = elements.component.size();
        Ok(match elements.component {
            ComponentType::F32 => elements.map(|b| std::array::from_fn(|c| f32_at(b, 4 * c))),
            component => elements
                .map(|b| std::array::from_fn(|c| float(&b[c * size..], component, elements.normalized))),
        })
    }

    /// Vectors of `N` unsigned integers.
    pub fn unsigned<const N: usize>(
        &self,
        index: Index<Accessor>,
        at: &str,
    ) -> Result<Vec<[u32; N]>, SceneError> {
        let e = self.elements(index, at, N)?;
        Ok(match e.component {
            ComponentType::U8 => e.map(|b| std::array::from_fn(|c| b[c].into())),
            ComponentType::U16 => {
                e.map(|b| std::array::from_fn(|c| u16::from_le_bytes([b[2 * c], b[2 * c + 1]]).into()))
            }
            ComponentType::U32 => e.map(|b| std::array::from_fn(|c| u32_at(b, 4 * c))),
            other => {
                let what = format!("is of {}, but {at} needs unsigned integers", component_name(other));
                return Err(self.invalid(format!("accessors[{}].componentType", index.value()), what));
            }
        })
    }

    /// Scalars of an unsigned integer type.
    pub fn integers(&self, index: Index<Accessor>, at: &str) -> Result<Vec<u32>, SceneError> {
        Ok(self.unsigned::<1>(index, at)?.into_iter().flatten().collect())
    }

    /// Number of components of an accessor's elements.
    pub fn components(&self, index: Index<Accessor>, at: &str) -> Result<usize, SceneError> {
        match self.get(index, at)?.type_ {
            Checked::Valid(t) => Ok(t.multiplicity()),
            Checked::Invalid => {
                Err(self.invalid(format!("accessors[{}].type", index.value()), "unknown type"))
            }
        }
    }

    /// Number of elements, without reading any.
    pub fn count(&self, index: Index<Accessor>, at: &str) -> Result<usize, SceneError> {
        if let Some(decoded) = self.decoded.get(&index.value()) {
            return Ok(decoded.count);
        }
        let count = self.get(index, at)?.count.0;
        if count > MAX_COUNT {
            let at = format!("accessors[{}].count", index.value());
            return Err(self.invalid(at, format!("{count} elements are more than {MAX_COUNT}")));
        }
        Ok(count as usize)
    }

    /// Checks that the elements of an accessor are there, without reading them.
    pub(crate) fn check_accessor(&self, index: usize) -> Result<(), SceneError> {
        let accessor = &self.root.accessors[index];
        let at = format!("accessors[{index}]");
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            return Ok(());
        };
        if self.decoded.contains_key(&index) {
            return Ok(());
        }
        let count = self.count(Index::new(index as u32), &at)?;
        if let Some(view) = accessor.buffer_view {
            let size = element_size(component.0, kind);
            self.gather(view, accessor.byte_offset.map_or(0, |o| o.0), size, count, &at)?;
        }
        if let Some(sparse) = &accessor.sparse {
            self.sparse_parts(sparse, element_size(component.0, kind), count, &at)?;
        }
        Ok(())
    }

    /// The elements of an accessor, sparse ones put in place.
    fn elements(
        &self,
        index: Index<Accessor>,
        used_at: &str,
        components: usize,
    ) -> Result<Elements<'_>, SceneError> {
        let accessor = self.get(index, used_at)?;
        let at = format!("accessors[{}]", index.value());
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            return Err(self.invalid(&at, "unknown component type or type"));
        };
        let decoded = self.decoded.get(&index.value());
        let component = decoded.map_or(component.0, |d| d.component);
        let matrix = matches!(kind, Type::Mat2 | Type::Mat3 | Type::Mat4);
        // Columns of matrices of small integers are padded; nothing in glTF uses them.
        if kind.multiplicity() != components || (matrix && component != ComponentType::F32) {
            let (kind, component) = (type_name(kind), component_name(component));
            let what = format!("is {kind} of {component}, but {used_at} needs {components} component(s)");
            return Err(self.invalid(&at, what));
        }
        let count = self.count(index, used_at)?;
        let size = component.size() * components;
        // A small file can have the same data read any number of times.
        let bytes = 4 * components as u64 * count as u64;
        if self.elements_read.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes)
            > self.max_geometry_bytes
        {
            return Err(self.invalid(
                used_at,
                format!("more than {} bytes of elements; see --max-geometry-bytes", self.max_geometry_bytes),
            ));
        }
        let packed =
            |bytes| Elements { bytes, stride: size, size, count, component, normalized: accessor.normalized };
        if let Some(decoded) = decoded {
            return Ok(packed(Cow::Borrowed(&decoded.bytes)));
        }
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let base = match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = self.gather(view, offset, size, count, &at)?;
                Elements { stride, ..packed(Cow::Borrowed(bytes)) }
            }
            // Absent data are zeros, to be filled by the sparse part. They are no way to ask for any amount of memory.
            None => {
                if count > self.total_bytes().max(1 << 16) {
                    let what =
                        format!("{count} elements without a bufferView are more than the file has bytes");
                    return Err(self.invalid(format!("{at}.count"), what));
                }
                packed(Cow::Owned(vec![0; count * size]))
            }
        };
        let Some(sparse) = &accessor.sparse else { return Ok(base) };
        let mut bytes = match (base.bytes, base.stride == size) {
            (bytes, true) => bytes.into_owned(),
            (bytes, false) => {
                (0..count).flat_map(|i| &bytes[i * base.stride..][..size]).copied().collect::<Vec<u8>>()
            }
        };
        bytes.truncate(count * size);
        let parts = self.sparse_parts(sparse, size, count, &at)?;
        for i in 0..parts.count {
            let index = &parts.indices[i * parts.index_stride..][..parts.index_size];
            let target = index.iter().rev().fold(0usize, |sum, &byte| sum << 8 | usize::from(byte));
            if target >= count {
                let what = format!("element {i} replaces element {target} of {count}");
                return Err(self.invalid(format!("{at}.sparse.indices"), what));
            }
            bytes[target * size..][..size].copy_from_slice(&parts.values[i * parts.value_stride..][..size]);
        }
        Ok(packed(Cow::Owned(bytes)))
    }

    fn sparse_parts(
        &self,
        sparse: &gltf::json::accessor::sparse::Sparse,
        size: usize,
        count: usize,
        at: &str,
    ) -> Result<SparseParts<'_>, SceneError> {
        let at = format!("{at}.sparse");
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            return Err(self.invalid(format!("{at}.indices.componentType"), "indices cannot be of this type"));
        };
        let changes = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if changes > count {
            return Err(self.invalid(format!("{at}.count"), format!("{changes} values for {count} elements")));
        }
        let index_size = index_type.0.size();
        let (indices, values) = (&sparse.indices, &sparse.values);
        let at_indices = format!("{at}.indices");
        let (index_bytes, index_stride) =
            self.gather(indices.buffer_view, indices.byte_offset.0, index_size, changes, &at_indices)?;
        let at_values = format!("{at}.values");
        let (value_bytes, value_stride) =
            self.gather(values.buffer_view, values.byte_offset.0, size, changes, &at_values)?;
        Ok(SparseParts {
            count: changes,
            indices: index_bytes,
            index_stride,
            index_size,
            values: value_bytes,
            value_stride,
        })
    }

    /// The part of a buffer view from the first to the end of the last of `count` elements of `size` bytes, and the
    /// stride between them.
    fn gather(
        &self,
        view: Index<buffer::View>,
        offset: u64,
        size: usize,
        count: usize,
        at: &str,
    ) -> Result<(&[u8], usize), SceneError> {
        let (bytes, view) = self.view(view, &format!("{at}.bufferView"))?;
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            let what = format!("byteStride {stride} is less than the {size} bytes of an element");
            return Err(self.invalid(at, what));
        }
        let Some(last) = count.checked_sub(1) else { return Ok((&[], stride)) };
        let end = (last as u64)
            .checked_mul(stride as u64)
            .and_then(|n| n.checked_add(offset)?.checked_add(size as u64));
        match end {
            Some(end) if end <= bytes.len() as u64 => Ok((&bytes[offset as usize..end as usize], stride)),
            _ => {
                let what = format!(
                    "{count} elements of {size} bytes at {offset}, stride {stride}, do not fit in {} bytes",
                    bytes.len()
                );
                Err(self.invalid(at, what))
            }
        }
    }
}

/// The name of a type in the specification.
pub(crate) fn type_name(kind: Type) -> &'static str {
    match kind {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    }
}

/// The name of a component type in the specification.
pub(crate) fn component_name(component: ComponentType) -> &'static str {
    match component {
        ComponentType::I8 => "byte",
        ComponentType::U8 => "unsigned byte",
        ComponentType::I16 => "short",
        ComponentType::U16 => "unsigned short",
        ComponentType::U32 => "unsigned int",
        ComponentType::F32 => "float",
    }
}

struct SparseParts<'a> {
    count: usize,
    indices: &'a [u8],
    index_stride: usize,
    index_size: usize,
    values: &'a [u8],
    value_stride: usize,
}

/// Bytes of an element; columns of matrices start at multiples of 4 bytes (glTF 2.0, section 3.6.2.4).
fn element_size(component: ComponentType, kind: Type) -> usize {
    let column = |rows: usize| (rows * component.size()).next_multiple_of(4);
    match kind {
        Type::Mat2 => 2 * column(2),
        Type::Mat3 => 3 * column(3),
        Type::Mat4 => 4 * column(4),
        _ => kind.multiplicity() * component.size(),
    }
}

fn u32_at(b: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]])
}

fn f32_at(b: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(b, at))
}

fn float(b: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, largest) = match component {
        ComponentType::I8 => (f32::from(b[0] as i8), 127.0),
        ComponentType::U8 => (f32::from(b[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
        ComponentType::U32 => (u32_at(b, 0) as f32, u32::MAX as f32),
        ComponentType::F32 => return f32_at(b, 0),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
