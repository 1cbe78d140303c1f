//! URIs of buffers and images: embedded data, or a path to a file. Unless others are allowed, it lies beside or below the scene.

use std::path::{Path, PathBuf};

use pt_scene::SceneError;
use pt_scene::read_file;

/// The target of a URI.
pub(crate) enum Target {
    /// Embedded bytes and the media type that they claim.
    Data(Vec<u8>, String),
    /// A file.
    File(FilePath),
}

/// A path with `/` between its parts, relative to the folder of the scene.
pub(crate) struct FilePath {
    /// The path that the URI stands for.
    pub decoded: String,
    /// The URI as it is, where that is another path: some programs write the name of a file without encoding its `%`.
    raw: Option<String>,
}

/// Parses a URI; the error says what is wrong with it. With `outside` the path may leave the folder of the scene.
pub(crate) fn parse(uri: &str, outside: bool) -> Result<Target, String> {
    if let Some(data) = uri.get(..5).filter(|s| s.eq_ignore_ascii_case("data:")).and(uri.get(5..)) {
        let (media, text) =
            data.split_once(";base64,").ok_or("a data: URI must be base64-encoded".to_string())?;
        let bytes = decode_base64(text).ok_or("the data: URI is not valid base64")?;
        // RFC 2397: the media type, then parameters with a value each.
        if media.split(';').skip(1).any(|parameter| !parameter.contains('=')) {
            return Err("the media type of the data: URI is malformed".into());
        }
        let media = media.split(';').next().unwrap_or_default().to_ascii_lowercase();
        return Ok(Target::Data(bytes, media));
    }
    let Some(decoded) = decode_percent(uri) else {
        check_path(uri, outside).map_err(|why| format!("{} {why}", shorten(uri)))?;
        return Ok(Target::File(FilePath { decoded: uri.into(), raw: None }));
    };
    check_path(&decoded, outside).map_err(|why| format!("{} {why}", shorten(uri)))?;
    let raw = (uri != decoded && check_path(uri, outside).is_ok()).then(|| uri.to_owned());
    Ok(Target::File(FilePath { decoded, raw }))
}

/// Why a path is not read; it follows the path in messages.
fn check_path(path: &str, outside: bool) -> Result<(), String> {
    const ONLY_FILES: &str = "only files are read, by relative paths";
    if path.contains('\0') {
        return Err("is no valid URI".into());
    }
    if has_scheme(path) {
        return Err(format!("names a scheme or a drive; {ONLY_FILES}"));
    }
    if path.contains('\\') {
        return Err(format!("contains a backslash; {ONLY_FILES}"));
    }
    if path.split('/').all(|part| matches!(part, "" | ".")) {
        return Err(format!("names no file; {ONLY_FILES}"));
    }
    if !outside && path.starts_with('/') {
        return Err(format!("is an absolute path; {OPTION}"));
    }
    if !outside && leaves(path) {
        return Err(format!("leaves the folder of the scene; {OPTION}"));
    }
    Ok(())
}

/// What lets a scene name files elsewhere.
const OPTION: &str = "--allow-outside reads files that are not beside or below the scene";

/// Whether the parts `..` of a relative path lead above its start.
fn leaves(path: &str) -> bool {
    let mut depth = 0;
    path.split('/').any(|part| {
        match part {
            "" | "." => {}
            ".." => depth -= 1,
            _ => depth += 1,
        }
        depth < 0
    })
}

impl FilePath {
    /// Reads the file, and returns the path under which it was looked for. Links lead out of `folder` only with `outside`.
    pub fn read(&self, folder: &Path, outside: bool) -> (&str, Result<Vec<u8>, String>) {
        let raw = self.raw.as_ref().filter(|_| !folder.join(&self.decoded).exists());
        let path = raw.filter(|raw| folder.join(raw).exists()).unwrap_or(&self.decoded);
        (path, read(folder, path, outside))
    }
}

fn read(folder: &Path, path: &str, outside: bool) -> Result<Vec<u8>, String> {
    let words = |e: SceneError| match e {
        SceneError::File { what, .. } => what,
        other => other.to_string(),
    };
    let file = folder.join(path);
    let Ok(real) = file.canonicalize() else { return read_file(&file).map_err(words) };
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_owned() };
    let folder = folder.canonicalize().map_err(|e| e.to_string())?;
    if !outside && !real.starts_with(&folder) {
        return Err(format!("is a link that leaves the folder of the scene; {OPTION}"));
    }
    if !real.is_dir() && !real.is_file() {
        return Err("is no regular file".into());
    }
    read_file(&real).map_err(words)
}

/// RFC 3986: a letter, then letters, digits, `+`, `-`, `.`, up to the colon. A drive letter has the same form.
fn has_scheme(uri: &str) -> bool {
    let Some((scheme, _)) = uri.split_once(':') else { return false };
    scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'))
}

/// A URI as it is shown in a message.
fn shorten(uri: &str) -> String {
    let start: String = uri.chars().take(80).collect();
    if start.len() < uri.len() { format!("{start:?}...") } else { format!("{start:?}") }
}

/// Standard and URL-safe alphabet; padding and white space are optional.
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
    // A lone last character carries no whole byte.
    (count < 6).then_some(out)
}

/// `None` where a `%` stands for no byte, or the bytes are no text.
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
    String::from_utf8(out).ok()
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
        assert!(decode_base64("TWFuT").is_none());
    }

    #[test]
    fn percent_encoding() {
        assert_eq!(decode_percent("Box%20With%20Spaces.bin").unwrap(), "Box With Spaces.bin");
        assert_eq!(decode_percent("a b").unwrap(), "a b");
        assert_eq!(decode_percent("%C3%BCber.bin").unwrap(), "über.bin");
        assert!(decode_percent("%2").is_none());
        assert!(decode_percent("%ff").is_none());
    }

    #[test]
    fn only_paths_below_the_scene() {
        let good = [
            "a.bin",
            "a/b.bin",
            "./a.bin",
            "ü ber.bin",
            "a%20b.bin",
            "a..b/c",
            "./c:d.bin",
            "...",
            "a/../b.bin",
            "a/%2E%2E/b",
            "10%.bin",
            "%ff",
        ];
        for uri in good {
            assert!(matches!(parse(uri, false), Ok(Target::File(_))), "{uri}");
        }
        let outside =
            ["../a", "a/../../b", "%2e%2e/a", "a/.././../b", "/etc/passwd", "%2Fetc/passwd", "//host/a"];
        for uri in outside {
            assert!(parse(uri, false).is_err_and(|text| text.contains("--allow-outside")), "{uri}");
            assert!(matches!(parse(uri, true), Ok(Target::File(_))), "{uri}");
        }
        let bad = [
            "C:/a",
            "C%3A/a",
            "c:a",
            "\\\\host\\a",
            "a\\..\\b",
            "%5C%5Chost",
            "..%5Ca",
            "http://a/b",
            "file:///a",
            "FILE:a",
            "",
            ".",
            "./",
            "/",
            "a%00b",
        ];
        for uri in bad {
            for outside in [false, true] {
                assert!(parse(uri, outside).is_err_and(|text| !text.contains("--allow-outside")), "{uri}");
            }
        }
        let data = parse("DATA:a/b;base64,TWE=", false);
        assert!(matches!(data, Ok(Target::Data(d, m)) if d == b"Ma" && m == "a/b"));
    }
}
