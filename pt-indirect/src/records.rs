//! Push constants of the kernels and what they read, for host and GPU.

use pt_shaders::dimensions::MAX_BOUNCES;

pt_shaders::gpu_constants! {
    /// Lists of paths for each surface that a path meets (`LIST_*` of `bounce_path.glsl`).
    pub const BOUNCE_LISTS: u32 = 3;
    /// Heads of all lists: a path has a ray from the first surface on, and one more behind the last.
    pub const BOUNCE_LIST_HEADS: u32 = BOUNCE_LISTS * (MAX_BOUNCES + 2);
    /// Directions of the diffuse lobe are drawn uniformly.
    pub const DRAW_UNIFORM_HEMISPHERE: u32 = 1;
    /// Half of the rays are drawn for the specular lobes.
    pub const DRAW_FIXED_HALF: u32 = 2;
}

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

pt_shaders::named_enum! {
    /// Whether surfaces get light that the paths of other pixels and frames have found.
    pub enum BounceReuse {
        /// Each pixel has the light of its own path.
        None = "none",
        /// Of the light that leaves what the first ray has met, the part that looks the same from everywhere is resampled over time and over neighbours
        /// (ReSTIR GI).
        RestirGi = "restir-gi",
    }
}

pt_shaders::named_enum! {
    /// Which rays `reuse=restir-gi` traces between surfaces and reused points.
    pub enum RestirVisibility {
        /// BIASED: none. Light comes through walls, and is lost where neighbours do not see what the pixel sees.
        None = "none",
        /// BIASED: one, for the sample that is kept. Light is lost where neighbours do not see what the pixel sees.
        Final = "final",
        /// Also those that weights need: a target is 0 where the point is hidden. Unbiased without the past, and with it in a scene that stands still and in
        /// which nothing is partly transparent (BLEND).
        InWeight = "in-weight",
    }
}

pt_shaders::gpu_struct! {
    /// Addresses of what the passes tell each other; `bounce_path.glsl` says what there is.
    pub struct BounceTables {
        /// `uvec4[]`.
        pub origins: u64,
        /// `uvec4[]`.
        pub directions: u64,
        /// `uvec4[]`.
        pub throughputs: u64,
        /// `uvec4[]`; 0: no solids.
        pub solids: u64,
        /// `float[]`; 0: no solids.
        pub passed: u64,
        /// `uvec4[]`.
        pub hits: u64,
        /// `uvec4[]`.
        pub firsts: u64,
        /// `uint[]`.
        pub first_directions: u64,
        /// `uvec4[]`.
        pub lights: u64,
        /// `uvec2[]`.
        pub reflected: u64,
        /// `uvec4[]`.
        pub shadow_origins: u64,
        /// `uvec4[]`.
        pub shadow_directions: u64,
        /// `uvec2[]`.
        pub shadow_lights: u64,
        /// `uvec4[]`; 0: bounces are not reused.
        pub reusable: u64,
        /// `uvec4[]`; 0: as above.
        pub shares: u64,
        /// `uvec4[]`; 0: as above.
        pub points: u64,
        /// Paths with a ray from the vertices 0, 2, 4...: `uint[]`.
        pub even_list: u64,
        /// From the others.
        pub odd_list: u64,
        /// Paths with a shadow ray: `uint[]`.
        pub shadow_list: u64,
        /// [`BOUNCE_LIST_HEADS`] heads: [`BOUNCE_LISTS`] for each vertex.
        pub heads: u64,
    }
}

pt_shaders::gpu_struct! {
    /// Of the passes of indirect lighting.
    pub struct IndirectPush {
        /// Device address of a [`BounceTables`].
        pub tables: u64,
        /// Workgroups in a row of a launch over the paths of a list.
        pub columns: u32,
        /// Width of the split frame.
        pub width: u32,
        /// Surfaces that the paths have scattered at, the first one left out.
        pub vertex: u32,
        /// `KIND_*` bits of the light that counts.
        pub kinds: u32,
        /// Instances that cast shadows.
        pub mask: u32,
        /// `GLASS_SHADOWS_*`
        pub glass_shadows: u32,
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
        /// `DRAW_*`: how the first ray is drawn.
        pub draw: u32,
        /// 2^bias on the texture gradients.
        pub lod_scale: f32,
        /// Factor on the width of a ray's cone; 0: textures at their finest level.
        pub texture_spread: f32,
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
        /// Largest mean radiance that a narrow path brings at once; 0: no limit.
        pub firefly: f32,
        /// Most frames that the past counts, 0: it is not reused; from bit 16 on neighbours.
        pub restir_counts: u32,
        /// How far they are, pixels.
        pub restir_radius: f32,
        /// Least distance of a reused point, over that of the surface from the camera.
        pub restir_distance: f32,
        /// Perceptual roughness from which on specular light is reused.
        pub restir_roughness: f32,
    }
}
