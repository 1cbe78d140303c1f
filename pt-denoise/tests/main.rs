//! All tests of pt-denoise but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod common;
mod composite;
mod disocclusion;
mod gradients;
mod histories;
mod low_frequency;
mod oracle;
mod program;
mod regressions;
mod static_light;
