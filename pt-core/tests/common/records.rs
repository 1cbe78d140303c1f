pt_shaders::gpu_struct! {
    /// Push constants of the test kernels.
    pub struct TestPush {
        /// Added to every texel.
        pub offset: f32,
    }
}
