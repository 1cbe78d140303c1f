use crate::records::ReflectRefractPush;
use crate::{Effects, GbufferParams, ThinRefraction, images, kernels};
use pt_core::frame::RayCount;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, StageInputs, StageIo};
use pt_shaders::channels::{self, ChannelId};
use pt_shaders::records::{CULL_BACK_FACES, MASK_OPAQUE, MASK_TRANSMISSIVE};

/// The reflect/refract stage: where the G-buffer holds a mirror or glass, the surface seen in or through it replaces it.
///
/// Metals below [`GbufferParams::mirror_roughness`] reflect with Schlick's Fresnel term, as their regular shading does. Glass
/// reflects by Fresnel's equations and lets the rest through: straight on when it is thin, bent and with absorption when it is
/// solid. Solids may overlap (nested dielectrics): the channel `interior` says which of them the path is inside of. The first glass of a path is split over the checkerboard fields; later choices are drawn, so that the expectation
/// is right; with planes the frame runs once for each of its lobes instead. What the last pass leaves: its rays ignore transmissive instances, and a mirror seen by them is shaded with the
/// light samples alone.
pub struct ReflectRefract {
    kernel: Kernel,
    io: StageIo,
}

/// What the stage updates. The last one: in scenes with effects.
const UPDATES: &[ChannelId] = &[
    channels::VISIBILITY,
    channels::BARYCENTRICS,
    channels::BASE_COLOR,
    channels::METALLIC_ROUGHNESS,
    channels::VIEW_DEPTH,
    channels::MOTION,
    channels::SHADING_POSITION,
    channels::VIEW_DIRECTION,
    channels::THROUGHPUT,
    channels::TRANSPARENT,
    channels::INTERIOR,
    images::EFFECTS_MOTION,
];

impl ReflectRefract {
    /// The images that the stage accesses; it writes and updates only where it replaces a surface.
    pub const IO: StageIo = StageIo {
        reads: &[channels::RNG_SEED, channels::BOUNCE_THROUGHPUT],
        writes: &[channels::CLUSTER, channels::NORMAL, channels::VERTEX_NORMAL],
        updates: UPDATES.split_at(UPDATES.len() - 1).0,
        ..StageIo::of("reflect refract")
    };

    /// The same in scenes with effects.
    pub const IO_EFFECTS: StageIo = StageIo { updates: UPDATES, ..Self::IO };

    /// Compiles the kernel. `has_planes`: the frame has several planes ([`crate::plane_count`]). `effect_layers`: [`GbufferParams::effect_layers`].
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(
        device: &Device,
        variant: TraceVariant,
        has_planes: bool,
        effect_layers: u32,
    ) -> pt_core::Result<Self> {
        let mut constants = variant.constants().to_vec();
        constants.push(("has_planes", has_planes.into()));
        let (code, io) = match Effects::are_in(variant.scene_features) {
            true => (&kernels::REFLECT_REFRACT_EFFECTS, Self::IO_EFFECTS),
            false => (&kernels::REFLECT_REFRACT, Self::IO),
        };
        if Effects::are_in(variant.scene_features) {
            constants.push(("effect_layers", effect_layers.into()));
        }
        let kernel = Kernel::trace::<ReflectRefractPush>(device, code, variant.backend, &constants)?;
        io.check([&kernel])?;
        Ok(Self { kernel, io })
    }

    /// The images that it accesses: [`Self::IO`] or [`Self::IO_EFFECTS`].
    pub fn io(&self) -> StageIo {
        self.io
    }

    /// Records pass `bounce_index`, of `plane`, of the [`GbufferParams::reflect_refract`] passes that follow the primary rays. `light_kinds`: `KIND_SUN` and
    /// `KIND_POSITIONAL` for the lights whose highlights rough glass shows, if the scene has its lights attached.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &GbufferParams,
        light_kinds: u32,
        bounce_index: u32,
        plane: u32,
    ) -> pt_core::Result<()> {
        let last = bounce_index + 1 >= params.reflect_refract;
        let push = ReflectRefractPush {
            bounce: bounce_index,
            mask: CULL_BACK_FACES | if last { MASK_OPAQUE } else { MASK_OPAQUE | MASK_TRANSMISSIVE },
            lod_scale: params.texture_lod_bias.exp2(),
            mirror_roughness: params.mirror_roughness,
            glass_roughness: params.glass_roughness,
            alternate_fields: u32::from(params.alternate_fields),
            light_kinds,
            double_refraction: u32::from(params.thin_refraction == ThinRefraction::Double),
            plane,
        };
        let name = format!("reflect refract {}", bounce_index + 1);
        let pass = inputs.pass(frame, &name, &self.kernel, &self.io);
        pass.touches_part().rays(RayCount::AtMostPerThread(1)).push(&push).dispatch(inputs.split_threads())
    }
}
