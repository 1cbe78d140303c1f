use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;

use gltf::json::{Index, Root, buffer, root::Get};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::accessor::Decoded;
use super::extensions::Support;
use super::notices::Notices;
use super::{LoadOptions, check, compression, extensions, glb, uri};
use crate::SceneError;
use crate::error::{one_line, read_file};

/// A parsed file with the bytes of its buffers.
pub(super) struct Document {
    pub root: Root,
    /// For messages.
    file: PathBuf,
    /// Where external files may lie; `None` for a file from memory.
    folder: Option<PathBuf>,
    buffers: Vec<Vec<u8>>,
    /// Buffer views that were compressed, by index.
    pub(super) views: BTreeMap<usize, Vec<u8>>,
    /// Accessors that were compressed, by index.
    pub(super) decoded: BTreeMap<usize, Decoded>,
    pub(super) max_geometry_bytes: u64,
    /// Bytes of all elements read so far.
    pub(super) elements_read: AtomicU64,
}

impl Document {
    pub fn read(file: &Path, options: &LoadOptions, notices: &mut Notices) -> Result<Self, SceneError> {
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        Self::parse(read_file(file)?, file, Some(folder), options, notices)
    }

    /// A file from memory. It can have no external buffers and images.
    pub fn parse(
        bytes: Vec<u8>,
        file: &Path,
        folder: Option<PathBuf>,
        options: &LoadOptions,
        notices: &mut Notices,
    ) -> Result<Self, SceneError> {
        let container = glb::split(bytes, notices).map_err(|what| SceneError::file(file, what))?;
        let root = check::json(&container.json, notices).map_err(|(at, what)| match at.as_str() {
            "" => SceneError::file(file, format!("is not a glTF 2.0 file: {what}")),
            _ => SceneError::Invalid { file: file.to_owned(), at: one_line(&at), what: one_line(&what) },
        })?;
        let mut document = Self {
            root,
            file: file.to_owned(),
            folder,
            buffers: Vec::new(),
            views: BTreeMap::new(),
            decoded: BTreeMap::new(),
            max_geometry_bytes: options.max_geometry_bytes,
            elements_read: AtomicU64::new(0),
        };
        document.check_header()?;
        document.read_buffers(container.binary, notices)?;
        check::structure(&document, notices)?;
        compression::decode_views(&mut document)?;
        compression::decode_primitives(&mut document)?;
        check::accessors(&document, notices)?;
        Ok(document)
    }

    fn check_header(&self) -> Result<(), SceneError> {
        let asset = &self.root.asset;
        let required = asset.min_version.as_ref().unwrap_or(&asset.version);
        if !required.starts_with("2.") || (asset.min_version.is_some() && required != "2.0") {
            return Err(self.invalid("asset", format!("glTF version {required}; only 2.0 can be read")));
        }
        let refused = |name: &&String| extensions::support(name) == Support::Refused;
        match self.root.extensions_required.iter().find(refused) {
            Some(name) => Err(SceneError::Extension { file: self.file.clone(), extension: one_line(name) }),
            None => Ok(()),
        }
    }

    fn read_buffers(&mut self, mut binary: Option<Vec<u8>>, notices: &mut Notices) -> Result<(), SceneError> {
        for (i, description) in self.root.buffers.iter().enumerate() {
            let at = format!("buffers[{i}]");
            let length = description.byte_length.0;
            let data = match &description.uri {
                // What only stands in for compressed data is not needed.
                _ if compression::is_fallback(description) => {
                    self.buffers.push(Vec::new());
                    continue;
                }
                Some(uri) => self.fetch_buffer(uri, &at, notices)?,
                None if i == 0 && binary.is_some() => {
                    let mut data = binary.take().unwrap_or_default();
                    // The chunk is padded to a multiple of 4 bytes.
                    if data.len() as u64 > length && data.len() as u64 - length < 4 {
                        data.truncate(length as usize);
                    }
                    data
                }
                None => return Err(self.invalid(at, "has neither a uri nor a GLB binary chunk")),
            };
            if (data.len() as u64) < length {
                let what = format!("has {} bytes, byteLength says {length}", data.len());
                return Err(self.invalid(at, what));
            }
            if data.len() as u64 > length {
                notices.add(&at, "has more bytes than byteLength says");
            }
            self.buffers.push(data);
        }
        Ok(())
    }

    fn fetch_buffer(&self, uri: &str, at: &str, notices: &mut Notices) -> Result<Vec<u8>, SceneError> {
        let (data, media) = self.fetch_any(uri, &format!("{at}.uri"))?;
        if let Some(media) = media
            && !matches!(media.as_str(), "application/octet-stream" | "application/gltf-buffer")
        {
            notices.add(at, "the media type of its data: URI is not that of a buffer");
        }
        Ok(data)
    }

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

    /// The bytes behind a URI: base64 data, or a file in the folder of the scene or below it.
    pub fn fetch(&self, uri: &str, at: &str) -> Result<Vec<u8>, SceneError> {
        Ok(self.fetch_any(uri, at)?.0)
    }

    /// Bytes, and the media type of embedded ones.
    fn fetch_any(&self, uri: &str, at: &str) -> Result<(Vec<u8>, Option<String>), SceneError> {
        match (uri::parse(uri).map_err(|what| self.invalid(at, what))?, &self.folder) {
            (uri::Target::Data(bytes, media), _) => Ok((bytes, Some(media))),
            (uri::Target::Path(path), Some(folder)) => {
                let bytes = uri::read_below(folder, &path);
                Ok((bytes.map_err(|what| self.invalid(at, format!("{path}: {what}")))?, None))
            }
            (uri::Target::Path(path), None) => {
                Err(self.invalid(at, format!("{path}: a scene from memory cannot name files")))
            }
        }
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
