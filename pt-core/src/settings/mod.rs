//! Parameters by dotted name: `stage.key=value` on the command line, tables in a TOML profile.
//!
//! Works on any tree of serde structs. Leaves are booleans, integers, finite floats, strings (also enum variants
//! without data), arrays of these, and `Option` of these, where `none` stands for absent. A float that may be "off" is
//! an `Option`, not infinity.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Number, Value};

use pt_image::atomic_file::FileError;

/// Spelling of the absent value of an `Option`.
const NONE: &str = "none";

/// Parameters that know their ranges. A struct of structs calls `validate` of its fields and puts their names in
/// front with [`InvalidValue::within`].
pub trait Validate {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of its range.
    fn validate(&self) -> Result<(), InvalidValue>;
}

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
    #[error("unknown key {key:?}, closest: {closest:?} ({table} has: {keys})")]
    UnknownKey {
        /// The key asked for.
        key: String,
        /// The known key that is spelt most like it.
        closest: String,
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
        /// What the key takes.
        expected: String,
    },
    /// The field refused the value (unknown variant, integer out of its type, ...).
    #[error("key {key:?}: {reason}")]
    Value {
        /// The key.
        key: String,
        /// What serde said.
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
        /// What the parser said.
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

/// One key for a listing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyInfo {
    /// Dotted name.
    pub key: String,
    /// Value in the listed parameters (their default, when those are listed), in TOML notation.
    pub value: String,
    /// `boolean`, `integer`, `number`, `string`, `array` or `optional`.
    pub kind: &'static str,
}

/// All keys of `settings` with their values, in a fixed order.
///
/// # Errors
/// [`SettingsError::Parameters`] when `T` is no tree of named fields.
pub fn list_keys<T: Serialize>(settings: &T) -> Result<Vec<KeyInfo>, SettingsError> {
    let tree = serde_json::to_value(settings)?;
    Ok(leaves(&tree)
        .into_iter()
        .map(|(key, leaf)| KeyInfo { key, value: literal(leaf), kind: kind(leaf) })
        .collect())
}

/// Applies assignments `stage.key=value` in order; ranges are checked once at the end, so that several keys may
/// move a range together.
///
/// # Errors
/// [`SettingsError`]; `settings` is unchanged then.
pub fn apply_sets<T, S>(settings: &mut T, assignments: &[S]) -> Result<(), SettingsError>
where
    T: Serialize + DeserializeOwned + Validate,
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

/// Applies one assignment, as [`apply_sets`].
///
/// # Errors
/// [`SettingsError`]; `settings` is unchanged then.
pub fn apply_set<T>(settings: &mut T, assignment: &str) -> Result<(), SettingsError>
where
    T: Serialize + DeserializeOwned + Validate,
{
    apply_sets(settings, &[assignment])
}

/// Lays the TOML `text` over `settings`: what it does not name stays.
///
/// # Errors
/// [`SettingsError`]; `settings` is unchanged then.
pub fn apply_toml<T>(settings: &mut T, text: &str) -> Result<(), SettingsError>
where
    T: Serialize + DeserializeOwned + Validate,
{
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
pub fn apply_profile<T>(settings: &mut T, path: &Path) -> Result<(), SettingsError>
where
    T: Serialize + DeserializeOwned + Validate,
{
    let bytes = pt_image::atomic_file::read(path)?;
    String::from_utf8(bytes)
        .map_err(|_| SettingsError::Toml { line: 1, reason: "the file is not UTF-8 text".into() })
        .and_then(|text| apply_toml(settings, &text))
        .map_err(|error| SettingsError::Profile { path: path.into(), error: Box::new(error) })
}

fn merge<T: Serialize + DeserializeOwned>(
    tree: &mut Value,
    prefix: &str,
    table: &toml::Table,
) -> Result<(), SettingsError> {
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

fn finish<T: DeserializeOwned + Validate>(settings: &mut T, tree: Value) -> Result<(), SettingsError> {
    let changed: T = serde_json::from_value(tree)?;
    changed.validate()?;
    *settings = changed;
    Ok(())
}

/// Puts `value` at the leaf `key` and lets serde check it: all other leaves came from valid parameters. What spells
/// [`NONE`] and cannot be a value of the leaf is tried as the absent value of an `Option`.
fn replace<T: Serialize + DeserializeOwned>(
    tree: &mut Value,
    key: &str,
    value: Result<Value, SettingsError>,
    spells_none: bool,
) -> Result<(), SettingsError> {
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
    outcome
}

fn check_leaf<T: Serialize + DeserializeOwned>(
    tree: &Value,
    key: &str,
    expects: &Value,
) -> Result<(), SettingsError> {
    let parameters: T = serde_json::from_value(tree.clone())
        .map_err(|error| SettingsError::Value { key: key.into(), reason: error.to_string() })?;
    // A number beyond the range of an f32 field arrives there as infinity, which JSON shows as null.
    let kept = serde_json::to_value(&parameters)?;
    match (lookup(tree, key), lookup(&kept, key)) {
        (Some(given), Some(Value::Null)) if !given.is_null() => Err(type_error(key, expects, literal(given))),
        _ => Ok(()),
    }
}

fn lookup<'a>(tree: &'a Value, key: &str) -> Option<&'a Value> {
    key.split('.').try_fold(tree, |node, name| node.as_object()?.get(name))
}

/// The leaf under `key`.
fn find<'a>(tree: &'a mut Value, key: &str) -> Result<&'a mut Value, SettingsError> {
    match lookup(tree, key) {
        None => return Err(unknown(tree, key)),
        Some(Value::Object(table)) => {
            return Err(SettingsError::Table { key: key.into(), keys: names(table) });
        }
        Some(_) => {}
    }
    let mut node = tree;
    for name in key.split('.') {
        node = &mut node[name];
    }
    Ok(node)
}

fn unknown(tree: &Value, key: &str) -> SettingsError {
    let mut path = Vec::new();
    let mut node = tree;
    for name in key.split('.') {
        match node.get(name) {
            Some(inner @ Value::Object(_)) => {
                path.push(name);
                node = inner;
            }
            _ => break,
        }
    }
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    // A slip in the whole key, or the right name without or under the wrong table; among the latter the likest table.
    let distance = |candidate: &str| {
        let whole = strsim::damerau_levenshtein(candidate, key);
        (whole.min(strsim::damerau_levenshtein(&last(candidate), &last(key)) + 1), whole)
    };
    let closest = leaves(tree).into_iter().map(|(candidate, _)| candidate).min_by_key(|key| distance(key));
    SettingsError::UnknownKey {
        key: key.into(),
        closest: closest.unwrap_or_default(),
        table: if path.is_empty() { "the top level".into() } else { format!("{:?}", path.join(".")) },
        keys: node.as_object().map(names).unwrap_or_default(),
    }
}

fn names(table: &Map<String, Value>) -> String {
    table.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
}

fn leaves(tree: &Value) -> Vec<(String, &Value)> {
    fn walk<'a>(prefix: &str, node: &'a Value, found: &mut Vec<(String, &'a Value)>) {
        match node {
            Value::Object(table) => {
                for (name, inner) in table {
                    let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
                    walk(&key, inner, found);
                }
            }
            leaf => found.push((prefix.into(), leaf)),
        }
    }
    let mut found = Vec::new();
    walk("", tree, &mut found);
    found
}

fn kind(leaf: &Value) -> &'static str {
    match leaf {
        Value::Null => "optional",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "table",
    }
}

/// A value in TOML notation.
fn literal(value: &Value) -> String {
    match value {
        Value::Null => NONE.into(),
        Value::Array(items) => format!("[{}]", items.iter().map(literal).collect::<Vec<_>>().join(", ")),
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            // An f32 field widened to f64 would print noise digits.
            Some(wide) if f64::from(wide as f32) == wide => format!("{:?}", wide as f32),
            Some(wide) => format!("{wide:?}"),
            None => number.to_string(),
        },
        other => other.to_string(),
    }
}

/// The command-line text `text` as a value of the type of `current`.
fn parse(key: &str, current: &Value, text: &str) -> Result<Value, SettingsError> {
    let as_toml =
        || toml::from_str::<toml::Table>(&format!("v = {text}")).ok().and_then(|mut table| table.remove("v"));
    let parsed = match current {
        // The text itself, so that no quotes are needed.
        Value::String(_) => Some(toml::Value::String(text.into())),
        // Unsigned 64-bit integers (seeds) do not fit TOML's signed ones.
        Value::Number(number) if !number.is_f64() => {
            if let Ok(unsigned) = text.parse::<u64>() {
                return Ok(unsigned.into());
            }
            as_toml()
        }
        Value::Number(_) => text.parse().ok().map(toml::Value::Float),
        Value::Null if text == NONE => return Ok(Value::Null),
        Value::Null => Some(as_toml().unwrap_or_else(|| toml::Value::String(text.into()))),
        _ => as_toml(),
    };
    match parsed {
        Some(value) => convert(key, current, &value),
        None => Err(type_error(key, current, text.into())),
    }
}

/// A TOML value for a leaf that now holds `current`.
fn convert(key: &str, current: &Value, value: &toml::Value) -> Result<Value, SettingsError> {
    let converted = match (current, value) {
        (Value::Bool(_), toml::Value::Boolean(flag)) => Some((*flag).into()),
        (Value::Number(number), toml::Value::Integer(integer)) if !number.is_f64() => Some((*integer).into()),
        (Value::Number(number), toml::Value::Integer(integer)) if number.is_f64() => {
            Number::from_f64(*integer as f64).map(Value::Number)
        }
        (Value::Number(number), toml::Value::Float(float)) if number.is_f64() => {
            Number::from_f64(*float).map(Value::Number)
        }
        (Value::String(_), toml::Value::String(text)) => Some(text.as_str().into()),
        (Value::Array(_), toml::Value::Array(_)) | (Value::Null, _) => json(value),
        _ => None,
    };
    converted.ok_or_else(|| type_error(key, current, value.to_string()))
}

/// Any TOML value; `None` for what JSON cannot hold (dates, non-finite numbers).
fn json(value: &toml::Value) -> Option<Value> {
    Some(match value {
        toml::Value::String(text) => text.as_str().into(),
        toml::Value::Integer(integer) => (*integer).into(),
        toml::Value::Float(float) => Value::Number(Number::from_f64(*float)?),
        toml::Value::Boolean(flag) => (*flag).into(),
        toml::Value::Datetime(_) => return None,
        toml::Value::Array(items) => Value::Array(items.iter().map(json).collect::<Option<_>>()?),
        toml::Value::Table(table) => Value::Object(
            table.iter().map(|(key, value)| Some((key.clone(), json(value)?))).collect::<Option<_>>()?,
        ),
    })
}

fn type_error(key: &str, current: &Value, value: String) -> SettingsError {
    let expected = match current {
        Value::Bool(_) => "boolean (true or false)".into(),
        Value::Number(number) if number.is_f64() => "finite number".into(),
        Value::Array(items) => format!("array of {} values like {}", items.len(), literal(current)),
        other => kind(other).into(),
    };
    SettingsError::Type { key: key.into(), value, expected }
}
