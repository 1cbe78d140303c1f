//! A contact sheet: every channel in false colour, side by side.

use pt_core::capture::read_layer;
use pt_core::rng::pcg;
use pt_core::{ChannelImages, Result};
use pt_image::image_file::{Layer, Samples, srgb_encode_8bit};
use pt_image::metrics::colour_map;
use pt_shaders::channels::ChannelId;

/// Most pixels of a tile from left to right.
const TILE: u32 = 320;
/// Pixels between tiles.
const GAP: u32 = 4;

/// Width, height and RGB bytes of the sheet.
pub struct Sheet {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<u8>,
    /// The channels of each row of tiles.
    pub rows: Vec<Vec<String>>,
}

/// The channels in the order of `ids`, in about as many columns as rows; waits for the device.
pub fn contact_sheet(images: &ChannelImages, ids: &[ChannelId]) -> Result<Sheet> {
    let [width, height] = images.size();
    let tile = [width.min(TILE), (height * width.min(TILE)).div_ceil(width).max(1)];
    let columns = (ids.len() as f64).sqrt().ceil().max(1.0) as u32;
    let rows: Vec<Vec<String>> =
        ids.chunks(columns as usize).map(|row| row.iter().map(|id| id.full_name()).collect()).collect();
    let side = |count: u32, pixels: u32| count * (pixels + GAP) + GAP;
    let (sheet_width, sheet_height) = (side(columns, tile[0]), side(rows.len() as u32, tile[1]));
    let mut pixels = vec![32u8; 3 * (sheet_width * sheet_height) as usize];
    for (i, &id) in (0..).zip(ids) {
        let colors = false_colors(&read_layer(images, id)?.0);
        let (left, top) = (GAP + i % columns * (tile[0] + GAP), GAP + i / columns * (tile[1] + GAP));
        for (x, y) in (0..tile[1]).flat_map(|y| (0..tile[0]).map(move |x| (x, y))) {
            let from = (y * height / tile[1] * width + x * width / tile[0]) as usize;
            let to = 3 * ((top + y) * sheet_width + left + x) as usize;
            pixels[to..to + 3].copy_from_slice(&colors[from]);
        }
    }
    Ok(Sheet { width: sheet_width, height: sheet_height, pixels, rows })
}

/// Directions as colours of their axes, numbers of things as colours without order, colours as they are; one number through the colour map
/// and several as red, green and blue, between the 1 % and 99 % quantiles.
fn false_colors(layer: &Layer) -> Vec<[u8; 3]> {
    let find = |name: &str| layer.channels.iter().find(|channel| channel.name == name).map(|c| &c.samples);
    let floats = |name: &str| find(name).filter(|s| !matches!(s, Samples::U32(_))).map(Samples::to_f32);
    let is_direction = find("code").is_some();
    if let [Some(x), Some(y), Some(z)] = ["X", "Y", "Z"].map(floats) {
        let axes = if is_direction {
            [x, y, z].map(|v| v.iter().map(|v| 0.5 + 0.5 * v).collect())
        } else {
            [x, y, z].map(stretched)
        };
        return together(&axes, |v| (255.0 * v).round() as u8);
    }
    if let [Some(r), Some(g), Some(b)] = ["R", "G", "B"].map(floats) {
        return together(&[r, g, b], srgb_encode_8bit);
    }
    if let [Some(x), Some(y)] = ["X", "Y"].map(floats) {
        let black = vec![0.0; x.len()];
        return together(&[stretched(x), stretched(y), black], |v| (255.0 * v).round() as u8);
    }
    if let Some(z) = floats("Z") {
        return stretched(z).into_iter().map(colour_map).collect();
    }
    let words = |samples: &Samples| match samples {
        Samples::U32(words) => words.clone(),
        other => other.to_f32().into_iter().map(f32::to_bits).collect(),
    };
    let mut mixed: Vec<u32> = Vec::new();
    for channel in &layer.channels {
        let words = words(&channel.samples);
        mixed.resize(words.len(), 0);
        mixed.iter_mut().zip(words).for_each(|(hash, word)| *hash = pcg(*hash ^ word));
    }
    mixed.into_iter().map(|hash| [hash as u8, (hash >> 8) as u8, (hash >> 16) as u8]).collect()
}

fn together([r, g, b]: &[Vec<f32>; 3], code: impl Fn(f32) -> u8) -> Vec<[u8; 3]> {
    r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b].map(&code)).collect()
}

/// Values from 0 to 1. The sky, which is farther than everything else, and what is not finite are at the ends.
fn stretched(values: Vec<f32>) -> Vec<f32> {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|v| v.abs() < 1e17).collect();
    sorted.sort_by(f32::total_cmp);
    let quantile =
        |share: f64| sorted.get((share * (sorted.len().max(1) - 1) as f64).round() as usize).copied();
    let (low, high) = (quantile(0.01).unwrap_or(0.0), quantile(0.99).unwrap_or(1.0));
    let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
    values.into_iter().map(|v| if v.is_nan() { 0.0 } else { ((v - low) * scale).clamp(0.0, 1.0) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_stretched_between_their_quantiles() {
        let mut values: Vec<f32> = (0..=100).map(|i| i as f32).collect();
        values.extend([1e18, f32::NAN, f32::NEG_INFINITY]);
        let found = stretched(values);
        assert_eq!((found[0], found[50], found[100]), (0.0, 0.5, 1.0));
        assert_eq!(found[101..], [1.0, 0.0, 0.0]);
        assert_eq!(stretched(vec![3.0; 4]), [0.0; 4]);
        assert!(stretched(Vec::new()).is_empty());
    }

    #[test]
    fn numbers_of_things_have_colours_of_their_own() {
        let layer = |words: Vec<u32>| Layer {
            name: "visibility".into(),
            channels: vec![pt_image::image_file::Channel { name: "x".into(), samples: Samples::U32(words) }],
        };
        let colors = false_colors(&layer(vec![1, 2, 1, u32::MAX]));
        assert!(colors[0] == colors[2] && colors[0] != colors[1] && colors[1] != colors[3]);
    }
}
