//! Declarations that the host and the GPU share, written once.
//!
//! * [`gpu_struct!`]: a record is declared in Rust and its GLSL declaration is generated from it (scalar block layout);
//! * [`named_enum!`]: an enum has its names and its GLSL constants from one declaration;
//! * [`channels`]: the frame contract, i.e. every screen-space image that passes between stages, and tables of private images;
//! * [`gpu_constants!`]: the same for constants, [`constants`]: those that several crates share;
//! * [`dimensions`]: the dimension of each random decision;
//! * [`records`]: the records that several crates share (camera, frame, scene tables);
//! * `compiler` (feature of the same name, for build scripts): GLSL to SPIR-V with includes, errors as file:line.
//!
//! The GLSL headers that several crates include lie in `glsl/`.

pub mod channels;
#[cfg(feature = "compiler")]
pub mod compiler;
pub mod constants;
pub mod dimensions;
pub mod format;
pub mod gpu_constants;
pub mod gpu_struct;
mod kernel_code;
mod knob_type;
pub mod named_enum;
pub mod records;

pub use glam;
pub use gpu_struct::{Field, GlslType, GpuStruct};
pub use kernel_code::{ShaderCode, Stage, TraceCode};
pub use knob_type::{KnobKind, KnobType};
pub use named_enum::{NamedEnum, NamedValue, UnknownName};
#[doc(hidden)]
pub use serde_core;
