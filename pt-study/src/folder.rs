//! The result folder of a running study.
//!
//! A finished cell is two lines of JSON in `cells/NAME.jsonl`, its [`CellRecord`] and its [`TimingRecord`], written at once and whole: a killed study
//! has all cells that it finished, and goes on with the next. At the end they are joined to `results.jsonl` and `timings.jsonl` in the order of the cells.

use crate::error::StudyError;
use crate::record::{CellRecord, FORMAT, StudyRecord, TimingRecord};
use pt_image::atomic_file::{read, write_atomic};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

const STUDY: &str = "study.json";
pub(crate) const RESULTS: &str = "results.jsonl";
pub(crate) const TIMINGS: &str = "timings.jsonl";
const CELLS: &str = "cells";
const LOCK: &str = ".lock";

/// A result folder that this process alone writes.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// The system releases the lock when the process ends, however it ends.
    _lock: File,
}

/// A finished cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// Its result.
    pub cell: CellRecord,
    /// Its times.
    pub timing: TimingRecord,
    /// Both as they are written. Numbers that are read and written again may differ in their last digit.
    lines: [String; 2],
}

impl Finished {
    /// A cell that has just been measured.
    ///
    /// # Errors
    /// A record that JSON cannot hold.
    pub fn new(cell: CellRecord, timing: TimingRecord) -> Result<Self, StudyError> {
        let lines = [to_json(&cell)?, to_json(&timing)?];
        Ok(Self { cell, timing, lines })
    }

    fn read(path: &Path, cell: &str, timing: &str) -> Result<Self, StudyError> {
        let lines = [cell.to_owned(), timing.to_owned()];
        Ok(Self { cell: from_json(path, cell)?, timing: from_json(path, timing)?, lines })
    }
}

impl Folder {
    /// Opens the folder for the study `record`: makes it, or goes on with what is there if `resume` allows it.
    ///
    /// # Errors
    /// Results that are there without `resume`, or are of another study, another version or another device; a folder that another process writes;
    /// a folder that cannot be made.
    pub fn open(path: &Path, record: &StudyRecord, resume: bool) -> Result<Self, StudyError> {
        let folder = Self::lock(path)?;
        let study = path.join(STUDY);
        if study.exists() {
            let found = read_study(path)?;
            // A study that failed before its first result leaves nothing to go on with.
            if !has_results(path)? {
                write_json(&study, record)?;
            } else if resume {
                check_same(path, &found, record)?;
                check_cells(path, &found, record)?;
            } else {
                return Err(StudyError::folder(
                    path,
                    "has results of a study; --resume goes on with it, another -o starts anew",
                ));
            }
        } else {
            // A process that was killed may have left the lock, and what it wrote of the first file.
            let is_ours = |name: &String| name == LOCK || name.starts_with(&format!(".{STUDY}."));
            if let Some(other) = entries(path)?.iter().find(|name| !is_ours(name)) {
                return Err(StudyError::folder(
                    path,
                    format!("is no result folder, it has {other}; -o takes a new folder"),
                ));
            }
            write_json(&study, record)?;
        }
        let cells = path.join(CELLS);
        fs::create_dir_all(&cells).map_err(|cause| cannot_make(&cells, &cause))?;
        Ok(folder)
    }

    fn lock(path: &Path) -> Result<Self, StudyError> {
        fs::create_dir_all(path).map_err(|cause| cannot_make(path, &cause))?;
        let name = path.join(LOCK);
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(&name);
        let file = file.map_err(|cause| cannot_make(&name, &cause))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { path: path.into(), _lock: file }),
            Err(TryLockError::WouldBlock) => Err(StudyError::folder(
                path,
                "another process writes into it; wait for its end, or give another folder",
            )),
            Err(TryLockError::Error(cause)) => {
                Err(StudyError::folder(name, format!("cannot be locked ({})", plain(&cause))))
            }
        }
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn cell_file(&self, name: &str) -> PathBuf {
        self.path.join(CELLS).join(format!("{name}.jsonl"))
    }

    /// A cell, if it is finished.
    ///
    /// # Errors
    /// A damaged file.
    pub fn finished(&self, name: &str) -> Result<Option<Finished>, StudyError> {
        let path = self.cell_file(name);
        if !path.exists() {
            return Ok(None);
        }
        let text = read_text(&path)?;
        let mut lines = text.lines();
        let (cell, timing) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
        Ok(Some(Finished::read(&path, cell, timing)?))
    }

    /// Keeps a finished cell.
    ///
    /// # Errors
    /// When the file cannot be written; nothing of it is left then.
    pub fn keep(&self, finished: &Finished) -> Result<(), StudyError> {
        let [cell, timing] = &finished.lines;
        Ok(write_atomic(&self.cell_file(&finished.cell.cell), format!("{cell}\n{timing}\n").as_bytes())?)
    }

    /// Joins finished cells, which are in their order.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn finish(&self, finished: &[Finished]) -> Result<(), StudyError> {
        let text = |place: usize| finished.iter().map(|f| f.lines[place].clone() + "\n").collect::<String>();
        write_atomic(&self.path.join(TIMINGS), text(1).as_bytes())?;
        Ok(write_atomic(&self.path.join(RESULTS), text(0).as_bytes())?)
    }
}

/// The study of a result folder.
///
/// # Errors
/// No result folder; another version of the records.
pub fn read_study(folder: &Path) -> Result<StudyRecord, StudyError> {
    let path = folder.join(STUDY);
    if !path.is_file() {
        return Err(StudyError::folder(
            folder,
            format!("is no result folder of pt study, it has no {STUDY}"),
        ));
    }
    let text = read_text(&path)?;
    let format =
        serde_json::from_str::<serde_json::Value>(&text).ok().and_then(|value| value.get("format")?.as_u64());
    if let Some(format) = format.filter(|&format| format != u64::from(FORMAT)) {
        return Err(StudyError::folder(
            &path,
            format!(
                "has format {format}, this program reads {FORMAT}; run the study again, or use the program that wrote it"
            ),
        ));
    }
    from_json(&path, &text)
}

/// The results of a finished study, in the order of the cells.
///
/// # Errors
/// A study that is not finished; damaged files.
pub fn read_results(folder: &Path) -> Result<Vec<CellRecord>, StudyError> {
    read_lines(&folder.join(RESULTS))
}

/// The times of a finished study, in the order of the cells.
///
/// # Errors
/// As [`read_results`].
pub fn read_timings(folder: &Path) -> Result<Vec<TimingRecord>, StudyError> {
    read_lines(&folder.join(TIMINGS))
}

/// The cells of a finished study, in their order.
pub(crate) fn read_finished(folder: &Path) -> Result<Vec<Finished>, StudyError> {
    // Damaged lines are named with their number.
    let counts = [read_results(folder)?.len(), read_timings(folder)?.len()];
    if counts[0] != counts[1] {
        return Err(StudyError::folder(
            folder,
            "results and timings have different numbers of lines; run the shard again",
        ));
    }
    let (cells, timings) = (read_text(&folder.join(RESULTS))?, read_text(&folder.join(TIMINGS))?);
    cells.lines().zip(timings.lines()).map(|(cell, timing)| Finished::read(folder, cell, timing)).collect()
}

fn read_lines<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, StudyError> {
    if !path.exists() {
        return Err(StudyError::folder(
            path,
            "is missing: the study is not finished; pt study --resume goes on with it",
        ));
    }
    let text = read_text(path)?;
    let line = |(i, line): (usize, &str)| {
        from_json(path, line)
            .map_err(|_| StudyError::folder(path, format!("line {} is damaged; run the study again", i + 1)))
    };
    text.lines().enumerate().map(line).collect()
}

/// Whether two folders belong to the same study on the same device; `found` is in `path`.
pub(crate) fn check_same(path: &Path, found: &StudyRecord, wanted: &StudyRecord) -> Result<(), StudyError> {
    let pairs = [
        ("name", &found.name, &wanted.name),
        ("version of pt", &found.version, &wanted.version),
        ("revision of pt", &found.revision, &wanted.revision),
        ("device", &found.device, &wanted.device),
        ("driver", &found.driver, &wanted.driver),
    ];
    if let Some((what, there, here)) = pairs.into_iter().find(|(_, there, here)| there != here) {
        return Err(StudyError::folder(
            path,
            format!("has results of another {what}: {there:?} there, {here:?} here; give another folder"),
        ));
    }
    if found.file != wanted.file {
        return Err(StudyError::folder(
            path,
            "has results of another study: its study file differs; give another folder",
        ));
    }
    Ok(())
}

/// Whether two folders belong to the same selection of the cells of a study; `found` is in `path`.
fn check_cells(path: &Path, found: &StudyRecord, wanted: &StudyRecord) -> Result<(), StudyError> {
    if found.cells == wanted.cells {
        return Ok(());
    }
    let cells = format!(
        "has results of another --filter: {} cells there, {} here; give another folder",
        found.cells, wanted.cells
    );
    Err(StudyError::folder(path, cells))
}

/// Names in a folder, sorted.
/// Whether a cell of the folder is finished.
fn has_results(folder: &Path) -> Result<bool, StudyError> {
    let cells = folder.join(CELLS);
    let is_cell = |name: &String| name.ends_with(".jsonl") && !name.starts_with('.');
    Ok(folder.join(RESULTS).exists() || (cells.is_dir() && entries(&cells)?.iter().any(is_cell)))
}

fn entries(folder: &Path) -> Result<Vec<String>, StudyError> {
    let list = fs::read_dir(folder)
        .map_err(|cause| StudyError::folder(folder, format!("cannot be listed ({})", plain(&cause))))?;
    let mut names: Vec<_> =
        list.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}

fn cannot_make(path: &Path, cause: &io::Error) -> StudyError {
    StudyError::folder(path, format!("cannot be made ({}); give another folder", plain(cause)))
}

/// What the system said, without its number.
fn plain(cause: &io::Error) -> String {
    let text = cause.to_string();
    text.split(" (os error").next().unwrap_or_default().to_owned()
}

pub(crate) fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), StudyError> {
    let text =
        serde_json::to_string_pretty(value).map_err(|error| StudyError::folder(path, error.to_string()))?;
    Ok(write_atomic(path, (text + "\n").as_bytes())?)
}

fn to_json<T: Serialize>(value: &T) -> Result<String, StudyError> {
    serde_json::to_string(value).map_err(|error| StudyError::folder(CELLS, error.to_string()))
}

fn read_text(path: &Path) -> Result<String, StudyError> {
    String::from_utf8(read(path)?).map_err(|_| StudyError::folder(path, "is damaged: it is not UTF-8 text"))
}

fn from_json<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, StudyError> {
    serde_json::from_str(text).map_err(|error| {
        StudyError::folder(path, format!("is damaged ({error}); remove it and resume the study"))
    })
}
