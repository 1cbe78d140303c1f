//! All tests of pt-reference but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod background;
mod bsdf;
mod closed_forms;
mod common;
mod film;
mod interior;
mod path_closed_forms;
mod path_estimates;
mod path_lights;
mod samplers;
