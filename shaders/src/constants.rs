//! Constants that host and GPU both see (`constants.glsl`).

use crate::gpu_constants;

gpu_constants! {
    /// "No index": an absent texture, a miss, an unlit cluster.
    pub const NONE: u32 = u32::MAX;

    /// `InstanceRecord::mask`: stops light.
    pub const MASK_OPAQUE: u32 = 1;
    /// `InstanceRecord::mask`: lets light through (KHR_materials_transmission); see `lights.glass_shadows`.
    pub const MASK_TRANSMISSIVE: u32 = 2;

    /// Bit of a ray's mask beside those of the instances: the ray goes through back faces of single-sided materials, as if they were not
    /// there (glTF 2.0, `material.doubleSided`). Those of solids bound their inside and stay.
    pub const CULL_BACK_FACES: u32 = 0x100;
    /// `InstanceRecord::mask`: all its triangles are single-sided.
    pub const MASK_SINGLE_SIDED: u32 = 0x200;
    /// `InstanceRecord::mask`: some of its triangles are single-sided, others are not.
    pub const MASK_MIXED_SIDES: u32 = 0x400;

    /// `MaterialRecord::flags`: both sides are shaded and emit.
    pub const MATERIAL_DOUBLE_SIDED: u32 = 1;
    /// `MaterialRecord::flags`: coverage is 1 where alpha >= cutoff, else 0.
    pub const MATERIAL_MASK: u32 = 2;
    /// `MaterialRecord::flags`: coverage is alpha.
    pub const MATERIAL_BLEND: u32 = 4;
    /// `MaterialRecord::flags`: the camera sees the base colour as radiance.
    pub const MATERIAL_UNLIT: u32 = 8;
    /// `MaterialRecord::flags`: rays to infinity that meet it end in the environment.
    pub const MATERIAL_SKY: u32 = 16;
    /// `MaterialRecord::flags`: what is seen in it has the motion of the surface, not that of the mirror image.
    pub const MATERIAL_OWN_MOTION: u32 = 32;
    /// First bit of the camera in `MaterialRecord::flags`.
    pub const MATERIAL_CAMERA_SHIFT: u32 = 16;

    /// `LightRecord::kind`: point light, intensity in candela.
    pub const LIGHT_POINT: u32 = 0;
    /// `LightRecord::kind`: spot light, intensity in candela.
    pub const LIGHT_SPOT: u32 = 1;
    /// `LightRecord::kind`: directional light, illuminance in lux.
    pub const LIGHT_DIRECTIONAL: u32 = 2;

    /// Entries of a list of rays that a workgroup of a kernel that traces takes (`ray_list.glsl`).
    pub const RAY_LIST_TRACE_GROUP: u32 = 32;
    /// The same of a kernel that shades. Wide: NVIDIA's compiler then keeps to 128 registers, and more threads hide the loads.
    pub const RAY_LIST_SHADING_GROUP: u32 = 512;
    /// Bytes of a `RayListHead`.
    pub const RAY_LIST_HEAD_BYTES: u32 = 32;

    /// Most subsets of a cluster's list of lights that have weights (`lights/subsets.glsl`).
    pub const MAX_SUBSETS: u32 = 256;

    /// `LocalLightRecord::kind`: the bits that say which it is, and the values.
    pub const LOCAL_KIND: u32 = 3;
    /// Emissive triangle.
    pub const LOCAL_TRIANGLE: u32 = 0;
    /// Point light.
    pub const LOCAL_POINT: u32 = 1;
    /// Spot light.
    pub const LOCAL_SPOT: u32 = 2;
    /// Quad of the environment.
    pub const LOCAL_ENVIRONMENT: u32 = 3;
    /// Bit of `LocalLightRecord::kind`: both sides of the triangle emit.
    pub const LOCAL_DOUBLE_SIDED: u32 = 4;
    /// Bit of `LocalLightRecord::kind`: a texture or the coverage decides on the emission of each point.
    pub const LOCAL_TEXTURED: u32 = 8;
    /// Bit of `LocalLightRecord::kind`: the second and third corner have changed places, for an instance that is mirrored.
    pub const LOCAL_SWAPPED: u32 = 16;
    /// Bit of `LightCandidateRecord::kind`: its digits do not do, for example for a sliver; the light is read from its `LocalLightRecord`.
    pub const LOCAL_EXACT: u32 = 32;

    /// Bit of a set of kinds of light: directional lights.
    pub const KIND_SUN: u32 = 1;
    /// Bit of a set of kinds of light: point and spot lights.
    pub const KIND_POSITIONAL: u32 = 2;
    /// Bit of a set of kinds of light: emissive triangles.
    pub const KIND_EMISSIVE: u32 = 4;
    /// Bit of a set of kinds of light: the environment.
    pub const KIND_ENVIRONMENT: u32 = 8;
    /// Bit of a set of kinds of light: all that one sampler chooses from.
    pub const KIND_LOCAL: u32 = 16;

    /// Bit of `scene_features` (scene.glsl), the set of what the scene has: base colour textures.
    pub const FEATURE_BASE_COLOR_TEXTURE: u32 = 1;
    /// Roughness and metalness textures.
    pub const FEATURE_METALLIC_ROUGHNESS_TEXTURE: u32 = 2;
    /// Normal maps, of the coat too.
    pub const FEATURE_NORMAL_TEXTURE: u32 = 4;
    /// Emission textures.
    pub const FEATURE_EMISSIVE_TEXTURE: u32 = 8;
    /// Any texture of the base layer.
    pub const FEATURES_TEXTURE: u32 = FEATURE_BASE_COLOR_TEXTURE
        | FEATURE_METALLIC_ROUGHNESS_TEXTURE
        | FEATURE_NORMAL_TEXTURE
        | FEATURE_EMISSIVE_TEXTURE;
    /// Materials with a `LobeRecord`.
    pub const FEATURE_LOBES: u32 = 16;
    /// Materials that transmit light.
    pub const FEATURE_TRANSMISSION: u32 = 32;
    /// MASK or BLEND materials.
    pub const FEATURE_COVERAGE: u32 = 64;
    /// Textures whose UV transform is not the identity.
    pub const FEATURE_TEXTURE_TRANSFORM: u32 = 128;
    /// Textures that are read at the second UV set.
    pub const FEATURE_SECOND_UV: u32 = 256;
    /// Vertices that are not white.
    pub const FEATURE_VERTEX_COLOR: u32 = 512;
    /// More than one instance.
    pub const FEATURE_INSTANCES: u32 = 1024;
    /// An instance with [`MASK_MIXED_SIDES`].
    pub const FEATURE_MIXED_SIDES: u32 = 2048;
    /// Portals of the environment.
    pub const FEATURE_PORTALS: u32 = 4096;
    /// MASK or BLEND materials, and tables of where their triangles are opaque or transparent.
    pub const FEATURE_OPACITY_TABLE: u32 = 8192;
    /// Directional lights that have a size, which is seen.
    pub const FEATURE_SUN_DISC: u32 = 16384;
    /// Surfaces that show the environment.
    pub const FEATURE_SKY: u32 = 32768;
    /// Materials with waves.
    pub const FEATURE_WAVES: u32 = 65536;
    /// Surfaces that show the view of a camera.
    pub const FEATURE_CAMERA_VIEWS: u32 = 131072;
    /// Samplers that filter the textures of materials, which every scene has; kernels without it draw one texel (texture_filter.glsl).
    pub const FEATURE_TEXTURE_FILTER: u32 = 262144;
    /// Particles, sprites, beams or fog.
    pub const FEATURE_EFFECTS: u32 = 524288;
    /// Bit of `TextureSlot::flags`: the texture is read at the second UV set.
    pub const TEXTURE_SECOND_UV: u32 = 1;
    /// Its sampler takes the nearest texel when it is magnified.
    pub const TEXTURE_MAG_NEAREST: u32 = 2;
    /// Its sampler takes the nearest texel when it is minified.
    pub const TEXTURE_MIN_NEAREST: u32 = 4;
    /// Its sampler takes the nearest mip level.
    pub const TEXTURE_MIP_NEAREST: u32 = 8;
    /// Its sampler takes the finest mip level alone.
    pub const TEXTURE_MIP_OFF: u32 = 16;
    /// Its sampler mirrors the texture along u where it repeats.
    pub const TEXTURE_MIRROR_U: u32 = 32;
    /// As [`TEXTURE_MIRROR_U`] along v.
    pub const TEXTURE_MIRROR_V: u32 = 64;
    /// Its sampler stretches the border along u.
    pub const TEXTURE_CLAMP_U: u32 = 128;
    /// As [`TEXTURE_CLAMP_U`] along v.
    pub const TEXTURE_CLAMP_V: u32 = 256;
    /// All bits of samplers that do not filter in some way; without any, a sampler filters anisotropically.
    pub const TEXTURE_UNFILTERED: u32 = TEXTURE_MAG_NEAREST | TEXTURE_MIN_NEAREST | TEXTURE_MIP_NEAREST | TEXTURE_MIP_OFF;
    /// Largest anisotropy of the textures of materials: how many times as long as wide the filter may be.
    pub const MAX_TEXTURE_ANISOTROPY: f32 = 8.0;

    /// Most fog volumes that a scene may have.
    pub const MAX_FOG_VOLUMES: u32 = 8;
    /// Bits of `EffectNode::effects` that hold a number of effects.
    pub const EFFECT_COUNT_BITS: u32 = 3;

    /// Parts of an edge of a triangle in its opacity table.
    pub const OPACITY_SIDE: u32 = 8;
    /// State of a micro-triangle: material and texture decide.
    pub const OPACITY_UNKNOWN: u32 = 0;
    /// State of a micro-triangle: it stops every ray.
    pub const OPACITY_OPAQUE: u32 = 1;
    /// State of a micro-triangle: it stops no ray.
    pub const OPACITY_TRANSPARENT: u32 = 2;
    /// Checkerboard flag of a surface that the camera sees directly.
    pub const FLAG_PRIMARY: u32 = 1;
    /// Checkerboard flag of a surface that is seen by reflection.
    pub const FLAG_REFLECTION: u32 = 2;
    /// Checkerboard flag of a surface that is seen by refraction.
    pub const FLAG_REFRACTION: u32 = 4;
    /// Checkerboard flags of a surface behind one that is split: one field reflects, the other refracts.
    pub const SPLIT_FLAGS: u32 = FLAG_REFLECTION | FLAG_REFRACTION;

    /// `LightBvhNode::link`: the node is a leaf.
    pub const LIGHT_BVH_LEAF: u32 = 0x80000000;
    /// `EnvironmentQuadNode::link`: the node is a quad. [`NONE`]: it is black.
    pub const ENVIRONMENT_QUAD_LEAF: u32 = 0x80000000;

    /// Distance of the environment, metres: no ray reaches farther. Its square is finite.
    pub const SKY_DISTANCE: f32 = 1e18;
    /// Channel `cluster`: there is no surface.
    pub const NO_CLUSTER: u32 = 0xffff;

    /// Side of a tile of the split frame that learns lights (nee-at), texels.
    pub const NEE_AT_SIDE: u32 = 8;
    /// Proxies of a tile; a power of two.
    pub const NEE_AT_PROXIES: u32 = 128;
    /// Bytes of a [`NeeAtTile`](crate::records::NeeAtTile).
    pub const NEE_AT_TILE_BYTES: u32 = 12 + 4 * NEE_AT_PROXIES;

    /// Side of the blue-noise mask in texels; a power of two. Its ranks fill 12 bits.
    pub const BLUE_NOISE_SIDE: u32 = 64;
}

#[cfg(test)]
mod tests {
    #[test]
    fn values_and_types_reach_glsl() {
        let text = super::glsl();
        for line in [
            "const uint NONE = 4294967295u;\n",
            "const uint SPLIT_FLAGS = 6u;\n",
            "const float SKY_DISTANCE = 1e18;\n",
        ] {
            assert!(text.contains(line), "{line}in\n{text}");
        }
    }
}
