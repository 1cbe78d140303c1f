//! Where the results come from: device, revision, knobs, commands, times of passes.

use super::input::Results;
use super::number::significant;
use super::table::{Datum, Table};
use crate::record::StudyRecord;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rows of the table of commands; the file of results has all.
const MOST_COMMANDS: usize = 2000;

/// Something known about the study.
#[derive(Serialize)]
pub struct Fact {
    pub name: &'static str,
    pub value: String,
}

pub fn facts(results: &Results) -> Vec<Fact> {
    let study = &results.study;
    let known = |text: &str| if text.is_empty() { "not known".into() } else { text.to_owned() };
    let done = results.cells.len();
    let cells = if done < study.cells { format!("{done} of {}", study.cells) } else { done.to_string() };
    let mut seeds: Vec<u64> = results.cells.iter().map(|cell| cell.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let mut facts = vec![
        Fact { name: "Program", value: format!("pt {}", study.version) },
        Fact { name: "Git revision", value: known(&study.revision) },
        Fact { name: "Device", value: known(&study.device) },
        Fact { name: "Driver", value: known(&study.driver) },
        Fact { name: "Baseline", value: study.baseline.clone() },
        Fact { name: "Variants", value: study.variants.len().to_string() },
        Fact { name: "Seeds", value: seeds.len().to_string() },
        Fact { name: "Cells", value: cells },
    ];
    if !results.timings.is_empty() {
        let seconds: f64 = results.timings.values().map(|timing| timing.wall_s).sum();
        facts.push(Fact { name: "Time of all cells", value: format!("{} s", significant(seconds, 3)) });
    }
    facts
}

/// What each variant sets.
pub fn knobs(study: &StudyRecord) -> Table {
    let axes = study.axes.iter().map(|axis| axis.name.as_str());
    let mut table = Table::new(["Variant"].into_iter().chain(axes).chain(["Settings"]));
    for variant in &study.variants {
        let value = |axis: &str| variant.axes.get(axis).map_or_else(Datum::none, Datum::text);
        let settings: Vec<String> = variant.set.iter().map(|set| format!("--set {set}")).collect();
        let settings = if settings.is_empty() {
            Datum::text("none")
        } else {
            Datum { class: "code", ..Datum::text(settings.join(" ")) }
        };
        let axes = study.axes.iter().map(|axis| value(&axis.name));
        table.rows.push([Datum::text(&variant.name)].into_iter().chain(axes).chain([settings]).collect());
    }
    table
}

/// Each cell with its command, and how many cells are left out.
pub fn commands(results: &Results) -> (Table, usize) {
    let metrics = results.study.metrics.iter().map(|metric| format!("#{}", metric.name)).collect::<Vec<_>>();
    let head = ["Cell", "Variant", "Scene", "#Seed"].into_iter().chain(metrics.iter().map(String::as_str));
    let mut table = Table::new(head.chain(["#GPU ms", "Command"]));
    for cell in results.cells.iter().take(MOST_COMMANDS) {
        let value = |name: &str| cell.metrics.get(name).copied().flatten();
        let metrics = results.study.metrics.iter().map(|metric| Datum::value(value(&metric.name)));
        let time = results.timings.get(&cell.cell).map(|timing| timing.gpu_ms);
        let seed = Datum::number(cell.seed as f64, cell.seed.to_string());
        let head = [Datum::text(&cell.cell), Datum::text(&cell.variant), Datum::text(&cell.scene), seed];
        let tail = [Datum::value(time), Datum::command(&cell.command)];
        table.rows.push(head.into_iter().chain(metrics).chain(tail).collect());
    }
    (table, results.cells.len().saturating_sub(MOST_COMMANDS))
}

/// GPU time of each pass: mean over the cells of a variant of the median over frames. `None`: no times.
pub fn passes(results: &Results) -> Option<Table> {
    let variants: Vec<&str> = results.study.variants.iter().map(|variant| variant.name.as_str()).collect();
    // In the order of the frame: a pass that only some variants have follows the pass that it follows there.
    let mut order: Vec<&str> = Vec::new();
    let mut times: BTreeMap<(&str, &str), f64> = BTreeMap::new();
    let mut counts: BTreeMap<&str, f64> = BTreeMap::new();
    for cell in &results.cells {
        let Some(timing) = results.timings.get(&cell.cell) else { continue };
        *counts.entry(&cell.variant).or_default() += 1.0;
        let mut place = 0;
        for pass in &timing.passes {
            place = match order.iter().position(|known| *known == pass.pass) {
                Some(known) => known + 1,
                None => {
                    order.insert(place, &pass.pass);
                    place + 1
                }
            };
            *times.entry((&pass.pass, &cell.variant)).or_default() += pass.median_ms;
        }
    }
    if order.is_empty() {
        return None;
    }
    let heads: Vec<String> = variants.iter().map(|variant| format!("#{variant}")).collect();
    let mut table = Table::new(["Pass"].into_iter().chain(heads.iter().map(String::as_str)));
    for pass in order {
        let time = |variant: &&str| Some(times.get(&(pass, *variant))? / counts.get(variant)?);
        let times = variants.iter().map(|variant| Datum::value(time(variant)));
        table.rows.push([Datum::text(pass)].into_iter().chain(times).collect());
    }
    Some(table)
}
