//! How variants and stages are told apart in figures: a colour and a marker each.
//!
//! The drawing library writes a colour into every element. The style sheet maps these colours to its own of the light and the dark theme
//! (`[stroke="#0072B2"]`), and the page hides a series by its colour. So every series has a colour of its own; after [`COLORS`] are used up they
//! differ in the last bits only, and in the dashes that the style sheet gives them.

use plotters::style::RGBColor;
use serde::Serialize;

/// Colours that people with any kind of colour blindness tell apart (after Okabe and Ito 2008, darkened for lines on white).
const COLORS: [(u8, u8, u8); 7] =
    [(0, 114, 178), (199, 82, 0), (0, 128, 96), (168, 81, 138), (168, 116, 0), (60, 148, 201), (140, 60, 60)];
/// Colour of the baseline.
const NEUTRAL: RGBColor = RGBColor(85, 85, 85);
/// Colour of what remains beside the parts of a sum.
const REST: RGBColor = RGBColor(150, 154, 160);
/// Text and axes.
pub const INK: RGBColor = RGBColor(51, 51, 52);
/// Lines of the grid.
pub const GRID: RGBColor = RGBColor(221, 221, 222);

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    Cross,
}

const MARKERS: [Marker; 4] = [Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross];

/// A series.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    pub name: String,
    /// Colour in the files of figures, `#RRGGBB`.
    pub hex: String,
    /// Name of its colour in the style sheet.
    pub slot: String,
    /// Whether its line is dashed.
    pub dashed: bool,
    pub marker: Marker,
    #[serde(skip)]
    pub color: RGBColor,
}

impl Series {
    fn new(name: &str, color: RGBColor, slot: String, dashed: bool, marker: Marker) -> Self {
        let hex = format!("#{:02X}{:02X}{:02X}", color.0, color.1, color.2);
        Self { name: name.into(), hex, slot, dashed, marker, color }
    }

    /// The series that others are compared with.
    pub fn neutral(name: &str) -> Self {
        Self::new(name, NEUTRAL, "neutral".into(), false, Marker::Circle)
    }

    /// What remains beside the parts of a sum.
    pub fn rest(name: &str) -> Self {
        Self::new(name, REST, "rest".into(), false, Marker::Square)
    }

    /// The series with a number.
    pub fn numbered(name: &str, number: usize) -> Self {
        let (slot, cycle) = (number % COLORS.len(), number / COLORS.len());
        let (r, g, b) = COLORS[slot];
        // Up to 64 cycles: the change is not seen.
        let color = RGBColor(r ^ (cycle & 3) as u8, g ^ (cycle >> 2 & 3) as u8, b ^ (cycle >> 4 & 3) as u8);
        Self::new(name, color, slot.to_string(), cycle % 2 == 1, MARKERS[number % MARKERS.len()])
    }
}

/// Series of names, of which one is the baseline.
pub fn series<'a>(names: impl Iterator<Item = &'a str>, baseline: Option<&str>) -> Vec<Series> {
    let mut number = 0..;
    names
        .map(|name| {
            if Some(name) == baseline {
                Series::neutral(name)
            } else {
                Series::numbered(name, number.next().unwrap_or_default())
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_series_has_its_own_colour() {
        let names: Vec<_> = (0..400).map(|n| n.to_string()).collect();
        let series = series(names.iter().map(String::as_str), Some("3"));
        let colours: BTreeSet<_> = series.iter().map(|s| &s.hex).collect();
        assert_eq!(colours.len(), 400);
        assert_eq!(series[3].slot, "neutral");
        let looks: BTreeSet<_> =
            series[..24].iter().map(|s| format!("{} {:?} {}", s.slot, s.marker, s.dashed)).collect();
        assert_eq!(looks.len(), 24);
    }
}
