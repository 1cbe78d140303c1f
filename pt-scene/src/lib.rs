//! Scenes on the CPU: everything that describes what is to be rendered, and everything that fills it.
//!
//! [`Scene`] is the one description that the rest of the workbench consumes. It is filled by [`load`] (glTF 2.0,
//! `.gltf` and `.glb`), by [`builtin`] (scenes made by code), or by either through [`open`]. Lat-long environments
//! come from `.hdr` and `.exr` files, or from code, through [`Environment`].
//!
//! Axes and units are those of glTF: +Y up, right-handed, metres, radiance and KHR_lights_punctual intensities used
//! one to one. Colours are linear with Rec. 709 primaries.
#![deny(missing_docs)]

pub mod animation;
pub mod bake;
mod builtin;
mod camera;
mod clusters;
mod dds;
mod environment;
mod error;
mod fingerprint;
mod framing;
pub mod gpu;
mod import;
mod light;
mod material;
mod merge;
mod mesh;
mod mips;
mod motion;
mod scene;
mod sky;
mod texture;
mod validate;

pub use animation::{AnimationChoice, AnimationInfo};
pub use builtin::{BUILTIN, builtin};
pub use camera::{Camera, CameraKey, CameraPath, Projection};
pub use clusters::{ClusterContents, ClusterStatistics, Clusters};
pub use dds::DdsTexture;
pub use environment::{Environment, EnvironmentImage, MAX_ENVIRONMENT_SIDE};
pub use error::SceneError;
pub use framing::automatic_camera;
pub use glam;
pub use import::{
    DEFAULT_MAX_GEOMETRY_BYTES, DEFAULT_MAX_TEXTURE_PIXELS, EXTENSIONS, ExtensionUse, LoadOptions,
    MAX_TEXTURE_SIDE, Support, load, load_bytes, open, support,
};
pub use light::{Light, LightKind};
pub use material::{AlphaMode, Lobes, MAX_PRIORITY, Material, TextureRef, media};
pub use mesh::Mesh;
pub use mips::{MipLevel, linear_from_srgb, srgb_from_linear};
pub use motion::{Blink, LightMotion, Motion};
pub use scene::{Attachment, Bounds, Instance, Scene, Statistics};
pub use sky::{default_sky, default_sun};
pub use texture::{BlockFormat, Filter, MipFilter, Sampler, Texels, Texture, TextureUsage, Wrap};
