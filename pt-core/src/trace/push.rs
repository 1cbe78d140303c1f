use pt_shaders::glam::Vec3;

pt_shaders::gpu_struct! {
    /// Push constants of the kernels that trace a list of rays.
    pub struct RayListPush {
        /// `Ray[count]`.
        pub rays: u64,
        /// `Hit[count]`.
        pub hits: u64,
        /// `uint`: how many rays have been taken; 0 at first.
        pub taken: u64,
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

pt_shaders::gpu_struct! {
    /// Push constants of `bvh_refit.comp`.
    pub struct RefitPush {
        /// `MeshRecord[]`.
        pub meshes: u64,
        /// `RefitNode[]`.
        pub nodes: u64,
        /// `NodeBounds[]`.
        pub bounds: u64,
        /// First entry of the level in `nodes`.
        pub first: u32,
        /// Number of nodes of the level.
        pub count: u32,
        /// Threads a row of the launch.
        pub width: u32,
        /// Alignment.
        pub pad: u32,
    }
}

pt_shaders::gpu_struct! {
    /// A node of a deforming mesh's BVH.
    pub struct RefitNode {
        /// Index of the mesh.
        pub mesh: u32,
        /// Index of the node in the mesh's BVH.
        pub node: u32,
        /// Where the bounds of the mesh's nodes begin.
        pub bounds: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Bounds of a node before they are put on its parent's grid.
    pub struct NodeBounds {
        /// Smallest corner.
        pub low: Vec3,
        /// Largest corner.
        pub high: Vec3,
    }
}
