//! Records that the kernels share with the host (`denoise_records.glsl`), and the variants of the denoiser.

use pt_shaders::glam::UVec2;
use pt_shaders::{gpu_struct, named_enum};

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
        /// See `AntilagParams::hf`.
        pub antilag_hf: f32,
        /// See `AntilagParams::spec`.
        pub antilag_spec: f32,
        /// See `AntilagParams::lf`.
        pub antilag_lf: f32,
        /// See `AntilagParams::gate_noise`.
        pub gate_noise: f32,
        /// Greatest length of a history.
        pub max_length: u32,
        /// 1 = there is no history.
        pub reset: u32,
    }
}

gpu_struct! {
    /// Push constants of `variance.comp` and `variance_spatial.comp`.
    pub struct VariancePush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// See `TemporalPush::alpha_hf`.
        pub alpha_hf: f32,
        /// See `TemporalPush::alpha_spec`.
        pub alpha_spec: f32,
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
    /// Push constants of `atrous.comp`; see `AtrousParams`.
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
    }
}

gpu_struct! {
    /// Push constants of `lf_downsample.comp`, `lf_atrous.comp` and `lf_upsample.comp`; see `LfParams`.
    pub struct LfPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Distance of the taps, tiles.
        pub step: u32,
        /// See `LfParams::depth`.
        pub depth: f32,
        /// See `LfParams::normal`.
        pub normal: f32,
    }
}

gpu_struct! {
    /// Push constants of `gradient.comp` and `gradient_atrous.comp`; see `AntilagParams`.
    pub struct GradientPush {
        /// Full frame in pixels.
        pub size: UVec2,
        /// Relative change that does not count.
        pub gate: f32,
        /// Distance of the taps, strata.
        pub step: u32,
        /// Factor on the third component.
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
    }
}
