//! Push constants.

pt_shaders::gpu_struct! {
    /// Push constants of `interleave.comp`.
    pub struct InterleavePush {
        /// 1 = blend the two halves of split surfaces, 0 = copy every pixel.
        pub blend_split: u32,
    }
}
