//! Push constants of the kernels.

pt_shaders::gpu_struct! {
    /// Of `direct.trace`.
    pub struct DirectPush {
        /// `KIND_*` bits.
        pub kinds: u32,
        /// Instances that cast shadows.
        pub mask: u32,
    }
}
