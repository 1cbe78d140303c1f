//! An image with its reference: reading, what to warn about, measuring.

use super::args::{CompareArgs, Region};
use crate::origin::differences;
use anyhow::{Context, Result};
use pt_core::console::print_warning;
use pt_image::image_file::{ImageState, LinearImage, PictureFile};
use pt_image::metrics::{Measurement, Metric, VARIANCE_LAYER, Variances, compare_estimates, variance_layer};
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

/// An image with its reference, cut to the region.
pub struct Pair {
    /// The image.
    pub a: LinearImage,
    /// Its reference.
    pub b: LinearImage,
    /// Size of the whole image, pixels.
    pub whole: [u32; 2],
    /// The metrics of the pair, in the order asked for.
    pub measured: Vec<Measurement>,
}

/// Warnings that were printed: those of one kind are printed once, for the first images that they are of.
#[derive(Default)]
pub struct Warned(HashSet<String>);

impl Warned {
    fn warn(&mut self, kind: &str, message: &str) {
        if self.0.insert(kind.into()) {
            print_warning(message);
        }
    }
}

/// Reads an image and its reference.
///
/// # Errors
/// Images that cannot be read.
pub fn read([a, b]: [&Path; 2], warned: &mut Warned) -> Result<[PictureFile; 2]> {
    let mut read = |path: &Path| {
        let file = PictureFile::read(path)?;
        for notice in &file.notices {
            warned.warn(notice, &format!("{}: {notice}", path.display()));
        }
        anyhow::Ok(file)
    };
    Ok([read(a)?, read(b)?])
}

/// Measures an image and its reference, which were read from the paths.
///
/// # Errors
/// Images that cannot be compared, a region outside.
pub fn measure(
    [a, b]: [&Path; 2],
    files: [PictureFile; 2],
    metrics: &[Metric],
    args: &CompareArgs,
    warned: &mut Warned,
) -> Result<Pair> {
    let variances = match metrics.iter().any(|metric| metric.uses_variances()) {
        true => Some([variance(args.region, a, &files[0])?, variance(args.region, b, &files[1])?]),
        false => None,
    };
    warn_about_states([a, b], &files, warned);
    warn_about_origins([a, b], &files, warned);
    let [of_a, of_b] = files.map(|file| file.picture);
    let whole = [of_a.width, of_a.height];
    let (of_a, of_b) = (cut(of_a, args.region, a)?, cut(of_b, args.region, b)?);
    if variances.is_some() && of_a.pixels == of_b.pixels {
        warned.warn("equal", "the images are equal, as estimates of one seed are: z-test tests nothing");
    }
    let variances = variances.as_ref().map(|[a, b]| Variances { a, b });
    let measured = compare_estimates(&of_a, &of_b, variances, metrics)
        .with_context(|| format!("cannot compare {} with {}", a.display(), b.display()))?;
    Ok(Pair { a: of_a, b: of_b, whole, measured })
}

/// A scene against a display has no common scale; FLIP, PSNR and SSIM bring both to display values, which may be wanted.
fn warn_about_states([a, b]: [&Path; 2], files: &[PictureFile; 2], warned: &mut Warned) {
    let [of_a, of_b] = files.each_ref().map(|file| file.picture.state);
    if of_a != of_b {
        let name = |state| match state {
            ImageState::SceneReferred => "scene-referred",
            ImageState::DisplayReferred => "display-referred",
        };
        let message = format!(
            "{} is {} and {} is {}: only psnr, ssim and flip compare values of one meaning",
            a.display(),
            name(of_a),
            b.display(),
            name(of_b)
        );
        warned.warn("states", &message);
    }
}

/// Images of different cameras, environments or light differ by more than their noise.
fn warn_about_origins(paths: [&Path; 2], files: &[PictureFile; 2], warned: &mut Warned) {
    let none = BTreeMap::new();
    let [a, b] = paths.map(|path| path.display().to_string());
    let [of_a, of_b] =
        files.each_ref().map(|file| file.layers.as_ref().map_or(&none, |layers| &layers.metadata));
    let found = differences((&a, of_a), (&b, of_b));
    if !found.is_empty() && warned.0.insert("origins".into()) {
        found.iter().for_each(|difference| print_warning(difference));
    }
}

/// The variances of a Monte Carlo estimate, in the same rectangle.
fn variance(region: Option<Region>, path: &Path, file: &PictureFile) -> Result<LinearImage> {
    let image = file.layers.as_ref().and_then(variance_layer).with_context(|| {
        format!(
            "z-test needs the variances of both images: {} is no EXR with channels R, G, B in a layer {VARIANCE_LAYER:?}",
            path.display()
        )
    })?;
    cut(image, region, path)
}

fn cut(image: LinearImage, region: Option<Region>, path: &Path) -> Result<LinearImage> {
    let Some(Region { x, y, width, height }) = region else {
        return Ok(image);
    };
    image.crop(x, y, width, height).with_context(|| {
        format!(
            "region {x},{y},{width},{height} reaches outside {} ({}x{} pixels)",
            path.display(),
            image.width,
            image.height
        )
    })
}
