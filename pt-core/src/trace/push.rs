pt_shaders::gpu_struct! {
    /// Push constants of the kernels that trace a list of rays.
    pub struct RayListPush {
        /// `Ray[count]`.
        pub rays: u64,
        /// `Hit[count]`.
        pub hits: u64,
        /// Number of rays.
        pub count: u32,
        /// Rays a row of the launch.
        pub width: u32,
        /// Instance mask of all rays.
        pub mask: u32,
        /// Of the numbers that decide which BLEND surfaces a ray meets.
        pub seed: u32,
    }
}
