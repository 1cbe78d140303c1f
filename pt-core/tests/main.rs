//! All tests of pt-core but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod capture;
mod frame;
mod plan;
mod random;
mod ray_offset;
mod settings;
mod trace;
mod twins;
mod variants;
