//! All tests of pt-scene but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod builtin;
mod closed;
mod clusters;
mod common;
mod deform;
mod environment;
mod instances;
mod materials_on_device;
mod physical_sky;
mod texture_filter;
mod textures;
mod textures_16_bit;
