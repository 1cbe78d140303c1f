//! The light tables that another crate gives to the scene on the device, and which of them a kernel needs.

use pt_core::frame::MissingTable;
use pt_core::{Buffer, Constant, Kernel};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{LightSampler, LightTablesRecord, RisSource, SamplerTableSet, SceneRecord};

/// Light tables. The addresses of their buffers are in the record of the scene.
#[derive(Default)]
pub struct LightTableSet {
    /// What kernels read.
    pub buffers: Vec<Buffer>,
    /// What kernels that trace shadow rays write too.
    pub updated: Vec<Buffer>,
    /// Whether the quads of the environment are among the local lights.
    pub environment_listed: bool,
    /// Whether the local lights of the last frame are kept.
    pub keeps_last_lights: bool,
    /// Whether all that choices of the last frame have read is kept.
    pub keeps_last_choices: bool,
}

const PREPARE: &str =
    "call LightTables::prepare with the sampler that the stage is made for, before the first frame";
const UPDATE: &str = "call LightTables::update in each frame, before the stages";
const KEEP: &str =
    "call LightTables::keep_last_frame(true), then LightTables::prepare, before the first frame";

/// The table that a kernel would read and that is not there. Kernels that choose lights have the constant `light_sampler`
/// (`lights/light_sampler.glsl`); those that do not name their sampler are not asked for anything.
pub(super) fn missing(set: &LightTableSet, record: &SceneRecord, kernel: &Kernel) -> Option<MissingTable> {
    let Some(Constant::Uint(code)) = kernel.constant("light_sampler") else { return None };
    let sampler = LightSampler::VALUES.iter().copied().find(|sampler| sampler.code() == code)?;
    let is = |name| kernel.constant(name) == Some(Constant::Bool(true));
    let is_not = |name| kernel.constant(name) == Some(Constant::Bool(false));
    let given = |source: &RisSource| kernel.constant("ris_source") == Some(Constant::Uint(source.code()));
    let source = RisSource::VALUES.iter().copied().find(given).unwrap_or(RisSource::Power);
    let tables = &record.light_tables;
    let reader = format!("the light sampler \"{}\"", sampler.name());
    let refuse = |table, remedy| Some(MissingTable { reader, table, remedy });
    if set.buffers.is_empty() {
        return refuse("the lights of the scene", "call LightTables::prepare before the first frame");
    }
    let SamplerTableSet { lists, statistics, tree } = sampler.tables(source);
    if lists && tables.cluster_lists == 0 {
        return refuse("the light lists of the clusters", PREPARE);
    }
    if tree && tables.light_bvh == 0 {
        return refuse("the light tree", PREPARE);
    }
    if statistics && tables.shadow_history == 0 {
        return refuse("the shadow statistics", PREPARE);
    }
    if is("environment_listed") && !set.environment_listed {
        return refuse("the quads of the environment among the local lights", PREPARE);
    }
    if is_not("environment_listed") && set.environment_listed {
        return refuse("local lights without quads of the environment", PREPARE);
    }
    if sampler == LightSampler::RestirDi && !set.keeps_last_lights {
        return refuse("the local lights of the last frame", PREPARE);
    }
    if is("replays_samples") && !set.keeps_last_choices {
        return refuse("the light tables of the last frame", KEEP);
    }
    let LightTablesRecord { lights: updated, .. } = record.light_tables_previous;
    if updated == 0 {
        return refuse("the lights where they are in this frame", UPDATE);
    }
    None
}
