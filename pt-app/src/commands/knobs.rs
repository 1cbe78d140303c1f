//! `pt knobs` lists everything that `--set` takes.

use crate::params::all_knobs;
use anyhow::{Result, ensure};
use clap::Args;
use pt_core::settings::{Knob, close_to};
use std::io::Write;

/// `pt knobs`
#[derive(Clone, Debug, Args)]
pub struct KnobsArgs {
    /// Only the knobs of this stage or table, or this knob.
    pub stage: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// A stage that has no knobs, standard output that cannot be written.
pub fn run(args: &KnobsArgs, out: &mut impl Write) -> Result<bool> {
    let mut knobs = all_knobs();
    if let Some(stage) = &args.stage {
        let mut stages: Vec<_> = knobs.iter().map(|knob| stage_of(knob).to_owned()).collect();
        stages.dedup();
        let known = stages.iter().map(String::as_str).chain(knobs.iter().map(|knob| knob.key.as_str()));
        let hint = close_to(stage, known);
        knobs.retain(|knob| knob.key == *stage || knob.key.starts_with(&format!("{stage}.")));
        ensure!(
            !knobs.is_empty(),
            "{stage}: no stage with knobs and no knob{hint} (the stages are {})",
            stages.join(", ")
        );
    }
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&knobs)?)?;
        return Ok(true);
    }
    for knob in &knobs {
        writeln!(out, "{} = {}  [{}]", knob.key, knob.default_text(), knob.takes())?;
        writeln!(out, "    {}", knob.description())?;
    }
    Ok(true)
}

fn stage_of(knob: &Knob) -> &str {
    knob.key.split('.').next().unwrap_or_default()
}
