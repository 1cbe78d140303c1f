//! Materials and their textures.

use crate::gpu_struct;
use glam::{Vec3, Vec4};

gpu_struct! {
    /// Use of a texture by a material.
    pub struct TextureSlot {
        /// Bindless index, or [`NONE`](super::NONE).
        pub texture: u32,
        /// `TEXTURE_*` bits.
        pub flags: u32,
        /// UV transform: two rows of an affine 2x3 matrix (KHR_texture_transform).
        pub transform: [[f32; 3]; 2],
    }
}

gpu_struct! {
    /// A glTF metallic-roughness material.
    pub struct MaterialRecord {
        /// Linear base colour factor and alpha.
        pub base_color: Vec4,
        /// Emitted radiance factor (emissiveFactor x emissiveStrength), linear.
        pub emissive: Vec3,
        /// Metalness factor.
        pub metallic: f32,
        /// Perceptual roughness factor.
        pub roughness: f32,
        /// Normal map scale.
        pub normal_scale: f32,
        /// Alpha cutoff of MASK materials.
        pub alpha_cutoff: f32,
        /// Index of refraction.
        pub ior: f32,
        /// KHR_materials_transmission factor.
        pub transmission: f32,
        /// KHR_materials_volume thickness; 0 = thin.
        pub thickness: f32,
        /// KHR_materials_specular factor.
        pub specular: f32,
        /// Distance in metres at which the attenuation colour is reached; 0 = no absorption.
        pub attenuation_distance: f32,
        /// KHR_materials_specular colour factor.
        pub specular_color: Vec3,
        /// `MATERIAL_*` bits. From bit [`MATERIAL_CAMERA_SHIFT`](crate::constants::MATERIAL_CAMERA_SHIFT): 1 + index of the camera whose
        /// view the surface shows; 0: none.
        pub flags: u32,
        /// KHR_materials_volume attenuation colour.
        pub attenuation_color: Vec3,
        /// Index of the `LobeRecord`, or [`NONE`](super::NONE): no extension lobe and no texture of those that stand there.
        pub lobes: u32,
        /// Of nested solids. Bits 0-7: priority. Bits 8-31: 1 + `medium` of the material on the front side of an interface
        /// of two solids; 0: none.
        pub nesting: u32,
        /// What is behind the surface: the first of all materials with the same index, attenuation and priority.
        pub medium: u32,
        /// Root mean square of the slope of its waves; 0: it has none.
        pub wave_slope: f32,
        /// Length of the longest of them, metres.
        pub wave_length: f32,
        /// Base colour and alpha.
        pub base_color_texture: TextureSlot,
        /// Roughness in g, metalness in b.
        pub metallic_roughness_texture: TextureSlot,
        /// Tangent-space normal.
        pub normal_texture: TextureSlot,
        /// Emission.
        pub emissive_texture: TextureSlot,
    }
}

gpu_struct! {
    /// What few materials have: lobes of KHR extensions, and textures of factors that stand in `MaterialRecord`. Textures
    /// multiply the factor of the same name.
    pub struct LobeRecord {
        /// KHR_materials_clearcoat factor.
        pub clearcoat: f32,
        /// Perceptual roughness of the coat.
        pub clearcoat_roughness: f32,
        /// Scale of the coat's normal map.
        pub clearcoat_normal_scale: f32,
        /// KHR_materials_sheen colour, linear.
        pub sheen_color: Vec3,
        /// Perceptual roughness of the sheen.
        pub sheen_roughness: f32,
        /// KHR_materials_anisotropy strength, 0 to 1.
        pub anisotropy_strength: f32,
        /// Direction of the anisotropy, radians from the tangent towards the bitangent.
        pub anisotropy_rotation: f32,
        /// KHR_materials_iridescence factor.
        pub iridescence: f32,
        /// Index of refraction of the thin film.
        pub iridescence_ior: f32,
        /// Thickness of the film in nanometres where the texture is 0.
        pub iridescence_thickness_min: f32,
        /// Thickness of the film in nanometres where the texture is 1 or absent.
        pub iridescence_thickness_max: f32,
        /// KHR_materials_dispersion: 20 / Abbe number.
        pub dispersion: f32,
        /// `MaterialRecord::transmission`, in r.
        pub transmission_texture: TextureSlot,
        /// `MaterialRecord::thickness`, in g; what traces rays takes the thickness from the geometry.
        pub thickness_texture: TextureSlot,
        /// `MaterialRecord::specular`, in a.
        pub specular_texture: TextureSlot,
        /// `MaterialRecord::specular_color`.
        pub specular_color_texture: TextureSlot,
        /// In r.
        pub clearcoat_texture: TextureSlot,
        /// In g.
        pub clearcoat_roughness_texture: TextureSlot,
        /// Tangent-space normal of the coat.
        pub clearcoat_normal_texture: TextureSlot,
        /// Colour.
        pub sheen_color_texture: TextureSlot,
        /// In a.
        pub sheen_roughness_texture: TextureSlot,
        /// Direction in rg (0 to 1 for -1 to 1), strength in b.
        pub anisotropy_texture: TextureSlot,
        /// In r.
        pub iridescence_texture: TextureSlot,
        /// Between minimum and maximum, in g.
        pub iridescence_thickness_texture: TextureSlot,
    }
}
