//! The scene's tables, and rays that are traced in them.

use super::light::LightTablesRecord;
use crate::constants::{RAY_LIST_HEAD_BYTES, RAY_LIST_SHADING_GROUP, RAY_LIST_TRACE_GROUP};
use crate::{gpu_struct, named_enum};
use glam::{UVec2, UVec3, Vec2, Vec3, Vec4};

gpu_struct! {
    /// The scene's tables as device addresses (`buffer_reference` types in scene.glsl).
    pub struct SceneRecord {
        /// The first instance. Kernels made for a scene that has no other find it here, the same for all threads.
        pub first_instance: InstanceRecord,
        /// Its mesh.
        pub first_mesh: MeshRecord,
        /// `InstanceRecord[instance_count]`.
        pub instances: u64,
        /// `MeshRecord[]`.
        pub meshes: u64,
        /// `MaterialRecord[]`.
        pub materials: u64,
        /// `LobeRecord[]`.
        pub lobes: u64,
        /// `EmissiveRecord[emissive_count]`.
        pub emissives: u64,
        /// `AliasRecord[emissive_count]`.
        pub emissive_alias: u64,
        /// `uint[]`: for each instance where its part of this table begins, or [`NONE`](super::NONE) when it has no emissive triangle;
        /// a part holds for each triangle of the mesh its index in `emissives`, or [`NONE`](super::NONE).
        pub emissive_lookup: u64,
        /// `AliasRecord[environment_size.x * environment_size.y]`.
        pub environment_alias: u64,
        /// `EnvironmentQuadRecord[environment_quad_count]`.
        pub environment_quads: u64,
        /// `EnvironmentQuadNode[]`: the quad-tree, the root first.
        pub environment_quad_nodes: u64,
        /// `AliasRecord[]`: for each quad a table over its cells.
        pub environment_quad_cells: u64,
        /// `PortalRecord[portal_count]`.
        pub portals: u64,
        /// The tables that change with the lights, as they are in this frame.
        pub light_tables: LightTablesRecord,
        /// The same as they were in the last frame, as far as something asks for them (`LightTables::keep_last_frame`, sampler
        /// restir-di); the other addresses are those of `light_tables`.
        pub light_tables_previous: LightTablesRecord,
        /// `uvec2[]`: shadow rays of this frame that reached a light, and that did not; see `lights/statistics.glsl`.
        pub shadow_counts: u64,
        /// `BvhNode[]` of the BVH over the instances (compute backend).
        pub tlas_nodes: u64,
        /// Instance indices in leaf order of `tlas_nodes`.
        pub tlas_instances: u64,
        /// Address of the driver's top-level acceleration structure (ray-query and rt-pipeline backends).
        pub tlas: u64,
        /// `ClusterNode[]`, the root first.
        pub clusters: u64,
        /// `uint[BLUE_NOISE_SIDE * BLUE_NOISE_SIDE]`: a blue-noise mask, ranks in the upper 12 bits.
        pub blue_noise: u64,
        /// `CameraRecord[]`: the scene's cameras, for surfaces that show what they see.
        pub cameras: u64,
        /// `EffectRecord[]`, in leaf order of `effect_nodes`.
        pub effects: u64,
        /// `EffectNode[effect_node_count]`.
        pub effect_nodes: u64,
        /// `FogRecord[fog_count]`.
        pub fog: u64,
        /// Nodes of the tree over the effects.
        pub effect_node_count: u32,
        /// Number of fog volumes.
        pub fog_count: u32,
        /// Number of emissive triangles.
        pub emissive_count: u32,
        /// Bindless index of the lat-long environment.
        pub environment_texture: u32,
        /// Width and height of the environment in texels.
        pub environment_size: UVec2,
        /// Cosine and sine of the environment's rotation about +Y.
        pub environment_rotation: Vec2,
        /// Factor on the environment's radiance; 0 = no environment.
        pub environment_intensity: f32,
        /// Coordinates that are near the origin, metres: there rays start off surfaces by a fixed length (ray_offset.glsl).
        pub near_origin: f32,
        /// Most local lights that there may be; dense shadow statistics have room for them.
        pub most_local_lights: u32,
        /// Entries of `shadow_counts`, 0: none; a power of two when they are hashed.
        pub shadow_count_slots: u32,
        /// 1 = `shadow_counts` is a hash table, 0 = it has an entry for every cluster, light and direction.
        pub shadow_counts_hashed: u32,
        /// Columns and rows of cells of the environment's quads.
        pub environment_grid: UVec2,
        /// How many quads of the environment are local lights.
        pub environment_quad_count: u32,
        /// How many portals there are.
        pub portal_count: u32,
        /// Seconds; 0 in scenes without waves.
        pub time: f32,
        /// Alignment.
        pub pad: UVec2,
    }
}

gpu_struct! {
    /// A node of the tree that divides space into clusters (`clusters.glsl`).
    pub struct ClusterNode {
        /// Plane: coordinates below it are in the first child, all others in the second.
        pub split: f32,
        /// Bits 0-1: axis, or 3 for a leaf. Bits 2-31: first of two children that follow each other, or the cluster.
        pub link: u32,
    }
}

gpu_struct! {
    /// A mesh placed in the world. Matrices are the rows of affine 3x4 matrices.
    pub struct InstanceRecord {
        /// This frame.
        pub world_from_object: [Vec4; 3],
        /// Its inverse.
        pub object_from_world: [Vec4; 3],
        /// Last frame.
        pub world_from_object_prev: [Vec4; 3],
        /// Index of the mesh.
        pub mesh: u32,
        /// Visibility mask (8 bits); a ray sees an instance when `ray mask & mask != 0`.
        pub mask: u32,
        /// 1 when the transform mirrors (negative determinant), so that front faces keep their side.
        pub mirrored: u32,
        /// Index of the material of all its triangles; `NONE`: those of the mesh.
        pub material: u32,
    }
}

gpu_struct! {
    /// Geometry of one mesh, as device addresses.
    pub struct MeshRecord {
        /// `BvhNode[]` (compute backend).
        pub bvh_nodes: u64,
        /// `BvhTriangle[triangle_count]` in leaf order (compute backend).
        pub bvh_triangles: u64,
        /// `vec3[]`, object space.
        pub positions: u64,
        /// The same in the last frame; the same address for a mesh that does not change its shape.
        pub positions_prev: u64,
        /// `VertexRecord[]`.
        pub vertices: u64,
        /// `vec4[]`: linear colour factor and alpha of each vertex; 0: all are white.
        pub colors: u64,
        /// `uvec3[triangle_count]`.
        pub indices: u64,
        /// `uint[triangle_count]`: material index per triangle.
        pub triangle_materials: u64,
        /// `uvec4[triangle_count - first_masked]`: opacity.glsl; 0: there is none.
        pub opacity: u64,
        /// Triangles from here on need the alpha test.
        pub first_masked: u32,
        /// Number of triangles.
        pub triangle_count: u32,
    }
}

gpu_struct! {
    /// Shading attributes of a vertex.
    pub struct VertexRecord {
        /// Octahedral normal, 2 x 16 bit.
        pub normal: u32,
        /// Octahedral tangent, 16 + 15 bit; top bit set = bitangent is -cross(N, T).
        pub tangent: u32,
        /// First UV set.
        pub uv0: [f32; 2],
        /// Second UV set.
        pub uv1: [f32; 2],
    }
}

gpu_struct! {
    /// A ray in world space; t counts in lengths of `direction`.
    pub struct Ray {
        /// Start.
        pub origin: Vec3,
        /// Nothing nearer counts.
        pub t_min: f32,
        /// Direction, not necessarily of unit length.
        pub direction: Vec3,
        /// Nothing farther counts.
        pub t_max: f32,
    }
}

gpu_struct! {
    /// Where a ray meets a triangle.
    pub struct Hit {
        /// Instance index; [`NONE`](super::NONE): nothing was hit, the rest means nothing.
        pub instance: u32,
        /// Triangle of the instance's mesh.
        pub triangle: u32,
        /// Weights of the triangle's second and third vertex.
        pub barycentrics: Vec2,
        /// Distance along the ray.
        pub t: f32,
    }
}

gpu_struct! {
    /// Head of a list of rays, or of paths, that one pass writes and later ones are launched over (`ray_list.glsl`).
    pub struct RayListHead {
        /// How many there are.
        pub count: u32,
        /// Workgroups of a launch of a kernel that traces them.
        pub groups: UVec3,
        /// Workgroups of a launch of a kernel that shades them.
        pub shading_groups: UVec3,
        /// How many have been taken by lanes that take a new ray when theirs is done (`trace/refill.glsl`).
        pub taken: u32,
    }
}

const _: () = assert!(size_of::<RayListHead>() == RAY_LIST_HEAD_BYTES as usize);

impl RayListHead {
    /// Of a list without entries; `columns`: workgroups in a row of a launch that traces.
    pub const fn empty(columns: u32) -> Self {
        Self {
            count: 0,
            groups: UVec3::new(columns, 0, 1),
            shading_groups: UVec3::new(columns * RAY_LIST_TRACE_GROUP / RAY_LIST_SHADING_GROUP, 0, 1),
            taken: 0,
        }
    }
}

gpu_struct! {
    /// A node of a compressed 8-wide BVH (Ylitie et al. 2017), of whole loads of 16 bytes.
    pub struct BvhNode {
        /// 0: origin x, y. 1: origin z; exponents x, y, z and the set of inner children, a byte each. 2: first inner child and
        /// first leaf entry, 28 bits each, with the set of leaves in the bits above (low half, high half). 3 to 8: planes of
        /// the children, a byte each: x lower, x upper, y lower, y upper, z lower, z upper. 9: 0.
        pub words: [u64; 10],
    }
}

gpu_struct! {
    /// A triangle as the BVH traversal wants it.
    pub struct BvhTriangle {
        /// First vertex, object space.
        pub v0: Vec3,
        /// Second vertex minus first.
        pub e1: Vec3,
        /// Third vertex minus first.
        pub e2: Vec3,
        /// Triangle index in the mesh.
        pub triangle: u32,
        /// 0: whole loads of 16 bytes.
        pub padding: [u32; 2],
    }
}

named_enum! {
    /// Which rays go through the back faces of single-sided materials; `CULLING_*` in GLSL.
    pub enum Culling: "CULLING" {
        /// None: both sides of all surfaces are seen.
        None = "none",
        /// Those of the camera, and on from mirrors and smooth glass: what is seen is what glTF asks for, light meets both sides.
        Camera = "camera",
        /// All, shadow rays too.
        All = "all",
    }
}

impl Culling {
    /// What is left of it for rays that the camera does not see along.
    pub const fn unseen(self) -> Self {
        match self {
            Self::None | Self::Camera => Self::None,
            Self::All => Self::All,
        }
    }
}
