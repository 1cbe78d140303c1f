use crate::kernels;
use crate::params::{BounceLights, IndirectParams};
use crate::records::IndirectPush;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels;

/// The indirect lighting stage: one path of bounce rays a pixel.
pub struct IndirectLighting {
    kernel: Kernel,
    lights: BounceLights,
}

impl IndirectLighting {
    /// The images that the stage accesses.
    pub const IO: StageIo = StageIo {
        reads: &[
            channels::RNG_SEED,
            channels::BASE_COLOR,
            channels::METALLIC_ROUGHNESS,
            channels::NORMAL,
            channels::SHADING_POSITION,
            channels::VIEW_DIRECTION,
            channels::VISIBILITY,
            channels::BARYCENTRICS,
            channels::THROUGHPUT,
            channels::BOUNCE_THROUGHPUT,
        ],
        writes: &[channels::COLOR_LF_SH, channels::COLOR_LF_COCG],
        updates: &[channels::COLOR_SPEC],
        ..StageIo::of("indirect lighting")
    };

    /// Compiles the kernel. The scene has the tables of the sampler that `lights` names.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device, variant: TraceVariant, lights: BounceLights) -> Result<Self> {
        let mut constants = variant.unseen().constants().to_vec();
        constants.extend([
            ("light_sampler", lights.kernel_sampler().code().into()),
            ("area_sampling", lights.area_sampling.code().into()),
            ("bvh_importance", lights.bvh_importance.code().into()),
        ]);
        let kernel = Kernel::trace::<IndirectPush>(device, &kernels::INDIRECT, variant.backend, &constants)?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel, lights })
    }

    /// Records the pass; without bounces there is none. The scene of `inputs` has its lights attached. `texture_lod_bias`: as that of the
    /// G-buffer.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &IndirectParams,
        texture_lod_bias: f32,
    ) -> Result<()> {
        if !params.is_on() {
            return Ok(());
        }
        let [width, height, depth] = inputs.split_threads();
        let rows = if params.is_half() { height.div_ceil(2) } else { height };
        let pass = inputs.pass(frame, "indirect lighting", &self.kernel, &Self::IO);
        pass.push(&params.push(&self.lights, texture_lod_bias)).dispatch([width, rows, depth])
    }
}
