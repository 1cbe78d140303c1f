//! What the test programs share.
#![allow(dead_code, reason = "no test program uses all of it")]

pub mod pixels;
pub mod records;
pub mod room;
pub mod view;

pub mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}
