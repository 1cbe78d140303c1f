//! The pictures of a cell: frame and reference, tone-mapped alike, and the error in false colour.

use super::measure::Shot;
use anyhow::{Context, Result};
use pt_image::image_file::{PixelLayout, write_png};
use pt_image::metrics::{Metric, compare, display_values, heatmap};
use pt_study::cell::Cell;
use std::collections::BTreeMap;
use std::path::Path;

/// Writes the pictures into `folder`/images; returns their paths in the folder. Frames with values that are no light have none.
///
/// # Errors
/// When a file cannot be written.
pub fn write(folder: &Path, cell: &Cell, shot: &Shot) -> Result<BTreeMap<String, String>> {
    let images = folder.join("images");
    std::fs::create_dir_all(&images).with_context(|| format!("{}: cannot be made", images.display()))?;
    let truth = &*shot.truth.image;
    let mut paths = BTreeMap::new();
    let Ok(flip) = compare(&shot.image, truth, &[Metric::Flip]) else { return Ok(paths) };
    let bytes = |pixels: &[[f32; 3]]| -> Vec<u8> {
        pixels.iter().flatten().map(|value| (value * 255.0).round() as u8).collect()
    };
    let (picture, reference) = display_values(&shot.image, truth);
    let errors = flip.first().map(|found| heatmap(&found.map, 1.0)).unwrap_or_default();
    for (what, name, pixels) in [
        ("picture", format!("{}.png", cell.name), bytes(&picture)),
        ("reference", format!("reference-{}.png", shot.truth.key), bytes(&reference)),
        ("error", format!("{}-flip.png", cell.name), errors),
    ] {
        write_png(&images.join(&name), truth.width, truth.height, PixelLayout::Rgb, &pixels)?;
        paths.insert(what.to_owned(), format!("images/{name}"));
    }
    Ok(paths)
}
