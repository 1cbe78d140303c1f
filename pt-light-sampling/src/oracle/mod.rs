//! The mathematics of the kernels on the CPU, plain and in double precision: what the kernels are tested against.
//!
//! Names are those of the GLSL functions in sampling.glsl, brdf.glsl, lights.glsl and lights/triangle_sampling.glsl.

pub mod brdf;
pub mod environment_quads;
pub mod light_bvh;
pub mod lights;
pub mod sampling;
pub mod triangle;
