//! All tests of pt-lights but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod common;
mod direct;
mod environment;
mod environment_list;
mod list_visibility;
mod nee_at;
mod portals;
#[cfg(feature = "program")]
mod program;
mod ray_list;
mod replay;
mod restir;
mod restir_noise;
mod samplers;
mod shadow_rays;
mod texels;
