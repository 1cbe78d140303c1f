//! Lights, and the tables of the samplers that choose among them.

use crate::constants::{NEE_AT_PROXIES, NEE_AT_TILE_BYTES};
use crate::{gpu_struct, named_enum};
use glam::{UVec2, UVec3, Vec3};

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
        /// `LOCAL_*`; [`LOCAL_EXACT`](super::LOCAL_EXACT). Bits 16 to 31: triangle: exponent of the edges + 128; point and spot light: radius as a
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
        /// First of four children: near and far column of the near row, the same of the far row. Or [`ENVIRONMENT_QUAD_LEAF`](super::ENVIRONMENT_QUAD_LEAF) and the index
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
        /// First of two children that follow each other, or [`LIGHT_BVH_LEAF`](super::LIGHT_BVH_LEAF) and the index of a light.
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
