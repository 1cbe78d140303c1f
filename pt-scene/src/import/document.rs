use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

use gltf::binary::Glb;
use gltf::json::{Index, Root, buffer, root::Get};

use super::SUPPORTED_EXTENSIONS;
use crate::SceneError;
use crate::error::{one_line, read_file};

/// A parsed file with the bytes of its buffers.
pub(super) struct Document {
    pub root: Root,
    file: PathBuf,
    buffers: Vec<Vec<u8>>,
}

impl Document {
    pub fn read(file: &Path) -> Result<Self, SceneError> {
        let bytes = read_file(file)?;
        let (json, binary) = split_container(&bytes).map_err(|what| SceneError::file(file, what))?;
        let root: Root = serde_json::from_slice(&json).map_err(|e| {
            SceneError::file(file, format!("is not a glTF 2.0 file: {}", one_line(&e.to_string())))
        })?;
        let mut document = Self { root, file: file.to_owned(), buffers: Vec::new() };
        document.check_header()?;
        let mut binary = binary.map(Cow::into_owned);
        for (i, description) in document.root.buffers.iter().enumerate() {
            let at = format!("buffers[{i}]");
            let data = match &description.uri {
                Some(uri) => document.fetch(uri, &at)?,
                None if i == 0 && binary.is_some() => binary.take().unwrap_or_default(),
                None => return Err(document.invalid(at, "has neither a uri nor a GLB binary chunk")),
            };
            if (data.len() as u64) < description.byte_length.0 {
                let what = format!("has {} bytes, byteLength says {}", data.len(), description.byte_length.0);
                return Err(document.invalid(at, what));
            }
            document.buffers.push(data);
        }
        Ok(document)
    }

    fn check_header(&self) -> Result<(), SceneError> {
        let asset = &self.root.asset;
        let required = asset.min_version.as_ref().unwrap_or(&asset.version);
        if !required.starts_with("2.") || (asset.min_version.is_some() && required != "2.0") {
            return Err(self.invalid("asset", format!("glTF version {required}; only 2.0 can be read")));
        }
        match self.root.extensions_required.iter().find(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str()))
        {
            Some(name) => Err(SceneError::Extension { file: self.file.clone(), extension: one_line(name) }),
            None => Ok(()),
        }
    }

    /// An error at a JSON path of this file.
    pub fn invalid(&self, at: impl ToString, what: impl ToString) -> SceneError {
        SceneError::Invalid { file: self.file.clone(), at: at.to_string(), what: one_line(&what.to_string()) }
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

    /// The bytes of a buffer view.
    pub fn view(&self, index: Index<buffer::View>, at: &str) -> Result<(&[u8], &buffer::View), SceneError> {
        let view = self.get(index, at)?;
        let at = format!("bufferViews[{}]", index.value());
        let data = self.buffers.get(view.buffer.value());
        let data =
            data.ok_or_else(|| self.invalid(&at, format!("buffer {} does not exist", view.buffer.value())))?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let bytes =
            start.checked_add(view.byte_length.0).and_then(|end| data.get(start as usize..end as usize));
        let bytes = bytes.ok_or_else(|| {
            let what = format!("{} bytes at {start} do not fit in {} bytes", view.byte_length.0, data.len());
            self.invalid(&at, what)
        })?;
        Ok((bytes, view))
    }

    /// The bytes behind a URI: base64 data, or a file in the folder of the scene or below it.
    pub fn fetch(&self, uri: &str, at: &str) -> Result<Vec<u8>, SceneError> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (_, text) = data
                .split_once(";base64,")
                .ok_or_else(|| self.invalid(at, "a data: URI must be base64-encoded"))?;
            return decode_base64(text).ok_or_else(|| self.invalid(at, "the data: URI is not valid base64"));
        }
        let relative =
            decode_percent(uri).ok_or_else(|| self.invalid(at, format!("{uri:?} is no valid URI")))?;
        let path = Path::new(&relative);
        let confined = path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if relative.contains("://") || relative.is_empty() || !confined {
            return Err(self.invalid(at, format!("{uri:?} is not a file beside or below the scene")));
        }
        let folder = self.file.parent().unwrap_or(Path::new(""));
        read_file(&folder.join(path)).map_err(|error| match error {
            SceneError::File { what, .. } => self.invalid(at, format!("{relative}: {what}")),
            other => other,
        })
    }
}

/// JSON and binary chunk.
type Chunks<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// The chunks of a GLB, or the file itself as JSON.
fn split_container(bytes: &[u8]) -> Result<Chunks<'_>, String> {
    if !bytes.starts_with(b"glTF") {
        return Ok((Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)), None));
    }
    // The crate subtracts the header's size from this length unchecked.
    let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if length.is_none_or(|length| length < 12) {
        return Err("the GLB header is cut short".into());
    }
    let glb = Glb::from_slice(bytes).map_err(|e| format!("broken GLB container: {e}"))?;
    Ok((glb.json, glb.bin))
}

/// Standard alphabet; padding and white space are optional.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for c in text.trim_end().trim_end_matches('=').bytes().filter(|c| !c.is_ascii_whitespace()) {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Some(out)
}

fn decode_percent(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(byte) = bytes.next() {
        out.push(match byte {
            b'%' => {
                let digit = |c: Option<u8>| char::from(c?).to_digit(16);
                (digit(bytes.next())? * 16 + digit(bytes.next())?) as u8
            }
            other => other,
        });
    }
    String::from_utf8(out).ok().filter(|path| !path.contains('\0'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_padding() {
        assert_eq!(decode_base64("TWFu").unwrap(), b"Man");
        assert_eq!(decode_base64("TWE=").unwrap(), b"Ma");
        assert_eq!(decode_base64("TQ==").unwrap(), b"M");
        assert_eq!(decode_base64("").unwrap(), b"");
        assert!(decode_base64("T*").is_none());
    }

    #[test]
    fn percent_encoding() {
        assert_eq!(decode_percent("Box%20With%20Spaces.bin").unwrap(), "Box With Spaces.bin");
        assert_eq!(decode_percent("a b").unwrap(), "a b");
        assert!(decode_percent("%2").is_none());
        assert!(decode_percent("%ff").is_none());
    }
}
