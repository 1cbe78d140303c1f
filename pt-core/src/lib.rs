//! Device, memory, kernels, the frame recorder, trace backends and captures: what every stage stands on.

mod backend;
pub mod buffer;
pub mod capture;
pub mod channels;
pub mod console;
pub mod device;
pub mod error;
pub mod frame;
pub mod harness;
pub mod image;
pub mod kernel;
pub mod pack;
pub mod phases;
pub mod rng;
pub mod sampler;
pub mod settings;
pub mod split;
pub mod test_support;
pub mod texture;
pub mod trace;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

pub use buffer::{Buffer, Location};
pub use channels::{ChannelImages, History};
pub use device::{Device, DeviceOptions};
pub use error::{Error, Result};
pub use frame::{Frame, Recorder};
pub use image::Image;
pub use kernel::Kernel;
pub use pt_shaders::{glam, gpu_struct};
