//! Records that several crates read on the GPU. Spaces: world is metres, +Y up, right-handed.

pub use crate::constants::*;

use crate::gpu_struct::GpuStruct;
use crate::{gpu_struct, named_enum};
use glam::{Mat4, UVec2, UVec3, Vec2, Vec3, Vec4};

gpu_struct! {
    /// One view. Perspective: `half_extent` = tangent of half the field of view; orthographic: half the image in metres.
    pub struct CameraRecord {
        /// View space: camera looks along -Z, +Y up.
        pub view_from_world: Mat4,
        /// Inverse of `view_from_world`.
        pub world_from_view: Mat4,
        /// Half the image plane at distance 1 (perspective) or in metres (orthographic); x right, y up.
        pub half_extent: Vec2,
        /// Thin lens radius in metres; 0 = pinhole.
        pub lens_radius: f32,
        /// Distance to the plane in focus, along the view axis, in metres.
        pub focus_distance: f32,
        /// 0 = perspective, 1 = orthographic.
        pub projection: u32,
        /// Alignment.
        pub pad: [u32; 3],
    }
}

gpu_struct! {
    /// What every kernel of a frame may ask for.
    pub struct FrameRecord {
        /// This frame's camera.
        pub camera: CameraRecord,
        /// Last frame's camera (the same in the first frame).
        pub camera_prev: CameraRecord,
        /// Full frame in pixels.
        pub size: UVec2,
        /// Width of one checkerboard field: ceil(W / 2).
        pub field_width: u32,
        /// Frames since the start of the run.
        pub frame_index: u32,
        /// Seed of the run.
        pub seed: u32,
        /// Alignment.
        pub pad: [u32; 3],
    }
}

/// Width of one checkerboard field of a frame that is `width` wide.
pub const fn field_width(width: u32) -> u32 {
    width.div_ceil(2)
}

impl FrameRecord {
    /// A frame of `size` pixels, seen by `camera` and, in the last frame, by `camera_prev`.
    pub fn new(
        camera: CameraRecord,
        camera_prev: CameraRecord,
        size: [u32; 2],
        frame_index: u32,
        seed: u32,
    ) -> Self {
        let field_width = field_width(size[0]);
        Self { camera, camera_prev, size: size.into(), field_width, frame_index, seed, pad: [0; 3] }
    }
}

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
        /// `uint[]`: for each instance where its part of this table begins, or [`NONE`] when it has no emissive triangle;
        /// a part holds for each triangle of the mesh its index in `emissives`, or [`NONE`].
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
        /// Number of instances.
        pub instance_count: u32,
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
        /// Alignment.
        pub pad: UVec2,
    }
}

gpu_struct! {
    /// A parallelogram that the environment shines through, world space.
    pub struct PortalRecord {
        /// One corner.
        pub corner: Vec3,
        /// From there to the next.
        pub edge1: Vec3,
        /// And to the one on the other side.
        pub edge2: Vec3,
    }
}

gpu_struct! {
    /// The tables by which lights are chosen, as device addresses, and how many lights there are. A scene has them twice: those of this
    /// frame and those of the last one (`lights/light_tables.glsl`).
    pub struct LightTablesRecord {
        /// `LightRecord[light_count]`: the directional lights, then the positional ones.
        pub lights: u64,
        /// `LocalLightRecord[local_light_count]`.
        pub local_lights: u64,
        /// `LightCandidateRecord[local_light_count]`: the same lights, as their weights in a choice need them.
        pub light_candidates: u64,
        /// `AliasRecord[local_light_count]`: local lights by luminous power.
        pub local_alias: u64,
        /// `ClusterListRecord[]` of each cluster.
        pub cluster_lists: u64,
        /// `uint[]`: the local lights that `cluster_lists` point to, those that stand still, subset by subset.
        pub cluster_entries: u64,
        /// `uvec2[]`: for each cluster which of the lights that stand still its list has, 32 in a word: a bit each, and the places before them;
        /// 0: there would be too many words, places are searched for.
        pub cluster_ranks: u64,
        /// `uint[]`: those that move.
        pub cluster_moving_entries: u64,
        /// `float[]`: for each cluster and side the weights of the subsets of its list; see `lights/subsets.glsl`.
        pub cluster_subsets: u64,
        /// `LightBvhNode[]`: the light tree, the root first.
        pub light_bvh: u64,
        /// `uint64_t[]`: for each local light its branches from the root.
        pub light_bvh_trails: u64,
        /// `uint[]`: `shadow_counts` of the frames before, two half floats. In a hash table every second word, after its key.
        pub shadow_history: u64,
        /// `uint[]`: what the entries of a hash table stand for, every second word; 0: free.
        pub shadow_keys: u64,
        /// Number of punctual lights.
        pub light_count: u32,
        /// How many of the punctual lights are directional.
        pub sun_count: u32,
        /// Number of local lights: emissive triangles, quads of the environment, point and spot lights; 0 if all are dark.
        pub local_light_count: u32,
        /// Luminous flux of the lights in the light tree.
        pub light_bvh_power: f32,
        /// Words of a cluster in `cluster_ranks`.
        pub cluster_rank_words: u32,
        /// Alignment.
        pub pad: u32,
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
        /// Instance index; [`NONE`]: nothing was hit, the rest means nothing.
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
        }
    }
}

gpu_struct! {
    /// A node of a compressed 8-wide BVH (Ylitie et al. 2017). As 64-bit words: on lavapipe the number of loads counts.
    pub struct BvhNode {
        /// 0: origin x, y. 1: origin z; exponents x, y, z and the set of inner children, a byte each. 2: first inner child and
        /// first leaf entry, 28 bits each, with the set of leaves in the bits above (low half, high half). 3 to 8: planes of
        /// the children, a byte each: x lower, x upper, y lower, y upper, z lower, z upper.
        pub words: [u64; 9],
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
    }
}

gpu_struct! {
    /// Use of a texture by a material.
    pub struct TextureSlot {
        /// Bindless index, or [`NONE`].
        pub texture: u32,
        /// 0 or 1.
        pub uv_set: u32,
        /// UV transform: two rows of an affine 2x3 matrix (KHR_texture_transform).
        pub transform: [[f32; 3]; 2],
    }
}

gpu_struct! {
    /// A glTF metallic-roughness material.
    pub struct MaterialRecord {
        /// Linear base colour factor and alpha.
        pub base_color: Vec4,
        /// Emitted radiance factor (emissiveFactor x emissiveStrength), linear.
        pub emissive: Vec3,
        /// Metalness factor.
        pub metallic: f32,
        /// Perceptual roughness factor.
        pub roughness: f32,
        /// Normal map scale.
        pub normal_scale: f32,
        /// Alpha cutoff of MASK materials.
        pub alpha_cutoff: f32,
        /// Index of refraction.
        pub ior: f32,
        /// KHR_materials_transmission factor.
        pub transmission: f32,
        /// KHR_materials_volume thickness; 0 = thin.
        pub thickness: f32,
        /// KHR_materials_specular factor.
        pub specular: f32,
        /// Distance in metres at which the attenuation colour is reached; 0 = no absorption.
        pub attenuation_distance: f32,
        /// KHR_materials_specular colour factor.
        pub specular_color: Vec3,
        /// `MATERIAL_*` bits.
        pub flags: u32,
        /// KHR_materials_volume attenuation colour.
        pub attenuation_color: Vec3,
        /// Index of the `LobeRecord`, or [`NONE`]: no extension lobe and no texture of those that stand there.
        pub lobes: u32,
        /// Of nested solids. Bits 0-7: priority. Bits 8-31: 1 + `medium` of the material on the front side of an interface
        /// of two solids; 0: none.
        pub nesting: u32,
        /// What is behind the surface: the first of all materials with the same index, attenuation and priority.
        pub medium: u32,
        /// Alignment.
        pub pad: [u32; 2],
        /// Base colour and alpha.
        pub base_color_texture: TextureSlot,
        /// Roughness in g, metalness in b.
        pub metallic_roughness_texture: TextureSlot,
        /// Tangent-space normal.
        pub normal_texture: TextureSlot,
        /// Emission.
        pub emissive_texture: TextureSlot,
    }
}

gpu_struct! {
    /// What few materials have: lobes of KHR extensions, and textures of factors that stand in `MaterialRecord`. Textures
    /// multiply the factor of the same name.
    pub struct LobeRecord {
        /// KHR_materials_clearcoat factor.
        pub clearcoat: f32,
        /// Perceptual roughness of the coat.
        pub clearcoat_roughness: f32,
        /// Scale of the coat's normal map.
        pub clearcoat_normal_scale: f32,
        /// KHR_materials_sheen colour, linear.
        pub sheen_color: Vec3,
        /// Perceptual roughness of the sheen.
        pub sheen_roughness: f32,
        /// KHR_materials_anisotropy strength, 0 to 1.
        pub anisotropy_strength: f32,
        /// Direction of the anisotropy, radians from the tangent towards the bitangent.
        pub anisotropy_rotation: f32,
        /// KHR_materials_iridescence factor.
        pub iridescence: f32,
        /// Index of refraction of the thin film.
        pub iridescence_ior: f32,
        /// Thickness of the film in nanometres where the texture is 0.
        pub iridescence_thickness_min: f32,
        /// Thickness of the film in nanometres where the texture is 1 or absent.
        pub iridescence_thickness_max: f32,
        /// KHR_materials_dispersion: 20 / Abbe number.
        pub dispersion: f32,
        /// `MaterialRecord::transmission`, in r.
        pub transmission_texture: TextureSlot,
        /// `MaterialRecord::thickness`, in g; what traces rays takes the thickness from the geometry.
        pub thickness_texture: TextureSlot,
        /// `MaterialRecord::specular`, in a.
        pub specular_texture: TextureSlot,
        /// `MaterialRecord::specular_color`.
        pub specular_color_texture: TextureSlot,
        /// In r.
        pub clearcoat_texture: TextureSlot,
        /// In g.
        pub clearcoat_roughness_texture: TextureSlot,
        /// Tangent-space normal of the coat.
        pub clearcoat_normal_texture: TextureSlot,
        /// Colour.
        pub sheen_color_texture: TextureSlot,
        /// In a.
        pub sheen_roughness_texture: TextureSlot,
        /// Direction in rg (0 to 1 for -1 to 1), strength in b.
        pub anisotropy_texture: TextureSlot,
        /// In r.
        pub iridescence_texture: TextureSlot,
        /// Between minimum and maximum, in g.
        pub iridescence_thickness_texture: TextureSlot,
    }
}

named_enum! {
    /// How `sampler.glsl` makes random numbers; `SAMPLER_*` in GLSL.
    pub enum SamplerKind: "SAMPLER" {
        /// A hash: all numbers are independent.
        Pcg = "pcg",
        /// Owen-scrambled Sobol points; pixels are independent.
        Sobol = "sobol",
        /// Owen-scrambled Sobol points over the whole image in the order of a scrambled Morton curve: the error is blue noise.
        BlueNoise = "blue-noise",
    }
}

named_enum! {
    /// Where the frame's stages take their random numbers from; `RANDOM_*` in GLSL.
    pub enum RandomSource: "RANDOM" {
        /// A hash: pixels, frames and dimensions are independent.
        White = "white",
        /// A blue-noise mask across the pixels: less of the error is left after a blur. Frames are independent.
        BlueNoise = "blue-noise",
        /// A scrambled Sobol sequence over the frames, moved by the mask from pixel to pixel: means of frames converge faster too.
        Sobol = "sobol",
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

named_enum! {
    /// How `triangle_sampling.glsl` draws a point of a triangle for a shading point; `AREA_SAMPLING_*` in GLSL.
    pub enum AreaSampling: "AREA_SAMPLING" {
        /// Uniform in area: cheap, and noisy near the triangle.
        Uniform = "uniform",
        /// Uniform in the solid angle that the triangle fills.
        Spherical = "spherical",
        /// Uniform in solid angle, then warped to be nearly proportional to the cosine at the receiver.
        Projected = "projected",
    }
}

named_enum! {
    /// What is seen where a camera ray meets no surface; `BACKGROUND_*` in GLSL.
    pub enum Background: "BACKGROUND" {
        /// The environment.
        Environment = "environment",
        /// Nothing: radiance 0, alpha 0. Mirrors and glass show the environment all the same.
        Transparent = "transparent",
    }
}

named_enum! {
    /// Which part of the specular light of emissive triangles direct lighting leaves to bounce rays; `EMISSION_SHARE_*` in GLSL.
    pub enum EmissionShare: "EMISSION_SHARE" {
        /// None: light samples find all of it.
        LightSamples = "light-samples",
        /// All of it where the surface is smoother than a perceptual roughness of 0.18, none where it is rougher.
        Crossover = "crossover",
        /// Multiple importance sampling: by the densities with which the two find a point of the triangle.
        Mis = "mis",
    }
}

gpu_struct! {
    /// A punctual light (KHR_lights_punctual), intensity used 1:1 with radiance.
    pub struct LightRecord {
        /// Colour x intensity: candela (point, spot) or lux (directional).
        pub intensity: Vec3,
        /// `LIGHT_*`.
        pub kind: u32,
        /// Position, world space.
        pub position: Vec3,
        /// Radius of a spherical source in metres (point, spot), half angle in radians (directional); 0 = delta.
        pub radius: f32,
        /// Direction in which the light shines, world space, unit length.
        pub direction: Vec3,
        /// Spot attenuation = clamp(cos * scale + offset)^2.
        pub spot_scale: f32,
        /// See `spot_scale`.
        pub spot_offset: f32,
        /// Probability with which this light is picked in its group (directional or positional).
        pub pmf: f32,
        /// Sum of `pmf` in the group up to and including this light.
        pub cdf: f32,
        /// Alignment.
        pub pad: u32,
    }
}

gpu_struct! {
    /// An emissive triangle: where to find it and how likely it is picked.
    pub struct EmissiveRecord {
        /// Instance index.
        pub instance: u32,
        /// Triangle of the instance's mesh.
        pub triangle: u32,
        /// Probability with which the alias table picks it.
        pub pmf: f32,
        /// Mean luminance of its radiance, with its texture.
        pub luminance: f32,
    }
}

named_enum! {
    /// What becomes of light on its straight way through transmissive surfaces.
    pub enum GlassShadows: "GLASS_SHADOWS" {
        /// It is stopped.
        Stopped = "stopped",
        /// It goes straight on, tinted and weakened by each surface.
        Tinted = "tinted",
        /// As `tinted` through smooth sheets and media of index 1, which do not bend it. Other glass stops it: rays alone find light behind it.
        Straight = "straight",
        /// It goes on as if they were not there.
        Passed = "passed",
    }
}

impl GlassShadows {
    /// Whether shadow rays look for glass, which tints their light.
    pub const fn tints(self) -> bool {
        matches!(self, Self::Tinted | Self::Straight)
    }
}

named_enum! {
    /// How the light is chosen that a shading point takes its sample from.
    pub enum LightSampler: "LIGHT_SAMPLER" {
        /// Each light with the same probability.
        Uniform = "uniform",
        /// By luminous power, wherever the point is.
        Power = "power",
        /// Among 8 of the lights of the point's cluster, by solid angle, Phong lobe and luminance.
        ClusterCdf = "cluster-cdf",
        /// As `cluster-cdf`, times the share of last frames' shadow rays of the cluster that reached the light.
        ClusterStats = "cluster-stats",
        /// By a random descent through a tree over the lights, with their bounds and the cones of their normals.
        LightBvh = "light-bvh",
        /// Resampled importance sampling: several candidates, of which the estimate of their light chooses one.
        Ris = "ris",
        /// As `ris`, then reuse of the samples of the last frame and of neighbours (spatiotemporal reservoir resampling).
        RestirDi = "restir-di",
        /// By what the samples of last frames found in the pixel's tile of the screen, else by luminous power.
        NeeAt = "nee-at",
    }
}

impl LightSampler {
    /// Whether a pixel can take its light sample of the last frame again (gradient pixels; `lights/light_tables.glsl`). `restir-di` and
    /// `nee-at` can't: their choices depend on histories of the screen that are not kept for a second frame.
    pub const fn replays(self) -> bool {
        !matches!(self, Self::RestirDi | Self::NeeAt)
    }

    /// Which tables it reads beside the lights themselves; `source`: where the candidates of `ris` and `restir-di` come from.
    pub const fn tables(self, source: RisSource) -> SamplerTableSet {
        let (lists, statistics, tree) = match self {
            Self::Uniform | Self::Power | Self::NeeAt => (false, false, false),
            Self::ClusterCdf => (true, false, false),
            Self::ClusterStats => (true, true, false),
            Self::LightBvh => (false, false, true),
            Self::Ris | Self::RestirDi => (matches!(source, RisSource::Cluster), false, false),
        };
        SamplerTableSet { lists, statistics, tree }
    }
}

/// Tables that a light sampler reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerTableSet {
    /// Light lists of the clusters.
    pub lists: bool,
    /// Shadow statistics of the lists.
    pub statistics: bool,
    /// The light tree.
    pub tree: bool,
}

named_enum! {
    /// How important a node of the light tree is for a shading point.
    pub enum BvhImportance: "BVH_IMPORTANCE" {
        /// By bounds of distance and angles.
        Bounds = "bounds",
        /// By products of spherical Gaussians of the lights and of the BRDF.
        SphericalGaussian = "spherical-gaussian",
    }
}

named_enum! {
    /// Where the candidates of resampled importance sampling come from.
    pub enum RisSource: "RIS_SOURCE" {
        /// All lights, by luminous power.
        Power = "power",
        /// The lights of the point's cluster, with equal probability.
        Cluster = "cluster",
    }
}

gpu_struct! {
    /// A local light as it is now: an emissive triangle, a point or a spot light, a quad of the environment. The table has the emissive
    /// triangles, then the positional lights in the order of their records, then the quads.
    pub struct LocalLightRecord {
        /// First corner or centre, world space. Quad: axis of the cone of its directions, world space, unit length.
        pub position: Vec3,
        /// `LOCAL_*`.
        pub kind: u32,
        /// Triangle: second corner - first. Quad: cosine and sine of the cone's half angle. Else radius, `spot_scale`, `spot_offset`.
        pub edge1: Vec3,
        /// Luminance of the mean radiance (triangle), of the intensity, or of the irradiance of a surface that faces the light (quad).
        pub luminance: f32,
        /// Triangle: third corner - first. Spot light: where it shines, unit length. Quad: cosine and sine of the environment's rotation,
        /// and its intensity.
        pub edge2: Vec3,
        /// Alignment.
        pub pad0: u32,
        /// Radiance without texture (triangle), or intensity.
        pub radiance: Vec3,
        /// Alignment.
        pub pad1: u32,
    }
}

gpu_struct! {
    /// What the weight of a local light in a choice needs of its [`LocalLightRecord`], in 32 bytes, one sector of a cache. Made and read in
    /// `lights/light_candidate.glsl`.
    pub struct LightCandidateRecord {
        /// As in [`LocalLightRecord`].
        pub position: Vec3,
        /// `LOCAL_*`; [`LOCAL_EXACT`]. Bits 16 to 31: triangle: exponent of the edges + 128; point and spot light: radius as a
        /// half float, rounded up.
        pub kind: u32,
        /// Triangle: the edges, 6 x 16 bits, signed normalised, times 2^exponent. Spot light: where it shines, octahedral, `spot_scale` and
        /// `spot_offset` as bits. Quad: cosine and sine of the cone's half angle as bits.
        pub words: UVec3,
        /// As in [`LocalLightRecord`].
        pub luminance: f32,
    }
}

gpu_struct! {
    /// A quad of the environment, a rectangle of cells. In it a direction is drawn by cell, then uniformly in the cell's solid angle.
    pub struct EnvironmentQuadRecord {
        /// Axis of a cone that has all its directions, unit length, as the picture is before its rotation.
        pub axis: Vec3,
        /// Cosine of the cone's half angle.
        pub cos_spread: f32,
        /// First column and row.
        pub corner: UVec2,
        /// Columns and rows.
        pub size: UVec2,
        /// First entry of its cells, row by row, in the table of all cells.
        pub first: u32,
        /// Luminance of the irradiance of a surface that faces it, at intensity 1.
        pub irradiance: f32,
    }
}

gpu_struct! {
    /// A node of the quad-tree over the environment.
    pub struct EnvironmentQuadNode {
        /// First column and row that belong to the children on the far side.
        pub split: UVec2,
        /// First of four children: near and far column of the near row, the same of the far row. Or [`ENVIRONMENT_QUAD_LEAF`] and the index
        /// of a quad.
        pub link: u32,
    }
}

gpu_struct! {
    /// The lights that a cluster's points may see: two parts of a table of local lights, each in ascending order.
    pub struct ClusterListRecord {
        /// First of the lights that stand still.
        pub first: u32,
        /// How many they are.
        pub count: u32,
        /// First of the lights that move.
        pub moving_first: u32,
        /// How many they are.
        pub moving_count: u32,
        /// Probability with which a light is picked among all instead; above 0 where the list leaves out lights.
        pub catch_all: f32,
    }
}

gpu_struct! {
    /// What a tile of the screen has learned about the local lights (`lights/nee_at.glsl`).
    pub struct NeeAtTile {
        /// Share of the samples that are drawn from `lights`; 0: they mean nothing.
        pub narrow: f32,
        /// Share of the other samples that are drawn uniformly from all lights, not by power.
        pub uniform_share: f32,
        /// How many samples have found light, of which the older ones count less.
        pub evidence: f32,
        /// The proxies: local lights in ascending order, with repetition.
        pub lights: [u32; NEE_AT_PROXIES as usize],
    }
}

const _: () = assert!(size_of::<NeeAtTile>() == NEE_AT_TILE_BYTES as usize);

gpu_struct! {
    /// Entry of an alias table (Walker 1977, construction of Vose 1991).
    pub struct AliasRecord {
        /// Probability of keeping this entry rather than taking `alias`.
        pub keep: f32,
        /// The other entry.
        pub alias: u32,
        /// Probability of this entry over the whole table.
        pub pmf: f32,
    }
}

gpu_struct! {
    /// A node of the tree over the local lights (`lights/light_bvh.glsl`), one sector of a cache. Where digits are lost, bounds become wider.
    pub struct LightBvhNode {
        /// Middle of the box of the points that emit.
        pub center: Vec3,
        /// Half of the box's size, rounded up: 3 x 8 bits, times 2^(bits 24 to 31 - 128).
        pub extent: u32,
        /// First of two children that follow each other, or [`LIGHT_BVH_LEAF`] and the index of a light.
        pub link: u32,
        /// Bits 0 to 15: axis of the cone of the emitters' normals: octahedral, 2 x 8 bits. Bits 16 to 23: sine of half of its half angle; bits 24 to
        /// 31: of half of the angle to the normal up to which a point emits; unsigned normalised, rounded up.
        pub cone: u32,
        /// Mean position of the power within the box, 3 x 8 bits, and standard deviation of the positions over half the box's diagonal, 8 bits:
        /// unsigned normalised.
        pub mean: u32,
        /// Bits 0 to 15: mean direction of the emission: octahedral, 2 x 5 bits, and its length, 6 bits. Bits 16 to 31: share of the power of all
        /// lights, the upper half of a float; 0: all lights of the node are dark.
        pub lobe: u32,
    }
}

macro_rules! table {
    ($($record:ident),* $(,)?) => {
        /// Name, size and members of every record of this module, for the layout check against SPIR-V.
        pub fn all() -> Vec<(&'static str, usize, Vec<crate::Field>)> {
            vec![$((<$record as GpuStruct>::STRUCT_NAME, size_of::<$record>(), $record::fields())),*]
        }

        fn declarations() -> String {
            [$($record::glsl()),*].concat()
        }
    };
}

// In order of use: a record stands after those that it contains.
table! {
    CameraRecord,
    FrameRecord,
    InstanceRecord,
    MeshRecord,
    LightTablesRecord,
    SceneRecord,
    ClusterNode,
    VertexRecord,
    Ray,
    Hit,
    RayListHead,
    BvhTriangle,
    BvhNode,
    TextureSlot,
    MaterialRecord,
    LobeRecord,
    LightRecord,
    EmissiveRecord,
    AliasRecord,
    LocalLightRecord,
    LightCandidateRecord,
    EnvironmentQuadRecord,
    EnvironmentQuadNode,
    PortalRecord,
    ClusterListRecord,
    LightBvhNode,
    NeeAtTile,
}

/// GLSL declarations of this module (`records.glsl`), after the constants.
pub fn glsl() -> String {
    let mut text = String::from("#include \"constants.glsl\"\n");
    text.push_str(&SamplerKind::glsl());
    text.push_str(&RandomSource::glsl());
    text.push_str(&Culling::glsl());
    text.push_str(&GlassShadows::glsl());
    text.push_str(&LightSampler::glsl());
    text.push_str(&RisSource::glsl());
    text.push_str(&BvhImportance::glsl());
    text.push_str(&AreaSampling::glsl());
    text.push_str(&Background::glsl());
    text.push_str(&EmissionShare::glsl());
    text.push_str(&declarations());
    text
}
