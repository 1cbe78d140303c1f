//! The GLB container (glTF 2.0, section 4).

use crate::notices::Notices;

/// JSON text of a file and, from a GLB, its binary chunk.
pub(crate) struct Container {
    pub json: Vec<u8>,
    pub binary: Option<Vec<u8>>,
}

const HEADER: usize = 12;
const JSON: u32 = 0x4E4F534A;
const BIN: u32 = 0x004E4942;

/// Splits a file into JSON and binary data: GLB (recognised by its magic bytes), or plain JSON.
pub(crate) fn split(file: Vec<u8>, notices: &mut Notices) -> Result<Container, String> {
    let mut container = chunks(file, notices)?;
    let text = container.json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    if text < container.json.len() {
        notices.add("JSON", "is padded with zero bytes instead of spaces");
        container.json.truncate(text);
    }
    Ok(container)
}

fn chunks(mut file: Vec<u8>, notices: &mut Notices) -> Result<Container, String> {
    if !file.starts_with(b"glTF") {
        if file.starts_with(b"\xef\xbb\xbf") {
            file.drain(..3);
        }
        return Ok(Container { json: file, binary: None });
    }
    let word = |at: usize| -> Option<u32> {
        file.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("the GLB header is cut short".into());
    };
    if version == 1 {
        return Err(version_message("1.0"));
    }
    if version != 2 {
        return Err(format!("GLB version {version}; only 2 can be read"));
    }
    let length = length as usize;
    if length < HEADER {
        return Err(format!("the GLB header gives {length} bytes as the length of the file"));
    }
    if length > file.len() {
        return Err(format!("the file is cut short: {} of {length} bytes", file.len()));
    }
    if length < file.len() {
        notices.add("GLB", format!("{} bytes after its end are ignored", file.len() - length));
    }
    let mut at = HEADER;
    let (mut json, mut binary) = (None, None);
    let mut chunk = 0;
    while at < length {
        let (Some(size), Some(kind), true) = (word(at), word(at + 4), at + 8 <= length) else {
            return Err(format!("GLB chunk {chunk}: its header is cut short"));
        };
        let (start, size) = (at + 8, size as usize);
        if size > length - start {
            return Err(format!("GLB chunk {chunk}: {size} bytes, but the file has {} more", length - start));
        }
        if !size.is_multiple_of(4) {
            notices.add(format!("GLB chunk {chunk}"), "its length is no multiple of 4");
        }
        match (chunk, kind) {
            (0, JSON) if size == 0 => return Err("GLB chunk 0: the JSON is empty".into()),
            (0, JSON) => json = Some(file[start..start + size].to_vec()),
            (0, _) => return Err("GLB chunk 0: is not the JSON".into()),
            (1, BIN) => binary = Some(start..start + size),
            (_, JSON) => return Err(format!("GLB chunk {chunk}: a second JSON")),
            (_, BIN) => return Err(format!("GLB chunk {chunk}: binary data must be the second chunk")),
            // Chunks of other kinds are to be skipped.
            _ => {}
        }
        at = start + size;
        chunk += 1;
    }
    let json = json.ok_or("the GLB has no JSON chunk")?;
    let binary = binary.map(|range| {
        // The largest part of the largest files: moved, not copied to new memory.
        file.truncate(range.end);
        file.drain(..range.start);
        file
    });
    Ok(Container { json, binary })
}

/// What to say about a file of another version.
pub(crate) fn version_message(version: &str) -> String {
    let way_out = if version.starts_with('1') { "; gltf-pipeline converts files of version 1.0" } else { "" };
    format!("is a glTF {version} file; only glTF 2.0 can be read{way_out}")
}
