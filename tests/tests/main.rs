//! Tests that cross crates, in one program: it is linked once, and its tests share devices with their kernels.

mod backends;
mod caustics;
mod closed_forms;
mod common;
mod compact;
mod effects;
mod environment;
mod godrays;
mod gradient_pixels;
mod import_circles;
mod indirect;
mod kinds;
mod memory;
mod physical_sky;
mod planes;
mod random;
mod replay;
mod sources;
mod sun_disc;
mod taa;
