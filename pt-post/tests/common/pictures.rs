//! Test pictures in linear display light, 0 to 1.

use pt_image::image_file::LinearImage;
use pt_post::oracle::{Image, srgb_encode};

/// sRGB codes of linear values.
pub fn to_codes(image: &Image) -> Image {
    let pixels = image.pixels.iter().map(|c| c.map(|v| srgb_encode(v.clamp(0.0, 1.0)))).collect();
    Image { size: image.size, pixels }
}

/// Mean over a pixel's box of a function of the plane, with 8 x 8 samples.
pub fn supersampled(size: [u32; 2], f: impl Fn(f64, f64) -> f64) -> Image {
    Image::from_fn(size, |x, y| {
        let place = |at: u32, i: u32| f64::from(at) + (f64::from(i) + 0.5) / 8.0;
        let sum: f64 = (0..64).map(|i| f(place(x, i % 8), place(y, i / 8))).sum();
        [sum / 64.0; 3]
    })
}

/// Rings whose frequency grows with the radius, up to 0.2 cycles a pixel in the corners: 0.4 in a frame of half the size.
pub fn zone_plate(size: [u32; 2]) -> Image {
    let half = size.map(|side| f64::from(side) / 2.0);
    let k = std::f64::consts::PI * 0.2 / half[0].hypot(half[1]);
    supersampled(size, move |x, y| {
        let squared = (x - half[0]).powi(2) + (y - half[1]).powi(2);
        0.5 + 0.45 * (k * squared).cos()
    })
}

/// Glyphs of 5 x 7 dots, one row a byte.
const GLYPHS: [[u8; 7]; 10] = [
    [0x1e, 0x11, 0x11, 0x1e, 0x14, 0x12, 0x11], // R
    [0x0e, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11], // A
    [0x11, 0x11, 0x0a, 0x04, 0x04, 0x04, 0x04], // Y
    [0x0e, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e], // S
    [0x1f, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04], // T
    [0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11], // K
    [0x0e, 0x11, 0x01, 0x06, 0x08, 0x10, 0x1f], // 2
    [0x0e, 0x11, 0x0e, 0x11, 0x11, 0x11, 0x0e], // 8
    [0x11, 0x1b, 0x15, 0x15, 0x11, 0x11, 0x11], // M
    [0x11, 0x11, 0x11, 0x15, 0x15, 0x1b, 0x11], // W
];

/// Dark glyphs on a light ground, tilted lines of growing size.
pub fn text(size: [u32; 2]) -> Image {
    supersampled(size, |x, y| {
        // 6 degrees.
        let (u, v) = (x * 0.9945 + y * 0.1045 + 8.0, y * 0.9945 - x * 0.1045 + 24.0);
        let (line, dot) = match v {
            v if v < 60.0 => (v / 30.0, 3.0),
            v if v < 100.0 => ((v - 60.0) / 40.0 + 2.0, 4.0),
            v => ((v - 100.0) / 60.0 + 3.0, 6.0),
        };
        let (column, row) = ((u / dot) as usize, (line.fract() * 10.0) as usize);
        let glyph = GLYPHS[(column / 6 + 3 * line as usize) % GLYPHS.len()];
        let ink = column % 6 < 5 && row < 7 && glyph[row] >> (4 - column % 6) & 1 == 1;
        if ink { 0.05 } else { 0.8 }
    })
}

/// A crop of a photographed environment, exposed and compressed by Reinhard's curve.
pub fn natural() -> Image {
    let photo = LinearImage::read(&pt_test_data::shared("environments/royal_esplanade_1k.hdr")).unwrap();
    Image::from_fn([256, 160], |x, y| {
        let c = photo.pixels[((y + 180) * photo.width + x + 300) as usize];
        c.map(|v| f64::from(v) * 0.8 / (1.0 + f64::from(v) * 0.8))
    })
}
