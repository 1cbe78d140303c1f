//! Arguments that select the device and the trace backend.

use super::values::named;
use clap::Args;
use pt_core::trace::TraceBackend;

/// Device and trace backend.
#[derive(Clone, Debug, Args)]
pub struct DeviceArgs {
    /// Trace backend. `auto` measures all of them and takes compute unless another one is clearly faster.
    #[arg(long, value_name = "B", value_parser = named::<TraceBackend>(), default_value_t = TraceBackend::Auto, help_heading = "Device")]
    pub backend: TraceBackend,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D", help_heading = "Device")]
    pub device: Option<String>,
    /// Run with the Vulkan validation layers; any message is an error.
    #[arg(long, help_heading = "Device")]
    pub validation: bool,
}
