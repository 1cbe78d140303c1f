//! All tests of pt-indirect but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod common;
mod program;
mod reuse;
mod sh;
