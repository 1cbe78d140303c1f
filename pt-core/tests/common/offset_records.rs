use pt_shaders::glam::Vec3;

pt_shaders::gpu_struct! {
    /// Push constants of the kernel that offsets rays.
    pub struct OffsetPush {
        /// Number of rays.
        pub count: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Where a ray leaves a surface.
    pub struct OffsetStart {
        /// World space.
        pub position: Vec3,
        /// Unit.
        pub direction: Vec3,
        /// Unit, on the side of the direction.
        pub normal: Vec3,
    }
}
