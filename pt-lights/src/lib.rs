//! Light sampling and the direct lighting pass.
//!
//! * [`LightLists`]: the lights of a scene and the probability of each; [`LightTables`]: the same on the GPU;
//! * `lights.glsl`, `sampling.glsl`, `brdf.glsl` (in pt-shaders): the samplers, for every kernel that needs light;
//! * [`DirectLighting`]: the pass, one candidate and one shadow ray for each kind of light;
//! * [`ClusterLists`](cluster_lists::ClusterLists): the lights that matter in each cluster;
//! * [`light_powers`]: the power of each light of a scene in watts;
//! * [`oracle`]: the same mathematics on the CPU.

mod alias;
pub mod cluster_lists;
mod direct;
mod emissive;
mod environment;
mod light_bounds;
mod lists;
mod nee_at;
pub mod oracle;
mod power;
mod punctual;
pub mod records;
mod sampler_tables;
mod statistics;
pub mod synthetic;
mod tables;
mod texture_mean;

pub use alias::AliasTable;
pub use direct::{DirectLighting, DirectParams};
pub use emissive::EmissiveTriangle;
pub use light_bounds::{LightBounds, local_lights};
pub use lists::LightLists;
pub use nee_at::NeeAt;
pub use power::{LightPower, light_powers};
pub use sampler_tables::SamplerTables;
pub use statistics::ShadowStatistics;
pub use tables::LightTables;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

/// Rec. 709 luminance of linear RGB (`luminance` of math.glsl).
pub fn luminance(c: glam::Vec3) -> f64 {
    let [r, g, b] = c.to_array().map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
