//! Writing files so that the final name only ever holds a complete file.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Why a file could not be written or read. Every message names the path and the way out.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The folder that is to hold the file is not there.
    #[error("cannot write {}: folder {} does not exist, create it first", path.display(), folder.display())]
    MissingFolder {
        /// The file asked for.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The parent path of the file is not a folder.
    #[error("cannot write {}: {} is not a folder", path.display(), folder.display())]
    NotAFolder {
        /// The file asked for.
        path: PathBuf,
        /// Its parent path.
        folder: PathBuf,
    },
    /// The path names a directory.
    #[error("cannot write {}: it is a directory, give a file name", path.display())]
    IsDirectory {
        /// The file asked for.
        path: PathBuf,
    },
    /// The path names a device, a pipe or a socket, which cannot be replaced by renaming.
    #[error("cannot write {}: it exists and is not a regular file", path.display())]
    NotARegularFile {
        /// The file asked for.
        path: PathBuf,
    },
    /// The folder is there, but no file can be made in it (permissions, read-only, full).
    #[error("cannot write {}: folder {} is not writable ({cause})", path.display(), folder.display())]
    NotWritable {
        /// The file asked for.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// Writing began and failed; nothing is left behind.
    #[error("cannot write {}: {cause}", path.display())]
    Write {
        /// The file asked for.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// The file could not be read.
    #[error("cannot read {}: {cause}", path.display())]
    Read {
        /// The file asked for.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
}

/// Writes `bytes` under `path`: into a temporary file of the same folder, flushed to the disk, then renamed.
///
/// A reader of `path` sees the old content or the new one, never a part, even if the process is killed while it
/// writes (a kill can leave a `.NAME.*.tmp` file beside it). A symbolic link is followed, not replaced.
///
/// # Errors
/// [`FileError`], with the temporary file removed.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let (target, folder) = resolve(path)?;
    let mut temporary = create_beside(path, &target, &folder)?;
    let write = |cause| FileError::Write { path: path.into(), cause: without_path(cause) };
    temporary.write_all(bytes).and_then(|()| temporary.as_file().sync_all()).map_err(write)?;
    rename(temporary, &target).map_err(write)?;
    // The name itself becomes durable with its folder. Some file systems refuse to sync a folder; the
    // content is whole either way.
    let _ = File::open(&folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Checks that [`write_atomic`] would be able to write `path`, for use before a long computation.
/// Makes and removes a temporary file in the folder, since permission bits alone do not tell.
///
/// # Errors
/// [`FileError`] as [`write_atomic`] would report it.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let (target, folder) = resolve(path)?;
    create_beside(path, &target, &folder).map(drop)
}

/// Reads a whole file.
///
/// # Errors
/// [`FileError::Read`] with the path.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    fs::read(path).map_err(|cause| FileError::Read { path: path.into(), cause })
}

/// The file that is to be replaced (links followed) and its folder.
fn resolve(path: &Path) -> Result<(PathBuf, PathBuf), FileError> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = match target.parent() {
        Some(parent) if parent.as_os_str().is_empty() => PathBuf::from("."),
        Some(parent) => parent.to_path_buf(),
        None => return Err(FileError::IsDirectory { path: path.into() }),
    };
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => return Err(FileError::IsDirectory { path: path.into() }),
        Ok(found) if !found.is_file() => return Err(FileError::NotARegularFile { path: path.into() }),
        _ if target.file_name().is_none() => return Err(FileError::IsDirectory { path: path.into() }),
        _ => {}
    }
    match fs::metadata(&folder) {
        Ok(found) if found.is_dir() => Ok((target, folder)),
        Ok(_) => Err(FileError::NotAFolder { path: path.into(), folder }),
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => {
            Err(FileError::MissingFolder { path: path.into(), folder })
        }
        Err(cause) => Err(FileError::NotWritable { path: path.into(), folder, cause }),
    }
}

fn create_beside(path: &Path, target: &Path, folder: &Path) -> Result<NamedTempFile, FileError> {
    let name = target.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    // A long final name must not make the temporary one too long for the file system.
    let prefix = format!(".{}.", name.chars().take(32).collect::<String>());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // tempfile's own 0600 would survive the rename; the umask still applies.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|cause| FileError::NotWritable {
        path: path.into(),
        folder: folder.into(),
        cause: without_path(cause),
    })
}

/// What went wrong, without the name of the temporary file, which would only distract.
fn without_path(cause: io::Error) -> io::Error {
    let text = cause.to_string();
    io::Error::new(cause.kind(), text.split(" at path ").next().unwrap_or_default())
}

/// Gives the temporary file its final name; on failure it is removed.
fn rename(temporary: NamedTempFile, target: &Path) -> io::Result<()> {
    temporary.persist(target).map(drop).map_err(|failed| failed.error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn failed_rename_leaves_no_temporary() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("taken");
        fs::create_dir(&target).unwrap();
        let temporary = create_beside(&target, &target, folder.path()).unwrap();
        assert_eq!(names_in(folder.path()).len(), 2, "the temporary file lies in the same folder");
        rename(temporary, &target).unwrap_err();
        assert_eq!(names_in(folder.path()), ["taken"]);
    }

    #[test]
    fn check_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(&folder.path().join("image.png")).unwrap();
        assert!(names_in(folder.path()).is_empty());
    }
}
