//! Studies: one switch or several, on these scenes with these seeds, and whether it matters. This crate reads study files, lists their
//! cells, keeps results, and does the statistics and the report. It needs no device: `pt study` runs the cells.

pub mod paired_times;
pub mod record;
