//! Where the work is done.

use super::values::named;
use clap::Args;
use pt_core::trace::TraceBackend;

/// Where it runs.
#[derive(Clone, Debug, Args)]
pub struct DeviceArgs {
    /// How rays are traced; `auto` measures all of them and takes compute unless another is clearly faster.
    #[arg(long, value_name = "B", value_parser = named::<TraceBackend>(), default_value_t = TraceBackend::Auto, help_heading = "Device")]
    pub backend: TraceBackend,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D", help_heading = "Device")]
    pub device: Option<String>,
    /// Run with the Vulkan validation layers; any message is an error.
    #[arg(long, help_heading = "Device")]
    pub validation: bool,
}
