//! The frame recorder. A pass declares what it reads and writes; barriers, timestamps, debug labels and the pass table follow
//! from that declaration. In steady state a frame allocates nothing and creates no pipelines.

mod copies;
mod count_rays;
mod hazards;
mod pass;
mod rays;
mod recorder;
mod resource;
mod timings;
mod uniforms;

pub(crate) use hazards::Touch;
pub use pass::{MissingTable, Pass};
pub use rays::{PassRays, RayCount};
pub use recorder::{FRAMES_IN_FLIGHT, Frame, Recorder};
pub use resource::{PassInfo, Resource};
pub use timings::{FrameTiming, PassTiming};
pub use uniforms::Uniforms;
