//! Parsers for the values of arguments.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use pt_shaders::{NamedEnum, NamedValue, UnknownName};

/// One of the names of an enum; help lists them all.
pub fn named<T: NamedEnum + Send + Sync>() -> impl TypedValueParser<Value = T> {
    one_of(T::NAMED).try_map(|name| -> Result<T, UnknownName> { T::from_name(&name) })
}

/// One of some names.
pub fn one_of(values: &'static [NamedValue]) -> PossibleValuesParser {
    PossibleValuesParser::new(values.iter().map(|value| PossibleValue::new(value.name).help(value.doc)))
}

/// Exactly `N` values with commas between them; `expected` says which.
///
/// # Errors
/// Another number of values, or one that is not of the kind.
pub fn numbers<T, const N: usize>(
    text: &str,
    expected: &str,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<[T; N], String> {
    let values: Result<Vec<T>, String> = text.split(',').map(|part| parse(part.trim())).collect();
    values.ok().and_then(|values| values.try_into().ok()).ok_or_else(|| format!("expected {expected}"))
}

/// A finite number, for times.
///
/// # Errors
/// Anything else.
pub fn finite_f64(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "expected a finite number".into())
}

/// A finite number.
///
/// # Errors
/// Anything else.
pub fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|value: &f32| value.is_finite()).ok_or_else(|| "expected a finite number".into())
}

/// A number of 0 or more.
///
/// # Errors
/// Anything else.
pub fn not_negative(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&value| value >= 0.0).ok_or_else(|| "expected a number of 0 or more".into())
}

/// A number of 0 or more, for times.
///
/// # Errors
/// Anything else.
pub fn not_negative_f64(text: &str) -> Result<f64, String> {
    finite_f64(text).ok().filter(|&value| value >= 0.0).ok_or_else(|| "expected a number of 0 or more".into())
}

/// A number above 0.
///
/// # Errors
/// Anything else.
pub fn positive_f64(text: &str) -> Result<f64, String> {
    finite_f64(text).ok().filter(|&value| value > 0.0).ok_or_else(|| "expected a number above 0".into())
}

/// `stage.key=value`. Only the form; keys and values are checked against the knobs.
///
/// # Errors
/// Another form.
pub fn assignment(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some((key, _)) if !key.trim().is_empty() => Ok(text.into()),
        _ => Err("expected stage.key=value".into()),
    }
}

/// A range of frames `A..B`: A and what follows, without B; not empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameRange(pub std::ops::Range<u32>);

impl std::str::FromStr for FrameRange {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |text: &str| text.parse().ok();
        let range = text.split_once("..").and_then(|(a, b)| Some(parse(a)?..parse(b)?));
        let range = range.ok_or("expected A..B, two numbers of frames, for example 0..8")?;
        if range.is_empty() { Err(format!("{text} has no frames")) } else { Ok(Self(range)) }
    }
}
