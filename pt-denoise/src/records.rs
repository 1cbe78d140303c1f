//! Records that the kernels share with the host (`denoise_records.glsl`), and the variants of the denoiser.

use pt_shaders::glam::UVec2;
use pt_shaders::{gpu_constants, gpu_struct, named_enum};

gpu_constants! {
    /// Blocks of pixels, one above the other, that a group of `variance.comp` takes.
    pub const VARIANCE_BLOCKS: u32 = 4;
}

named_enum! {
    /// Which pixel of a stratum is its gradient pixel.
    pub enum GradientPixel {
        /// The one that was the brightest in the last frame.
        Brightest = "brightest",
        /// Any of them.
        Random = "random",
    }
}

named_enum! {
    /// Pixels of a stratum, which has one gradient pixel.
    pub enum Stratum {
        /// 3 x 3: gradients at a third of the resolution.
        Three = "3x3",
        /// 5 x 5: fewer pixels take an old light sample, and gradients are coarser.
        Five = "5x5",
    }
}

impl Stratum {
    /// Pixels along a side.
    #[allow(dead_code, reason = "build scripts need the GLSL alone")]
    pub const fn side(self) -> u32 {
        match self {
            Self::Three => 3,
            Self::Five => 5,
        }
    }
}

named_enum! {
    /// Which way gradient pixels are found.
    pub enum Projection {
        /// From this frame's pixels to where the motion of their surfaces comes from.
        Backward = "backward",
        /// From random pixels of the last frame to where their surfaces are now.
        Forward = "forward",
    }
}

named_enum! {
    /// The filter over gradients.
    pub enum GradientFilter {
        /// 3 x 3 taps, twice as far apart in each level.
        Atrous = "atrous",
        /// 5 x 5 taps, three times as far apart in each level.
        Strided = "strided",
    }
}

named_enum! {
    /// What the history of specular light follows.
    pub enum SpecularMotion: "SPECULAR_MOTION" {
        /// The surface.
        Surface = "surface",
        /// The mirror image behind it, at the distance of what the surface reflects.
        Virtual = "virtual",
        /// The mirror image where the last frame had one at that distance, else the surface.
        Better = "better",
    }
}

named_enum! {
    /// In which order the pixels of an a-trous level are filtered.
    pub enum Schedule {
        /// Pixels whose taps are the same are filtered together (Dolp, Hanika and Dachsbacher 2024).
        Permuted = "permuted",
        /// Neighbours are filtered together (Dammertz et al. 2010).
        Dilated = "dilated",
    }
}

named_enum! {
    /// Taps of an a-trous level, and their weights.
    pub enum AtrousKernel {
        /// 3 x 3 taps, binomial.
        Three = "3x3",
        /// 5 x 5 taps, B3 spline (Dammertz et al. 2010).
        Five = "5x5",
    }
}

named_enum! {
    /// How the light channels are denoised.
    pub enum Denoiser {
        /// Not at all.
        Off = "off",
        /// Mean over the frames along the motion of the surfaces.
        Accumulate = "accumulate",
        /// Spatiotemporal variance-guided filtering (Schied et al. 2017).
        Svgf = "svgf",
        /// svgf whose history follows changes of the light: adaptive temporal filtering (Schied, Peters and Dachsbacher 2018).
        Asvgf = "asvgf",
        /// The a-trous filter of svgf alone, over each frame by itself.
        Atrous = "atrous",
        /// Blurs whose output is the history of the next frame (Zhdanov 2021, "ReBLUR").
        Recurrent = "recurrent",
        /// Intel Open Image Denoise, of each frame by itself; in the program pt-denoise alone, built with the feature oidn.
        Oidn = "oidn",
    }
}

named_enum! {
    /// How the histories of the denoiser are kept from frame to frame.
    pub enum HistoryFormat {
        /// In 32-bit floats.
        Full = "full",
        /// As roots in half floats, rounded at random.
        Half = "half",
    }
}

named_enum! {
    /// Networks of Open Image Denoise.
    pub enum OidnQuality {
        /// The most accurate one.
        High = "high",
        /// The one between.
        Balanced = "balanced",
        /// The fastest one, for pictures that change in real time.
        Fast = "fast",
    }
}

gpu_struct! {
    /// Push constants of `composite.comp`; see `DenoiseParams`.
    pub struct CompositePush {
        /// Factor on the diffuse channel.
        pub scale_hf: f32,
        /// Factor on the indirect diffuse channel.
        pub scale_lf: f32,
        /// Factor on the specular channel.
        pub scale_spec: f32,
        /// Factor on the transparent layer's radiance.
        pub scale_overlay: f32,
        /// 1 = `albedo` stands for every surface's diffuse albedo.
        pub use_albedo: u32,
        /// See `use_albedo`.
        pub albedo: f32,
        /// 1 = pixels whose camera ray meets no surface are empty.
        pub transparent_background: u32,
        /// Least roughness of surfaces that reflect indirect diffuse light; above 1: none.
        pub fake_specular: f32,
        /// 1 = the light is a history that holds roots.
        pub roots: u32,
        /// The same of indirect diffuse light.
        pub roots_lf: u32,
    }
}

gpu_struct! {
    /// Push constants of `temporal.comp`; see `TemporalParams`.
    pub struct TemporalPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Least weight of a frame in the diffuse channel.
        pub alpha_hf: f32,
        /// Least weight of a frame in the specular channel.
        pub alpha_spec: f32,
        /// Least weight of a frame in the indirect diffuse channel.
        pub alpha_lf: f32,
        /// Least weight of a frame in the moments.
        pub alpha_moments: f32,
        /// Greatest difference in distance, relative to the distance.
        pub depth: f32,
        /// Least cosine between the normals.
        pub normal: f32,
        /// Limit of a sample over what is expected; 0 = none.
        pub firefly: f32,
        /// The same of indirect diffuse light.
        pub firefly_lf: f32,
        /// See `AntilagParams::hf`.
        pub antilag_hf: f32,
        /// See `AntilagParams::spec`.
        pub antilag_spec: f32,
        /// See `AntilagParams::lf`.
        pub antilag_lf: f32,
        /// See `AntilagParams::gate`.
        pub gate: f32,
        /// See `AntilagParams::gate_noise`.
        pub gate_noise: f32,
        /// `SPECULAR_MOTION_*`.
        pub specular: u32,
        /// See `TemporalParams::parallax`; 0 = none.
        pub parallax: f32,
        /// Greatest length of a history.
        pub max_length: u32,
        /// 1 = there is no history.
        pub reset: u32,
        /// Frame and seed of the random numbers by which histories in half floats are rounded.
        pub rounding: UVec2,
    }
}

gpu_struct! {
    /// Push constants of `variance.comp` and `variance_spatial.comp`.
    pub struct VariancePush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// See `AtrousParams::depth`.
        pub depth: f32,
        /// See `AtrousParams::normal`.
        pub normal: f32,
        /// See `TemporalPush::firefly`.
        pub firefly: f32,
        /// Least length of a history whose moments count.
        pub min_length: u32,
    }
}

gpu_struct! {
    /// Push constants of `atrous_*.comp`; see `AtrousParams`.
    pub struct AtrousPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Distance of the taps, pixels.
        pub step: u32,
        /// See `AtrousParams::depth`.
        pub depth: f32,
        /// See `AtrousParams::normal`.
        pub normal: f32,
        /// See `AtrousParams::luminance_hf`.
        pub luminance_hf: f32,
        /// See `AtrousParams::luminance_spec`.
        pub luminance_spec: f32,
        /// See `AtrousParams::lobe`.
        pub lobe: f32,
        /// 1 = the source holds roots of light.
        pub roots: u32,
        /// 1 = the target is a history.
        pub to_history: u32,
        /// See `TemporalPush::rounding`.
        pub rounding: UVec2,
    }
}

gpu_struct! {
    /// Push constants of the kernels `lf_*.comp`; see `LfParams`.
    pub struct LfPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Distance of the taps, tiles.
        pub step: u32,
        /// See `LfParams::depth`.
        pub depth: f32,
        /// See `LfParams::normal`.
        pub normal: f32,
        /// See `LfParams::deflicker`.
        pub limit: f32,
        /// See `LfParams::leak_guard`.
        pub guard: u32,
        /// 1 = the source holds roots.
        pub roots: u32,
    }
}

gpu_struct! {
    /// Push constants of `gradient_filter.glsl`.
    pub struct GradientPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Distance of the taps, strata.
        pub step: u32,
        /// Factor on the third and fourth component of sums.
        pub variance: f32,
    }
}

gpu_struct! {
    /// Push constants of `gradient_pixels.comp`.
    pub struct GradientPixelsPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// See `TemporalPush::depth`.
        pub depth: f32,
        /// See `TemporalPush::normal`.
        pub normal: f32,
        /// See `TemporalPush::reset`.
        pub reset: u32,
        /// 1 = the brightest pixel of the last frame, 0 = any.
        pub brightest: u32,
        /// 1 = from the last frame's pixels.
        pub forward: u32,
    }
}

gpu_struct! {
    /// Push constants of `recurrent_*.comp` and `history_fix.comp`; see `RecurrentParams`.
    pub struct RecurrentPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Greatest radius, pixels.
        pub radius: f32,
        /// See `AtrousParams::depth`.
        pub depth: f32,
        /// See `AtrousParams::normal`.
        pub normal: f32,
        /// See `AtrousParams::lobe`.
        pub lobe: f32,
        /// See `RecurrentParams::fix_frames`.
        pub fix_frames: u32,
        /// See `TemporalPush::rounding`.
        pub rounding: UVec2,
    }
}
