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

/// `DirectPush::kinds`: directional lights.
pub const KIND_SUN: u32 = 1;
/// `DirectPush::kinds`: point and spot lights.
pub const KIND_POSITIONAL: u32 = 2;
/// `DirectPush::kinds`: emissive triangles.
pub const KIND_EMISSIVE: u32 = 4;
/// `DirectPush::kinds`: the environment.
pub const KIND_ENVIRONMENT: u32 = 8;

/// GLSL of this module (`lights_records.glsl`).
#[allow(dead_code, reason = "for the build script, which includes this file")]
pub fn glsl() -> String {
    let kinds = [
        ("KIND_SUN", KIND_SUN),
        ("KIND_POSITIONAL", KIND_POSITIONAL),
        ("KIND_EMISSIVE", KIND_EMISSIVE),
        ("KIND_ENVIRONMENT", KIND_ENVIRONMENT),
    ];
    let constants: String =
        kinds.iter().map(|(name, bit)| format!("const uint {name} = {bit}u;\n")).collect();
    constants + &<DirectPush as pt_shaders::GpuStruct>::glsl()
}
