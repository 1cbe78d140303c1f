//! Scenes on the CPU: everything that describes what is to be rendered, and everything that fills it.
//!
//! [`Scene`] is the one description that the rest of the workbench consumes. The crate pt-import fills it from glTF files,
//! [`builtin`] with scenes that are made by code. Lat-long environments come from `.hdr` and `.exr` files, or from code,
//! through [`Environment`].
//!
//! Axes and units are those of glTF: +Y up, right-handed, metres, radiance and KHR_lights_punctual intensities used
//! one to one. Colours are linear with Rec. 709 primaries.
#![deny(missing_docs)]

pub mod animation;
mod bounds;
mod builtin;
mod camera;
mod clusters;
mod environment;
mod error;
mod extension;
mod fingerprint;
mod framing;
pub mod gpu;
mod hash;
mod light;
mod material;
mod merge;
mod mesh;
mod mips;
mod motion;
mod posing;
mod scene;
mod sky;
mod texture;
mod transform;
mod usage;
mod validate;

pub use animation::{AnimationChoice, AnimationInfo};
pub use bounds::Bounds;
pub use builtin::{BUILTIN, builtin};
pub use camera::{Camera, CameraKey, CameraPath, Projection, without_scale};
pub use clusters::{ClusterContents, ClusterStatistics, Clusters};
pub use environment::{Environment, EnvironmentImage, MAX_ENVIRONMENT_SIDE};
pub use error::{SceneError, one_line, read_file};
pub use extension::{ExtensionUse, Support};
pub use framing::automatic_camera;
pub use glam;
pub use light::{Light, LightKind, shines};
pub use material::{AlphaMode, Lobes, MAX_PRIORITY, Material, TextureRef, media};
pub use mesh::Mesh;
pub use mips::{MipLevel, decode_texel, encode_normal, linear_from_srgb, srgb_from_linear};
pub use motion::{Blink, LightMotion, Motion};
pub use scene::{Attachment, Instance, Scene, Statistics};
pub use sky::{default_sky, default_sun};
pub use texture::{BlockFormat, Filter, MAX_TEXTURE_SIDE, MipFilter, Sampler, Texels, Texture, Wrap};
pub use transform::{MAX_COORDINATE, is_invertible, visible};
pub use usage::TextureUsage;
pub use validate::{Flaw, Part};
