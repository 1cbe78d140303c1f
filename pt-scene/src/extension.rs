//! The glTF extensions that a file uses, and how the importer treated them.

/// What an importer does with an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Honoured.
    Supported,
    /// Left out, with a notice; a picture shows nothing of it, so that it is no obstacle where it is required.
    Ignored,
    /// It changes the picture: left out with a notice where a file merely uses it, refused by name where it is required.
    Refused,
}

/// An extension that a file uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExtensionUse {
    /// As in `extensionsUsed`.
    pub name: String,
    /// Named in `extensionsRequired`.
    pub required: bool,
    /// What became of it: [`Support::Supported`] or [`Support::Ignored`], as the scene was loaded.
    pub support: Support,
}
