//! All tests of pt-gbuffer but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod effects;
mod format;
mod godrays;
mod motion;
mod opacity_table;
mod primary_rays;
mod program;
mod reflect_refract;
