//! A parsed file with its bytes, and the errors that name places in it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::AtomicU64;

use gltf::json::accessor::ComponentType;
use gltf::json::{Index, Root, buffer, root::Get};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::uri;
use pt_scene::SceneError;
use pt_scene::one_line;

/// A parsed file with the bytes of its buffers.
pub(crate) struct Document {
    pub root: Root,
    /// For messages.
    pub(crate) file: PathBuf,
    /// Where external files may lie; `None` for a file from memory.
    pub(crate) folder: Option<PathBuf>,
    pub(crate) buffers: Vec<Vec<u8>>,
    /// Buffer views that were compressed, by index.
    pub(crate) views: BTreeMap<usize, Vec<u8>>,
    /// Accessors that were compressed, by index.
    pub(crate) decoded: BTreeMap<usize, Decoded>,
    /// External files may lie elsewhere too.
    pub(crate) allow_outside: bool,
    pub(crate) max_geometry_bytes: u64,
    /// Bytes of all elements read so far.
    pub(crate) elements_read: AtomicU64,
}

/// The elements of an accessor that came out of a compressed stream, tightly packed.
pub(crate) struct Decoded {
    pub component: ComponentType,
    pub count: usize,
    pub bytes: Vec<u8>,
}

impl Document {
    /// An error at a JSON path of this file.
    pub fn invalid(&self, at: impl ToString, what: impl ToString) -> SceneError {
        let at = one_line(&at.to_string());
        SceneError::Invalid { file: self.file.clone(), at, what: one_line(&what.to_string()) }
    }

    /// Follows an index, which may be out of range.
    pub fn get<T>(&self, index: Index<T>, at: &str) -> Result<&T, SceneError>
    where
        Root: Get<T>,
    {
        self.root
            .get(index)
            .ok_or_else(|| self.invalid(at, format!("index {} does not exist", index.value())))
    }

    /// The bytes of a buffer view, decompressed.
    pub fn view(&self, index: Index<buffer::View>, at: &str) -> Result<(&[u8], &buffer::View), SceneError> {
        let view = self.get(index, at)?;
        if let Some(bytes) = self.views.get(&index.value()) {
            return Ok((bytes, view));
        }
        let offset = view.byte_offset.map_or(0, |offset| offset.0);
        let at = format!("bufferViews[{}]", index.value());
        Ok((self.range(view.buffer.value(), offset, view.byte_length.0, &at)?, view))
    }

    /// Bytes of all buffers.
    pub fn total_bytes(&self) -> usize {
        self.buffers.iter().map(Vec::len).sum()
    }

    /// Bytes of a buffer.
    pub fn range(&self, buffer: usize, offset: u64, length: u64, at: &str) -> Result<&[u8], SceneError> {
        let data = self.buffers.get(buffer);
        let data = data
            .ok_or_else(|| self.invalid(format!("{at}.buffer"), format!("index {buffer} does not exist")))?;
        let end = offset.checked_add(length).filter(|&end| end <= data.len() as u64);
        end.map(|end| &data[offset as usize..end as usize]).ok_or_else(|| {
            let what = format!("{length} bytes at {offset} do not fit in {} bytes", data.len());
            self.invalid(at, what)
        })
    }

    /// The bytes behind a URI: base64 data, or a file, in the folder of the scene or below it unless others are allowed.
    pub fn fetch(&self, uri: &str, at: &str) -> Result<Vec<u8>, SceneError> {
        Ok(self.fetch_any(uri, at)?.0)
    }

    /// Bytes, and the media type of embedded ones.
    pub fn fetch_any(&self, uri: &str, at: &str) -> Result<(Vec<u8>, Option<String>), SceneError> {
        let target = uri::parse(uri, self.allow_outside).map_err(|what| self.invalid(at, what))?;
        let path = match target {
            uri::Target::Data(bytes, media) => return Ok((bytes, Some(media))),
            uri::Target::File(path) => path,
        };
        let Some(folder) = &self.folder else {
            return Err(self.invalid(at, format!("{}: a scene from memory cannot name files", path.decoded)));
        };
        let (path, bytes) = path.read(folder, self.allow_outside);
        Ok((bytes.map_err(|what| self.invalid(at, format!("{path}: {what}")))?, None))
    }

    /// An extension object that the JSON crate has no type for. `at` is the path of the object that is extended.
    pub fn extension<T: DeserializeOwned>(
        &self,
        others: Option<&Map<String, Value>>,
        name: &str,
        at: &str,
    ) -> Result<Option<T>, SceneError> {
        let Some(value) = others.and_then(|others| others.get(name)) else { return Ok(None) };
        let parsed = T::deserialize(value);
        let at = if at.is_empty() { String::new() } else { format!("{at}.") };
        parsed.map(Some).map_err(|e| self.invalid(format!("{at}extensions.{name}"), e))
    }
}
