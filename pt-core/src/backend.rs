//! The trace backend that is used.

use crate::device::Device;
use crate::error::{Error, Result};
use pt_shaders::{NamedEnum, UnknownName, named_enum};
use std::fmt;
use std::str::FromStr;

named_enum! {
    /// How the closest hit of a ray is found.
    pub enum TraceBackend {
        /// Compute on a CPU device; on others the fastest for this scene, measured.
        Auto = "auto",
        /// Our own BVH in compute kernels, on every device.
        Compute = "compute",
        /// `VK_KHR_ray_query` in compute kernels.
        RayQuery = "ray-query",
        /// `VK_KHR_ray_tracing_pipeline`.
        RtPipeline = "rt-pipeline",
        /// As `RtPipeline`; after each ray that asks for its nearest hit, the device may sort its threads by what they have hit
        /// (`VK_NV_ray_tracing_invocation_reorder`).
        RtReorder = "rt-reorder",
    }
}

#[expect(clippy::derivable_impls, reason = "named_enum! declares the enum")]
impl Default for TraceBackend {
    fn default() -> Self {
        Self::Auto
    }
}

impl TraceBackend {
    /// All that find hits, that is without `Auto`.
    pub const CONCRETE: [Self; 4] = [Self::Compute, Self::RayQuery, Self::RtPipeline, Self::RtReorder];

    /// Why the device can't do it; `None`: it can.
    pub fn missing(self, device: &Device) -> Option<String> {
        let capabilities = device.info().capabilities;
        let extension = match self {
            Self::RayQuery if !capabilities.ray_query => "VK_KHR_ray_query",
            Self::RtPipeline if !capabilities.rt_pipeline => "VK_KHR_ray_tracing_pipeline",
            Self::RtReorder if !capabilities.rt_reorder => "VK_NV_ray_tracing_invocation_reorder",
            _ => return None,
        };
        Some(format!("{} ({}) has no {extension}", device.info().name, device.info().driver))
    }

    /// Those that the device can do.
    pub fn available(device: &Device) -> Vec<Self> {
        Self::CONCRETE.into_iter().filter(|b| b.missing(device).is_none()).collect()
    }

    /// # Errors
    /// [`Error::Unsupported`] if the device does not support it; names the missing extension and the backends that it supports.
    pub fn check(self, device: &Device) -> Result<()> {
        self.missing(device).map_or(Ok(()), |why| {
            let names: Vec<_> = Self::available(device).into_iter().map(Self::name).collect();
            Err(Error::Unsupported(format!("backend {self}: {why}; this device has {}", names.join(", "))))
        })
    }
}

impl fmt::Display for TraceBackend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for TraceBackend {
    type Err = UnknownName;
    fn from_str(text: &str) -> std::result::Result<Self, UnknownName> {
        Self::from_name(text)
    }
}
