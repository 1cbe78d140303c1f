pt_shaders::gpu_struct! {
    /// Push constants of the test kernels.
    pub struct SamplerPush {
        /// Which sampler.
        pub family: u32,
        /// Number of samples.
        pub count: u32,
        /// Seed of the random numbers.
        pub seed: u32,
        /// GGX alpha, or 1 - cos of a cone's half angle.
        pub parameter: f32,
        /// View direction, or shading point.
        pub vector: glam::Vec3,
    }
}

pt_shaders::gpu_struct! {
    /// What a sampler returned.
    pub struct SampleRecord {
        /// Point or direction.
        pub value: glam::Vec3,
        /// Its density.
        pub pdf: f32,
        /// Radiance of a light sample, diffuse part of a BRDF.
        pub radiance: glam::Vec3,
        /// Density by a function of the direction alone.
        pub pdf_again: f32,
        /// Target of a light sample, specular part of a BRDF.
        pub target: glam::Vec3,
        /// Entry of an alias table; flags of a light sample: 1 = delta, 2 = finite.
        pub word: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `pack_light.comp`.
    pub struct PackedRecord {
        /// The code.
        pub code: glam::UVec2,
        /// What it stands for.
        pub light: glam::Vec3,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `nee_at_picks.comp`.
    pub struct NeeAtPicksPush {
        /// A `NeeAtTile`.
        pub tile: u64,
        /// 0: picks; 1: the probability of each light.
        pub family: u32,
        /// Number of them.
        pub count: u32,
    }
}
