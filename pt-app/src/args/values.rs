//! Values of arguments.

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
