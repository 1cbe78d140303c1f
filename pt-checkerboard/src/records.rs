//! Push constants.

use pt_shaders::glam::UVec2;

pt_shaders::gpu_struct! {
    /// Push constants of `interleave.comp`.
    pub struct InterleavePush {
        /// 1 = blend the two halves of split surfaces, 0 = copy every pixel.
        pub blend_split: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `add_plane.comp`.
    pub struct AddPlanePush {
        /// Pixels of the frame.
        pub size: UVec2,
    }
}
