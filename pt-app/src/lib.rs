//! The parts of the `pt` program.

pub mod cli;
pub mod compare;
pub mod console;
