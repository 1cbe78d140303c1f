//! Push constants of the kernel and the enums that it reads, for host and GPU.

pt_shaders::named_enum! {
    /// How the direction of a bounce ray is drawn for the diffuse lobe.
    pub enum Hemisphere {
        /// In proportion to the cosine: least noise for the normal of the surface itself.
        Cosine = "cosine",
        /// All directions alike: those at the horizon count for neighbours with other normals.
        Uniform = "uniform",
    }
}

pt_shaders::named_enum! {
    /// How often a bounce ray is drawn for the specular lobes.
    pub enum LobeChoice {
        /// In proportion to what the lobes reflect towards the viewer.
        Fresnel = "fresnel",
        /// Every second time, on every surface that has any.
        Half = "half",
    }
}

pt_shaders::gpu_struct! {
    /// Of `indirect.trace`.
    pub struct IndirectPush {
        /// `KIND_*` bits of the light that counts.
        pub kinds: u32,
        /// Instances that cast shadows.
        pub mask: u32,
        /// 1 = transmissive surfaces tint the light that goes through them.
        pub tinted_glass: u32,
        /// Surfaces that a path scatters at after the first one.
        pub bounces: u32,
        /// 1 = every other row of the split frame, diffuse light alone, of twice the weight.
        pub half_rows: u32,
        /// Bounces before Russian roulette begins.
        pub roulette_start: u32,
        /// `EMISSION_SHARE_*`.
        pub emission_share: u32,
        /// 1 = diffuse light is stored with its direction.
        pub directional: u32,
        /// 1 = directions of the diffuse lobe are drawn uniformly.
        pub uniform_hemisphere: u32,
        /// 1 = half of the rays are drawn for the specular lobes.
        pub fixed_half: u32,
        /// 2^bias on the texture gradients.
        pub lod_scale: f32,
        /// Factor on the width of a ray's cone; 0: textures at their finest level.
        pub texture_spread: f32,
        /// `RIS_SOURCE_*`.
        pub ris_source: u32,
        /// Candidates of resampled importance sampling.
        pub ris_candidates: u32,
        /// 1 = the numbers that choose them are spread evenly.
        pub ris_stratified: u32,
        /// Part of the visible normals that specular directions are drawn from.
        pub ndf_trim: f32,
        /// Perceptual roughness from which on specular light fades out; 1: never.
        pub specular_fade: f32,
        /// Weakens specular light by ray length times roughness, 1 / m.
        pub anti_flicker: f32,
        /// Distance at which bounced light of directional lights has faded out, metres; 0: never.
        pub sun_range: f32,
        /// Largest radiance of a sample; 0: no limit.
        pub clamp: f32,
    }
}
