//! Records and constants that the kernels share with the host (`reference_records.glsl`).

use pt_shaders::glam::{UVec2, UVec3, UVec4, Vec2, Vec3, Vec4};
use pt_shaders::records::RayListHead;
use pt_shaders::{GpuStruct, gpu_struct, named_enum};

named_enum! {
    /// How weights are given to light sampling and BSDF sampling (Veach 1997, section 9.2.2); `HEURISTIC_*` in GLSL.
    pub enum Heuristic: "HEURISTIC" {
        /// In proportion to the densities.
        Balance = "balance",
        /// In proportion to their squares.
        Power = "power",
    }
}

named_enum! {
    /// Which strategies look for light; `STRATEGY_*` in GLSL.
    pub enum Strategy: "STRATEGY" {
        /// Light sampling and BSDF sampling, combined by the heuristic.
        Both = "both",
        /// Light sampling; BSDF sampling only where it alone can find the light (delta lobes, unlisted emission).
        Lights = "lights",
        /// BSDF sampling; light sampling only of delta lights.
        Bsdf = "bsdf",
    }
}

named_enum! {
    /// How light sampling picks a light at a vertex. Directional lights and the environment are picked by power in any case.
    pub enum PathLights {
        /// One of the kinds triangle, point or spot (among the others), then one of that kind by its power.
        PerKind = "per-kind",
        /// Triangles, points and spots are one kind; each with the same probability.
        Uniform = "uniform",
        /// Triangles, points and spots are one kind; by power.
        Power = "power",
        /// Triangles, points and spots are one kind; by what the list of the vertex's cluster says.
        ClusterCdf = "cluster-cdf",
        /// Triangles, points and spots are one kind; by a descent through the light tree.
        LightBvh = "light-bvh",
    }
}

gpu_struct! {
    /// The sums of a pixel, of whole loads of 16 bytes.
    pub struct FilmPixel {
        /// Sum of the samples' radiance.
        pub sum: Vec3,
        /// Rays traced for the nearest hit.
        pub rays: u32,
        /// What rounding dropped from `sum`.
        pub sum_rest: Vec3,
        /// Shadow rays traced.
        pub shadow_rays: u32,
        /// Sum of the squares of the samples' radiance.
        pub square: Vec3,
        /// What rounding dropped from `square`.
        pub square_rest: Vec3,
        /// 0.
        pub padding: UVec2,
    }
}

gpu_struct! {
    /// Sums of what a pixel's camera rays saw first. Rays that saw nothing add nothing.
    pub struct FirstHitPixel {
        /// Base colour.
        pub albedo: Vec3,
        /// Shading normal on the viewer's side, world space.
        pub normal: Vec3,
        /// Distance from the camera along the ray, metres.
        pub depth: f32,
        /// Where the point was in the last frame minus where it is, UV.
        pub motion: Vec2,
        /// Rays that saw a surface.
        pub hits: f32,
    }
}

/// `ProgressRecord::lists`: the slots with a shadow ray.
pub const LIST_SHADOW: u32 = 2;

gpu_struct! {
    /// How far the iterations of a tile have come. Words that a kernel reads are written by others.
    pub struct ProgressRecord {
        /// The live slots that are read and written alternately, and those with a shadow ray; of workgroups at least one each.
        pub lists: [RayListHead; 3],
        /// Workgroups of path_advance.comp: the whole tile's when it begins samples.
        pub advance_groups: UVec3,
        /// 1: the next iteration begins samples where the last ones are complete.
        pub sweep: u32,
        /// 1: no path was left for the last iteration.
        pub done: u32,
        /// Paths that leave threads of the device idle: while there are no more, every iteration begins samples. Stays as it is.
        pub few_paths: u32,
    }
}

gpu_struct! {
    /// Push constants of the path tracer's kernels.
    pub struct PathPush {
        /// Interior list of the camera (interior.glsl): words and indices of refraction.
        pub camera_solids: UVec4,
        /// See `camera_solids`.
        pub camera_iors: Vec4,
        /// `FilmPixel[]`, rows from the top.
        pub film: u64,
        /// `FirstHitPixel[]`, rows from the top.
        pub first_hit: u64,
        /// `uint`: samples dropped because they were not finite.
        pub dropped: u64,
        /// `ProgressRecord`.
        pub progress: u64,
        /// Paths between the kernels (path_slots.glsl).
        pub paths: u64,
        /// Top left pixel of the tile.
        pub tile_origin: UVec2,
        /// Its width and height.
        pub tile_size: UVec2,
        /// Index of the first sample.
        pub first_sample: u32,
        /// Samples to add.
        pub sample_count: u32,
        /// Scattering events after the first hit, at most.
        pub max_bounces: u32,
        /// Scattering events before Russian roulette begins.
        pub roulette_start: u32,
        /// 1: emission of surfaces counts (also of those that are not sampled).
        pub emission: u32,
        /// `HEURISTIC_*`.
        pub heuristic: u32,
        /// `STRATEGY_*`.
        pub strategy: u32,
        /// Largest radiance of a sample, per channel; 0: no limit.
        pub clamp: f32,
        /// Base-2 logarithm of the samples a pixel gets in all, rounded up.
        pub log2_spp: u32,
        /// Number of the iteration; 0 begins the tile's samples.
        pub iteration: u32,
    }
}

/// GLSL of this module (`reference_records.glsl`).
#[allow(dead_code, reason = "for the build script, which includes this file")]
pub fn glsl() -> String {
    let mut text = format!("const uint LIST_SHADOW = {LIST_SHADOW}u;\n");
    text.push_str(&format!("const uint FILM_PIXEL_BYTES = {}u;\n", size_of::<FilmPixel>()));
    text.push_str(&Heuristic::glsl());
    text.push_str(&Strategy::glsl());
    for record in [FilmPixel::glsl(), FirstHitPixel::glsl(), ProgressRecord::glsl(), PathPush::glsl()] {
        text.push_str(&record);
    }
    text
}
