//! The identity of a reference render: slices can be merged, and checkpoints resumed, only if it agrees.

use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Names and values of everything that determines the samples: scene, view, size, seed, parameters, program version.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identity(pub BTreeMap<String, String>);

/// Prefix of the metadata keys under which files keep an [`Identity`].
const PREFIX: &str = "identity.";

impl Identity {
    /// Adds an entry.
    pub fn with(mut self, name: &str, value: impl ToString) -> Self {
        self.0.insert(name.into(), value.to_string());
        self
    }

    /// The first difference from `expected` in words; `None` when they agree. Of values that are JSON objects it names the member.
    pub fn difference(&self, expected: &Self) -> Option<String> {
        let entries = |identity: &Self| -> Map<String, Value> {
            identity.0.iter().map(|(name, value)| (name.clone(), object_or_text(value))).collect()
        };
        let (name, [there, here]) = first_difference(&entries(self), &entries(expected))?;
        Some(format!("{name} is {there} there and {here} here"))
    }

    /// Entries for a file's metadata.
    pub fn metadata(&self) -> impl Iterator<Item = (String, String)> + '_ {
        self.0.iter().map(|(name, value)| (format!("{PREFIX}{name}"), value.clone()))
    }

    /// Inverse of [`Identity::metadata`]; other entries are left out.
    pub fn from_metadata(metadata: &BTreeMap<String, String>) -> Self {
        let entries = metadata.iter().filter_map(|(key, value)| Some((key.strip_prefix(PREFIX)?, value)));
        Self(entries.map(|(name, value)| (name.to_owned(), value.clone())).collect())
    }
}

fn object_or_text(value: &str) -> Value {
    match serde_json::from_str(value) {
        Ok(Value::Object(members)) => Value::Object(members),
        _ => Value::String(value.into()),
    }
}

/// The first member in which two objects differ, by its path, and its two values in words.
fn first_difference(a: &Map<String, Value>, b: &Map<String, Value>) -> Option<(String, [String; 2])> {
    let name = a.keys().chain(b.keys()).filter(|name| a.get(*name) != b.get(*name)).min()?;
    let values = [a.get(name), b.get(name)];
    if let [Some(Value::Object(a)), Some(Value::Object(b))] = values
        && let Some((inner, values)) = first_difference(a, b)
    {
        return Some((format!("{name}.{inner}"), values));
    }
    Some((name.clone(), values.map(text)))
}

fn text(value: Option<&Value>) -> String {
    match value {
        None => "nothing".into(),
        Some(Value::String(text)) => short(text),
        Some(value) => short(&value.to_string()),
    }
}

fn short(value: &str) -> String {
    const MOST: usize = 60;
    if value.chars().count() <= MOST {
        value.into()
    } else {
        value.chars().take(MOST).chain("...".chars()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_named() {
        let a = Identity::default().with("seed", 3).with("size", "4x4");
        assert_eq!(a.difference(&a), None);
        let b = a.clone().with("seed", 4);
        assert_eq!(b.difference(&a).unwrap(), "seed is 4 there and 3 here");
        let c = a.clone().with("camera", "x");
        assert_eq!(a.difference(&c).unwrap(), "camera is nothing there and x here");
        let knobs = |params: &str| a.clone().with("params", params);
        let [plain, other, less] = [
            r#"{"a": 1, "t": {"x": true, "y": false}, "z": "on"}"#,
            r#"{"a": 1, "t": {"x": true, "y": true}, "z": "off"}"#,
            r#"{"a": 1, "t": {"x": true, "y": false}}"#,
        ]
        .map(knobs);
        assert_eq!(plain.difference(&other).unwrap(), "params.t.y is false there and true here");
        assert_eq!(less.difference(&plain).unwrap(), "params.z is nothing there and on here");
        let mut file: BTreeMap<String, String> = a.metadata().collect();
        file.insert("other".into(), "1".into());
        assert_eq!(Identity::from_metadata(&file), a);
    }
}
