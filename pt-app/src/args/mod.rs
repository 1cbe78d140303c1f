//! Groups of arguments that several commands share.

mod camera;
mod device;
pub mod flags;
mod frame;
mod post;
mod scene;
pub mod values;

pub use camera::{CameraArgs, CameraChoice, LookAt};
pub use device::DeviceArgs;
pub use frame::FrameArgs;
pub use post::PostArgs;
pub use scene::{LoadArgs, SceneArgs};
