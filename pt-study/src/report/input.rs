//! Reads a result folder.

use super::ReportError;
use crate::folder::{RESULTS, TIMINGS, read_results, read_study, read_timings};
use crate::record::{CellRecord, StudyRecord, TimingRecord};
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
        let study = read_study(folder)?;
        let path = folder.join(RESULTS);
        let cells = read_results(folder)?;
        if cells.is_empty() {
            return Err(ReportError::Empty { path });
        }
        let known = |cell: &CellRecord| study.variants.iter().any(|variant| variant.name == cell.variant);
        if let Some(cell) = cells.iter().find(|cell| !known(cell)) {
            let (cell, variant) = (cell.cell.clone(), cell.variant.clone());
            return Err(ReportError::Variant { path, cell, variant });
        }
        let timings = if folder.join(TIMINGS).exists() { read_timings(folder)? } else { Vec::new() };
        let timings = timings.into_iter().map(|timing| (timing.cell.clone(), timing)).collect();
        Ok(Self { study, cells, timings })
    }
}
