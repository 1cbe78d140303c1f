//! The files of two sequences, paired by the numbers of their frames.

use crate::output::number_of_frame;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Extensions of the files of a folder that are frames.
const EXTENSIONS: [&str; 5] = ["png", "jpg", "jpeg", "hdr", "exr"];

/// The same frame of two sequences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Number of the frame.
    pub frame: u32,
    /// File of the image.
    pub a: PathBuf,
    /// File of its reference.
    pub b: PathBuf,
}

/// Whether a name is of a sequence: a folder, or a run of `#` in the name of the file.
pub fn is_sequence(path: &Path) -> bool {
    path.is_dir() || has_pattern(path)
}

fn has_pattern(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains('#'))
}

/// The frames of both sequences in the order of their numbers, at least one.
///
/// # Errors
/// A folder that cannot be read or has no frames, a file without a number, two of one number, a frame that only one sequence has.
pub fn pairs(a: &Path, b: &Path) -> Result<Vec<Pair>> {
    let (mut of_a, mut of_b) = (frames(a)?, frames(b)?);
    for (there, here, missing) in [(&of_a, &of_b, b), (&of_b, &of_a, a)] {
        let lacking: Vec<_> = there.iter().filter(|(frame, _)| !here.contains_key(frame)).collect();
        if let Some((frame, file)) = lacking.first() {
            let others = match lacking.len() - 1 {
                0 => String::new(),
                n => format!(", and {n} more"),
            };
            bail!(
                "{} lacks frame {frame}, which is {} in the other sequence{others}",
                missing.display(),
                file.display()
            );
        }
    }
    let frames: Vec<u32> = of_a.keys().copied().collect();
    let pair = |frame| Some(Pair { frame, a: of_a.remove(&frame)?, b: of_b.remove(&frame)? });
    Ok(frames.into_iter().filter_map(pair).collect())
}

/// The files of a sequence by their numbers.
fn frames(path: &Path) -> Result<BTreeMap<u32, PathBuf>> {
    let (folder, number): (_, fn(&Path, &Path) -> Option<u32>) = match has_pattern(path) {
        true => (path.parent().unwrap_or(Path::new("")), number_of_frame),
        false => (path, |_, file| number_in_name(file)),
    };
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(listed).with_context(|| format!("cannot read {}", listed.display()))?;
    let mut names = entries
        .map(|entry| Ok(folder.join(entry?.file_name())))
        .collect::<std::io::Result<Vec<_>>>()
        .with_context(|| format!("cannot read {}", listed.display()))?;
    names.sort();
    let mut found: BTreeMap<u32, PathBuf> = BTreeMap::new();
    for file in names.into_iter().filter(|file| is_image(file)) {
        let Some(frame) = number(path, &file) else {
            if has_pattern(path) {
                continue;
            }
            bail!(
                "{}: the name has no number of a frame; give a run of # for the number instead of the folder, as {}",
                file.display(),
                path.join("frame_####.png").display()
            );
        };
        if let Some(other) = found.insert(frame, file.clone()) {
            bail!(
                "{} and {} are both of frame {frame}; give a run of # for the number instead of the folder, as {}",
                other.display(),
                file.display(),
                pattern_of(&file).display()
            );
        }
    }
    if found.is_empty() {
        bail!("{}: has no frames ({})", path.display(), EXTENSIONS.join(", "));
    }
    Ok(found)
}

/// Hidden files are none: a file that is being written has such a name.
fn is_image(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    !name.starts_with('.') && EXTENSIONS.contains(&extension.as_str())
}

/// Where the last run of digits is in a name without its extension.
fn digits(stem: &str) -> Option<(&str, &str, &str)> {
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].trim_end_matches(|c: char| c.is_ascii_digit()).len();
    Some((&stem[..start], &stem[start..end], &stem[end..]))
}

fn number_in_name(file: &Path) -> Option<u32> {
    digits(file.file_stem()?.to_str()?)?.1.parse().ok()
}

/// The name with a run of `#` for the number.
fn pattern_of(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let extension = file.extension().unwrap_or_default().to_string_lossy();
    match digits(&stem) {
        Some((before, number, after)) => {
            file.with_file_name(format!("{before}{}{after}.{extension}", "#".repeat(number.len())))
        }
        None => file.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digits_are_the_number() {
        let number = |name: &str| number_in_name(name.as_ref());
        assert_eq!(number("on/v2_frame_0012.exr"), Some(12));
        assert_eq!(number("on/7b.png"), Some(7));
        assert_eq!(number("on/final.png"), None);
        assert_eq!(number("on/99999999999.png"), None);
        assert_eq!(pattern_of("cap/reference_000012.exr".as_ref()), Path::new("cap/reference_######.exr"));
        assert!(is_sequence("a/f_##.png".as_ref()) && !is_sequence("a#/f.png".as_ref()));
    }
}
