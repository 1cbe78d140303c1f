use crate::kernels;
use crate::nee_at::NeeAt;
use crate::params::DirectParams;
use crate::records::{DirectPush, LightRays, RayCounts};
use crate::restir::Restir;
use pt_core::trace::TraceVariant;
use pt_core::{Buffer, Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels;
use pt_shaders::records::LightSampler;

/// The direct lighting stage: for each light sample of a pixel a shadow ray.
pub struct DirectLighting {
    kernel: Kernel,
    /// The passes before it, of `sampler=restir-di`.
    restir: Option<Restir>,
    nee_at: Option<NeeAt>,
}

impl DirectLighting {
    /// The images that the pass of every sampler accesses.
    pub const IO: StageIo = StageIo {
        reads: &[
            channels::RNG_SEED,
            channels::BASE_COLOR,
            channels::METALLIC_ROUGHNESS,
            channels::NORMAL,
            channels::VERTEX_NORMAL,
            channels::SHADING_POSITION,
            channels::VIEW_DIRECTION,
            channels::CLUSTER,
            channels::VISIBILITY,
            channels::BARYCENTRICS,
            channels::THROUGHPUT,
            channels::BOUNCE_THROUGHPUT,
        ],
        writes: &[channels::COLOR_HF, channels::COLOR_SPEC],
        ..StageIo::of("direct lighting")
    };

    /// The images that the stage's passes access, in order.
    pub fn io(params: &DirectParams) -> Vec<StageIo> {
        let mut all = Vec::new();
        if params.is_restir() {
            all.extend(Restir::io(params));
        }
        all.extend(NeeAt::is_used(params).then_some(NeeAt::IO));
        all.push(Self::IO);
        all.extend(params.is_restir().then_some(Restir::SHADING));
        all
    }

    /// Compiles the kernels.
    pub fn new(device: &Device, variant: TraceVariant, params: &DirectParams) -> Result<Self> {
        let merged = params.rays == LightRays::Merged;
        let sampler = if merged { params.sampler } else { LightSampler::Power };
        let mut constants = variant.unseen().constants().to_vec();
        constants.extend([
            ("light_sampler", sampler.code().into()),
            ("area_sampling", params.area_sampling.code().into()),
            ("bvh_importance", params.bvh_importance.code().into()),
            ("merged_rays", merged.into()),
            ("replays_samples", params.replays().into()),
        ]);
        let restir = params.is_restir().then(|| Restir::new(device, variant, params)).transpose()?;
        let code = if restir.is_some() { &kernels::DIRECT_RESTIR } else { &kernels::DIRECT };
        let kernel = Kernel::trace::<DirectPush>(device, code, variant.backend, &constants)?;
        Self::IO.check([&kernel])?;
        if restir.is_some() {
            Restir::SHADING.check([&kernel])?;
        }
        let nee_at = NeeAt::is_used(params).then(|| NeeAt::new(device)).transpose()?;
        Ok(Self { kernel, restir, nee_at })
    }

    /// What tiles of the screen have learned about the lights, with `sampler=nee-at`.
    pub fn nee_at(&self) -> Option<&NeeAt> {
        self.nee_at.as_ref()
    }

    /// Records the passes. The scene of `inputs` has its lights attached. `texture_lod_bias`: as that of the G-buffer.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
        texture_lod_bias: f32,
    ) -> Result<()> {
        self.record_counted(frame, inputs, params, texture_lod_bias, None)
    }

    /// As [`DirectLighting::record`]; also counts the shadow rays and notes the choices.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record_counted(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
        texture_lod_bias: f32,
        counted: Option<&Counted>,
    ) -> Result<()> {
        let mut push = params.push(texture_lod_bias);
        if !inputs.images.has_history() {
            push.restir_history = 0;
        }
        if let Some(restir) = &self.restir {
            restir.record(frame, inputs, &push)?;
        }
        if let Some(nee_at) = &self.nee_at {
            nee_at.record(frame, inputs, params)?;
            nee_at.fill(&mut push);
        }
        // Only surfaces with lobes are looked up again at the visible triangle.
        let pass = inputs.pass(frame, "direct lighting", &self.kernel, &Self::IO).touches_part();
        let mut pass = self.nee_at.iter().fold(pass, |pass, nee_at| nee_at.bind(pass));
        if self.restir.is_some() {
            pass = pass.touches(inputs.images, &Restir::SHADING);
        }
        if let Some(counted) = counted {
            push.counts = counted.rays.address();
            push.choices = counted.choices.address();
            pass = pass.addresses_updated(&counted.rays).addresses_written(&counted.choices);
        }
        pass.push(&push).dispatch(inputs.split_threads())
    }
}

/// Buffers for what direct lighting counts.
pub struct Counted {
    rays: Buffer,
    choices: Buffer,
}

impl Counted {
    /// For a split frame of that many texels. Zero rays.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn new(device: &Device, texels: usize) -> Result<Self> {
        Ok(Self {
            rays: Buffer::from_slice(device, "ray counts", &[RayCounts { traced: 0, arrived: 0 }])?,
            choices: Buffer::from_slice(device, "choices", &vec![[u32::MAX, 0]; texels])?,
        })
    }

    /// Shadow rays since the counts were made; waits for the device.
    ///
    /// # Errors
    /// When the device fails.
    pub fn rays(&self) -> Result<RayCounts> {
        Ok(self.rays.read()?[0])
    }

    /// For each texel of the split frame the local light of the last sample and a hash of the point on it; waits.
    ///
    /// # Errors
    /// When the device fails.
    pub fn choices(&self) -> Result<Vec<[u32; 2]>> {
        self.choices.read()
    }
}
