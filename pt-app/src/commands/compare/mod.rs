//! `pt compare` measures an image, or the frames of a sequence, against its reference and checks limits.

mod args;
mod checks;
mod frames;
mod images;
mod motion;
mod pair;
mod report;
mod sequence;

pub use args::{CompareArgs, Limit, MetricName, Region};

use crate::output::check_no_printf;
use anyhow::{Result, bail};
use std::io::Write;

/// Runs the command; true when every limit is kept.
///
/// # Errors
/// Images that cannot be read or compared, a frame that only one sequence has, a region outside, a heat map that cannot be written.
pub fn run(args: &CompareArgs, out: &mut impl Write) -> Result<bool> {
    for path in [&args.a, &args.b].into_iter().filter(|path| !path.exists()) {
        check_no_printf(path)?;
    }
    match [&args.a, &args.b].map(|path| frames::is_sequence(path)) {
        [false, false] => images::run(args, out),
        [true, true] => sequence::run(args, out),
        [a_is_sequence, _] => {
            let (sequence, image) = if a_is_sequence { (&args.a, &args.b) } else { (&args.b, &args.a) };
            bail!(
                "{} is a sequence of frames and {} is not; give two images or two sequences",
                sequence.display(),
                image.display()
            )
        }
    }
}
