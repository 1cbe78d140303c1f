//! The JSON text: into typed structs, with the path of what does not fit; and what those structs do not show.

use std::cell::RefCell;
use std::fmt;

use gltf::json::Root;
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Value, json};

use crate::notices::{Notices, Remark};

/// Parses the text. An error is a JSON path, empty for the whole text, and what is wrong there.
pub(crate) fn read(text: &[u8], notices: &mut Notices) -> Result<Root, (String, String)> {
    let mut reader = serde_json::Deserializer::from_slice(text);
    let root = match root(&mut reader) {
        Ok(whole) => reader.end().map(|()| whole).map_err(|e| (String::new(), e.to_string()))?,
        Err(error) => root(completed(text).ok_or(error)?)?,
    };
    let remarks = RefCell::new(Vec::new());
    let mut reader = serde_json::Deserializer::from_slice(text);
    let walk = Walk { path: Path::Root, remarks: &remarks };
    walk.deserialize(&mut reader).map_err(|e| (String::new(), e.to_string()))?;
    notices.extend(remarks.into_inner());
    Ok(root)
}

/// The version that a text claims, or shows by its form, if it is one that cannot be read: glTF 1.0 has objects where 2.0 has
/// arrays, and did not always name its version.
pub(crate) fn older_version(text: &[u8]) -> Option<String> {
    let document: Value = serde_json::from_slice(text).ok()?;
    let version = document.get("asset").and_then(|asset| asset.get("version"));
    let version = version.map(|version| version.as_str().map_or_else(|| version.to_string(), str::to_owned));
    let is_object = |key: &str| document.get(key).is_some_and(Value::is_object);
    let has_objects = ["meshes", "nodes", "scenes", "accessors", "bufferViews"].into_iter().any(is_object);
    match version {
        Some(version) if version.parse().is_ok_and(|number: f64| number < 2.0) => Some(version),
        None if has_objects => Some("1.0".into()),
        _ => None,
    }
}

fn root<'de>(reader: impl Deserializer<'de, Error = serde_json::Error>) -> Result<Root, (String, String)> {
    serde_path_to_error::deserialize(reader).map_err(|e| {
        let path = e.path().to_string();
        (if path == "." { String::new() } else { path }, e.into_inner().to_string())
    })
}

/// The text with what the JSON crate insists on though the format lets it be left out: `nodes` of a scene, and `node` of an
/// animation channel that an extension aims at something else; that channel gets a path that nothing has. `None` when neither was
/// missing.
fn completed(text: &[u8]) -> Option<Value> {
    let mut document: Value = serde_json::from_slice(text).ok()?;
    let mut is_changed = false;
    for scene in items(&mut document, "scenes").filter_map(Value::as_object_mut) {
        is_changed |= !scene.contains_key("nodes");
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
    for animation in items(&mut document, "animations") {
        for channel in items(animation, "channels") {
            let target = channel.get_mut("target").and_then(Value::as_object_mut);
            if let Some(target) = target.filter(|target| !target.contains_key("node")) {
                is_changed = true;
                target.insert("node".into(), json!(0));
                target.insert("path".into(), json!("none"));
            }
        }
    }
    is_changed.then_some(document)
}

/// What the array `key` of an object holds; nothing if there is none.
fn items<'a>(object: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    object.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

#[derive(Clone, Copy)]
enum Path<'a> {
    Root,
    Key(&'a Path<'a>, &'a str),
    Index(&'a Path<'a>, usize),
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Path::Root => Ok(()),
            Path::Key(Path::Root, key) => write!(f, "{key}"),
            Path::Key(parent, key) => write!(f, "{parent}.{key}"),
            Path::Index(parent, index) => write!(f, "{parent}[{index}]"),
        }
    }
}

impl Path<'_> {
    /// Whether the keys here are names of vertex attributes.
    fn is_attributes(&self) -> bool {
        matches!(self, Path::Key(_, "attributes") | Path::Index(Path::Key(_, "targets"), _))
    }
}

/// Visits every value below `path`.
struct Walk<'a> {
    path: Path<'a>,
    remarks: &'a RefCell<Vec<Remark>>,
}

impl Walk<'_> {
    fn remark(&self, at: impl ToString, what: &str) {
        self.remarks.borrow_mut().push((at.to_string(), what.into()));
    }
}

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<(), A::Error> {
        let mut count = 0;
        while let Some(()) =
            items.next_element_seed(Walk { path: Path::Index(&self.path, count), remarks: self.remarks })?
        {
            count += 1;
        }
        if count == 0 {
            self.remark(self.path, "is an empty array, which should be left out");
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<(), A::Error> {
        let mut count = 0;
        while let Some(key) = entries.next_key::<String>()? {
            count += 1;
            if key == "extras" || key == "extensions" {
                entries.next_value::<IgnoredAny>()?;
                continue;
            }
            let path = Path::Key(&self.path, &key);
            if self.path.is_attributes() && !is_attribute_name(&key) {
                self.remark(path, "is no name of a vertex attribute; left out");
            }
            entries.next_value_seed(Walk { path, remarks: self.remarks })?;
        }
        if count == 0 && self.path.is_attributes() {
            self.remark(self.path, "has no attributes");
        }
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }
}

/// glTF 2.0, section 3.7.2.1: the semantics, numbered without leading zeros, and anything that begins with `_`.
fn is_attribute_name(name: &str) -> bool {
    let number = |n: &str| n == "0" || (!n.starts_with('0') && n.bytes().all(|c| c.is_ascii_digit()));
    match name.split_once('_') {
        None => matches!(name, "POSITION" | "NORMAL" | "TANGENT"),
        Some(("", _)) => true,
        Some(("TEXCOORD" | "COLOR" | "JOINTS" | "WEIGHTS", n)) => !n.is_empty() && number(n),
        Some(_) => false,
    }
}
