//! All tests of pt-image but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod exr_pictures;
mod hdr_pictures;
mod image_file;
mod metrics;
