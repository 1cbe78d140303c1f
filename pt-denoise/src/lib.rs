//! From the light channels of the split frame to its radiance.
//!
//! [`DenoiseChain`] filters the light channels; its variants are those of [`Denoiser`]. [`Composite`] multiplies the light by the
//! reflectance that it was divided by and by the path throughput, and adds the transparent layer.

#![forbid(unsafe_code)]

mod gradient_pixels;
mod histories;
pub mod images;
pub mod oracle;
mod passes;
mod records;
mod variants;

pub use gradient_pixels::GradientPixels;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};
use pt_shaders::ShaderCode;
use pt_shaders::channels::{
    BASE_COLOR, COLOR, METALLIC_ROUGHNESS, NORMAL, SHADING_POSITION, THROUGHPUT, TRANSPARENT, VIEW_DIRECTION,
};
use pt_shaders::records::Background;
use records::CompositePush;

pub use passes::{AntilagParams, AtrousParams, LfParams, RecurrentParams, TemporalParams};
pub use records::{
    AtrousKernel, Denoiser, GradientFilter, GradientPixel, HistoryFormat, OidnQuality, Projection, Schedule,
    SpecularMotion, Stratum,
};
pub use variants::DenoiseChain;

knobs! {
    /// Knobs of the denoiser and of the composite. Those of the composite show parts of the light by themselves; every value but the default
    /// changes energy; a transparent background leaves out the environment that the camera sees.
    pub struct DenoiseParams {
        /// How the light channels are denoised.
        pub variant: Denoiser = Denoiser::Asvgf => structural;
        /// How the histories are kept from frame to frame: `half` takes 56 bytes a pixel less, its roundings are noise without bias of about 0.2 % of a pixel's light, and light above 4e9
        /// is lost.
        pub histories: HistoryFormat = HistoryFormat::Full => structural;
        /// Temporal accumulation.
        pub temporal: TemporalParams;
        /// How history follows changes of the light.
        pub antilag: AntilagParams;
        /// The a-trous filter.
        pub atrous: AtrousParams;
        /// The filter of indirect diffuse light.
        pub lf: LfParams;
        /// The recurrent blur.
        pub recurrent: RecurrentParams;
        /// Which network `oidn` runs (Áfra 2024, openimagedenoise.org).
        pub oidn_quality: OidnQuality = OidnQuality::High;
        /// Factor on the diffuse channel.
        pub scale_hf: f32 = 1.0, in 0.0..=10.0;
        /// Factor on the indirect diffuse channel.
        pub scale_lf: f32 = 1.0, in 0.0..=10.0;
        /// Factor on the specular channel.
        pub scale_spec: f32 = 1.0, in 0.0..=10.0;
        /// Factor on the radiance of the transparent layer; its alpha is not changed.
        pub scale_overlay: f32 = 1.0, in 0.0..=10.0;
        /// Diffuse albedo of all surfaces, instead of their own.
        pub fixed_albedo: Option<f32> = None, in 0.0..=1.0;
        /// Surfaces of at least this roughness reflect indirect diffuse light as its spherical harmonics have it, and none do without a value; it stands for bounce
        /// rays that are not traced (`indirect.specular_fade`), and adds light where they are.
        pub fake_specular: Option<f32> = None, in 0.0..=1.0;
        /// What is seen where a camera ray meets no surface.
        pub background: Background = Background::Environment => structural;
    }
}

/// Light channels, material and transparent layer to `color`.
///
/// A non-finite input makes its own pixel non-finite and no other. The alpha of `color` holds the checkerboard flags; it is 0 for the
/// pixels of a transparent background.
pub struct Composite {
    kernel: Kernel,
    io: StageIo,
}

impl Composite {
    /// The images that it accesses besides its [`SplitLight`], without indirect light; it writes every pixel.
    pub const IO: StageIo = StageIo {
        reads: &[BASE_COLOR, METALLIC_ROUGHNESS, SHADING_POSITION, VIEW_DIRECTION, THROUGHPUT, TRANSPARENT],
        writes: &[COLOR],
        ..StageIo::of("composite")
    };

    /// The same with indirect light, which is evaluated at the normal of the pixel.
    pub const IO_INDIRECT: StageIo = StageIo {
        reads: &[
            BASE_COLOR,
            METALLIC_ROUGHNESS,
            NORMAL,
            SHADING_POSITION,
            VIEW_DIRECTION,
            THROUGHPUT,
            TRANSPARENT,
        ],
        ..Self::IO
    };

    /// [`Composite::IO`] or, with indirect light, [`Composite::IO_INDIRECT`].
    pub const fn io_for(indirect: bool) -> StageIo {
        if indirect { Self::IO_INDIRECT } else { Self::IO }
    }

    /// Creates the kernel for direct light, or for direct and indirect light.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn for_light(device: &Device, indirect: bool) -> Result<Self> {
        if indirect { Self::with_indirect(device) } else { Self::new(device) }
    }

    /// Creates the kernel for direct light alone.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device) -> Result<Self> {
        Self::with_kernel(device, &kernels::COMPOSITE, Self::IO)
    }

    /// Creates the kernel for direct and indirect light.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn with_indirect(device: &Device) -> Result<Self> {
        Self::with_kernel(device, &kernels::COMPOSITE_INDIRECT, Self::IO_INDIRECT)
    }

    fn with_kernel(device: &Device, code: &ShaderCode, io: StageIo) -> Result<Self> {
        let kernel = Kernel::compute::<CompositePush>(device, code, &[])?;
        io.check([&kernel])?;
        Ok(Self { kernel, io })
    }

    /// Adds its pass to the frame; `light` may come from the lighting stages or from any denoiser. It has indirect light if and only if the
    /// composite was made for it.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        light: SplitLight<'_>,
        params: &DenoiseParams,
    ) -> Result<()> {
        let mut pass = inputs
            .pass(frame, "composite", &self.kernel, &self.io)
            .sample("light_hf", light.hf)
            .sample("light_spec", light.spec);
        if let Some(lf) = light.lf {
            pass = pass.sample("light_lf_sh", lf.sh).sample("light_lf_cocg", lf.cocg);
        }
        pass.push(&CompositePush {
            scale_hf: params.scale_hf,
            scale_lf: params.scale_lf,
            scale_spec: params.scale_spec,
            scale_overlay: params.scale_overlay,
            use_albedo: u32::from(params.fixed_albedo.is_some()),
            albedo: params.fixed_albedo.unwrap_or(0.0),
            transparent_background: u32::from(params.background == Background::Transparent),
            fake_specular: params.fake_specular.unwrap_or(2.0),
            roots: histories::holds_roots(light.hf).into(),
            roots_lf: light.lf.is_some_and(|lf| histories::holds_roots(lf.sh)).into(),
        })
        .dispatch(inputs.split_threads())
    }
}
