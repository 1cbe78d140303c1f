//! The identity of a reference render: slices can be merged, and checkpoints resumed, only if it agrees.

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

    /// The first difference from `expected` in words; `None` when they agree.
    pub fn difference(&self, expected: &Self) -> Option<String> {
        let names = self.0.keys().chain(expected.0.keys());
        let name = names.filter(|name| self.0.get(*name) != expected.0.get(*name)).min()?;
        let show = |identity: &Self| identity.0.get(name).map_or("nothing".into(), |value| short(value));
        Some(format!("{name} is {} there and {} here", show(self), show(expected)))
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
        let mut file: BTreeMap<String, String> = a.metadata().collect();
        file.insert("other".into(), "1".into());
        assert_eq!(Identity::from_metadata(&file), a);
    }
}
