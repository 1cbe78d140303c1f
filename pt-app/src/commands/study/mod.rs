//! `pt study` runs the cells of a study file, each in this process, and summarizes them.

mod args;
mod dry_run;
mod measure;
mod pictures;
mod plan;
mod runner;
mod summary;
mod truth;
mod turn;
mod views;

pub use args::{MergeArgs, ReportArgs, StudyArgs, StudyCommand};

use crate::interrupt::Interrupt;
use crate::output::check_folder;
use crate::progress::Progress;
use anyhow::Result;
use plan::Plan;
use pt_core::{Device, DeviceOptions};
use pt_image::atomic_file::write_atomic;
use pt_study::folder::{Finished, Folder, read_results, read_study, read_timings};
use pt_study::merge::merge;
use pt_study::report;
use runner::Runner;
use std::io::Write;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// A wrong study file, a folder of something else, files that can't be read or written, a device that can't do it.
pub fn run(args: &StudyArgs, out: &mut impl Write) -> Result<bool> {
    match &args.command {
        Some(StudyCommand::Merge(args)) => {
            let cells = merge(&args.shards, &args.output)?;
            writeln!(out, "{cells} cells joined")?;
            conclude(&args.output, out)?;
        }
        Some(StudyCommand::Report(args)) => {
            if let Some(file) = &args.markdown {
                let (study, cells) = (read_study(&args.folder)?, read_results(&args.folder)?);
                let text = summary::markdown(&study, &cells, &read_timings(&args.folder)?);
                write_atomic(file, text.as_bytes())?;
            }
            if let Some(file) = &args.figure {
                write_atomic(file, report::figure_svg(&args.folder)?.as_bytes())?;
            }
            conclude(&args.folder, out)?;
        }
        None => run_study(args, out)?,
    }
    Ok(true)
}

fn run_study(args: &StudyArgs, out: &mut impl Write) -> Result<()> {
    let plan = Plan::new(args)?;
    if args.dry_run {
        return dry_run::print(&plan, args.output.as_deref(), out);
    }
    let Some(output) = &args.output else { return Ok(()) };
    check_folder(output)?;
    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: args.validation })?;
    let record = plan.record(&device);
    let folder = Folder::open(output, &record, args.resume)?;
    let cells = plan.shard();
    let interrupt = Interrupt::listen()?;
    let cache = args.cache.clone().unwrap_or_else(|| output.join("references"));
    let mut runner = Runner::new(&plan, &device, &cache, output)?;
    let done = cells.iter().filter(|cell| matches!(folder.finished(&cell.name), Ok(Some(_)))).count() as u32;
    let mut progress = Progress::resuming(done, cells.len() as u32, "cell");
    let mut finished: Vec<Finished> = Vec::new();
    for cell in cells {
        if let Some(found) = folder.finished(&cell.name)? {
            finished.push(found);
            continue;
        }
        if interrupt.is_pressed() {
            break;
        }
        let found = runner.run(cell)?;
        folder.keep(&found)?;
        finished.push(found);
        progress.step();
    }
    progress.finish();
    interrupt.report(finished.len() as u32, cells.len() as u32, "cells");
    if finished.len() < cells.len() {
        writeln!(out, "{} of {} cells are done; --resume goes on", finished.len(), cells.len())?;
        return Ok(());
    }
    folder.finish(&finished)?;
    conclude(folder.path(), out)
}

/// Prints the summary, writes the report, and ends with its path.
fn conclude(folder: &Path, out: &mut impl Write) -> Result<()> {
    let (study, cells) = (read_study(folder)?, read_results(folder)?);
    if cells.is_empty() {
        writeln!(out, "no cells: there are more shards than cells")?;
        return Ok(());
    }
    summary::print(&study, &cells, out)?;
    writeln!(out, "{}", report::write(folder)?.display())?;
    Ok(())
}
