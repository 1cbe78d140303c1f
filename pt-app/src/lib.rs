//! The parts of the `pt` program.

pub mod aov;
pub mod args;
pub mod camera_path;
pub mod cli;
pub mod commands;
pub mod frame;
pub mod frame_capture;
pub mod ground_truth;
pub mod inputs;
pub mod interrupt;
pub mod origin;
pub mod output;
pub mod params;
pub mod progress;
pub mod session;
pub mod timings;
