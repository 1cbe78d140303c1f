//! The commands, each with its arguments.

#[cfg(feature = "codecs")]
pub mod bake;
pub mod bench;
pub mod capture;
pub mod compare;
pub mod import;
pub mod info;
pub mod knobs;
pub mod merge;
pub mod passes;
pub mod reference;
pub mod render;
pub mod replay;
pub mod scenes;
pub mod sheet;
pub mod study;
pub mod view;
