//! Colour spaces that image files name by chromaticities, into linear RGB with Rec. 709 primaries and white D65.

use glam::{DMat3, DVec2, DVec3};

/// Chromaticities (CIE 1931 x, y) of the three primaries and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chromaticities {
    pub red: DVec2,
    pub green: DVec2,
    pub blue: DVec2,
    pub white: DVec2,
}

/// ITU-R BT.709, the primaries of everything in the workbench.
pub(super) const REC_709: Chromaticities = Chromaticities {
    red: DVec2::new(0.64, 0.33),
    green: DVec2::new(0.3, 0.6),
    blue: DVec2::new(0.15, 0.06),
    white: DVec2::new(0.3127, 0.329),
};

/// Files round chromaticities to three or four digits.
const SAME: f64 = 2e-4;

/// Tristimulus values to the cone responses in which the Bradford adaptation scales (Lam 1985; ICC.1:2022, annex E.3).
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

impl Chromaticities {
    /// The eight numbers x, y of red, green, blue and white, in this order; `None` for zeros, which some programs write where they
    /// do not know them.
    pub fn from_numbers(numbers: [f64; 8]) -> Option<Self> {
        let [rx, ry, gx, gy, bx, by, wx, wy] = numbers;
        let [red, green] = [DVec2::new(rx, ry), DVec2::new(gx, gy)];
        let known = Self { red, green, blue: DVec2::new(bx, by), white: DVec2::new(wx, wy) };
        (numbers != [0.0; 8]).then_some(known)
    }

    /// The matrix that takes linear RGB of this space to linear RGB of Rec. 709, white to white (Bradford adaptation);
    /// `None` where the spaces are the same but for rounding.
    ///
    /// # Errors
    /// In words: the chromaticities do not define a colour space.
    pub fn to_rec_709(self) -> Result<Option<DMat3>, String> {
        let near = |a: DVec2, b: DVec2| (a - b).abs().max_element() <= SAME;
        let same = [
            (self.red, REC_709.red),
            (self.green, REC_709.green),
            (self.blue, REC_709.blue),
            (self.white, REC_709.white),
        ];
        if same.iter().all(|&(a, b)| near(a, b)) {
            return Ok(None);
        }
        let matrix = self.xyz_from_rgb().and_then(|source| {
            let adaptation = adapt(self.white, REC_709.white)?;
            let target = REC_709.xyz_from_rgb()?;
            Some(target.inverse() * adaptation * source)
        });
        matrix.filter(DMat3::is_finite).map(Some).ok_or_else(|| {
            let [r, g, b, w] = [self.red, self.green, self.blue, self.white];
            format!("the chromaticities red {r}, green {g}, blue {b}, white {w} do not define a colour space")
        })
    }

    /// The matrix from linear RGB to CIE XYZ, with Y = 1 for white (SMPTE RP 177-1993); `None` unless white is a mixture of
    /// the primaries.
    fn xyz_from_rgb(self) -> Option<DMat3> {
        let direction = |c: DVec2| DVec3::new(c.x, c.y, 1.0 - c.x - c.y);
        let primaries = DMat3::from_cols(direction(self.red), direction(self.green), direction(self.blue));
        if !(primaries.determinant().abs() > 1e-6 && self.white.y > 0.0) {
            return None;
        }
        let amounts = primaries.inverse() * tristimulus(self.white);
        (amounts.min_element() > 0.0).then(|| primaries * DMat3::from_diagonal(amounts))
    }
}

/// CIE XYZ to linear RGB of Rec. 709, without adaptation: white is D65.
pub(super) fn rec_709_from_xyz() -> DMat3 {
    REC_709.xyz_from_rgb().map_or(DMat3::IDENTITY, |matrix| matrix.inverse())
}

/// CIE XYZ of a chromaticity, with Y = 1.
fn tristimulus(c: DVec2) -> DVec3 {
    DVec3::new(c.x, c.y, 1.0 - c.x - c.y) / c.y
}

/// Tristimulus values under white `from` to those that look alike under white `to`.
fn adapt(from: DVec2, to: DVec2) -> Option<DMat3> {
    let [from, to] = [from, to].map(|white| BRADFORD * tristimulus(white));
    let scale = DMat3::from_diagonal(to / from);
    (from.min_element() > 0.0).then(|| BRADFORD.inverse() * scale * BRADFORD)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DVec3, b: DVec3, tolerance: f64) {
        assert!((a - b).abs().max_element() <= tolerance, "{a} is not {b}");
    }

    #[test]
    fn rec_709_is_left_alone() {
        assert_eq!(REC_709.to_rec_709(), Ok(None));
        let rounded = Chromaticities { white: DVec2::new(0.3127, 0.3291), ..REC_709 };
        assert_eq!(rounded.to_rec_709(), Ok(None));
    }

    #[test]
    fn ap1_is_converted_as_published() {
        let ap1 = Chromaticities::from_numbers([0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767]);
        let matrix = ap1.unwrap().to_rec_709().unwrap().unwrap();
        // The matrix of the Academy's colour transforms (AP1 to Rec. 709, Bradford), by rows.
        let published = DMat3::from_cols_array(&[
            1.705_052, -0.130_257, -0.024_003, -0.621_791, 1.140_803, -0.128_969, -0.083_258, -0.010_548,
            1.152_972,
        ]);
        for (a, b) in matrix.to_cols_array().into_iter().zip(published.to_cols_array()) {
            assert!((a - b).abs() < 2e-4, "{matrix} is not {published}");
        }
        close(matrix * DVec3::new(0.6, 0.3, 0.2), DVec3::new(0.82, 0.26, 0.18), 0.005);
    }

    #[test]
    fn white_stays_white_whatever_the_primaries() {
        let spaces = [
            // AP0, whose blue lies below the axis; tristimulus values as they are; Radiance's own; wide gamut.
            [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767],
            [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0],
            [0.64, 0.33, 0.29, 0.6, 0.15, 0.06, 0.333, 0.333],
            [0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329],
        ];
        for numbers in spaces {
            let matrix = Chromaticities::from_numbers(numbers).unwrap().to_rec_709().unwrap().unwrap();
            close(matrix * DVec3::ONE, DVec3::ONE, 1e-9);
        }
        close(rec_709_from_xyz() * tristimulus(REC_709.white), DVec3::ONE, 1e-9);
    }

    #[test]
    fn what_is_no_colour_space_is_refused() {
        assert_eq!(Chromaticities::from_numbers([0.0; 8]), None);
        let bad = [
            [f64::NAN; 8],
            [0.64, 0.33, 0.64, 0.33, 0.15, 0.06, 0.3127, 0.329],
            [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.0],
            // White outside of the triangle.
            [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.7, 0.29],
        ];
        for numbers in bad {
            let text = Chromaticities::from_numbers(numbers).unwrap().to_rec_709().unwrap_err();
            assert!(text.contains("do not define a colour space"), "{text}");
        }
    }
}
