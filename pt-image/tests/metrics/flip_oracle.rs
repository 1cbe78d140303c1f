//! FLIP as the papers define it, in plain loops: filters are two-dimensional sums in f64, nothing is separated, and the
//! tone mapper is inverted by bisection.

use std::f64::consts::PI;

/// Rows of `width` pixels of linear RGB.
pub struct Image {
    pub width: usize,
    pub pixels: Vec<[f64; 3]>,
}

impl Image {
    pub fn new(width: usize, pixels: &[[f32; 3]]) -> Self {
        Self { width, pixels: pixels.iter().map(|pixel| pixel.map(f64::from)).collect() }
    }

    fn map(&self, f: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        Self { width: self.width, pixels: self.pixels.iter().map(|&pixel| f(pixel)).collect() }
    }

    /// Sum over the square of `radius` round pixel `at` of channel x weight(dx, dy), the nearest pixel beyond borders.
    fn filter(&self, at: usize, channel: usize, radius: i64, weight: impl Fn(f64, f64) -> f64) -> f64 {
        let (width, height) = (self.width as i64, (self.pixels.len() / self.width) as i64);
        let (x, y) = (at as i64 % width, at as i64 / width);
        let mut sum = 0.0;
        for dy in -radius..=radius {
            for dx in -radius..=radius {
                let (x, y) = ((x + dx).clamp(0, width - 1), (y + dy).clamp(0, height - 1));
                sum += self.pixels[(y * width + x) as usize][channel] * weight(dx as f64, dy as f64);
            }
        }
        sum
    }
}

/// Sum of the weights over the square, of those that `keep` admits.
fn total(radius: i64, weight: impl Fn(f64, f64) -> f64, keep: impl Fn(f64) -> bool) -> f64 {
    let offsets = || (-radius..=radius).map(|offset| offset as f64);
    let weights = offsets().flat_map(|y| offsets().map(move |x| (x, y))).map(|(x, y)| weight(x, y));
    weights.filter(|&weight| keep(weight)).sum()
}

const XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

fn multiply(rows: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// X/Xn, Y/Yn, Z/Zn for the white of the display.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (multiply(XYZ, rgb), multiply(XYZ, [1.0; 3]));
    [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]]
}

/// By Cramer's rule.
fn rgb_of_relative(relative: [f64; 3]) -> [f64; 3] {
    let white = multiply(XYZ, [1.0; 3]);
    let xyz = [relative[0] * white[0], relative[1] * white[1], relative[2] * white[2]];
    let det = |m: [[f64; 3]; 3]| -> f64 {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    [0, 1, 2].map(|column| {
        let mut replaced = XYZ;
        for row in 0..3 {
            replaced[row][column] = xyz[row];
        }
        det(replaced) / det(XYZ)
    })
}

fn ycxcz(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn rgb_of_ycxcz([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    rgb_of_relative([cx / 500.0 + y, y, y - cz / 200.0])
}

fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    let f = |t: f64| {
        if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t * (29.0f64 / 6.0).powi(2) / 3.0 + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz(rgb).map(f);
    let (l, a, b) = (116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z));
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// The colour error of two colours: HyAB distance to the power 0.7, remapped so that 0.4 of the largest (green against
/// blue) becomes 0.95.
pub fn colour_error(a: [f64; 3], b: [f64; 3]) -> f64 {
    let hyab = |a: [f64; 3], b: [f64; 3]| {
        let (a, b) = (hunt_lab(a), hunt_lab(b));
        ((a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()).powf(0.7)
    };
    let largest = hyab([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let (knee, value) = (0.4 * largest, hyab(a, b));
    if value < knee { value * 0.95 / knee } else { 0.95 + (value - knee) / (largest - knee) * 0.05 }
}

/// Colours as resolved by the eye: contrast sensitivity filters in YCxCz, then clamped linear RGB.
fn resolved(image: &Image, ppd: f64) -> Vec<[f64; 3]> {
    let channels = image.map(ycxcz);
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i64;
    let gaussian = |a: f64, b: f64, x: f64, y: f64| {
        a * (PI / b).sqrt() * (-PI * PI * (x * x + y * y) / (ppd * ppd) / b).exp()
    };
    let filters: [&dyn Fn(f64, f64) -> f64; 3] =
        [&|x, y| gaussian(1.0, 0.0047, x, y), &|x, y| gaussian(1.0, 0.0053, x, y), &|x, y| {
            gaussian(34.1, 0.04, x, y) + gaussian(13.5, 0.025, x, y)
        }];
    let totals = filters.map(|filter| total(radius, filter, |_| true));
    (0..image.pixels.len())
        .map(|at| {
            let filtered = [0, 1, 2].map(|c| channels.filter(at, c, radius, filters[c]) / totals[c]);
            rgb_of_ycxcz(filtered).map(|value| value.clamp(0.0, 1.0))
        })
        .collect()
}

/// Magnitude of edges and points of each pixel.
fn features(image: &Image, ppd: f64) -> Vec<[f64; 2]> {
    let grey = image.map(|rgb| [(ycxcz(rgb)[0] + 16.0) / 116.0, 0.0, 0.0]);
    let sigma = 0.5 * 0.082 * ppd;
    let radius = (3.0 * sigma).ceil() as i64;
    let gaussian = |x: f64, y: f64| (-(x * x + y * y) / (2.0 * sigma * sigma)).exp();
    let magnitudes = |kernel: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let positive = total(radius, kernel, |weight| weight > 0.0);
        let negative = -total(radius, kernel, |weight| weight < 0.0);
        let normalised = |x: f64, y: f64| {
            let weight = kernel(x, y);
            weight / if weight > 0.0 { positive } else { negative }
        };
        let filtered = |at: usize| {
            let x = grey.filter(at, 0, radius, normalised);
            let y = grey.filter(at, 0, radius, |x, y| normalised(y, x));
            (x * x + y * y).sqrt()
        };
        (0..image.pixels.len()).map(filtered).collect()
    };
    let edges = magnitudes(&|x, y| -x * gaussian(x, y));
    let points = magnitudes(&|x, y| (x * x / (sigma * sigma) - 1.0) * gaussian(x, y));
    edges.into_iter().zip(points).map(|(edge, point)| [edge, point]).collect()
}

/// LDR FLIP of linear display values.
pub fn ldr_flip(reference: &Image, test: &Image, ppd: f64) -> Vec<f64> {
    let (colours_a, colours_b) = (resolved(reference, ppd), resolved(test, ppd));
    let (features_a, features_b) = (features(reference, ppd), features(test, ppd));
    let error = |at: usize| {
        let colour = colour_error(colours_a[at], colours_b[at]);
        let difference = |kind: usize| (features_a[at][kind] - features_b[at][kind]).abs();
        let feature = (difference(0).max(difference(1)) / 2.0f64.sqrt()).sqrt();
        colour.powf(1.0 - feature)
    };
    (0..reference.pixels.len()).map(error).collect()
}

fn aces(x: f64) -> f64 {
    let x = 0.6 * x;
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// First and last exposure in stops, and their number.
pub fn exposures(reference: &Image) -> (f64, f64, usize) {
    let mut luminances: Vec<f64> =
        reference.pixels.iter().map(|p| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]).collect();
    luminances.sort_by(f64::total_cmp);
    let median = luminances[luminances.len() / 2].max(2.0f64.powi(-23));
    let largest = luminances.last().unwrap().max(median);
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if aces(middle) < 0.85 { low = middle } else { high = middle }
    }
    let (start, stop) = ((low / largest).log2(), (low / median).log2());
    (start, stop, ((stop - start).ceil() as usize).max(2))
}

/// HDR FLIP.
pub fn hdr_flip(reference: &Image, test: &Image, ppd: f64) -> Vec<f64> {
    let (start, stop, count) = exposures(reference);
    let mut largest = vec![0.0f64; reference.pixels.len()];
    for index in 0..count {
        let exposure = start + (stop - start) * index as f64 / (count - 1) as f64;
        let shown = |image: &Image| image.map(|pixel| pixel.map(|value| aces(2.0f64.powf(exposure) * value)));
        for (largest, error) in largest.iter_mut().zip(ldr_flip(&shown(reference), &shown(test), ppd)) {
            *largest = largest.max(error);
        }
    }
    largest
}
