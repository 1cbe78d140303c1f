//! Errors of studies.

use pt_image::atomic_file::FileError;
use std::path::PathBuf;

/// Why a study cannot be read, run or merged. Each message is one line.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Something in a study file is wrong.
    #[error("{}:{line}:{column}: {reason}", path.display())]
    At {
        /// The study file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What is wrong, and what is expected.
        reason: String,
    },
    /// A file of a result folder is wrong.
    #[error("{}: {reason}", path.display())]
    Folder {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// A wrong filter or shard.
    #[error("{0}")]
    Selection(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl StudyError {
    /// Of a file or folder.
    pub fn folder(path: impl Into<PathBuf>, reason: impl Into<String>) -> Self {
        Self::Folder { path: path.into(), reason: reason.into() }
    }
}
