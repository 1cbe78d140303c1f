//! The colour spaces of FLIP.

use glam::{DMat3, DVec3, Mat3, Vec3};

/// Rec. 709 RGB to CIE XYZ, row by row (IEC 61966-2-1 primaries and white as exact fractions).
const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// Conversions between linear RGB and XYZ relative to white (white is 1, 1, 1).
pub struct ColourSpace {
    from_rgb: Mat3,
    to_rgb: Mat3,
}

impl ColourSpace {
    pub fn new() -> Self {
        let [x, y, z] = RGB_TO_XYZ.map(|row| DVec3::from_array(row) / row.iter().sum::<f64>());
        let from_rgb = DMat3::from_cols(x, y, z).transpose();
        Self { from_rgb: from_rgb.as_mat3(), to_rgb: from_rgb.inverse().as_mat3() }
    }

    /// Achromatic, red-green and blue-yellow: Y, X - Y and Y - Z relative to white. The YCxCz of FLIP 2020 (eq. 1) is an
    /// affine function of each of them, which filters of unit sum leave unchanged.
    pub fn opponent(&self, rgb: [f32; 3]) -> [f32; 3] {
        let xyz = self.from_rgb * Vec3::from_array(rgb);
        [xyz.y, xyz.x - xyz.y, xyz.y - xyz.z]
    }

    /// CIE L*a*b* with chroma in proportion to lightness (Hunt effect, FLIP 2020, section 4.1.2), of a colour that is
    /// first brought into the gamut of the display.
    pub fn hunt_lab(&self, [y, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
        let rgb = self.to_rgb * Vec3::new(y + red_green, y, y - blue_yellow);
        let xyz = self.from_rgb * rgb.clamp(Vec3::ZERO, Vec3::ONE);
        let [x, y, z] = xyz.to_array().map(lab_curve);
        let lightness = 116.0 * y - 16.0;
        let hunt = 0.01 * lightness;
        [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
    }
}

/// CIE 15: a cube root with a linear piece at black.
fn lab_curve(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

/// Distance of two L*a*b* colours that suits large differences (Abasi et al. 2020): city-block in lightness, Euclidean
/// in chroma.
pub fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}
