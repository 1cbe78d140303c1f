//! Groups of arguments that several commands share.

mod camera;
mod device;
mod scene;
pub mod values;

pub use camera::{CameraArgs, CameraChoice, LookAt};
pub use device::{BackendChoice, DeviceArgs};
pub use scene::{LoadArgs, SceneArgs};
