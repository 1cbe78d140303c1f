//! Errors in settings.

use pt_image::atomic_file::FileError;
use std::path::PathBuf;

/// A field outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key}: {value} is out of range, expected {expected}")]
pub struct InvalidValue {
    /// Dotted name of the field.
    pub key: String,
    /// Its value.
    pub value: String,
    /// The range, with the unit.
    pub expected: String,
}

impl InvalidValue {
    /// The same error one table further out.
    #[must_use]
    pub fn within(self, table: &str) -> Self {
        Self { key: format!("{table}.{}", self.key), ..self }
    }
}

/// Checks that `value` lies in `range` (NaN never does); `unit` may be empty.
///
/// # Errors
/// [`InvalidValue`] that names `key` and the range.
pub fn check_range<N: PartialOrd + std::fmt::Display>(
    key: &str,
    value: N,
    range: std::ops::RangeInclusive<N>,
    unit: &str,
) -> Result<(), InvalidValue> {
    if range.contains(&value) {
        return Ok(());
    }
    let expected = format!("{} to {} {unit}", range.start(), range.end());
    Err(InvalidValue { key: key.into(), value: value.to_string(), expected: expected.trim_end().into() })
}

/// Why a setting was not taken. The parameters are unchanged then.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// Not of the form `key=value`.
    #[error("setting {text:?} is not of the form stage.key=value")]
    Syntax {
        /// The text.
        text: String,
    },
    /// No such key.
    #[error("unknown key {key:?}{hint} ({table} has: {keys})")]
    UnknownKey {
        /// The key asked for.
        key: String,
        /// The known key that is spelt like it, from [`close_to`](super::close_to).
        hint: String,
        /// The deepest table on the way that exists.
        table: String,
        /// The keys of that table.
        keys: String,
    },
    /// The key names a table, not a value.
    #[error("key {key:?} is a table, set one of its keys: {keys}")]
    Table {
        /// The key asked for.
        key: String,
        /// The keys of the table.
        keys: String,
    },
    /// The value has another type than the key, or one that the field cannot hold.
    #[error("key {key:?}: expected {expected}, got {value}")]
    Type {
        /// The key.
        key: String,
        /// The value as given.
        value: String,
        /// The values that the key accepts.
        expected: String,
    },
    /// The field refused the value (unknown variant, integer out of its type, ...).
    #[error("key {key:?}: {reason}")]
    Value {
        /// The key.
        key: String,
        /// Message of serde.
        reason: String,
    },
    /// Out of the range that the parameters allow.
    #[error(transparent)]
    Range(#[from] InvalidValue),
    /// The profile is not TOML.
    #[error("line {line}: {reason}")]
    Toml {
        /// Line of the file, from 1.
        line: usize,
        /// Message of the parser.
        reason: String,
    },
    /// The profile could not be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Any of these, in a profile.
    #[error("profile {}: {error}", path.display())]
    Profile {
        /// The profile.
        path: PathBuf,
        /// What is wrong in it.
        error: Box<SettingsError>,
    },
    /// The parameters themselves cannot be taken apart: an error of the program.
    #[error("parameters cannot be listed: {0}")]
    Parameters(#[from] serde_json::Error),
}
