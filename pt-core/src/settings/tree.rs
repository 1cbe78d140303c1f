//! Parameters as a tree of JSON values: look-up by key, and parsing of values from text.

use super::error::SettingsError;
use serde_json::{Map, Number, Value};

/// Spelling of the absent value of an `Option`.
pub(super) const NONE: &str = "none";

pub(super) fn lookup<'a>(tree: &'a Value, key: &str) -> Option<&'a Value> {
    key.split('.').try_fold(tree, |node, name| node.as_object()?.get(name))
}

/// The leaf under `key`.
pub(super) fn find<'a>(tree: &'a mut Value, key: &str) -> Result<&'a mut Value, SettingsError> {
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

pub(super) fn unknown(tree: &Value, key: &str) -> SettingsError {
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
    let leaves = leaves(tree);
    SettingsError::UnknownKey {
        key: key.into(),
        hint: close_to(key, leaves.iter().map(|(candidate, _)| candidate.as_str())),
        table: if path.is_empty() { "the top level".into() } else { format!("{:?}", path.join(".")) },
        keys: node.as_object().map(names).unwrap_or_default(),
    }
}

/// The one of `known` that is spelt most like `key`: a slip in the whole key, or the right name without or under the wrong table; among the
/// latter the likest table. `None` without any.
pub fn closest_key<'a>(key: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let distance = |candidate: &str| {
        let whole = strsim::damerau_levenshtein(candidate, key);
        (whole.min(strsim::damerau_levenshtein(&last(candidate), &last(key)) + 1), whole)
    };
    known.into_iter().min_by_key(|candidate| distance(candidate))
}

/// What a message about an unknown name says about the known ones: `, closest: "NAME"`, or nothing if none of them is spelt like it.
/// At most a quarter of the letters of the whole key may differ, or a third of those of its last name.
pub fn close_to<'a>(key: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let key = key.to_lowercase();
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let is_near = |a: &str, b: &str, part: usize| {
        strsim::damerau_levenshtein(a, b) <= (a.chars().count() / part).max(1)
    };
    let is_like = |candidate: &&str| {
        is_near(&key, candidate, 4) || (!last(&key).is_empty() && is_near(&last(&key), &last(candidate), 3))
    };
    let closest = closest_key(&key, known.into_iter().filter(is_like));
    closest.map(|name| format!(", closest: {name:?}")).unwrap_or_default()
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
pub(super) fn literal(value: &Value) -> String {
    match value {
        Value::Null => NONE.into(),
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
pub(super) fn parse(key: &str, current: &Value, text: &str) -> Result<Value, SettingsError> {
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
pub(super) fn convert(key: &str, current: &Value, value: &toml::Value) -> Result<Value, SettingsError> {
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
        (Value::Null, _) => json(value),
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

pub(super) fn type_error(key: &str, current: &Value, value: String) -> SettingsError {
    let expected = match current {
        Value::Bool(_) => "boolean (true or false)".into(),
        Value::Number(number) if number.is_f64() => "finite number".into(),
        other => kind(other).into(),
    };
    SettingsError::Type { key: key.into(), value, expected }
}
