//! Ground truth: direct light by brute force on the CPU, in double precision, and the mathematics of the path tracer to come.

#![forbid(unsafe_code)]

mod bvh;
pub mod direct;

pub mod oracle;
