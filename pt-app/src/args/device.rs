//! Where the work is done.

use clap::{Args, ValueEnum};
use pt_core::trace::TraceBackend;

/// Where it runs.
#[derive(Clone, Debug, Args)]
pub struct DeviceArgs {
    /// How rays are traced; auto measures and leaves compute for what is clearly faster.
    #[arg(long, value_name = "B", value_enum, default_value_t = BackendChoice::Auto, help_heading = "Device")]
    pub backend: BackendChoice,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D", help_heading = "Device")]
    pub device: Option<String>,
    /// Run with the Vulkan validation layers; any message is an error.
    #[arg(long, help_heading = "Device")]
    pub validation: bool,
}

/// How rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendChoice {
    /// The fastest on this device and scene.
    Auto,
    /// Own BVH in compute kernels, on every device.
    Compute,
    /// VK_KHR_ray_query.
    RayQuery,
    /// VK_KHR_ray_tracing_pipeline.
    RtPipeline,
}

impl From<BackendChoice> for TraceBackend {
    fn from(choice: BackendChoice) -> Self {
        match choice {
            BackendChoice::Auto => Self::Auto,
            BackendChoice::Compute => Self::Compute,
            BackendChoice::RayQuery => Self::RayQuery,
            BackendChoice::RtPipeline => Self::RtPipeline,
        }
    }
}
