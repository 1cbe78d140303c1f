//! Records of `deform.comp`.

use pt_shaders::GpuStruct;
use pt_shaders::glam::{Vec3, Vec4};

pt_shaders::gpu_struct! {
    /// Push constants.
    pub struct DeformPush {
        /// `DeformVertex[count + 1]`; the last one only ends the lists.
        pub vertices: u64,
        /// `DeltaRecord[]`.
        pub deltas: u64,
        /// `InfluenceRecord[]`.
        pub influences: u64,
        /// `JointRecord[]`, the pose.
        pub joints: u64,
        /// `float[]`: weights of the morph targets, the pose.
        pub weights: u64,
        /// `vec3[count]`, written.
        pub positions: u64,
        /// `VertexRecord[count]`, normals and tangents written.
        pub records: u64,
        /// Number of vertices.
        pub count: u32,
        /// Threads a row of the launch.
        pub width: u32,
    }
}

pt_shaders::gpu_struct! {
    /// A vertex at rest.
    pub struct DeformVertex {
        /// Object space, metres.
        pub position: Vec3,
        /// Its first displacement.
        pub first_delta: u32,
        /// Unit normal.
        pub normal: Vec3,
        /// Its first joint.
        pub first_influence: u32,
        /// Unit tangent with the bitangent's sign.
        pub tangent: Vec4,
    }
}

pt_shaders::gpu_struct! {
    /// What a morph target does to a vertex at weight 1.
    pub struct DeltaRecord {
        /// Index into the weights.
        pub target: u32,
        /// Added to the position.
        pub position: Vec3,
        /// Added to the normal.
        pub normal: Vec3,
        /// Added to the tangent.
        pub tangent: Vec3,
    }
}

pt_shaders::gpu_struct! {
    /// A joint that moves a vertex.
    pub struct InfluenceRecord {
        /// Index into the joints.
        pub joint: u32,
        /// Share.
        pub weight: f32,
    }
}

pt_shaders::gpu_struct! {
    /// World-from-mesh transform of a joint: rows of an affine 3x4 matrix.
    pub struct JointRecord {
        /// The rows.
        pub rows: [Vec4; 3],
    }
}

/// GLSL of this module (`deform_records.glsl`).
#[allow(dead_code, reason = "for the build script, which includes this file")]
pub fn glsl() -> String {
    [
        DeformPush::glsl(),
        DeformVertex::glsl(),
        DeltaRecord::glsl(),
        InfluenceRecord::glsl(),
        JointRecord::glsl(),
    ]
    .concat()
}
