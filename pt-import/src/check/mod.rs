//! Checks of everything in a file, used by the scene or not: references that lead nowhere and data that do not fit are errors;
//! what the format forbids but what reads the same in every case is a notice.

mod data;
mod json;
mod meshes;
mod nodes;

use crate::document::Document;
use crate::notices::Notices;
pub(crate) use json::{older_version, read as json};
use pt_scene::SceneError;

/// Checks references, and everything else that does not need the compressed data.
pub(crate) fn structure(document: &Document, notices: &mut Notices) -> Result<(), SceneError> {
    data::views(document, notices)?;
    data::references(document)?;
    nodes::check(document, notices)?;
    meshes::check(document, notices)
}

/// Accessors, once all data are there.
pub(crate) fn accessors(document: &Document, notices: &mut Notices) -> Result<(), SceneError> {
    data::accessors(document, notices)
}
