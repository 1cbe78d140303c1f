//! The frame recorder. A pass says what it reads and what it writes; barriers, timestamps, debug labels and the pass
//! table follow from that one declaration.

mod copies;
mod hazards;
mod pass;
mod recorder;
mod uniforms;

pub(crate) use hazards::Touch;
pub use pass::{Pass, PassInfo};
pub use recorder::{Frame, FrameTiming, PassTiming, Recorder};
pub use uniforms::Uniforms;
