//! Checked reading of accessors: any component type, normalisation, strides, sparse substitution.

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use super::document::Document;
use crate::SceneError;

/// How the bytes of one component are to be understood.
struct Layout {
    component: ComponentType,
    normalized: bool,
}

/// More elements than a 32-bit vertex index can name are a mistake, and no reason to allocate.
const MAX_COUNT: u64 = 1 << 31;

impl Document {
    /// Vectors of `N` floats; integers are normalised where the accessor says so.
    pub fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        at: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let (layout, elements) = self.elements(index, at, N)?;
        let size = layout.component.size();
        let decode = |bytes: &[u8]| {
            std::array::from_fn(|c| float(&bytes[c * size..], layout.component, layout.normalized))
        };
        Ok(elements.chunks_exact(N * size).map(decode).collect())
    }

    /// Scalars of an unsigned integer type.
    pub fn integers(&self, index: Index<Accessor>, at: &str) -> Result<Vec<u32>, SceneError> {
        let (layout, elements) = self.elements(index, at, 1)?;
        let decode: fn(&[u8]) -> u32 = match layout.component {
            ComponentType::U8 => |b| b[0].into(),
            ComponentType::U16 => |b| u16::from_le_bytes([b[0], b[1]]).into(),
            ComponentType::U32 => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            other => return Err(self.invalid(at, format!("{other:?} cannot be an index"))),
        };
        Ok(elements.chunks_exact(layout.component.size()).map(decode).collect())
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

    /// The elements of an accessor, tightly packed, sparse ones put in place.
    fn elements(
        &self,
        index: Index<Accessor>,
        used_at: &str,
        components: usize,
    ) -> Result<(Layout, Vec<u8>), SceneError> {
        let accessor = self.get(index, used_at)?;
        let at = format!("accessors[{}]", index.value());
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            return Err(self.invalid(&at, "unknown component type or type"));
        };
        if kind.multiplicity() != components || matches!(kind, Type::Mat2 | Type::Mat3) {
            return Err(
                self.invalid(&at, format!("is {kind:?}, but {used_at} needs {components} component(s)"))
            );
        }
        if accessor.count.0 > MAX_COUNT {
            return Err(self.invalid(&at, format!("count {} is too large", accessor.count.0)));
        }
        let count = accessor.count.0 as usize;
        let layout = Layout { component: component.0, normalized: accessor.normalized };
        let size = layout.component.size() * components;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let mut bytes = match accessor.buffer_view {
            Some(view) => self.gather(view, offset, size, count, &at)?,
            // Absent data are zeros, filled by the sparse part. Without one they would be a way to ask for any amount of memory.
            None if accessor.sparse.is_some() => vec![0; self.sparse_size(size, count, &at)?],
            None => return Err(self.invalid(&at, "has neither a bufferView nor sparse values")),
        };
        if let Some(sparse) = &accessor.sparse {
            let at = format!("{at}.sparse");
            let Checked::Valid(index_type) = sparse.indices.component_type else {
                return Err(self.invalid(&at, "unknown component type of the indices"));
            };
            let changes = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            if changes > count {
                return Err(self.invalid(&at, format!("{changes} values for {count} elements")));
            }
            let width = index_type.0.size();
            let indices =
                self.gather(sparse.indices.buffer_view, sparse.indices.byte_offset.0, width, changes, &at)?;
            let values =
                self.gather(sparse.values.buffer_view, sparse.values.byte_offset.0, size, changes, &at)?;
            for (i, value) in indices.chunks_exact(width).zip(values.chunks_exact(size)) {
                let i = i.iter().rev().fold(0usize, |sum, &byte| sum << 8 | usize::from(byte));
                let target = bytes.get_mut(i.saturating_mul(size)..i.saturating_add(1).saturating_mul(size));
                target
                    .ok_or_else(|| self.invalid(&at, format!("index {i} is past {count}")))?
                    .copy_from_slice(value);
            }
        }
        Ok((layout, bytes))
    }

    fn sparse_size(&self, size: usize, count: usize, at: &str) -> Result<usize, SceneError> {
        const LIMIT: usize = 1 << 30;
        let bytes = size * count;
        if bytes > LIMIT {
            Err(self.invalid(at, format!("{bytes} bytes of zeros are too many")))
        } else {
            Ok(bytes)
        }
    }

    /// `count` elements of `size` bytes from a buffer view, which may be strided.
    fn gather(
        &self,
        view: Index<buffer::View>,
        offset: u64,
        size: usize,
        count: usize,
        at: &str,
    ) -> Result<Vec<u8>, SceneError> {
        let (bytes, view) = self.view(view, at)?;
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(
                self.invalid(at, format!("byteStride {stride} is less than the {size} bytes of an element"))
            );
        }
        let Some(last) = count.checked_sub(1) else { return Ok(Vec::new()) };
        let end = (last as u64)
            .checked_mul(stride as u64)
            .and_then(|n| n.checked_add(offset)?.checked_add(size as u64));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let what = format!(
                "{count} elements of {size} bytes at {offset}, stride {stride}, do not fit in {} bytes",
                bytes.len()
            );
            return Err(self.invalid(at, what));
        }
        let start = offset as usize;
        Ok((0..count).flat_map(|i| &bytes[start + i * stride..start + i * stride + size]).copied().collect())
    }
}

fn float(b: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, largest) = match component {
        ComponentType::I8 => (f32::from(b[0] as i8), 127.0),
        ComponentType::U8 => (f32::from(b[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
        ComponentType::U32 => (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, u32::MAX as f32),
        ComponentType::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
