//! `pt sheet` puts many images on one sheet, each with its name under it.
//!
//! Images are shrunk to their tile by area averages of linear light, or shown as they are where they are smaller. Scene-linear
//! images (EXR, HDR) are scaled so that the geometric mean of their luminance is 0.18, then x / (1 + x) for each channel.

mod font;

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::inputs::Inputs;
use anyhow::{Context, Result, bail};
use clap::Args;
use pt_image::image_file::{
    ImageSize, ImageState, LinearImage, OutputFormat, PixelLayout, check_output, check_size,
    srgb_encode_8bit, write_png,
};

/// `pt sheet`
#[derive(Clone, Debug, Args)]
pub struct SheetArgs {
    /// PNG, JPEG, EXR or HDR images; a .txt file becomes a tile with its text.
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// Sheet to write.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// Tiles per row [default: the sheet is as square as possible]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub columns: Option<u32>,
    /// Size of a tile without its label, pixels.
    #[arg(long, value_name = "WxH", default_value = "256x192")]
    pub tile: ImageSize,
}

/// Pixels between tiles, and of a line of text.
const GAP: u32 = 4;
const LINE: u32 = font::HEIGHT + 3;
const PAPER: [u8; 3] = [24, 24, 26];
const INK: [u8; 3] = [225, 225, 220];
const WARNING: [u8; 3] = [255, 170, 90];

/// Runs the command.
///
/// # Errors
/// Images that cannot be read, a sheet that is too large or cannot be written.
pub fn run(args: &SheetArgs, out: &mut impl Write) -> Result<bool> {
    if check_output(&args.output)? != OutputFormat::Png {
        bail!("{}: a sheet must be a PNG", args.output.display());
    }
    Inputs::default().with("one of the images", &args.images).check([&args.output])?;
    let [tile_w, tile_h] = args.tile.into();
    let count = args.images.len() as u32;
    let columns = args.columns.unwrap_or_else(|| square_columns(count, tile_w, tile_h)).min(count);
    let rows = count.div_ceil(columns);
    let (cell_w, cell_h) = (tile_w + GAP, tile_h + LINE + GAP);
    let side = |cells: u32, cell: u32| u64::from(cells) * u64::from(cell) + u64::from(GAP);
    check_size(side(columns, cell_w), side(rows, cell_h))?;
    let mut sheet = Sheet::new(columns * cell_w + GAP, rows * cell_h + GAP);
    for (i, path) in args.images.iter().enumerate() {
        let (column, row) = (i as u32 % columns, i as u32 / columns);
        let (x, y) = (GAP + column * cell_w, GAP + row * cell_h);
        if path.extension().is_some_and(|e| e == "txt") {
            let text =
                std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
            sheet.paragraph(x, y, [tile_w, tile_h], &text);
        } else {
            sheet.picture(x, y, [tile_w, tile_h], &LinearImage::read(path)?);
        }
        sheet.line(x, y + tile_h + 2, tile_w, &label(path), INK);
    }
    write_png(&args.output, sheet.width, sheet.height, PixelLayout::Rgb, &sheet.pixels)?;
    writeln!(out, "{}: {count} tiles, {}x{} pixels", args.output.display(), sheet.width, sheet.height)?;
    Ok(true)
}

fn label(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The number of columns that makes the sheet most nearly square.
fn square_columns(count: u32, tile_w: u32, tile_h: u32) -> u32 {
    let uneven = |columns: u32| {
        let (w, h) = (columns * tile_w, count.div_ceil(columns) * tile_h);
        w.max(h)
    };
    (1..=count).min_by_key(|&columns| uneven(columns)).unwrap_or(1)
}

/// RGB pixels, rows from the top.
struct Sheet {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

impl Sheet {
    fn new(width: u32, height: u32) -> Self {
        let pixels = PAPER.iter().copied().cycle().take(3 * width as usize * height as usize).collect();
        Self { width, height, pixels }
    }

    fn set(&mut self, x: u32, y: u32, color: [u8; 3]) {
        let at = 3 * (y as usize * self.width as usize + x as usize);
        self.pixels[at..at + 3].copy_from_slice(&color);
    }

    /// One line of text, cut off at `width` pixels.
    fn line(&mut self, x: u32, y: u32, width: u32, text: &str, color: [u8; 3]) {
        for (i, character) in text.chars().take((width / font::ADVANCE) as usize).enumerate() {
            for (dx, dy) in (0..font::ADVANCE).flat_map(|dx| (0..font::HEIGHT).map(move |dy| (dx, dy))) {
                if font::pixel(character, dx, dy) {
                    self.set(x + i as u32 * font::ADVANCE + dx, y + dy, color);
                }
            }
        }
    }

    /// Text broken between letters, as far as it fits.
    fn paragraph(&mut self, x: u32, y: u32, [width, height]: [u32; 2], text: &str) {
        let text: Vec<char> = text.split_whitespace().collect::<Vec<_>>().join(" ").chars().collect();
        let per_line = (width / font::ADVANCE).max(1) as usize;
        for (i, line) in text.chunks(per_line).take((height / LINE) as usize).enumerate() {
            self.line(x, y + i as u32 * LINE, width, &line.iter().collect::<String>(), WARNING);
        }
    }

    /// A picture in the middle of its tile.
    fn picture(&mut self, x: u32, y: u32, tile: [u32; 2], image: &LinearImage) {
        let shrink = (f64::from(image.width) / f64::from(tile[0]))
            .max(f64::from(image.height) / f64::from(tile[1]))
            .max(1.0);
        let size = [image.width, image.height].map(|n| ((f64::from(n) / shrink).round() as u32).max(1));
        let tone = Tone::of(image);
        let (left, top) =
            (x + (tile[0] - size[0].min(tile[0])) / 2, y + (tile[1] - size[1].min(tile[1])) / 2);
        for (px, py) in
            (0..size[0].min(tile[0])).flat_map(|px| (0..size[1].min(tile[1])).map(move |py| (px, py)))
        {
            let mean = area_mean(image, [px, py], size);
            self.set(left + px, top + py, mean.map(|c| srgb_encode_8bit(tone.apply(c))));
        }
    }
}

/// Mean of the pixels that target pixel `at` of an image of `size` covers, by their covered area.
fn area_mean(image: &LinearImage, at: [u32; 2], size: [u32; 2]) -> [f32; 3] {
    let span = |i: u32, to: u32, from: u32| {
        let scale = f64::from(from) / f64::from(to);
        let (start, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        (start.floor() as u32..(end.ceil() as u32).min(from))
            .map(move |p| (p, end.min(f64::from(p) + 1.0) - start.max(f64::from(p))))
    };
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for (y, wy) in span(at[1], size[1], image.height) {
        for (x, wx) in span(at[0], size[0], image.width) {
            let pixel = image.pixels[y as usize * image.width as usize + x as usize];
            let weight = wx * wy;
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += weight * f64::from(value);
            }
            total += weight;
        }
    }
    sum.map(|s| (s / total) as f32)
}

enum Tone {
    Display,
    Scene { exposure: f32 },
}

impl Tone {
    fn of(image: &LinearImage) -> Self {
        if image.state == ImageState::DisplayReferred {
            return Self::Display;
        }
        let luminance = |p: &[f32; 3]| f64::from(0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]);
        let lit = image.pixels.iter().map(luminance).filter(|l| l.is_finite() && *l > 1e-6);
        let (sum, count) = lit.fold((0.0, 0u32), |(sum, count), l| (sum + l.ln(), count + 1));
        let mean = if count > 0 { (sum / f64::from(count)).exp() } else { 1.0 };
        Self::Scene { exposure: (0.18 / mean) as f32 }
    }

    fn apply(&self, value: f32) -> f32 {
        match self {
            Self::Display => value,
            Self::Scene { exposure } => {
                let x = (exposure * value).max(0.0);
                if x.is_finite() { x / (1.0 + x) } else { 1.0 }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_make_sheets_nearly_square() {
        assert_eq!(square_columns(46, 256, 192), 6);
        assert_eq!(square_columns(1, 256, 192), 1);
    }

    #[test]
    fn shrinking_keeps_the_mean() {
        let pixels = (0..70u32).map(|i| [i as f32, 1.0, (i % 7) as f32]).collect();
        let image = LinearImage { width: 10, height: 7, pixels, state: ImageState::DisplayReferred };
        let mut sum = [0.0; 3];
        for (x, y) in (0..3).flat_map(|x| (0..2).map(move |y| (x, y))) {
            let mean = area_mean(&image, [x, y], [3, 2]);
            sum.iter_mut().zip(mean).for_each(|(s, m)| *s += m / 6.0);
        }
        assert!(
            (sum[0] - 34.5).abs() < 1e-4 && (sum[1] - 1.0).abs() < 1e-6 && (sum[2] - 3.0).abs() < 1e-4,
            "{sum:?}"
        );
    }

    #[test]
    fn letters_differ() {
        let shape = |c: char| -> Vec<bool> {
            (0..font::HEIGHT).flat_map(|y| (0..font::ADVANCE).map(move |x| font::pixel(c, x, y))).collect()
        };
        let all: Vec<char> = (' '..='~').collect();
        for (i, &a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|&b| shape(a) != shape(b)), "{a} looks like another letter");
            assert!((0..font::HEIGHT).all(|y| !font::pixel(a, 5, y)), "{a} touches the next letter");
        }
        assert_eq!(shape('\u{e9}'), shape('?'));
    }
}
