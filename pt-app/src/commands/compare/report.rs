//! What the text and the JSON of two images and of two sequences have in common.

use super::args::CompareArgs;
use super::checks::Checks;
use anyhow::Result;
use pt_image::metrics::DISPLAY_TRANSFORM;
use serde_json::{Value, json};
use std::io::Write;

/// Prints the names, the number of frames of a sequence, and the size of what is compared, pixels.
///
/// # Errors
/// When `out` cannot be written.
pub fn print_heading(
    args: &CompareArgs,
    frames: Option<usize>,
    [width, height]: [u32; 2],
    out: &mut impl Write,
) -> Result<()> {
    writeln!(out, "a (image)     {}", args.a.display())?;
    writeln!(out, "b (reference) {}", args.b.display())?;
    if let Some(frames) = frames {
        write!(out, "frames: {frames}, ")?;
    }
    match args.region {
        None => writeln!(out, "{width}x{height} pixels")?,
        Some(region) => writeln!(out, "{width}x{height} pixels from {},{}", region.x, region.y)?,
    }
    Ok(())
}

/// The JSON: the fields of both kinds, and `own` ones of this kind.
pub fn document<const N: usize>(
    args: &CompareArgs,
    [width, height]: [u32; 2],
    checks: &Checks,
    own: [(&str, Value); N],
) -> Value {
    let mut document = json!({
        "a": args.a.display().to_string(),
        "b": args.b.display().to_string(),
        "width": width,
        "height": height,
        "region": args.region.map(|region| [region.x, region.y, region.width, region.height]),
        "display_values": DISPLAY_TRANSFORM,
        "passed": checks.passed(),
        "checks": checks.json(),
    });
    for (key, value) in own {
        document[key] = value;
    }
    document
}
