//! URIs of buffers and images: embedded data, or a path to a file beside or below the scene. Everything else is refused.

use std::path::{Path, PathBuf};

use pt_scene::SceneError;
use pt_scene::read_file;

/// The target of a URI.
pub(crate) enum Target {
    /// Embedded bytes and the media type that they claim.
    Data(Vec<u8>, String),
    /// A relative path with `/` between its parts.
    Path(String),
}

/// Parses a URI; the error says what is wrong with it.
pub(crate) fn parse(uri: &str) -> Result<Target, String> {
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
    let path = decode_percent(uri).ok_or_else(|| format!("{} is no valid URI", shorten(uri)))?;
    let refused =
        |why: &str| Err(format!("{} {why}; only files beside or below the scene are read", shorten(uri)));
    if has_scheme(uri) || has_scheme(&path) {
        return refused("names a scheme or a drive");
    }
    if path.contains('\\') {
        return refused("contains a backslash");
    }
    if path.starts_with('/') {
        return refused("is an absolute path");
    }
    if path.split('/').any(|part| part == "..") {
        return refused("leaves the folder of the scene");
    }
    if path.split('/').all(|part| matches!(part, "" | ".")) {
        return refused("names no file");
    }
    Ok(Target::Path(path))
}

/// Reads the file at a path that [`parse`] accepted, unless links lead it out of `folder`.
pub(crate) fn read_below(folder: &Path, path: &str) -> Result<Vec<u8>, String> {
    let words = |e: SceneError| match e {
        SceneError::File { what, .. } => what,
        other => other.to_string(),
    };
    let file = folder.join(path);
    let Ok(real) = file.canonicalize() else { return read_file(&file).map_err(words) };
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_owned() };
    let folder = folder.canonicalize().map_err(|e| e.to_string())?;
    if !real.starts_with(&folder) {
        return Err("is a link that leaves the folder of the scene".into());
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
        let good = ["a.bin", "a/b.bin", "./a.bin", "ü ber.bin", "a%20b.bin", "a..b/c", "./c:d.bin", "..."];
        for uri in good {
            assert!(matches!(parse(uri), Ok(Target::Path(_))), "{uri}");
        }
        let bad = [
            "../a",
            "a/../../b",
            "%2e%2e/a",
            "a/%2E%2E/b",
            "/etc/passwd",
            "%2Fetc/passwd",
            "//host/a",
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
            "a%00b",
        ];
        for uri in bad {
            assert!(parse(uri).is_err(), "{uri}");
        }
        assert!(matches!(parse("DATA:a/b;base64,TWE="), Ok(Target::Data(d, m)) if d == b"Ma" && m == "a/b"));
    }
}
