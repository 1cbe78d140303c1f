//! Push constants.

pt_shaders::gpu_struct! {
    /// Push constants of `composite.comp`; see `DenoiseParams`.
    pub struct CompositePush {
        /// Factor on the diffuse channel.
        pub scale_hf: f32,
        /// Factor on the indirect diffuse channel.
        pub scale_lf: f32,
        /// Factor on the specular channel.
        pub scale_spec: f32,
        /// Factor on the transparent layer's radiance.
        pub scale_overlay: f32,
        /// 1 = `albedo` stands for every surface's diffuse albedo.
        pub use_albedo: u32,
        /// See `use_albedo`.
        pub albedo: f32,
        /// 1 = pixels whose camera ray meets no surface are empty.
        pub transparent_background: u32,
    }
}
