//! Pictures of the results.

use super::measure::Measured;
use super::truth::Truth;
use anyhow::{Context, Result};
use pt_image::image_file::{self, PixelLayout};
use pt_image::metrics::{RELMSE_EPSILON, heatmap};
use std::path::Path;

/// Largest relative error of the colour scale.
const TOP: f32 = 1.0;

/// Writes for each sampler the mean of its runs (`SAMPLER.png`, shown as sRGB without tone mapping) and the relative error of a run in
/// false colour (`SAMPLER-error.png`, from 0 to 1).
pub fn write(results: &[Measured], truth: &Truth, size: [u32; 2], folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))?;
    for m in results {
        let relative = m
            .error
            .iter()
            .zip(&truth.mean)
            .map(|(error, mean)| (error / (mean.length_squared() / 3.0 + RELMSE_EPSILON).sqrt()) as f32);
        let colours = heatmap(&relative.collect::<Vec<_>>(), TOP);
        let shown: Vec<u8> = m
            .picture
            .iter()
            .flat_map(|p| p.to_array().map(|c| image_file::srgb_encode_8bit(c as f32)))
            .collect();
        for (name, bytes) in
            [(file_name(&m.choice.name), shown), (format!("{}-error", file_name(&m.choice.name)), colours)]
        {
            image_file::write_png(
                &folder.join(format!("{name}.png")),
                size[0],
                size[1],
                PixelLayout::Rgb,
                &bytes,
            )?;
        }
    }
    Ok(())
}

/// The name of an entry, without the signs between its knobs.
fn file_name(entry: &str) -> String {
    entry.replace([':', '=', '/', '\\'], "_")
}
