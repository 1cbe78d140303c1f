//! The base of every stage: device, memory, kernels, the frame recorder and plan, knobs, trace backends and captures.

mod backend;
mod block;
pub mod blue_noise;
pub mod buffer;
pub mod capture;
pub mod channels;
pub mod console;
pub mod device;
pub mod error;
pub mod frame;
mod half_codes;
pub mod harness;
mod history;
pub mod image;
mod inputs;
pub mod kernel;
mod layout;
mod lock;
pub mod memory;
pub mod pack;
pub mod phases;
pub mod plan;
pub mod random;
mod ray_list;
pub mod rng;
pub mod sampler;
pub mod settings;
mod sizes;
pub mod sobol;
pub mod split;
mod substitute;
mod surfaces;
mod tables;
pub mod test_support;
mod texels;
pub mod texture;
pub mod trace;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

pub use buffer::{Buffer, Location};
pub use channels::{ChannelImages, TableWish};
pub use device::{Device, DeviceOptions};
pub use error::{Error, Result};
pub use frame::{Frame, Recorder};
pub use image::Image;
pub use inputs::{LowFrequencyLight, SceneResources, SplitLight, StageInputs};
pub use kernel::{Constant, Kernel};
pub use plan::{FramePlan, Kept, StageIo};
pub use pt_shaders::{KnobType, glam, gpu_struct};
pub use ray_list::RayLists;
pub use sizes::FrameSizes;
pub use substitute::Substitute;
pub use surfaces::Surfaces;
pub use tables::TableMemory;
