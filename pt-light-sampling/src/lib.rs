//! Light sampling, for every stage that needs light.
//!
//! * [`LightLists`]: the lights of a scene and the probability of each; [`LightTables`]: the same on the GPU;
//! * `lights.glsl`, `lights/`, `sampling.glsl`, `brdf.glsl` (in pt-shaders): the samplers, for every kernel that needs light;
//! * [`ClusterLists`](cluster_lists::ClusterLists): the lights that matter in each cluster; [`ShadowStatistics`]: which of them arrive;
//! * [`light_powers`]: the power of each light of a scene in watts;
//! * [`oracle`]: the same mathematics on the CPU.

mod alias;
pub mod cluster_lists;
mod emissive;
mod environment;
mod environment_quads;
mod light_bounds;
mod light_bvh;
mod lists;
pub mod oracle;
mod places;
mod power;
mod punctual;
pub mod records;
mod sampler_tables;
mod statistics;
mod table;
mod tables;
pub mod test_support;
mod texture_mean;

pub use alias::AliasTable;
pub use emissive::EmissiveTriangle;
pub use environment_quads::EnvironmentQuads;
pub use light_bounds::{LightBounds, local_lights};
pub use light_bvh::{LightBvh, NO_TRAIL};
pub use lists::LightLists;
pub use power::{LightPower, light_powers};
pub use sampler_tables::{SamplerChoice, SamplerTables};
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
