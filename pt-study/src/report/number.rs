//! Numbers as text.

/// Significant digits of the smallest magnitude in a column of means.
const DIGITS: i32 = 4;
/// Digits of the smallest uncertainty where there is one: more digits would be noise.
const UNCERTAIN_DIGITS: i32 = 2;
/// Most decimals of a column; smaller numbers are written with an exponent.
const MOST_DECIMALS: i32 = 7;

/// A number alone, with three significant digits and no more zeros than needed: `0.0123`, `1.5`, `2.1e-6`.
pub fn short(value: f64) -> String {
    let text = significant(value, 3);
    match text.split_once('.') {
        Some((_, fraction)) if !fraction.contains('e') => {
            text.trim_end_matches('0').trim_end_matches('.').into()
        }
        _ => text,
    }
}

/// A number alone, with a number of significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value.is_finite() { "0".into() } else { "not finite".into() };
    }
    let exponent = value.abs().log10().floor() as i32;
    if (-4..7).contains(&exponent) {
        let decimals = (digits - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        let decimals = (digits - 1) as usize;
        format!("{value:.decimals$e}")
    }
}

/// How all numbers of a column are written, so that they can be compared digit by digit.
#[derive(Clone, Copy)]
pub struct Column {
    decimals: i32,
}

impl Column {
    /// Enough decimals for the smallest magnitude of the values to show its leading digits.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let decimals = Self::decimals(values, DIGITS).unwrap_or(0);
        Self { decimals }
    }

    /// Enough decimals for the smallest of the uncertainties of the values; for the values if none has an uncertainty.
    pub fn of_uncertain(values: impl Iterator<Item = f64>, uncertainties: impl Iterator<Item = f64>) -> Self {
        Self::decimals(uncertainties, UNCERTAIN_DIGITS)
            .map_or_else(|| Self::of(values), |decimals| Self { decimals })
    }

    fn decimals(values: impl Iterator<Item = f64>, digits: i32) -> Option<i32> {
        let least = values.map(f64::abs).filter(|v| *v > 0.0 && v.is_finite()).fold(f64::INFINITY, f64::min);
        least.is_finite().then(|| (digits - 1 - least.log10().floor() as i32).max(0))
    }

    /// The number without a sign if it is positive.
    pub fn text(self, value: f64) -> String {
        if self.decimals > MOST_DECIMALS {
            return significant(value, DIGITS - 1);
        }
        format!("{value:.*}", self.decimals as usize)
    }

    /// The number with its sign.
    pub fn signed(self, value: f64) -> String {
        let text = self.text(value);
        if value > 0.0 { format!("+{text}") } else { text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_their_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.5, "1.5"),
            (0.0123, "0.0123"),
            (100.0, "100"),
            (2.1e-6, "2.10e-6"),
            (-0.5, "-0.5"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_column_has_one_number_of_decimals() {
        let column = Column::of([0.0123, 1.5].into_iter());
        assert_eq!((column.text(0.0123), column.text(1.5)), ("0.01230".into(), "1.50000".into()));
        assert_eq!((column.signed(0.5), column.signed(-0.5)), ("+0.50000".into(), "-0.50000".into()));
        let uncertain = |half: &[f64]| Column::of_uncertain([0.25].into_iter(), half.iter().copied());
        assert_eq!(uncertain(&[0.0012, 0.3]).signed(0.25), "+0.2500");
        assert_eq!(uncertain(&[0.0]).signed(0.25), "+0.2500");
        assert_eq!(Column::of([1e-9].into_iter()).text(1e-9), "1.00e-9");
        assert_eq!(Column::of(std::iter::empty()).text(0.0), "0");
    }
}
