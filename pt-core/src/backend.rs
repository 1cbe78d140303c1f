//! Which way of finding hits is used.

use crate::device::Device;
use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// A way of finding hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TraceBackend {
    /// The fastest on this device and scene, measured.
    #[default]
    Auto,
    /// Own traversal in compute kernels.
    Compute,
    /// `VK_KHR_ray_query` in compute kernels.
    RayQuery,
    /// `VK_KHR_ray_tracing_pipeline`.
    RtPipeline,
}

impl TraceBackend {
    /// All that find hits, that is without `Auto`.
    pub const CONCRETE: [Self; 3] = [Self::Compute, Self::RayQuery, Self::RtPipeline];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Compute => "compute",
            Self::RayQuery => "ray-query",
            Self::RtPipeline => "rt-pipeline",
        }
    }

    /// Why the device can't do it; `None`: it can.
    pub fn missing(self, device: &Device) -> Option<String> {
        let capabilities = device.info().capabilities;
        let extension = match self {
            Self::RayQuery if !capabilities.ray_query => "VK_KHR_ray_query",
            Self::RtPipeline if !capabilities.rt_pipeline => "VK_KHR_ray_tracing_pipeline",
            _ => return None,
        };
        Some(format!("{} ({}) has no {extension}", device.info().name, device.info().driver))
    }

    /// Those that the device can do.
    pub fn available(device: &Device) -> Vec<Self> {
        Self::CONCRETE.into_iter().filter(|b| b.missing(device).is_none()).collect()
    }

    /// # Errors
    /// [`Error::Unsupported`] when the device can't do it, naming what it lacks and what can be used.
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

/// No backend has that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown trace backend \"{0}\"; there are auto, compute, ray-query, rt-pipeline")]
pub struct UnknownBackend(String);

impl FromStr for TraceBackend {
    type Err = UnknownBackend;
    fn from_str(text: &str) -> std::result::Result<Self, UnknownBackend> {
        let all = [Self::Auto].into_iter().chain(Self::CONCRETE);
        all.into_iter().find(|b| b.name() == text).ok_or_else(|| UnknownBackend(text.into()))
    }
}
