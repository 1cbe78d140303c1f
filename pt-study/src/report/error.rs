//! Why a report could not be written.

use crate::error::StudyError;
use pt_image::atomic_file::FileError;
use std::path::PathBuf;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The folder does not hold the results of a study.
    #[error(transparent)]
    Folder(#[from] StudyError),
    /// The report could not be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The folder has no result.
    #[error("{} holds no cell yet: run the study, then write its report", path.display())]
    Empty {
        /// The file without lines.
        path: PathBuf,
    },
    /// A cell names a variant that the study does not have.
    #[error("{}: cell {cell} belongs to variant {variant}, which study.json does not list", path.display())]
    Variant {
        /// The file of cells.
        path: PathBuf,
        /// Name of the cell.
        cell: String,
        /// Name of the variant.
        variant: String,
    },
    /// A figure could not be drawn. This is a fault of the program.
    #[error("the figure {title} could not be drawn: {cause}")]
    Figure {
        /// Its title.
        title: String,
        /// What the plotting library said.
        cause: String,
    },
    /// The template could not be filled in. This is a fault of the program.
    #[error("the template of the report could not be filled in: {0}")]
    Template(String),
    /// The page is too large without any picture.
    #[error("the report would have {bytes} bytes without any picture, more than {limit}; split the study")]
    Size {
        /// Its size.
        bytes: usize,
        /// The most it may have.
        limit: usize,
    },
}
