//! Tables of the page, as the template takes them.

use super::number::significant;
use serde::Serialize;

/// A table.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    pub head: Vec<Head>,
    pub rows: Vec<Vec<Datum>>,
}

/// Head of a column.
#[derive(Debug, Serialize)]
pub struct Head {
    pub text: String,
    /// Whether the column holds numbers.
    pub number: bool,
}

/// A cell of a table.
#[derive(Debug, Default, Serialize)]
pub struct Datum {
    pub text: String,
    /// Value by which a column of numbers is sorted.
    pub sort: Option<f64>,
    /// Class of the style sheet; empty: none.
    pub class: &'static str,
    /// Whether the text is a command, with a button that copies it.
    pub command: bool,
    /// Series whose marker stands before the text.
    pub series: Option<super::series::Series>,
}

impl Table {
    /// A table without rows. A `#` before a name: a column of numbers.
    pub fn new<'a>(head: impl IntoIterator<Item = &'a str>) -> Self {
        let head = head
            .into_iter()
            .map(|name| {
                let text = name.strip_prefix('#');
                Head { text: text.unwrap_or(name).into(), number: text.is_some() }
            })
            .collect();
        Self { head, rows: Vec::new() }
    }
}

impl Datum {
    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// A number as it is to be written.
    pub fn number(value: f64, text: String) -> Self {
        Self { text, sort: Some(value), ..Self::default() }
    }

    /// A number with four digits; a dash where there is none.
    pub fn value(value: Option<f64>) -> Self {
        value.map_or_else(Self::none, |value| Self::number(value, significant(value, 4)))
    }

    /// Nothing is known.
    pub fn none() -> Self {
        Self::text("–")
    }

    /// A command.
    pub fn command(text: impl Into<String>) -> Self {
        Self { command: true, ..Self::text(text) }
    }

    /// The name of a variant or a stage, with the marker of its series.
    pub fn series(series: &super::series::Series) -> Self {
        Self { series: Some(series.clone()), ..Self::text(&series.name) }
    }
}
