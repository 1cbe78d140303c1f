//! The parts of the `pt` program.

pub mod aov;
pub mod bake;
pub mod bench;
mod bench_path;
mod bench_post;
pub mod cli;
pub mod cli_reference;
pub mod compare;
mod font;
pub mod frame;
pub mod info;
pub mod output;
pub mod params;
pub mod passes;
pub mod post_args;
pub mod progress;
pub mod reference;
pub mod render;
pub mod scene_args;
pub mod scene_stats;
pub mod scenes;
pub mod session;
pub mod sheet;
