//! TOML tables whose errors name file, line and column.

use crate::error::StudyError;
use crate::keys::{Key, names};
use pt_core::settings::close_to;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A TOML file.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Its path, for messages.
    pub path: &'a Path,
    /// Its text.
    pub text: &'a str,
}

/// A value with its place.
pub type Value<'a> = Spanned<DeValue<'a>>;

impl<'a> Source<'a> {
    /// Parses the file.
    pub fn parse(self) -> Result<Spanned<DeTable<'a>>, StudyError> {
        DeTable::parse(self.text)
            .map_err(|error| self.error(error.span().unwrap_or(0..0), error.message().replace('\n', ", ")))
    }

    /// An error at a place.
    pub fn error(self, span: Range<usize>, reason: impl Into<String>) -> StudyError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        StudyError::At { path: self.path.into(), line, column, reason: reason.into() }
    }

    /// An error at entry `index` of the list `key` of the root table, or at the single value that stands for the list.
    pub fn error_at(self, key: &str, index: usize, reason: impl Into<String>) -> StudyError {
        let span = self.parse().ok().and_then(|root| {
            let (_, value) = root.get_ref().iter().find(|(name, _)| name.get_ref() == key)?;
            Some(self.list(value).get(index)?.span())
        });
        self.error(span.unwrap_or(0..0), reason)
    }

    /// A table of which only `keys` are allowed; `what` names it in messages.
    pub fn table<'t>(
        self,
        table: &'t DeTable<'a>,
        what: &str,
        keys: &[Key],
    ) -> Result<Table<'a, 't>, StudyError> {
        let known = names(keys);
        match table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
            Some(key) => {
                let name = key.get_ref();
                let closest = close_to(name, known.iter().copied());
                Err(self.error(
                    key.span(),
                    format!("unknown key {name:?}{closest} ({what} has: {})", known.join(", ")),
                ))
            }
            None => Ok(Table { source: self, table }),
        }
    }

    /// The entries of a list, or a single value that stands for a list of one.
    pub fn list<'t>(self, value: &'t Value<'a>) -> &'t [Value<'a>] {
        match value.get_ref() {
            DeValue::Array(items) => items,
            _ => std::slice::from_ref(value),
        }
    }

    /// A string.
    pub fn string(self, value: &Value<'_>) -> Result<String, StudyError> {
        self.expect(value, "a string", value.get_ref().as_str().map(str::to_owned))
    }

    /// A whole number of 0 or more.
    pub fn number(self, value: &Value<'_>) -> Result<u64, StudyError> {
        let number = match value.get_ref() {
            DeValue::Integer(number) => u64::from_str_radix(number.as_str(), number.radix()).ok(),
            _ => None,
        };
        self.expect(value, "a whole number of 0 or more", number)
    }

    /// A finite number.
    pub fn float(self, value: &Value<'_>) -> Result<f64, StudyError> {
        let number: Option<f64> = match value.get_ref() {
            DeValue::Integer(number) => number.as_str().parse().ok(),
            DeValue::Float(number) => number.as_str().parse().ok(),
            _ => None,
        };
        self.expect(value, "a finite number", number.filter(|number| number.is_finite()))
    }

    /// A boolean.
    pub fn boolean(self, value: &Value<'_>) -> Result<bool, StudyError> {
        self.expect(value, "true or false", value.get_ref().as_bool())
    }

    /// A value of a knob, as `--set` takes it.
    pub fn knob_text(self, value: &Value<'_>) -> Result<String, StudyError> {
        let text = match value.get_ref() {
            DeValue::String(text) => Some(text.to_string()),
            DeValue::Boolean(flag) => Some(flag.to_string()),
            DeValue::Integer(number) => {
                i128::from_str_radix(number.as_str(), number.radix()).ok().map(|number| number.to_string())
            }
            DeValue::Float(number) => number.as_str().parse::<f64>().ok().map(|number| number.to_string()),
            _ => None,
        };
        self.expect(value, "a boolean, a number or a name", text)
    }

    fn expect<T>(self, value: &Value<'_>, expected: &str, found: Option<T>) -> Result<T, StudyError> {
        found.ok_or_else(|| {
            let article = value.get_ref().type_str();
            self.error(value.span(), format!("expected {expected}, got a value of type {article}"))
        })
    }
}

/// A table with its place.
#[derive(Clone, Copy)]
pub struct Table<'a, 't> {
    source: Source<'a>,
    table: &'t DeTable<'a>,
}

impl<'a, 't> Table<'a, 't> {
    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&'t Value<'a>> {
        self.table.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
    }

    /// The value of a key, read by `read`.
    pub fn read<T>(
        &self,
        key: &str,
        read: impl Fn(Source<'a>, &'t Value<'a>) -> Result<T, StudyError>,
    ) -> Result<Option<T>, StudyError> {
        self.get(key).map(|value| read(self.source, value)).transpose()
    }

    /// The values of a list, or a single value.
    pub fn read_list<T>(
        &self,
        key: &str,
        read: impl Fn(Source<'a>, &'t Value<'a>) -> Result<T, StudyError>,
    ) -> Result<Option<Vec<T>>, StudyError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let items = self.source.list(value);
        if items.is_empty() {
            return Err(self.source.error(value.span(), format!("{key} is empty: the study has no cells")));
        }
        items.iter().map(|item| read(self.source, item)).collect::<Result<_, _>>().map(Some)
    }

    /// One of some names.
    pub fn one_of<T: Copy>(&self, key: &str, names: &[(&str, T)]) -> Result<Option<T>, StudyError> {
        self.read(key, |source, value| {
            let name = source.string(value)?;
            names.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
                let known: Vec<_> = names.iter().map(|(name, _)| *name).collect();
                source.error(value.span(), format!("{key} {name:?}: expected one of {}", known.join(", ")))
            })
        })
    }
}
