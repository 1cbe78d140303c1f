pt_shaders::gpu_struct! {
    /// Where a surface is asked for.
    pub struct MaterialCase {
        /// Weights of the triangle's second and third vertex.
        pub barycentrics: glam::Vec2,
        /// Instance index.
        pub instance: u32,
        /// Triangle of the instance's mesh.
        pub triangle: u32,
        /// UV that the footprint is wide along u and v.
        pub footprint: glam::Vec2,
        /// Numbers of the stochastic texture filter: texel.
        pub random_texel: glam::Vec2,
        /// Mip level, and place along the footprint.
        pub random_level_place: glam::Vec2,
    }
}

pt_shaders::gpu_struct! {
    /// Members of MaterialSample and LobesSample.
    pub struct MaterialResult {
        pub base_color: glam::Vec3,
        pub alpha: f32,
        pub metallic: f32,
        pub roughness: f32,
        pub ior: f32,
        pub specular: f32,
        pub specular_color: glam::Vec3,
        pub transmission: f32,
        pub normal: glam::Vec3,
        pub emission: glam::Vec3,
        pub clearcoat: f32,
        pub clearcoat_roughness: f32,
        pub clearcoat_normal: glam::Vec3,
        pub sheen_color: glam::Vec3,
        pub sheen_roughness: f32,
        pub anisotropy: f32,
        pub anisotropy_direction: glam::Vec2,
        pub iridescence: f32,
        pub iridescence_ior: f32,
        pub iridescence_thickness: f32,
        pub dispersion: f32,
    }
}
