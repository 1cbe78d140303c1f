//! Push constants of the kernels, and the records of their tables.

use pt_shaders::glam::{UVec3, Vec3};

pt_shaders::named_enum! {
    /// How a material of metalness between 0 and 1 is shaded.
    pub enum PartialMetal {
        /// As a mixture of two BRDFs, a dielectric and a metal (glTF 2.0, appendix B.2).
        TwoBrdfs = "two-brdfs",
        /// As one BRDF with mixed albedo and F0, as in Quake II RTX: darker.
        MixedParameters = "mixed-parameters",
    }
}

pt_shaders::named_enum! {
    /// How many shadow rays go to local lights.
    pub enum LightRays {
        /// One for emissive triangles, one for point and spot lights, each light picked by its power.
        PerKind = "per-kind",
        /// One, to the light that `sampler` picks among all.
        Merged = "merged",
    }
}

pt_shaders::named_enum! {
    /// Which shadow rays go to the environment.
    pub enum EnvironmentRays {
        /// One of its own.
        Own = "own",
        /// With `rays=merged`: none of its own. The environment is divided into quads, which `sampler` picks among all lights.
        List = "list",
    }
}

pt_shaders::named_enum! {
    /// How the samples of several reservoirs are weighted by `sampler=restir-di`; `RESTIR_WEIGHTS_*` in GLSL.
    pub enum RestirWeights: "RESTIR_WEIGHTS" {
        /// By their numbers of candidates alone: biased, loses light where not all of them could hold the sample. The cheapest.
        OneOverM = "one-over-m",
        /// Balance heuristic over all reservoirs: unbiased; its cost grows with the square of the number of neighbours.
        Balance = "balance",
        /// Each neighbour against the pixel itself: unbiased.
        Pairwise = "pairwise",
    }
}

pt_shaders::named_enum! {
    /// Which shadow rays `sampler=restir-di` traces; `RESTIR_VISIBILITY_*` in GLSL.
    pub enum RestirVisibility: "RESTIR_VISIBILITY" {
        /// That of the sample which the pixel is shaded with; reservoirs do not know about it. Unbiased.
        None = "none",
        /// The same, and hidden samples are dropped before the next frame reuses them: biased, loses light where a point sees a lamp that its
        /// neighbours or its past did not see.
        Final = "final",
        /// Also those that weights need: a target is 0 where the sample is hidden. Unbiased; the past is reused without.
        InWeight = "in-weight",
    }
}

pt_shaders::named_enum! {
    /// Which probability of a light `sampler=nee-at` puts into the weights of multiple importance sampling against rays that the surface reflects;
    /// `NEE_AT_PDF_*` in GLSL. The estimate itself always divides by the exact one.
    pub enum NeeAtPdf: "NEE_AT_PDF" {
        /// That with which a candidate is drawn.
        Exact = "exact",
        /// The mean of that of the tile's proxies and that of all lights, whatever share of the candidates each has: unbiased too, as both sides
        /// use it, but of other noise.
        Averaged = "averaged",
    }
}

pt_shaders::named_enum! {
    /// How light is stored between the stages; `LIGHT_STORAGE_*` in GLSL.
    pub enum LightStorage: "LIGHT_STORAGE" {
        /// As 32-bit floating-point numbers.
        Fp32 = "fp32",
        /// With the precision of 32 bits a pixel: mantissas of 9 bits and a common exponent, rounded at random so that the mean is kept.
        Rgbe = "rgbe",
    }
}

pt_shaders::gpu_struct! {
    /// Addresses of what the passes of direct lighting tell each other; `shadow_ray_slots.glsl`.
    pub struct ShadowRayTables {
        /// `uvec4` for each slot and texel: where its ray ends.
        pub ends: u64,
        /// `uvec4` for each slot and texel: the light that its ray brings.
        pub lights: u64,
        /// A [`RayListHead`](pt_shaders::records::RayListHead).
        pub head: u64,
        /// A word for each slot and texel.
        pub list: u64,
        /// A word for each texel.
        pub states: u64,
        /// `float` for each texel: part of specular light that bounce rays find.
        pub shares: u64,
        /// Two `vec4` for each texel, 0: none.
        pub sums: u64,
    }
}

pt_shaders::gpu_struct! {
    /// What the direct lighting pass has traced.
    pub struct RayCounts {
        /// Shadow rays.
        pub traced: u32,
        /// Those that reached their light.
        pub arrived: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `nee_at_proxies.comp`.
    pub struct NeeAtPush {
        /// `NeeAtTile[]` to make.
        pub tiles: u64,
        /// The same of the last frame.
        pub tiles_before: u64,
        /// `uvec2[]` of the split frame: a light and the bits of its weight, of the last frame.
        pub feedback: u64,
        /// Share of the samples that are drawn from the proxies.
        pub narrow: f32,
        /// Share of the other samples that are drawn uniformly.
        pub uniform_share: f32,
        /// Share of the evidence that outlives a frame.
        pub history: f32,
        /// Proxies of a tile that are lights by power.
        pub global_proxies: u32,
        /// Proxies of a tile that are kept from the last frame.
        pub kept_proxies: u32,
        /// 1 = there is no last frame.
        pub reset: u32,
    }
}

pt_shaders::gpu_struct! {
    /// What photons are aimed at: a box in the space of an instance.
    pub struct CausticTarget {
        /// The instance; [`NONE`](pt_shaders::records::NONE): the box is in world space.
        pub instance: u32,
        /// Smallest corner.
        pub low: Vec3,
        /// Largest corner.
        pub high: Vec3,
    }
}

pt_shaders::gpu_struct! {
    /// A target where it is in this frame, world space.
    pub struct CausticBox {
        /// A corner.
        pub corner: Vec3,
        /// The edges that begin there.
        pub edges: [Vec3; 3],
    }
}

pt_shaders::gpu_struct! {
    /// What stands before the cells of the photons.
    pub struct CausticHead {
        /// Irradiance times area, lm, that one unit of the cells' sums stands for.
        pub flux_unit: f32,
        /// Where the grid lies in this frame, parts of a cell.
        pub offset: Vec3,
    }
}

pt_shaders::gpu_struct! {
    /// Light that arrived in a cell: sums of whole numbers, which are the same in any order.
    pub struct CausticCell {
        /// Hash of the cell's place; 0: the entry is free.
        pub key: u32,
        /// Flux.
        pub flux: UVec3,
        /// Sum of the directions that it came from, each times half the largest component of its flux; two's complement.
        pub direction: UVec3,
        /// Photons.
        pub count: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of the passes of caustics.
    pub struct CausticsPush {
        /// `CausticTarget[targets]`.
        pub targets: u64,
        /// `CausticBox[targets]`.
        pub boxes: u64,
        /// [`CausticHead`].
        pub head: u64,
        /// `CausticCell[]`, a power of two of them.
        pub cells: u64,
        /// How many targets there are.
        pub target_count: u32,
        /// Cells less one.
        pub cell_mask: u32,
        /// Photons of a frame.
        pub photons: u32,
        /// Edge of a cell, metres.
        pub cell_size: f32,
        /// 2^bias on the texture gradients.
        pub lod_scale: f32,
        /// 1 = one BRDF of mixed parameters, see brdf.glsl.
        pub mixed: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of the passes of direct lighting.
    pub struct DirectPush {
        /// Device address of a [`RayCounts`], 0: nothing is counted.
        pub counts: u64,
        /// Device address of a `uvec2` for each texel, 0: none: the local light of the last sample ([`NONE`](pt_shaders::records::NONE):
        /// none) and a hash of the point on it.
        pub choices: u64,
        /// `NeeAtTile[]`, 0: none.
        pub nee_at_tiles: u64,
        /// `uvec2[]` of the split frame: a light and the bits of its weight, for the next frame; 0: none.
        pub nee_at_feedback: u64,
        /// Device address of a [`ShadowRayTables`].
        pub shadow_rays: u64,
        /// `KIND_*` bits.
        pub kinds: u32,
        /// Instances that cast shadows.
        pub mask: u32,
        /// `GLASS_SHADOWS_*`
        pub glass_shadows: u32,
        /// 1 = one BRDF of mixed parameters, see brdf.glsl.
        pub mixed: u32,
        /// Perceptual roughness up to which a second ray looks for the environment.
        pub reflection_roughness: f32,
        /// 2^bias on the texture gradients.
        pub lod_scale: f32,
        /// Light samples a pixel.
        pub samples: u32,
        /// Candidates of resampled importance sampling.
        pub ris_candidates: u32,
        /// 1 = the numbers that choose them are spread evenly.
        pub ris_stratified: u32,
        /// Most that the past counts, in units of `ris_candidates`; 0: it is not reused.
        pub restir_history: u32,
        /// Neighbours.
        pub restir_spatial: u32,
        /// How far they are, pixels.
        pub restir_radius: f32,
        /// `RESTIR_WEIGHTS_*`.
        pub restir_weights: u32,
        /// `RESTIR_VISIBILITY_*`.
        pub restir_visibility: u32,
        /// Candidates of a sample of nee-at.
        pub nee_at_candidates: u32,
        /// Which light sample of the frame it is.
        pub light_sample: u32,
        /// Workgroups in a row of the launch over the shadow rays.
        pub ray_columns: u32,
        /// `EMISSION_SHARE_*`.
        pub emission_share: u32,
        /// 1 = nee-at learns from reflected rays.
        pub nee_at_bsdf_feedback: u32,
        /// Shares of the samples of the environment (`packUnorm2x16`): x = drawn by the cosine, y = of the others, drawn through portals.
        pub environment_shares: u32,
    }
}
