use crate::bounces::{Bounces, List, TABLES, TABLES_OF_SUM, Tables};
use crate::kernels;
use crate::params::{BounceLights, IndirectParams};
use crate::records::IndirectPush;
use crate::reuse::Reuse;
use pt_core::frame::Pass;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Error, Frame, Kernel, Result, StageInputs, StageIo, TableWish};
use pt_shaders::channels;
use pt_shaders::records::FEATURE_TRANSMISSION;
use std::thread;

/// The indirect lighting stage: one path of bounce rays a pixel. A pass for each step of the paths: what traces rays does nothing else, so that
/// it needs few registers, and no thread waits for paths that have ended.
pub struct IndirectLighting {
    choice: Kernel,
    rays: Kernel,
    /// What rays meet at the last vertex, and before.
    last_lights: Kernel,
    lights: Option<Kernel>,
    shadow_rays: Kernel,
    /// Where glass tints shadow rays.
    glass: Option<Kernel>,
    sum: Kernel,
    /// With `reuse=restir-gi`.
    reuse: Option<Reuse>,
    bounces: Bounces,
    bounce_lights: BounceLights,
}

impl IndirectLighting {
    /// The images that the passes of the paths access.
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
            channels::INTERIOR,
        ],
        writes: &[channels::COLOR_LF_SH, channels::COLOR_LF_COCG],
        updates: &[channels::COLOR_SPEC],
        tables: TABLES_OF_SUM,
        ..StageIo::of("indirect lighting")
    };

    /// Those of the passes before bounces are reused.
    const PATHS: StageIo = StageIo { reads: Self::IO.reads, tables: TABLES, ..StageIo::of("bounce paths") };

    /// The name of the first pass, which has a thread for each path.
    pub const FIRST_PASS: &str = "choose bounces";

    /// The images that the stage's passes access, in order.
    pub fn io(params: &IndirectParams) -> Vec<StageIo> {
        let mut all = vec![Self::PATHS];
        if params.reuses() {
            all.extend(Reuse::IO);
        }
        all.push(Self::IO);
        all
    }

    /// Compiles the kernels that the structural knobs of `params` ask for. The scene has the tables of the sampler that `lights` names.
    /// `effect_layers`: effects along a ray that are kept sorted, as the knob of the G-buffer says.
    ///
    /// # Errors
    /// When the device refuses them.
    pub fn new(
        device: &Device,
        variant: TraceVariant,
        lights: BounceLights,
        params: &IndirectParams,
        effect_layers: u32,
    ) -> Result<Self> {
        let transmits = variant.scene_features & FEATURE_TRANSMISSION != 0;
        let has_glass = transmits && lights.glass_shadows.tints();
        let constants = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
        ];
        let reuses = ("reuses_bounces", params.reuses().into());
        let compute = |code, more: &[_]| {
            Kernel::compute::<IndirectPush>(device, code, &[&constants[..], more].concat())
        };
        let trace = |code, more: &[_]| {
            let constants = [&variant.unseen().constants()[..], more].concat();
            Kernel::trace::<IndirectPush>(device, code, variant.backend, &constants)
        };
        let shading = |last: bool| {
            let constants = [
                ("last_vertex", last.into()),
                ("light_sampler", lights.kernel_sampler().code().into()),
                ("area_sampling", lights.area_sampling.code().into()),
                ("bvh_importance", lights.bvh_importance.code().into()),
                ("ris_source", lights.ris_source.code().into()),
                ("replays_samples", lights.replays.into()),
                reuses,
            ];
            compute(&kernels::BOUNCE_LIGHTS, &constants)
        };
        thread::scope(|threads| {
            // These take the most time to compile.
            let last = threads.spawn(|| shading(true));
            let before = (params.bounces > 1.0).then(|| threads.spawn(|| shading(false)));
            let choice = threads.spawn(|| compute(&kernels::CHOOSE_BOUNCES, &[reuses]));
            let reuse = params.reuses().then(|| threads.spawn(|| Reuse::new(device, variant, params)));
            let sum = match params.reuses() {
                true => &kernels::INDIRECT_LIGHTING_REUSED,
                false => &kernels::INDIRECT_LIGHTING,
            };
            let stage = Self {
                rays: trace(&kernels::BOUNCE_RAYS, &[("has_solids", transmits.into())])?,
                shadow_rays: trace(&kernels::BOUNCE_SHADOW_RAYS, &[reuses])?,
                glass: has_glass.then(|| trace(&kernels::BOUNCE_GLASS, &[reuses])).transpose()?,
                sum: compute(sum, &[("effect_layers", effect_layers.into())])?,
                reuse: reuse.map(join).transpose()?,
                choice: join(choice)?,
                last_lights: join(last)?,
                lights: before.map(join).transpose()?,
                bounces: Bounces::new(device, transmits, has_glass, params.reuses()),
                bounce_lights: lights,
            };
            Self::IO.check([
                &stage.choice,
                &stage.rays,
                &stage.last_lights,
                &stage.shadow_rays,
                &stage.sum,
            ])?;
            Ok(stage)
        })
    }

    /// The tables that the stage declares, for frames of `size` pixels; where their plan does not know of them, the stage makes its own.
    pub fn tables(&self, size: [u32; 2], params: &IndirectParams) -> Vec<TableWish> {
        self.bounces.wishes(size, params.is_half())
    }

    /// Records the passes; without bounces there are none. The scene of `inputs` has its lights attached. `texture_lod_bias`: as that of the
    /// G-buffer. The first frame of a size takes device memory.
    ///
    /// # Errors
    /// When the passes do not fit into the frame, or their tables into the memory.
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
        if params.bounces > 1.0 && self.lights.is_none() {
            return Err(Error::StructuralKnob { key: "indirect.bounces".into() });
        }
        if params.reuses() != self.reuse.is_some() {
            return Err(Error::StructuralKnob { key: "indirect.reuse".into() });
        }
        let mut push = params.push(&self.bounce_lights, texture_lod_bias);
        if !inputs.images.has_history() {
            push.restir_counts &= !0xffff;
        }
        let tables = &self.bounces.prepare(frame, inputs.images, params.is_half(), &mut push)?;
        let [width, height, depth] = inputs.split_threads();
        let rows = if params.is_half() { height.div_ceil(2) } else { height };
        let threads = [width, rows, depth];

        let pass = self.pass(frame, inputs, Self::FIRST_PASS, &self.choice, tables, &push);
        let pass = pass.streams_written(&tables.origins).streams_written(&tables.directions);
        let pass = pass.streams_written(&tables.firsts).streams_written(&tables.first_directions);
        // Paths that begin in solids have all of their state.
        let begun = tables.path().skip(2).filter(|_| !tables.solids().is_empty());
        let pass = begun.fold(pass, Pass::streams_written);
        let pass = tables.reuse().iter().fold(pass, |pass, reuse| pass.streams_written(&reuse.reusable));
        pass.streams_written(tables.ray_list(0)).dispatch(threads)?;

        // Behind the last vertex rays follow what delta lobes show.
        for vertex in 0..=push.bounces {
            push.vertex = vertex;
            self.record_vertex(frame, inputs, tables, &push)?;
        }
        if let (Some(reuse), Some(reuse_tables)) = (&self.reuse, tables.reuse()) {
            reuse.record(frame, inputs, tables, reuse_tables, &push)?;
        }
        let pass = self.pass(frame, inputs, Self::IO.stage, &self.sum, tables, &push);
        let pass = pass.streams(&tables.firsts).streams(&tables.first_directions);
        let pass = tables
            .reuse()
            .iter()
            .fold(pass, |pass, reuse| pass.streams(&reuse.points).streams(&reuse.reusable));
        pass.streams(&tables.lights).streams(&tables.reflected).dispatch(threads)
    }

    /// The passes of a surface that the paths meet.
    fn record_vertex(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        tables: &Tables,
        push: &IndirectPush,
    ) -> Result<()> {
        let vertex = push.vertex;
        let name = |pass: &str| if vertex == 0 { pass.to_owned() } else { format!("{pass} {}", vertex + 1) };
        let pass = self.pass(frame, inputs, &name("bounce rays"), &self.rays, tables, push);
        let pass = pass.streams(tables.ray_list(vertex)).streams_written(&tables.hits_and_shadow_origins);
        let ray = [&tables.origins, &tables.directions];
        // Rays that begin in solids may be moved on.
        let moves = !tables.solids().is_empty();
        let pass = match moves {
            true => tables.path().fold(pass, Pass::streams_updated),
            false => ray.into_iter().fold(pass, Pass::streams),
        };
        tables.trace(pass, List::Rays, vertex)?;

        let lights = self.lights.as_ref().filter(|_| vertex + 1 < push.bounces).unwrap_or(&self.last_lights);
        let pass = self.pass(frame, inputs, &name("bounce lights"), lights, tables, push);
        let is_end = vertex == push.bounces;
        let hits = if is_end { Pass::streams } else { Pass::streams_updated };
        let mut pass = hits(pass.streams(tables.ray_list(vertex)), &tables.hits_and_shadow_origins);
        // The first ray has a throughput of 1 where it begins in no solid.
        pass = match (vertex == 0 && !moves, is_end) {
            (true, _) => tables.path().skip(2).fold(pass, Pass::streams_written),
            (false, false) => tables.path().skip(2).fold(pass, Pass::streams_updated),
            (false, true) => tables.path().skip(2).fold(pass, Pass::streams),
        };
        pass = ray.into_iter().fold(pass, if is_end { Pass::streams } else { Pass::streams_updated });
        pass = match vertex {
            0 => pass
                .streams(&tables.firsts)
                .streams_written(&tables.lights)
                .streams_written(&tables.reflected),
            _ => pass.streams_updated(&tables.lights),
        };
        if let Some(reuse) = tables.reuse() {
            pass = pass.streams_updated(&reuse.reusable);
            pass = match vertex {
                0 => pass.streams_written(&reuse.shares).streams_written(&reuse.points),
                _ => pass.streams(&reuse.shares),
            };
        }
        let [directions, lights] = [&tables.shadow_directions, &tables.shadow_lights];
        if !is_end {
            let lists = [&tables.shadow_list, tables.ray_list(vertex + 1)];
            pass = [directions, lights].into_iter().chain(lists).fold(pass, Pass::streams_written);
        }
        tables.shade(pass, List::Rays, vertex)?;
        if is_end {
            return Ok(());
        }

        let shadow = [&tables.hits_and_shadow_origins, directions, lights];
        let pass = self.pass(frame, inputs, &name("bounce shadow rays"), &self.shadow_rays, tables, push);
        let pass = shadow.into_iter().chain([&tables.shadow_list]).fold(pass, Pass::streams);
        let pass = tables.glass_list(vertex).into_iter().fold(pass, Pass::streams_written);
        tables.trace(lit(pass, tables), List::ShadowRays, vertex)?;

        let Some(glass) = &self.glass else { return Ok(()) };
        let pass = self.pass(frame, inputs, &name("bounce glass"), glass, tables, push);
        let pass = shadow.into_iter().chain(tables.glass_list(vertex)).fold(pass, Pass::streams);
        tables.trace(lit(pass, tables), List::Glass, vertex)
    }

    fn pass<'f, 'r>(
        &self,
        frame: &'f mut Frame<'r>,
        inputs: &StageInputs<'_>,
        name: &str,
        kernel: &'f Kernel,
        tables: &Tables,
        push: &IndirectPush,
    ) -> Pass<'f, 'r> {
        // Not every texel has a path, and not every path all rays.
        tables.bind(inputs.pass(frame, name, kernel, &Self::IO).touches_part()).push(push)
    }
}

/// Declares what add_light() of `bounce_path.glsl` accesses.
fn lit<'f, 'r>(pass: Pass<'f, 'r>, tables: &Tables) -> Pass<'f, 'r> {
    let pass = pass.streams_updated(&tables.lights);
    tables
        .reuse()
        .iter()
        .fold(pass, |pass, reuse| pass.streams_updated(&reuse.reusable).streams(&reuse.shares))
}

/// What the thread has made.
fn join<T>(thread: thread::ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
