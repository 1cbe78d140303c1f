//! Knobs by dotted name: `stage.key=value` on the command line, tables in a TOML profile.
//!
//! [`knobs!`](crate::knobs!) declares them. A value is a boolean, an integer, a finite float, a name of an enum, or an `Option` of these, where
//! `none` stands for absent. A float that may be "off" is an `Option`, not infinity.

mod error;
mod knobs;
mod tree;

pub use error::{InvalidValue, SettingsError, check_range};
pub use knobs::{Knob, Knobs};
pub use tree::{close_to, closest_key};

use pt_shaders::KnobKind;
use serde_json::Value;
use std::path::Path;
use tree::{NONE, convert, find, literal, lookup, parse, type_error, unknown};

/// Applies assignments `stage.key=value` in order; ranges are checked once at the end, so that several keys may
/// move a range together.
///
/// # Errors
/// [`SettingsError`]; `settings` is unchanged then.
pub fn apply_sets<T, S>(settings: &mut T, assignments: &[S]) -> Result<(), SettingsError>
where
    T: Knobs,
    S: AsRef<str>,
{
    let mut tree = serde_json::to_value(&*settings)?;
    for assignment in assignments {
        let text = assignment.as_ref();
        let (key, value) = text
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
            .filter(|(key, _)| !key.is_empty())
            .ok_or_else(|| SettingsError::Syntax { text: text.into() })?;
        let parsed = parse(key, find(&mut tree, key)?, value);
        replace::<T>(&mut tree, key, parsed, value == NONE)?;
    }
    finish(settings, tree)
}

/// Applies the TOML `text` to `settings`; settings that it does not name keep their values.
///
/// # Errors
/// [`SettingsError`]; `settings` is unchanged then.
pub fn apply_toml<T: Knobs>(settings: &mut T, text: &str) -> Result<(), SettingsError> {
    let table: toml::Table = toml::from_str(text).map_err(|error: toml::de::Error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count() + 1;
        SettingsError::Toml { line, reason: error.message().replace('\n', ", ") }
    })?;
    let mut tree = serde_json::to_value(&*settings)?;
    merge::<T>(&mut tree, "", &table)?;
    finish(settings, tree)
}

/// Lays a TOML profile file over `settings`.
///
/// # Errors
/// [`SettingsError::Profile`] that names the file, or [`SettingsError::File`]; `settings` is unchanged then.
pub fn apply_profile<T: Knobs>(settings: &mut T, path: &Path) -> Result<(), SettingsError> {
    let bytes = pt_image::atomic_file::read(path)?;
    String::from_utf8(bytes)
        .map_err(|_| SettingsError::Toml { line: 1, reason: "the file is not UTF-8 text".into() })
        .and_then(|text| apply_toml(settings, &text))
        .map_err(|error| SettingsError::Profile { path: path.into(), error: Box::new(error) })
}

fn merge<T: Knobs>(tree: &mut Value, prefix: &str, table: &toml::Table) -> Result<(), SettingsError> {
    for (name, value) in table {
        let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        if let toml::Value::Table(inner) = value
            && (inner.is_empty() || matches!(lookup(tree, &key), Some(Value::Object(_)) | None))
        {
            // An unknown table is an error of its own, even when empty.
            if lookup(tree, &key).is_none() {
                return Err(unknown(tree, &key));
            }
            merge::<T>(tree, &key, inner)?;
            continue;
        }
        let converted = convert(&key, find(tree, &key)?, value);
        replace::<T>(tree, &key, converted, value.as_str() == Some(NONE))?;
    }
    Ok(())
}

fn finish<T: Knobs>(settings: &mut T, tree: Value) -> Result<(), SettingsError> {
    let changed: T = serde_json::from_value(tree)?;
    changed.validate()?;
    *settings = changed;
    Ok(())
}

/// Puts `value` at the leaf `key` and lets serde check it: all other leaves came from valid parameters. What spells
/// [`NONE`] and cannot be a value of the leaf is tried as the absent value of an `Option`.
fn replace<T: Knobs>(
    tree: &mut Value,
    key: &str,
    value: Result<Value, SettingsError>,
    spells_none: bool,
) -> Result<(), SettingsError> {
    let given = value.as_ref().ok().and_then(Value::as_str).map(str::to_owned);
    let outcome = value.and_then(|value| {
        let expects = find(tree, key)?.clone();
        *find(tree, key)? = value;
        check_leaf::<T>(tree, key, &expects)
    });
    if outcome.is_err() && spells_none {
        *find(tree, key)? = Value::Null;
        if serde_json::from_value::<T>(tree.clone()).is_ok() {
            return Ok(());
        }
    }
    outcome.map_err(|error| explained(error, &T::knobs(), given.as_deref()))
}

/// Says what the knob takes, where its value is wrong. `given`: the value, if it is text.
fn explained(error: SettingsError, knobs: &[Knob], given: Option<&str>) -> SettingsError {
    let takes = |key: &str| knobs.iter().find(|knob| knob.key == key).map(|knob| (knob.kind, knob.takes()));
    match error {
        SettingsError::Type { key, value, expected } => {
            let expected = match takes(&key) {
                Some((KnobKind::Enum, names)) => format!("one of {names}"),
                Some((KnobKind::Integer | KnobKind::Number, range)) => format!("{expected}, {range}"),
                _ => expected,
            };
            SettingsError::Type { key, value, expected }
        }
        // The names that an enum has are in serde's message too; of an optional knob it says only Rust's type.
        SettingsError::Value { key, reason } => match takes(&key) {
            Some((KnobKind::Integer, takes)) => {
                SettingsError::Value { key, reason: format!("expected a whole number below 2^32, {takes}") }
            }
            Some((KnobKind::Enum, names)) => {
                let hint = given.map(|given| close_to(given, names.split(", "))).unwrap_or_default();
                SettingsError::Value { key, reason: format!("{reason}{hint}") }
            }
            Some((_, takes)) => SettingsError::Value { key, reason: format!("expected {takes}") },
            _ => SettingsError::Value { key, reason },
        },
        other => other,
    }
}

fn check_leaf<T: Knobs>(tree: &Value, key: &str, expects: &Value) -> Result<(), SettingsError> {
    let parameters: T = serde_json::from_value(tree.clone())
        .map_err(|error| SettingsError::Value { key: key.into(), reason: error.to_string() })?;
    // A number beyond the range of an f32 field arrives there as infinity, which JSON shows as null.
    let kept = serde_json::to_value(&parameters)?;
    match (lookup(tree, key), lookup(&kept, key)) {
        (Some(given), Some(Value::Null)) if !given.is_null() => Err(type_error(key, expects, literal(given))),
        _ => Ok(()),
    }
}
