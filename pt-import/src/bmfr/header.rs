//! `camera_matrices.h`: initialisers of C arrays.

use super::BmfrError;
use std::path::Path;

/// How a frame was seen.
pub(super) struct View {
    /// Sixteen numbers in the order of the file.
    pub matrix: [f64; 16],
    /// Place of the sample in its pixel, 0 to 1.
    pub offset: [f32; 2],
}

/// The views of all frames.
pub(super) fn read_views(text: &str) -> Result<Vec<View>, String> {
    let matrices = numbers(text, "camera_matrices")?;
    if matrices.is_empty() || !matrices.len().is_multiple_of(16) {
        return Err(format!("camera_matrices has {} numbers, not 16 for each frame", matrices.len()));
    }
    let offsets = numbers(text, "pixel_offsets")?;
    if offsets.len() != matrices.len() / 8 {
        return Err(format!("pixel_offsets has {} numbers, not 2 for each frame", offsets.len()));
    }
    let views = matrices.chunks_exact(16).zip(offsets.chunks_exact(2));
    Ok(views
        .map(|(m, o)| View { matrix: std::array::from_fn(|k| m[k]), offset: [o[0] as f32, o[1] as f32] })
        .collect())
}

pub(super) fn read(path: &Path) -> Result<Vec<View>, BmfrError> {
    let bytes = pt_image::atomic_file::read(path)?;
    read_views(&String::from_utf8_lossy(&bytes)).map_err(|problem| BmfrError::content(path, problem))
}

/// The numbers of the initialiser of an array.
fn numbers(text: &str, name: &str) -> Result<Vec<f64>, String> {
    let missing = || format!("has no array {name} = {{...}};");
    let after = text.split_once(name).ok_or_else(missing)?.1;
    let initialiser = after.split_once('=').ok_or_else(missing)?.1;
    let initialiser = initialiser.split_once(';').ok_or_else(missing)?.0;
    let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '+' | '-');
    let words = without_comments(initialiser);
    let words = words.split(|c| !is_part(c)).filter(|word| !word.is_empty());
    words
        .map(|word| {
            let number = word.trim_end_matches(['f', 'F']).parse::<f64>().ok().filter(|v| v.is_finite());
            number.ok_or_else(|| format!("{name}: \"{word}\" is no number"))
        })
        .collect()
}

fn without_comments(text: &str) -> String {
    let mut rest = text;
    let mut out = String::new();
    while let Some(start) = ["//", "/*"].iter().filter_map(|mark| rest.find(mark)).min() {
        out.push_str(&rest[..start]);
        let comment = &rest[start..];
        let end = if comment.starts_with("//") {
            comment.find('\n')
        } else {
            comment.find("*/").map(|end| end + 2)
        };
        rest = end.map_or("", |end| &comment[end..]);
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_read_and_others_are_refused() {
        let matrix = "{{1.0f, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1.5e0f, 0}, /* the last; row */ {0, 0, 0, 1}}";
        let offsets = "const float pixel_offsets[1][2] = {{0.5f, 0.25f}};";
        let good = format!(
            "// of 1 frame\nconst float camera_matrices[1][4][4] = {{{}}};\n{offsets}",
            matrix.replace("; row", "")
        );
        let views = read_views(&good).unwrap();
        assert_eq!((views.len(), views[0].matrix[10], views[0].offset), (1, -1.5, [0.5, 0.25]));
        for (text, wanted) in [
            (good.replace("pixel_offsets", "offsets"), "no array pixel_offsets"),
            (good.replace("-1.5e0f", "-1.5e0f, 3"), "17 numbers"),
            (good.replace("-1.5e0f", "NAN"), "\"NAN\" is no number"),
            (good.replace("0.25f", "0.25f, 1"), "pixel_offsets has 3 numbers"),
            (String::new(), "no array camera_matrices"),
        ] {
            let problem = read_views(&text).err().unwrap();
            assert!(problem.contains(wanted), "{problem}");
        }
    }
}
