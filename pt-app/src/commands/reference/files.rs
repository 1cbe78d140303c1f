//! Files of estimates.

use anyhow::{Result, ensure};
use pt_image::image_file::{OutputFormat, check_output};
use pt_reference::{EstimateFile, denoiser_inputs};
use std::collections::BTreeMap;
use std::path::Path;

/// Checks before any work that an estimate can be written to `path`.
pub fn check_exr(path: &Path) -> Result<()> {
    ensure!(
        check_output(path)? == OutputFormat::Exr,
        "{}: the output is linear radiance with its variance, an .exr",
        path.display()
    );
    Ok(())
}

/// Writes an estimate, and beside it the inputs of a denoiser, unless it is to stay `alone`.
pub fn write(
    path: &Path,
    file: &EstimateFile,
    metadata: BTreeMap<String, String>,
    alone: bool,
) -> Result<()> {
    let mut image = file.to_image()?;
    image.metadata.extend(metadata);
    if !alone {
        for (beside, image) in denoiser_inputs(path, &file.estimate)? {
            if beside != path {
                image.write_exr(&beside)?;
            }
        }
    }
    Ok(image.write_exr(path)?)
}
