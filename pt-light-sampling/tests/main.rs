//! All tests of pt-light-sampling but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod cluster_lists;
mod common;
mod environment_quads;
mod light_bvh;
mod lights;
mod samplers;
mod sampling;
mod shadow_statistics;
mod triangle_sampling;
