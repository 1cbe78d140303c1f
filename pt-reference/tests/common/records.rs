pt_shaders::gpu_struct! {
    /// A surface in the frame of its shading normal, and directions.
    pub struct BsdfCase {
        /// Linear.
        pub base_color: glam::Vec3,
        /// 0..1.
        pub metallic: f32,
        /// GGX alpha along x and y; 0: a delta.
        pub alpha: glam::Vec2,
        /// Index of refraction behind over in front.
        pub eta: f32,
        /// KHR_materials_specular factor.
        pub specular: f32,
        /// And its colour.
        pub specular_color: glam::Vec3,
        /// 0..1.
        pub transmission: f32,
        /// Clearcoat factor.
        pub coat: f32,
        /// 0: a delta.
        pub coat_alpha: f32,
        /// Normal of the coat.
        pub coat_normal: glam::Vec3,
        /// Linear.
        pub sheen_color: glam::Vec3,
        /// Square of the roughness.
        pub sheen_alpha: f32,
        /// `BSDF_SOLID` = 1, `BSDF_ENERGY_COMPENSATION` = 2.
        pub flags: u32,
        /// Normal of the triangle.
        pub face_normal: glam::Vec3,
        /// To the viewer.
        pub wo: glam::Vec3,
        /// To the light.
        pub wi: glam::Vec3,
        /// Thin film: strength, index of refraction, thickness in nm.
        pub film: glam::Vec3,
        /// Alignment.
        pub pad: [u32; 2],
        /// Random numbers.
        pub u: glam::Vec4,
    }
}

pt_shaders::gpu_struct! {
    /// A boundary that a path crosses. Words as interior.glsl packs them.
    pub struct InteriorEvent {
        /// The solid behind the surface.
        pub behind: u32,
        /// Its index of refraction.
        pub behind_ior: f32,
        /// The solid in front of the surface, 0: none.
        pub front: u32,
        /// Its index of refraction.
        pub front_ior: f32,
        /// 1: from the front to behind.
        pub entering: u32,
    }
}

pt_shaders::gpu_struct! {
    /// What interior.glsl says about an `InteriorEvent`.
    pub struct InteriorResult {
        /// Word of the solid on the path's side.
        pub here: u32,
        /// And on the other.
        pub beyond: u32,
        /// Their index of refraction.
        pub here_ior: f32,
        /// As above.
        pub beyond_ior: f32,
        /// What is there after the crossing.
        pub top: u32,
        /// 1: a false hit.
        pub false_hit: u32,
    }
}

pt_shaders::gpu_struct! {
    /// A place in the sequences of sampler.glsl.
    pub struct SamplerCase {
        /// `SAMPLER_*`.
        pub kind: u32,
        /// Pixel.
        pub x: u32,
        /// Pixel.
        pub y: u32,
        /// Sample of the pixel.
        pub index: u32,
        /// Seed of the run.
        pub seed: u32,
        /// Logarithm of the samples of a pixel.
        pub log2_spp: u32,
        /// Dimension.
        pub dimension: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of the list kernels.
    pub struct ListPush {
        /// Number of threads.
        pub count: u32,
        /// Entries of a thread.
        pub per_thread: u32,
    }
}

pt_shaders::gpu_struct! {
    /// What bsdf.glsl says about a `BsdfCase`.
    pub struct BsdfResult {
        /// Value for wi.
        pub f_cos: glam::Vec3,
        /// Density of wi.
        pub pdf: f32,
        /// Of the sample.
        pub direction: glam::Vec3,
        /// Its density; 0: no sample.
        pub sample_pdf: f32,
        /// f cos / pdf.
        pub weight: glam::Vec3,
        /// SAMPLE_DELTA = 1, SAMPLE_TRANSMISSION = 2.
        pub flags: u32,
        /// Value for the sample's direction.
        pub sample_f_cos: glam::Vec3,
        /// Density of the sample's direction.
        pub pdf_again: f32,
        /// The coat's normal, bent for wo.
        pub bent: glam::Vec3,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of the statistical kernels.
    pub struct HistogramPush {
        /// Axis of the chart.
        pub axis: glam::Vec3,
        /// Width of the lobe in the chart, radians or so.
        pub width: f32,
        /// Number of threads.
        pub count: u32,
        /// Samples of each thread, or midpoints along each side of a bin.
        pub per_thread: u32,
        /// Seed of the random numbers.
        pub seed: u32,
        /// Bins along each side of the chart.
        pub bins: u32,
        /// Which case.
        pub index: u32,
        /// Alignment.
        pub pad: [u32; 3],
    }
}
