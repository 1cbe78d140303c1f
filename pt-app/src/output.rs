//! The images that `pt render` writes.

use anyhow::{Result, bail};
use pt_image::image_file::{OutputFormat, check_output};
use std::path::{Path, PathBuf};

/// An image file: of the last frame, or of each when its name has a run of `#`, which stands for the frame's number
/// from 0, with zeros in front.
pub struct Output {
    path: PathBuf,
    format: OutputFormat,
}

impl Output {
    /// Checks that it will be possible to write it.
    ///
    /// # Errors
    /// An unknown extension, a folder that is missing or not writable, a directory, a number as `printf` has it.
    pub fn new(path: &Path) -> Result<Self> {
        check_no_printf(path)?;
        let format = check_output(&numbered(path, 0).unwrap_or_else(|| path.into()))?;
        Ok(Self { path: path.into(), format })
    }

    /// The kind of file.
    pub fn format(&self) -> OutputFormat {
        self.format
    }

    /// The file of frame `index`; `None` when that is not the last one, and only that is written.
    pub fn of_frame(&self, index: u32, is_last: bool) -> Option<PathBuf> {
        numbered(&self.path, index).or_else(|| is_last.then(|| self.path.clone()))
    }
}

/// Checks that the number of a frame is not written as `printf` has it.
///
/// # Errors
/// `%d` and the like.
pub fn check_no_printf(path: &Path) -> Result<()> {
    if let Some(width) = printf_width(path) {
        let hashes = "#".repeat(width);
        bail!("{}: a run of # stands for the number of the frame here, for example {hashes}", path.display());
    }
    Ok(())
}

/// Checks that a folder can be made at `path`, or is there.
///
/// # Errors
/// A file.
pub fn check_folder(path: &Path) -> Result<()> {
    if path.exists() && !path.is_dir() {
        bail!("{}: is a file; -o takes a folder here", path.display());
    }
    Ok(())
}

/// Whether `file`, which exists and has no links in its path, is the output `path`, or one of its frames.
pub fn stands_for(path: &Path, file: &Path) -> bool {
    if path.canonicalize().is_ok_and(|path| path == file) {
        return true;
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if folder.canonicalize().ok().as_deref() != file.parent() {
        return false;
    }
    number_of_frame(path, file).is_some()
}

/// The number for which the run of `#` in the name of `path` stands in the name of `file`; `None` if that is no frame of `path`. Folders
/// are not compared.
pub fn number_of_frame(path: &Path, file: &Path) -> Option<u32> {
    let name = path.file_name()?.to_str()?;
    let last = name.rfind('#')?;
    let (start, end) = (name[..=last].trim_end_matches('#'), &name[last + 1..]);
    let index = file.file_name()?.to_str()?.strip_prefix(start)?.strip_suffix(end)?.parse().ok()?;
    (numbered(path, index)?.file_name() == file.file_name()).then_some(index)
}

/// The digits of a frame number written as `%d` or `%04d`; `None` without one.
fn printf_width(path: &Path) -> Option<usize> {
    let name = path.file_name()?.to_str()?;
    let number = |part: &str| {
        let (digits, rest) = part.split_once('d')?;
        let is_number =
            digits.bytes().all(|b| b.is_ascii_digit()) && !rest.starts_with(char::is_alphanumeric);
        is_number.then(|| digits.to_owned())
    };
    let digits = name.split('%').skip(1).find_map(number)?;
    Some(if digits.is_empty() { 1 } else { digits.parse().unwrap_or(1).clamp(1, 9) })
}

/// `None` without a run of `#` in the file's name. The last run counts.
fn numbered(path: &Path, index: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let end = name.rfind('#')? + 1;
    let start = name[..end].trim_end_matches('#').len();
    let width = end - start;
    Some(path.with_file_name(format!("{}{index:0width$}{}", &name[..start], &name[end..])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_frames() {
        let name = |path: &str, index| numbered(path.as_ref(), index).map(|p| p.to_str().unwrap().to_owned());
        assert_eq!(name("a/f_###.exr", 7).unwrap(), "a/f_007.exr");
        assert_eq!(name("a/f_#.exr", 123).unwrap(), "a/f_123.exr");
        assert_eq!(name("a/#1_##b.exr", 2).unwrap(), "a/#1_02b.exr");
        assert_eq!(name("a##/f.exr", 2), None);
        for (path, width) in
            [("f_%04d.png", Some(4)), ("%d.png", Some(1)), ("50%done.png", None), ("a.png", None)]
        {
            assert_eq!(printf_width(path.as_ref()), width, "{path}");
        }
    }
}
