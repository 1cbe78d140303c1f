//! Reads a result folder.

use super::ReportError;
use crate::record::{CellRecord, FORMAT, StudyRecord, TimingRecord};
use pt_image::atomic_file::read;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::path::Path;

/// What a report is made of.
pub struct Results {
    pub study: StudyRecord,
    pub cells: Vec<CellRecord>,
    /// Times by the name of the cell. A cell may have none: results that were merged without them, another program.
    pub timings: BTreeMap<String, TimingRecord>,
}

impl Results {
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        let path = folder.join("study.json");
        let bytes = read(&path)?;
        let record = |line: usize| ReportError::Record {
            path: path.clone(),
            line: line.max(1),
            what: "record of a study",
        };
        // The format first: a record of another one may have other fields.
        let any: serde_json::Value = serde_json::from_slice(&bytes).map_err(|error| record(error.line()))?;
        let found = any["format"].as_u64().and_then(|format| u32::try_from(format).ok());
        match found {
            Some(FORMAT) => {}
            Some(found) => return Err(ReportError::Format { path, found }),
            None => return Err(record(1)),
        }
        let study: StudyRecord = serde_json::from_slice(&bytes).map_err(|error| record(error.line()))?;

        let path = folder.join("results.jsonl");
        let cells: Vec<CellRecord> = lines(&path, "record of a cell")?;
        if cells.is_empty() {
            return Err(ReportError::Empty { path });
        }
        let known = |cell: &CellRecord| study.variants.iter().any(|variant| variant.name == cell.variant);
        if let Some(cell) = cells.iter().find(|cell| !known(cell)) {
            let (cell, variant) = (cell.cell.clone(), cell.variant.clone());
            return Err(ReportError::Variant { path, cell, variant });
        }

        let path = folder.join("timings.jsonl");
        let timings: Vec<TimingRecord> =
            if path.exists() { lines(&path, "record of times")? } else { Vec::new() };
        let timings = timings.into_iter().map(|timing| (timing.cell.clone(), timing)).collect();
        Ok(Self { study, cells, timings })
    }
}

/// The records of a file with one on each line.
fn lines<T: DeserializeOwned>(path: &Path, what: &'static str) -> Result<Vec<T>, ReportError> {
    let bytes = read(path)?;
    bytes
        .split(|byte| *byte == b'\n')
        .enumerate()
        .filter(|(_, line)| !line.trim_ascii().is_empty())
        .map(|(index, line)| {
            serde_json::from_slice(line).map_err(|_| ReportError::Record {
                path: path.into(),
                line: index + 1,
                what,
            })
        })
        .collect()
}
