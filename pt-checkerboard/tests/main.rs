//! All tests of pt-checkerboard but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod add_plane;
mod interleave;
mod program;
