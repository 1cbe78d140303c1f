//! Device, memory, kernels, the frame recorder, trace backends, capture files and metrics: what every stage stands on.

pub mod buffer;
pub mod device;
pub mod error;
pub mod image;
pub mod texture;

pub use buffer::{Buffer, Location};
pub use device::{Device, DeviceOptions};
pub use error::{Error, Result};
pub use image::Image;
pub use pt_shaders::{glam, gpu_struct};
