//! All tests of pt-import but those of its modules, in one program: it is linked once, and its tests share devices with their kernels.

mod animation;
mod animation_end;
mod animation_poses;
#[cfg(feature = "codecs")]
mod bake;
mod common;
#[cfg(feature = "codecs")]
mod compression;
mod effects;
mod files;
mod flat_nodes;
mod gltf_geometry;
mod gltf_scenes;
#[cfg(feature = "codecs")]
mod images;
mod material_kinds;
mod model_materials;
mod odd_files;
mod refusals;
mod specular_glossiness;
