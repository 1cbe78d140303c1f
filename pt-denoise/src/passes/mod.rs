//! The passes that the denoisers consist of.

mod atrous;
mod gradients;
mod low_frequency;
mod temporal;
mod variance;

pub(crate) use atrous::Atrous;
pub use atrous::AtrousParams;
pub use gradients::AntilagParams;
pub(crate) use gradients::{AntilagDirect, AntilagIndirect, variance_factor};
pub use low_frequency::LfParams;
pub(crate) use low_frequency::{LfSpatial, LfTemporal};
pub use temporal::TemporalParams;
pub(crate) use temporal::{MAX_LENGTH, Temporal};
pub(crate) use variance::Variance;
