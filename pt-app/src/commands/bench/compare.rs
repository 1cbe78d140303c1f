//! `pt bench compare` says whether passes have become slower.

use super::frame::file::{BenchFile, PassRecord, Times};
use crate::args::values::not_negative;
use crate::inputs::Inputs;
use anyhow::{Result, ensure};
use clap::Args;
use pt_core::console::print_warning;
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_study::paired_times::{Change, LEAST_ROUNDS, Threshold, Verdict, judge};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};

/// `pt bench compare`
#[derive(Clone, Debug, Args)]
#[command(after_help = METHOD)]
pub struct CompareArgs {
    /// File of `pt bench frame`, `stage` or `all`: before.
    #[arg(value_name = "A.json")]
    pub before: PathBuf,
    /// File of the same benchmark: after.
    #[arg(value_name = "B.json")]
    pub after: PathBuf,
    /// Changes of at most this many per cent are no regression. Two runs of one program differ by less on an undisturbed GPU.
    #[arg(long, value_name = "PCT", default_value_t = 2.0, value_parser = not_negative)]
    pub threshold: f32,
    /// Changes of at most this many milliseconds are no regression: the clock and the launch of a pass leave as much uncertain.
    #[arg(long, value_name = "MS", default_value_t = 0.001, value_parser = not_negative)]
    pub least_ms: f32,
    /// Also write the rows to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
}

const METHOD: &str = "\
The median of each round of A is compared with that of the same round of B: frames of a round are correlated, rounds hardly. \
The interval is that of the trimmed mean of the logarithms of the ratios, at an error rate of 5 % for all passes together (Holm). \
Of files with several runs (--append) each run is one sample.

Exit codes: 0 no regression, 1 a regression, 2 files that do not fit together.";

/// A line of the comparison.
struct Row {
    part: String,
    pass: String,
    change: Change,
}

/// Runs the command; false if there is a regression.
///
/// # Errors
/// Files that can't be read, that are of other benchmarks, or that have too few rounds.
pub fn run(args: &CompareArgs, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.json {
        Inputs::default().with("one of the benchmarks", [&args.before, &args.after]).check([path])?;
        check_writable(path)?;
    }
    let (before, after) = (BenchFile::read(&args.before)?, BenchFile::read(&args.after)?);
    check_fit((&args.before, &before), (&args.after, &after))?;
    let mut rows = Vec::new();
    let mut left_out = Vec::new();
    for part in 0..before.parts.len() {
        compare_part(&before, &after, part, &mut rows, &mut left_out);
    }
    ensure!(!rows.is_empty(), "the files have no times in common");
    let threshold = Threshold { share: f64::from(args.threshold) / 100.0, ms: f64::from(args.least_ms) };
    let changes: Vec<_> = rows.iter().map(|row| row.change).collect();
    let verdicts = judge(&changes, threshold);

    writeln!(out, "before: {}\nafter:  {}", before.command, after.command)?;
    writeln!(
        out,
        "{}, {}x{}, {} rounds of {} frames in {} of each, {} ({})",
        before.scene,
        before.size[0],
        before.size[1],
        before.rounds.iter().sum::<u32>(),
        before.frames,
        match before.rounds.len() {
            1 => "1 run".to_owned(),
            several => format!("{several} runs"),
        },
        before.device,
        before.driver
    )?;
    let width = rows.iter().map(|row| row.pass.chars().count()).max().unwrap_or(0).max(5);
    writeln!(
        out,
        "{:<12}  {:<width$}  {:>10}  {:>10}  {:>10}  {:>24}",
        "part", "pass", "before ms", "after ms", "change", "interval"
    )?;
    let percent = |ratio: f64| format!("{:+.2} %", 100.0 * (ratio - 1.0));
    for (row, (verdict, [low, high])) in rows.iter().zip(&verdicts) {
        let Row { part, pass, change } = row;
        writeln!(
            out,
            "{part:<12}  {pass:<width$}  {:>10.4}  {:>10.4}  {:>10}  {:>24}  {}",
            change.median_ms[0],
            change.median_ms[1],
            percent(change.ratio()),
            format!("{} to {}", percent(*low), percent(*high)),
            words(*verdict)
        )?;
    }
    for pass in &left_out {
        print_warning(pass);
    }
    let regressions: Vec<_> = rows
        .iter()
        .zip(&verdicts)
        .filter(|(_, (verdict, _))| *verdict == Verdict::Regression)
        .map(
            |(row, _)| {
                if row.part == row.pass { row.pass.clone() } else { format!("{} ({})", row.pass, row.part) }
            },
        )
        .collect();
    match regressions.as_slice() {
        [] => writeln!(out, "no regression of more than {} %", args.threshold)?,
        some => writeln!(out, "slower by more than {} %: {}", args.threshold, some.join(", "))?,
    }
    if let Some(path) = &args.json {
        let rows: Vec<_> = rows
            .iter()
            .zip(&verdicts)
            .map(|(Row { part, pass, change }, (verdict, interval))| {
                json!({
                    "part": part, "pass": pass, "before_ms": change.median_ms[0], "after_ms": change.median_ms[1],
                    "ratio": change.ratio(), "interval": interval, "p_value": change.p_value(), "verdict": words(*verdict),
                })
            })
            .collect();
        let document = json!({
            "before": before.command, "after": after.command, "threshold_percent": args.threshold,
            "least_ms": args.least_ms, "regressions": regressions, "not_compared": left_out, "rows": rows,
        });
        write_atomic(path, serde_json::to_string_pretty(&document)?.as_bytes())?;
    }
    Ok(regressions.is_empty())
}

fn words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Regression => "regression",
        Verdict::Improvement => "improvement",
        Verdict::BelowThreshold => "below the threshold",
        Verdict::NotShown => "no difference shown",
    }
}

/// Rows of a part: its passes, then all of it. A pass that can't be compared is named in `left_out`.
fn compare_part(a: &BenchFile, b: &BenchFile, part: usize, rows: &mut Vec<Row>, left_out: &mut Vec<String>) {
    let (before, after) = (&a.parts[part], &b.parts[part]);
    let is_in = |pass: &PassRecord, passes: &[PassRecord]| passes.iter().any(|there| there.pass == pass.pass);
    let part = &before.name;
    let mut add =
        |pass: &str, before: &Times, after: &Times| match Change::of(&a.batches(before), &b.batches(after)) {
            Some(change) => rows.push(Row { part: part.clone(), pass: pass.into(), change }),
            None => left_out.push(format!("{pass}: too few times above 0 to compare")),
        };
    for pass in &before.passes {
        if let Some(there) = after.passes.iter().find(|there| there.pass == pass.pass) {
            add(&pass.pass, &pass.time, &there.time);
        }
    }
    add(&before.name, &before.time, &after.time);
    let alone = before.passes.iter().filter(|pass| !is_in(pass, &after.passes)).map(|pass| (pass, "after"));
    let new = after.passes.iter().filter(|pass| !is_in(pass, &before.passes)).map(|pass| (pass, "before"));
    left_out.extend(alone.chain(new).map(|(pass, where_not)| {
        format!("{}: the run {where_not} has no such pass, it is not compared", pass.pass)
    }));
}

/// Refuses files that are not of one benchmark.
fn check_fit((path_a, a): (&Path, &BenchFile), (path_b, b): (&Path, &BenchFile)) -> Result<()> {
    let names = format!("{} and {}", path_a.display(), path_b.display());
    let difference = a.difference(b).or_else(|| {
        let runs = |file: &BenchFile| match file.rounds[..] {
            [rounds] => format!("{rounds} rounds of a run"),
            ref several => format!("{} runs", several.len()),
        };
        (runs(a) != runs(b)).then(|| format!("they hold {} and {}", runs(a), runs(b)))
    });
    ensure!(difference.is_none(), "{names} do not fit together: {}", difference.unwrap_or_default());
    let (count, what) = match a.rounds[..] {
        [rounds] => (rounds as usize, "rounds (--rounds)"),
        ref several => (several.len(), "runs (--append)"),
    };
    ensure!(count >= LEAST_ROUNDS, "{names} hold {count} {what}; an interval needs at least {LEAST_ROUNDS}");
    if a.driver != b.driver {
        print_warning(&format!("the drivers differ: {} and {}", a.driver, b.driver));
    }
    Ok(())
}
