//! Groups of arguments that several commands share.

mod camera;
mod device;
pub mod flags;
mod frame;
mod post;
mod scene;
pub mod values;

pub use camera::{CameraArgs, CameraChoice, DEFAULT_VFOV, LookAt};
pub use device::DeviceArgs;
pub use frame::FrameArgs;
pub use post::PostArgs;
pub use scene::{LoadArgs, SceneArgs};

/// Names of the flags that stand for knobs.
pub fn picture_flags() -> impl Iterator<Item = &'static str> {
    <post::Picture as flags::FlagSet>::FLAGS.iter().map(|flag| flag.name)
}
