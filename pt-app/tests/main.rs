//! All tests of pt-app but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod box_denoiser;
mod capture;
mod cli;
mod compare;
mod foreign_files;
mod full_disk;
mod indirect;
mod knobs;
mod newcomer;
mod outputs;
mod picture;
mod program;
mod reference;
mod scenes;
mod strangers;
mod study;
mod view;
