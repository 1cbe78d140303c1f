//! Compiled kernels as the build scripts emit them.

/// Shader stage of a compiled module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Compute kernel.
    Compute,
    /// Ray generation shader.
    RayGen,
    /// Closest-hit shader.
    ClosestHit,
    /// Any-hit shader.
    AnyHit,
    /// Miss shader.
    Miss,
}

/// One SPIR-V module.
#[derive(Clone, Copy, Debug)]
pub struct ShaderCode {
    /// File stem of the GLSL source; pass tables and error messages use it.
    pub name: &'static str,
    /// Stage of its `main`.
    pub stage: Stage,
    /// SPIR-V, little endian.
    pub spirv: &'static [u8],
}

/// A kernel that traces rays (`*.trace`), compiled once for every trace backend from the same source.
#[derive(Clone, Copy, Debug)]
pub struct TraceCode {
    /// File stem of the GLSL source.
    pub name: &'static str,
    /// Own BVH traversal in a compute kernel.
    pub compute: ShaderCode,
    /// `VK_KHR_ray_query` in a compute kernel.
    pub ray_query: ShaderCode,
    /// Ray generation shader of a `VK_KHR_ray_tracing_pipeline`.
    pub ray_gen: ShaderCode,
    /// The same with `VK_NV_ray_tracing_invocation_reorder`.
    pub ray_gen_reorder: ShaderCode,
}
