//! The passes that the denoisers consist of.

mod atrous;
mod temporal;
mod variance;

pub(crate) use atrous::Atrous;
pub use atrous::AtrousParams;
pub use temporal::TemporalParams;
pub(crate) use temporal::{MAX_LENGTH, Temporal};
pub(crate) use variance::Variance;
