//! What the tests share.

#![allow(dead_code, reason = "each test uses its part")]

pub mod gpu;
pub mod pictures;
pub mod quality;
