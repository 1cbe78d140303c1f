//! The direct lighting pass.
//!
//! [`DirectLighting`] lights the surfaces of the G-buffer; how lights are chosen and sampled is pt-light-sampling's part.

mod direct;
pub mod records;
pub mod synthetic;

pub use direct::{Counted, DirectLighting, DirectParams};

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
