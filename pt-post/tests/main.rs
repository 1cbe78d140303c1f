//! All tests of pt-post but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod accumulate;
mod bloom;
mod common;
mod exposure;
mod fsr;
mod program;
mod taa;
mod tone_map;
mod upscalers;
