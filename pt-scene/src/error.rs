use std::path::{Path, PathBuf};

/// Why a scene, texture or environment could not be loaded. Every message is one line: the file, the place in it, what
/// is wrong.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read at all.
    #[error("{}: {what}", file.display())]
    File {
        /// The file or folder in question.
        file: PathBuf,
        /// What went wrong, in words.
        what: String,
    },
    /// The file was read, but a part of it breaks the format.
    #[error("{}: {at}: {what}", file.display())]
    Invalid {
        /// The scene file.
        file: PathBuf,
        /// JSON path of the offending part, for example `meshes[2].primitives[0].attributes.POSITION`.
        at: String,
        /// What is wrong with it.
        what: String,
    },
    /// The file requires a glTF extension that this importer does not have.
    #[error("{}: extensionsRequired: {extension} is not supported; re-export the scene without it", file.display())]
    Extension {
        /// The scene file.
        file: PathBuf,
        /// Name of the extension.
        extension: String,
    },
    /// A filled scene breaks an invariant of [`crate::Scene`]; see [`crate::Scene::validate`].
    #[error("scene {scene}: {what}")]
    Inconsistent {
        /// Name of the scene.
        scene: String,
        /// The invariant that does not hold, with the place.
        what: String,
    },
}

impl SceneError {
    /// An error about a whole file or folder.
    pub fn file(file: &Path, what: impl ToString) -> Self {
        Self::File { file: file.to_owned(), what: one_line(&what.to_string()) }
    }
}

/// Reads a whole file; a folder, a missing file and an empty file each get their own words.
pub fn read_file(file: &Path) -> Result<Vec<u8>, SceneError> {
    use std::io::ErrorKind::{IsADirectory, NotFound};
    if file.is_dir() {
        return Err(SceneError::file(file, "is a folder, not a file"));
    }
    let bytes = std::fs::read(file).map_err(|e| match e.kind() {
        NotFound => SceneError::file(file, "no such file"),
        IsADirectory => SceneError::file(file, "is a folder, not a file"),
        _ => SceneError::file(file, e),
    })?;
    if bytes.is_empty() { Err(SceneError::file(file, "the file is empty")) } else { Ok(bytes) }
}

/// Messages of other libraries may span lines; ours never do.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
