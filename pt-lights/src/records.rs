//! Push constants of the kernels.

pt_shaders::named_enum! {
    /// How a material of metalness between 0 and 1 is shaded.
    pub enum PartialMetal {
        /// As a mixture of two BRDFs, a dielectric and a metal (glTF 2.0, appendix B.2).
        TwoBrdfs = "two-brdfs",
        /// As one BRDF with mixed albedo and F0, as in Quake II RTX: darker.
        MixedParameters = "mixed-parameters",
    }
}

pt_shaders::named_enum! {
    /// What becomes of the direct light on its way through transmissive surfaces.
    pub enum GlassShadows {
        /// It is stopped.
        Stopped = "stopped",
        /// It goes straight on, tinted and weakened by each surface.
        Tinted = "tinted",
        /// It goes on as if they were not there.
        Passed = "passed",
    }
}

pt_shaders::named_enum! {
    /// How many shadow rays go to local lights.
    pub enum LightRays {
        /// One for emissive triangles, one for point and spot lights, each light picked by its power.
        PerKind = "per-kind",
        /// One, to the light that `sampler` picks among all.
        Merged = "merged",
    }
}

pt_shaders::named_enum! {
    /// How shadow statistics are kept.
    pub enum StatisticsTable {
        /// Dense as long as it has at most four million entries, else sparse.
        Auto = "auto",
        /// An entry for every cluster, light and direction.
        Dense = "dense",
        /// A hash table: entries for what shadow rays have asked for.
        Sparse = "sparse",
    }
}

pt_shaders::gpu_struct! {
    /// Of `local_lights.comp`.
    pub struct LocalLightsPush {
        /// Device address of the table.
        pub local_lights: u64,
        /// Threads in a row.
        pub width: u32,
        /// Alignment.
        pub pad: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `shadow_statistics.comp`.
    pub struct ShadowStatisticsPush {
        /// Share of the history that a frame keeps.
        pub keep: f32,
        /// Threads in a row.
        pub width: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `nee_at_proxies.comp`.
    pub struct NeeAtPush {
        /// `NeeAtTile[]` to make.
        pub tiles: u64,
        /// The same of the last frame.
        pub tiles_before: u64,
        /// `uvec2[]` of the split frame: a light and the bits of its weight, of the last frame.
        pub feedback: u64,
        /// Share of the samples that are drawn from the proxies.
        pub narrow: f32,
        /// Share of the other samples that are drawn uniformly.
        pub uniform_share: f32,
        /// Share of the evidence that outlives a frame.
        pub history: f32,
        /// Proxies of a tile that are lights by power.
        pub global_proxies: u32,
        /// Proxies of a tile that are kept from the last frame.
        pub kept_proxies: u32,
        /// 1 = there is no last frame.
        pub reset: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `direct.trace`.
    pub struct DirectPush {
        /// `NeeAtTile[]`, 0: none.
        pub nee_at_tiles: u64,
        /// `uvec2[]` of the split frame: a light and the bits of its weight, for the next frame; 0: none.
        pub nee_at_feedback: u64,
        /// `KIND_*` bits.
        pub kinds: u32,
        /// Instances that cast shadows.
        pub mask: u32,
        /// 1 = transmissive surfaces tint the light that goes through them.
        pub tinted_glass: u32,
        /// 1 = one BRDF of mixed parameters, see brdf.glsl.
        pub mixed: u32,
        /// Perceptual roughness up to which a second ray looks for the environment.
        pub reflection_roughness: f32,
        /// 2^bias on the texture gradients.
        pub lod_scale: f32,
        /// Light samples a pixel.
        pub samples: u32,
        /// `RIS_SOURCE_*`.
        pub ris_source: u32,
        /// Candidates of resampled importance sampling.
        pub ris_candidates: u32,
        /// 1 = the numbers that choose them are spread evenly.
        pub ris_stratified: u32,
        /// Candidates of a sample of nee-at.
        pub nee_at_candidates: u32,
        /// Alignment.
        pub pad: u32,
    }
}
