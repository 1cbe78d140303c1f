//! All tests of pt-study but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod keys;
mod report;
mod study;
