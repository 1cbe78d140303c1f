//! `pt merge` joins slices of one render of `pt reference`.

use super::reference::files::{check_exr, write};
use crate::inputs::Inputs;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use pt_core::capture::keys;
use pt_image::image_file::LayeredImage;
use pt_reference::{Estimate, EstimateFile};
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// `pt merge`
#[derive(Clone, Debug, Args)]
pub struct MergeArgs {
    /// Files of `pt reference` with disjoint ranges of samples of one render.
    #[arg(required = true, value_name = "A.exr")]
    pub inputs: Vec<PathBuf>,
    /// Image to write, in the format of `pt reference`.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Write only OUT.exr.
    #[arg(long)]
    pub no_aov: bool,
}

/// Runs the command.
///
/// # Errors
/// Files that are not estimates, that belong to different renders, or that share samples.
pub fn run(args: &MergeArgs, out: &mut impl Write) -> Result<bool> {
    check_exr(&args.output)?;
    Inputs::default().with("one of the slices", &args.inputs).check([&args.output])?;
    let mut files: Vec<(&Path, EstimateFile)> = Vec::new();
    for path in &args.inputs {
        files.push((path, EstimateFile::read(path)?));
    }
    let (first_path, first) = &files[0];
    for (path, file) in &files[1..] {
        if let Some(difference) = file.identity.difference(&first.identity) {
            bail!("{} and {} are of different renders: {difference}", path.display(), first_path.display());
        }
    }
    let mut ranges: Vec<_> = files
        .iter()
        .flat_map(|(path, file)| file.ranges.iter().map(move |range| (range.clone(), *path)))
        .collect();
    ranges.sort_by_key(|(range, _)| (range.start, range.end));
    for pair in ranges.windows(2) {
        let [(a, in_a), (b, in_b)] = pair else { continue };
        ensure!(
            a.end <= b.start,
            "{} and {} have samples in common: {}..{} and {}..{}",
            in_a.display(),
            in_b.display(),
            a.start,
            a.end,
            b.start,
            b.end
        );
    }
    let (background, identity) = (first.background, first.identity.clone());
    let mut joined: Vec<Range<u32>> = Vec::new();
    for (range, _) in ranges {
        match joined.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => joined.push(range),
        }
    }
    let parts: Vec<Estimate> = files.into_iter().map(|(_, file)| file.estimate).collect();
    let estimate = Estimate::merge(&parts).context("cannot merge")?;
    let file = EstimateFile { estimate, ranges: joined, background, identity };
    // Of one render, so that they show the same.
    let mut metadata = LayeredImage::read_metadata(&args.inputs[0]);
    metadata
        .retain(|key, _| [keys::SCENE, keys::CAMERA, keys::ENVIRONMENT, keys::LIGHT].contains(&key.as_str()));
    write(&args.output, &file, metadata, args.no_aov)?;
    writeln!(
        out,
        "{}: {} files, {} samples a pixel, relative error {:.4}",
        args.output.display(),
        parts.len(),
        file.estimate.samples,
        file.estimate.relative_error()
    )?;
    Ok(true)
}
