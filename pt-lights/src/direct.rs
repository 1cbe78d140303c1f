use crate::caustics::Caustics;
use crate::kernels;
use crate::nee_at::NeeAt;
use crate::params::DirectParams;
use crate::records::{CausticTarget, DirectPush, LightRays, RayCounts, RestirVisibility};
use crate::restir::Restir;
use crate::shadow_rays::{ShadowRays, TABLES};
use pt_core::trace::TraceVariant;
use pt_core::{Buffer, Device, Frame, Kernel, Result, StageInputs, StageIo, TableWish};
use pt_shaders::channels;
use pt_shaders::records::{EmissionShare, LightSampler};

/// The direct lighting stage. Three passes for each light sample: lights are chosen, shadow rays are traced, and what arrives is added up. Apart
/// from each other they need fewer registers than in one kernel, so that the device hides more of the time that memory takes.
pub struct DirectLighting {
    choice: Kernel,
    tracing: Kernel,
    sum: Kernel,
    shadow_rays: ShadowRays,
    /// The passes before them, of `sampler=restir-di`.
    restir: Option<Restir>,
    nee_at: Option<NeeAt>,
    caustics: Option<Caustics>,
    emission_share: EmissionShare,
}

impl DirectLighting {
    /// The images that the passes of every sampler access.
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
        let shading = [
            Some(Self::IO),
            params.is_restir().then_some(Restir::SHADING),
            drops_hidden(params).then_some(Restir::DROPPING),
        ];
        // Their passes are the same.
        all.extend(shading.into_iter().flatten().map(|io| StageIo { tables: TABLES, ..io }));
        all
    }

    /// The tables that the stage declares, for frames of `size` pixels; where their plan does not know of them, the stage makes its own.
    pub fn tables(size: [u32; 2], params: &DirectParams) -> Vec<TableWish> {
        crate::shadow_rays::wishes(size, params)
    }

    /// Compiles the kernels, without caustics.
    pub fn new(device: &Device, variant: TraceVariant, params: &DirectParams) -> Result<Self> {
        Self::with_caustics(device, variant, params, &[])
    }

    /// Compiles the kernels. `targets`: those of [`caustic_targets`](crate::caustic_targets); without any the stage has no passes for caustics.
    ///
    /// # Errors
    /// When the device refuses them, or has no room for the grid.
    pub fn with_caustics(
        device: &Device,
        variant: TraceVariant,
        params: &DirectParams,
        targets: &[CausticTarget],
    ) -> Result<Self> {
        let caustics = (params.caustics && params.sun && !targets.is_empty())
            .then(|| Caustics::new(device, variant, params, targets))
            .transpose()?;
        let merged = params.rays == LightRays::Merged;
        let sampler = if merged { params.sampler } else { LightSampler::Power };
        let sampler = ("light_sampler", sampler.code().into());
        let merged = ("merged_rays", merged.into());
        let replays = ("replays_samples", params.replays().into());
        let restir = params.is_restir().then(|| Restir::new(device, variant, params)).transpose()?;
        let code = if restir.is_some() { &kernels::CHOOSE_LIGHTS_RESTIR } else { &kernels::CHOOSE_LIGHTS };
        let constants = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
            ("area_sampling", params.area_sampling.code().into()),
            ("bvh_importance", params.bvh_importance.code().into()),
            sampler,
            merged,
            ("environment_listed", params.is_environment_listed().into()),
            ("nee_at_pdf", params.nee_at_pdf.code().into()),
            ("ris_source", params.ris_source.code().into()),
            replays,
        ];
        let choice = Kernel::compute::<DirectPush>(device, code, &constants)?;
        let mut constants = variant.unseen().constants().to_vec();
        constants.extend([merged, ("has_caustics", caustics.is_some().into())]);
        let trace =
            |code, constants: &_| Kernel::trace::<DirectPush>(device, code, variant.backend, constants);
        let tracing = trace(&kernels::SHADOW_RAYS, &constants)?;
        constants.extend([sampler, replays, ("light_storage", params.storage.code().into())]);
        let drops = drops_hidden(params);
        let code = if drops { &kernels::DIRECT_LIGHTING_DROP } else { &kernels::DIRECT_LIGHTING };
        let sum = trace(code, &constants)?;
        Self::IO.check([&choice, &tracing, &sum])?;
        if restir.is_some() {
            Restir::SHADING.check([&choice])?;
        }
        if drops {
            Restir::DROPPING.check([&sum])?;
        }
        let nee_at = NeeAt::is_used(params).then(|| NeeAt::new(device)).transpose()?;
        let shadow_rays = ShadowRays::new(device);
        let emission_share = EmissionShare::LightSamples;
        Ok(Self { choice, tracing, sum, shadow_rays, restir, nee_at, caustics, emission_share })
    }

    /// The images that the pass of caustics accesses after all others, if the stage has it.
    pub fn caustics_io(&self) -> Option<StageIo> {
        self.caustics.as_ref().map(|_| Caustics::IO)
    }

    /// Leaves part of the specular light of emissive triangles to the bounce rays of pt-indirect. Without this call no light is left out.
    pub fn leave_to_bounce_rays(&mut self, share: EmissionShare) {
        self.emission_share = share;
    }

    /// What tiles of the screen have learned about the lights, with `sampler=nee-at`.
    pub fn nee_at(&self) -> Option<&NeeAt> {
        self.nee_at.as_ref()
    }

    /// Records the passes. The scene of `inputs` has its lights attached. `texture_lod_bias`: as that of the G-buffer. The first frame of a
    /// size takes device memory.
    ///
    /// # Errors
    /// When the passes do not fit into the frame, or their tables into the memory.
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
    /// As [`DirectLighting::record`].
    pub fn record_counted(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
        texture_lod_bias: f32,
        counted: Option<&Counted>,
    ) -> Result<()> {
        let mut push = params.push(texture_lod_bias);
        push.emission_share = self.emission_share.code();
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
        if let Some(counted) = counted {
            push.counts = counted.rays.address();
            push.choices = counted.choices.address();
        }
        self.shadow_rays.prepare(frame, inputs.images, params, &mut push)?;
        if let Some(caustics) = &self.caustics {
            caustics.record_photons(frame, inputs, params)?;
        }
        for light_sample in 0..params.samples {
            push.light_sample = light_sample;
            self.record_sample(frame, inputs, params, &push, counted)?;
        }
        if let Some(caustics) = &self.caustics {
            caustics.record_light(frame, inputs, params, texture_lod_bias)?;
        }
        Ok(())
    }

    /// The three passes of a light sample.
    fn record_sample(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
        push: &DirectPush,
        counted: Option<&Counted>,
    ) -> Result<()> {
        // Only surfaces with lobes are looked up again at the visible triangle, and not every texel has all rays.
        let pass = inputs.pass(frame, "choose lights", &self.choice, &Self::IO).touches_part();
        let pass = self.nee_at.iter().fold(pass, |pass, nee_at| nee_at.bind_tiles(pass));
        let mut pass = self.shadow_rays.bind_choice(pass);
        if self.restir.is_some() {
            pass = pass.touches(inputs.images, &Restir::SHADING);
        }
        let pass = counted.iter().fold(pass, |pass, counted| pass.addresses_written(&counted.choices));
        pass.push(push).dispatch(inputs.split_threads())?;

        let pass = inputs.pass(frame, "shadow rays", &self.tracing, &Self::IO).touches_part();
        self.shadow_rays.trace(pass.push(push))?;

        let pass = inputs.pass(frame, Self::IO.stage, &self.sum, &Self::IO).touches_part();
        let pass = self.nee_at.iter().fold(pass, |pass, nee_at| nee_at.bind_feedback(pass));
        let mut pass = self.shadow_rays.bind_sum(pass, params, push.light_sample);
        if drops_hidden(params) {
            pass = pass.touches(inputs.images, &Restir::DROPPING);
        }
        let pass = counted.iter().fold(pass, |pass, counted| pass.addresses_updated(&counted.rays));
        pass.push(push).dispatch(inputs.split_threads())
    }
}

/// Whether samples that are hidden are taken out of the reservoirs.
fn drops_hidden(params: &DirectParams) -> bool {
    params.is_restir() && params.restir_visibility == RestirVisibility::Final
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
