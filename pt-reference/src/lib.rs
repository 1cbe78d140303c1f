//! Ground truth: direct light by brute force on the CPU, in double precision. The path tracer is yet to come.

#![forbid(unsafe_code)]

mod bvh;
pub mod direct;
