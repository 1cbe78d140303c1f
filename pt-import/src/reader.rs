//! From the bytes of a file to a [`Document`] that has been checked and decompressed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;

#[cfg(feature = "codecs")]
use crate::compression;
use crate::document::Document;
use crate::extensions::{needs_codecs, support};
use crate::glb::version_message;
use crate::notices::Notices;
use crate::options::LoadOptions;
use crate::{check, glb};
use pt_scene::{SceneError, Support, one_line, read_file};

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
        let root = check::json(&container.json, notices).map_err(|(at, what)| {
            match (check::older_version(&container.json), at.as_str()) {
                (Some(version), _) => SceneError::file(file, version_message(&version)),
                (None, "") if std::str::from_utf8(&container.json).is_err() => {
                    SceneError::file(file, "is not a glTF 2.0 file, it is no text and has no header of a GLB")
                }
                (None, "") => {
                    let lacks = what.strip_prefix("missing field `").and_then(|rest| rest.split('`').next());
                    let why = lacks.map_or_else(
                        || format!("its text is no JSON of one ({})", one_line(&what)),
                        |name| format!("it has no {name:?}"),
                    );
                    SceneError::file(file, format!("is not a glTF 2.0 file: {why}"))
                }
                _ => SceneError::Invalid { file: file.to_owned(), at: one_line(&at), what: one_line(&what) },
            }
        })?;
        let mut document = Self {
            root,
            file: file.to_owned(),
            folder,
            buffers: Vec::new(),
            views: BTreeMap::new(),
            decoded: BTreeMap::new(),
            allow_outside: options.allow_outside,
            max_geometry_bytes: options.max_geometry_bytes,
            elements_read: AtomicU64::new(0),
        };
        document.check_header()?;
        document.read_buffers(container.binary, notices)?;
        check::structure(&document, notices)?;
        #[cfg(feature = "codecs")]
        {
            compression::decode_views(&mut document)?;
            compression::decode_primitives(&mut document)?;
        }
        check::accessors(&document, notices)?;
        Ok(document)
    }

    fn check_header(&self) -> Result<(), SceneError> {
        let asset = &self.root.asset;
        let required = asset.min_version.as_ref().unwrap_or(&asset.version);
        if !required.starts_with("2.") || (asset.min_version.is_some() && required != "2.0") {
            return Err(self.invalid("asset", version_message(required)));
        }
        let refused = |name: &&String| support(name) == Support::Refused;
        match self.root.extensions_required.iter().find(refused) {
            Some(name) if needs_codecs(name) => {
                let what =
                    format!("{name} needs a program built with the feature codecs of pt-import, such as pt");
                Err(self.invalid("extensionsRequired", what))
            }
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
                #[cfg(feature = "codecs")]
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
}
