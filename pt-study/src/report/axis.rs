//! Axes of figures: their range and where their marks are.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// An axis. Positions on it are linear: those of a logarithmic axis are exponents of ten.
#[derive(Clone)]
pub struct Axis {
    pub label: String,
    pub logarithmic: bool,
    /// Ends, as positions.
    pub low: f64,
    pub high: f64,
    /// Positions of the marks.
    pub marks: Vec<f64>,
}

/// Ratio of the largest to the smallest value from which on a scale is logarithmic.
const LOGARITHMIC_FROM: f64 = 8.0;
/// About how many marks an axis has.
const MARKS: f64 = 5.0;

impl Axis {
    /// An axis that shows all the values. `zero`: it begins at 0. Else it is logarithmic where `may_be_logarithmic` and the values, all
    /// above 0, spread far.
    pub fn of(label: &str, values: impl Iterator<Item = f64>, zero: bool, may_be_logarithmic: bool) -> Self {
        let (mut least, mut most) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(v), most.max(v)));
        if !(least.is_finite() && most.is_finite()) {
            (least, most) = (0.0, 1.0);
        }
        if zero {
            (least, most) = (least.min(0.0), most.max(0.0));
        }
        if most - least <= f64::EPSILON * most.abs() {
            let half = if most == 0.0 { 0.5 } else { 0.1 * most.abs() };
            (least, most) = (least - if zero { 0.0 } else { half }, most + half);
        }
        let logarithmic = may_be_logarithmic && !zero && least > 0.0 && most > LOGARITHMIC_FROM * least;
        let position = |value: f64| if logarithmic { value.log10() } else { value };
        let (low, high) = (position(least), position(most));
        let room = 0.04 * (high - low);
        let low = if zero && least == 0.0 { 0.0 } else { low - room };
        let high = if zero && most == 0.0 { 0.0 } else { high + room };
        let marks = if logarithmic { decades(low, high) } else { steps(low, high) };
        Self { label: label.into(), logarithmic, low, high, marks }
    }

    /// Where a value is; `None`: it has no place on a logarithmic axis.
    pub fn position(&self, value: f64) -> Option<f64> {
        let position = if self.logarithmic { value.log10() } else { value };
        position.is_finite().then_some(position)
    }

    /// Text of a mark.
    pub fn text(&self, position: f64) -> String {
        if self.logarithmic {
            return super::number::short(10_f64.powf(position));
        }
        // As many decimals as tell two marks apart.
        let step = self.marks.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        // A step of a power of ten may be a little below it.
        let step = (step.log10() + 1e-9).floor();
        let decimals = if step.is_finite() { (-step).max(0.0) } else { 0.0 };
        if position == 0.0 {
            "0".into()
        } else if (0.0..=4.0).contains(&decimals) && position.abs() < 1e6 {
            format!("{position:.0$}", decimals as usize)
        } else {
            let digits = (position.abs().log10() + 1e-9).floor() - step;
            format!("{position:.0$e}", digits.clamp(0.0, 6.0) as usize)
        }
    }

    /// Room that the label and the longest mark need beside a vertical axis, pixels.
    pub fn text_width(&self) -> u32 {
        let longest = self.marks.iter().map(|mark| self.text(*mark).len()).max().unwrap_or(0);
        (30 + 8 * longest as u32).max(66)
    }

    /// With marks at whole numbers alone, where there are any.
    pub fn whole(mut self) -> Self {
        if self.marks.iter().any(|mark| mark.fract() == 0.0) {
            self.marks.retain(|mark| mark.fract() == 0.0);
        }
        self
    }
}

/// The drawing library asks an axis for its marks and their texts.
impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, position: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (position - self.low) / (self.high - self.low);
        from + (share * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { vec![] } else { self.marks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, position: &f64) -> String {
        self.text(*position)
    }
}

/// Multiples of 1, 2 or 5 times a power of ten within a range.
fn steps(low: f64, high: f64) -> Vec<f64> {
    let wanted = (high - low) / MARKS;
    let power = 10_f64.powf(wanted.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= wanted).unwrap_or(wanted);
    let first = (low / step).ceil() as i64;
    (first..).map(|n| n as f64 * step).take_while(|mark| *mark <= high).take(32).collect()
}

/// Exponents within a range: decades, and 2 and 5 times them where there are few.
fn decades(low: f64, high: f64) -> Vec<f64> {
    let between: &[f64] = if high - low > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    (low.floor() as i32..=high.ceil() as i32)
        .flat_map(|decade| between.iter().map(move |m| f64::from(decade) + m.log10()))
        .filter(|mark| (low..=high).contains(mark))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_marks_within_their_range() {
        let cases: [(&[f64], bool, bool); 8] = [
            (&[0.01, 0.5], false, true),
            (&[1e-9, 1e9], false, true),
            (&[3.0, 3.0], false, true),
            (&[0.0, 0.0], true, false),
            (&[], false, true),
            (&[f64::NAN, f64::INFINITY], false, true),
            (&[-2.0, 7.0], true, false),
            (&[-7.0, -2.0], true, false),
        ];
        for (values, zero, log) in cases {
            let axis = Axis::of("x", values.iter().copied(), zero, log);
            assert!(axis.low < axis.high, "{values:?}");
            assert!((2..=20).contains(&axis.marks.len()), "{values:?}: {:?}", axis.marks);
            assert!(axis.marks.iter().all(|m| (axis.low..=axis.high).contains(m)));
            assert!(!zero || axis.low <= 0.0 && axis.high >= 0.0);
        }
        let axis = Axis::of("x", [0.996, 1.004].into_iter(), false, true);
        assert_eq!(
            axis.marks.iter().map(|m| axis.text(*m)).collect::<Vec<_>>(),
            ["0.996", "0.998", "1.000", "1.002", "1.004"]
        );
        let texts = |axis: &Axis| axis.marks.iter().map(|m| axis.text(*m)).collect::<Vec<_>>();
        let small = Axis::of("x", [0.00030, 0.00033].into_iter(), false, true);
        assert_eq!(texts(&small), ["3.0e-4", "3.1e-4", "3.2e-4", "3.3e-4"]);
        assert!(small.text_width() > 66);
        assert_eq!(texts(&Axis::of("frame", [10.0, 11.0].into_iter(), false, false).whole()), ["10", "11"]);
        let axis = Axis::of("x", [0.01, 0.5].into_iter(), false, true);
        assert!(axis.logarithmic && axis.position(0.0).is_none());
        assert_eq!(
            axis.marks.iter().map(|m| axis.text(*m)).collect::<Vec<_>>(),
            ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]
        );
    }
}
