//! Records of the test kernel.

use pt_shaders::glam::Vec3;

pt_shaders::gpu_struct! {
    /// What the kernel reads and writes for one case.
    pub struct ShRecord {
        /// Two unit directions.
        pub directions: [Vec3; 2],
        /// Radiance from them.
        pub radiances: [Vec3; 2],
        /// Unit normal.
        pub normal: Vec3,
        /// Result: irradiance.
        pub irradiance: Vec3,
        /// Result: irradiance at `normal` of `sh_encode_irradiance` of the first direction and radiance, for the second direction as normal.
        pub of_irradiance: Vec3,
        /// Result: irradiance at `normal` of `sh_constant` of the first radiance.
        pub of_constant: Vec3,
        /// Result: luma coefficients of both together, l = 1.
        pub luma1: Vec3,
        /// Result: luma, l = 0.
        pub luma0: f32,
        /// Result: Co, Cg.
        pub chroma: [f32; 2],
    }
}
