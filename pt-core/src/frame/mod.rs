//! The frame recorder. A pass says what it reads and what it writes; barriers, timestamps, debug labels and the pass
//! table follow from that one declaration.

mod copies;
mod hazards;
mod pass;
mod recorder;
mod resource;
mod uniforms;

pub(crate) use hazards::Touch;
pub use pass::Pass;
pub use recorder::{Frame, FrameTiming, PassTiming, Recorder};
pub use resource::{PassInfo, Resource};
pub use uniforms::Uniforms;
