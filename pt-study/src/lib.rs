//! Studies: one switch or several, on these scenes with these seeds, and whether it matters. This crate reads study files, lists their
//! cells, keeps results, and does the statistics and the report. It needs no device: `pt study` runs the cells.

#![forbid(unsafe_code)]

pub mod cell;
pub mod cost;
mod error;
pub mod file;
mod file_reader;
pub mod folder;
pub mod keys;
pub mod ledger;
pub mod merge;
pub mod metric;
pub mod paired_times;
pub mod record;
pub mod report;
pub mod statistics;
mod study_reader;
pub mod summary;
mod toml_reader;

pub use error::StudyError;
