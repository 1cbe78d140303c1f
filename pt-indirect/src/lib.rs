//! Indirect diffuse light as it is filtered and stored: luma with its direction in spherical harmonics up to l = 1, chroma
//! without. The GPU side is `sh.glsl`; [`oracle`] is the same mathematics on the CPU.
//!
//! Bounce rays, which will fill this representation, are not here yet: the frame has no indirect lighting pass.

#![forbid(unsafe_code)]

pub mod oracle;
