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
    /// A BRDF and directions to evaluate it for.
    pub struct BrdfCase {
        /// Base colour, f90 of the dielectric.
        pub base: glam::Vec4,
        /// F0 of the dielectric.
        pub f0: glam::Vec3,
        /// Metalness.
        pub metallic: f32,
        /// Perceptual roughness.
        pub roughness: f32,
        /// View direction.
        pub v: glam::Vec3,
        /// Light direction.
        pub l: glam::Vec3,
        /// Random numbers.
        pub xi: glam::Vec3,
        /// 1 = mixed parameters.
        pub mixed: u32,
        /// Alignment.
        pub pad: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `light_bvh.comp`.
    pub struct LightBvhPush {
        /// Address of the nodes.
        pub nodes: u64,
        /// Address of the trails.
        pub trails: u64,
        /// Shading point.
        pub position: glam::Vec3,
        /// Perceptual roughness.
        pub roughness: f32,
        /// Normal.
        pub normal: glam::Vec3,
        /// Number of picks, or of lights.
        pub count: u32,
        /// Direction to the viewer.
        pub view: glam::Vec3,
        /// Seed of the random numbers.
        pub seed: u32,
        /// 1 = importance by spherical Gaussians.
        pub gaussian: u32,
        /// 1 = picks, 0 = the pmf of each light.
        pub picks: u32,
    }
}
