//! The glTF extensions that a file uses, and how the importer treated them.

/// How an importer treats an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Honoured.
    Supported,
    /// Left out, with a notice. It does not affect a picture, so a file may require it.
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
    /// How it was treated: [`Support::Supported`] or [`Support::Ignored`], because the scene was loaded.
    pub support: Support,
}
