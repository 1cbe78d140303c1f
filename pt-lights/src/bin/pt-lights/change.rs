//! How long samplers take to follow a change: the scene stands still at one time, jumps to another, and stands still there.

use super::contestant::{Choice, Contestant};
use super::measure::Plan;
use super::report::{pair, with_scene};
use super::statistics::{Interval, mean, ratio, relmse};
use super::truth::Truth;
use super::view::View;
use anyhow::Result;
use pt_core::Recorder;
use serde_json::{Value, json};
use std::io::Write;

/// A sampler has settled when its error is at most so many times the steady one.
const SETTLED: f64 = 1.1;
/// Frames over which the error is averaged for that.
const WINDOW: usize = 4;

/// The times before and after the change, seconds.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    pub before: f64,
    pub after: f64,
}

impl Change {
    /// Reads `BEFORE:AFTER`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let time = |text: &str| text.trim().parse::<f64>().ok().filter(|time| time.is_finite());
        text.split_once(':')
            .and_then(|(before, after)| Some(Self { before: time(before)?, after: time(after)? }))
            .ok_or_else(|| format!("{text} is not BEFORE:AFTER, two times in seconds"))
    }
}

/// What a sampler did after the change.
pub struct Followed {
    pub choice: Choice,
    /// Light of the first frame after the change over that of the reference.
    pub first_ratio: Interval,
    /// relMSE of that frame.
    pub first: Interval,
    /// relMSE of a frame in the last half of the frames.
    pub steady: Interval,
    /// Frames until the error was within a tenth of that; `None`: it was not.
    pub frames_to_settle: Option<usize>,
    /// relMSE of each frame, mean over the runs.
    pub errors: Vec<f64>,
}

/// Measures all samplers; the scene of the view is at `change.after`.
pub fn follow(
    view: &mut View,
    truth: &Truth,
    mask: &[bool],
    choices: &[Choice],
    plan: &Plan,
    change: Change,
    mut tell: impl FnMut(&str),
) -> Result<Vec<Followed>> {
    let mut results = Vec::new();
    for choice in choices {
        tell(&format!("{}: {} runs of {} frames", choice.name, plan.runs, plan.warm_up + plan.frames));
        let mut contestant = Contestant::new(view, choice, plan.seed)?;
        let mut recorder = Recorder::new(&view.device)?;
        let (mut ratios, mut runs) = (Vec::new(), Vec::new());
        for run in 0..plan.runs {
            contestant.restart(view)?;
            let seed = plan.seed.wrapping_add(1 + run);
            view.set_time(change.before, change.before);
            for index in 0..plan.warm_up {
                contestant.frame(view, &mut recorder, (index, seed), None)?;
            }
            let mut errors = Vec::new();
            for index in 0..plan.frames {
                let previous = if index == 0 { change.before } else { change.after };
                view.set_time(change.after, previous);
                let light = contestant.frame(view, &mut recorder, (plan.warm_up + index, seed), None)?;
                errors.push(relmse(&light, 1.0, truth, mask));
                if index == 0 {
                    ratios.push(ratio(&light, 1.0, truth, mask));
                }
            }
            runs.push(errors);
        }
        let half = plan.frames as usize / 2;
        let steady: Vec<f64> = runs.iter().map(|errors| mean(errors[half..].iter().copied())).collect();
        let errors: Vec<f64> = (0..plan.frames as usize).map(|i| mean(runs.iter().map(|r| r[i]))).collect();
        let steady = Interval::of(&steady);
        results.push(Followed {
            choice: choice.clone(),
            first_ratio: Interval::of(&ratios),
            first: Interval::of(&runs.iter().map(|errors| errors[0]).collect::<Vec<_>>()),
            frames_to_settle: settled(&errors, steady.mean),
            steady,
            errors,
        });
    }
    Ok(results)
}

/// The first frame from which on the error, averaged over a few frames, is near the steady one.
fn settled(errors: &[f64], steady: f64) -> Option<usize> {
    let near = |window: &[f64]| mean(window.iter().copied()) <= SETTLED * steady;
    errors.windows(WINDOW.min(errors.len())).position(near)
}

/// Prints a line for each sampler.
pub fn table(results: &[Followed], plan: &Plan, change: Change, out: &mut impl Write) -> Result<()> {
    let width = results.iter().map(|r| r.choice.name.len()).max().unwrap_or(0).max(14);
    writeln!(
        out,
        "from {} s to {} s after {} frames; {} runs of {} frames; relMSE of a frame with 95 % intervals over the runs",
        change.before, change.after, plan.warm_up, plan.runs, plan.frames
    )?;
    writeln!(
        out,
        "{:<width$} {:>18} {:>12} {:>30} {:>9}",
        "sampler", "first mean / ref.", "first frame", "steady", "settled"
    )?;
    for r in results {
        let half = |i: Interval| 0.5 * (i.high - i.low);
        writeln!(
            out,
            "{:<width$} {:>18} {:>12.3e} {:>30} {:>9}",
            r.choice.name,
            format!("{:.4} +- {:.4}", r.first_ratio.mean, half(r.first_ratio)),
            r.first.mean,
            format!("{:.3e} +- {:.1e}", r.steady.mean, half(r.steady)),
            r.frames_to_settle.map_or("never".into(), |frames| frames.to_string()),
        )?;
    }
    Ok(())
}

/// The same as a table in Markdown, the quickest first.
pub fn markdown(results: &[Followed]) -> String {
    let mut order: Vec<&Followed> = results.iter().collect();
    let settled = |r: &Followed| r.frames_to_settle.unwrap_or(usize::MAX);
    order.sort_by(|a, b| settled(a).cmp(&settled(b)).then(a.steady.mean.total_cmp(&b.steady.mean)));
    let mut text =
        "| sampler | frames until settled | first frame, mean / reference | first frame | steady |\n\
         | --- | --- | --- | --- | --- |\n"
            .to_owned();
    for r in order {
        let half = |i: Interval| 0.5 * (i.high - i.low);
        let row = [
            format!("`{}`", r.choice.name),
            r.frames_to_settle.map_or("never".into(), |frames| frames.to_string()),
            format!("{:.4} ± {:.4}", r.first_ratio.mean, half(r.first_ratio)),
            format!("{:.2e}", r.first.mean),
            format!("{:.2e} ± {:.0} %", r.steady.mean, 100.0 * half(r.steady) / r.steady.mean),
        ];
        text += &format!("| {} |\n", row.join(" | "));
    }
    text
}

/// The rows for a JSON file.
pub fn rows(results: &[Followed], plan: &Plan, change: Change, view: &View) -> Vec<Value> {
    let row = |r: &Followed| {
        let fields = json!({
            "sampler": r.choice.name,
            "before_s": change.before,
            "after_s": change.after,
            "frames_to_settle": r.frames_to_settle,
            "mean_ratio_first_frame": r.first_ratio.mean,
            "mean_ratio_first_frame_ci": pair(r.first_ratio),
            "relmse_first_frame": r.first.mean,
            "relmse_first_frame_ci": pair(r.first),
            "relmse_steady": r.steady.mean,
            "relmse_steady_ci": pair(r.steady),
            "relmse_frames": r.errors,
            "runs": plan.runs,
            "frames": plan.frames,
            "warm_up": plan.warm_up,
        });
        with_scene(view, fields)
    };
    results.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_window_near_the_steady_error_counts() {
        assert_eq!(settled(&[9.0, 5.0, 1.1, 1.0, 1.0, 1.0, 1.0], 1.0), Some(2));
        assert_eq!(settled(&[1.0, 1.2, 0.9, 1.0, 1.0], 1.0), Some(0));
        assert_eq!(settled(&[3.0, 3.0, 3.0, 3.0, 3.0], 1.0), None);
        assert_eq!(settled(&[1.0], 1.0), Some(0));
    }

    #[test]
    fn changes_are_two_times() {
        assert!(Change::parse("0.6:0.85").is_ok_and(|c| (c.before, c.after) == (0.6, 0.85)));
        for wrong in ["1", "1:", "a:2", "1:inf"] {
            assert!(Change::parse(wrong).unwrap_err().contains("BEFORE:AFTER"), "{wrong}");
        }
    }
}
