//! Caustics of directional lights (`caustics.glsl`): photons through smooth glass, and the grid that they are gathered in.

use crate::kernels;
use crate::params::DirectParams;
use crate::records::{CausticBox, CausticCell, CausticHead, CausticTarget, CausticsPush, PartialMetal};
use pt_core::frame::RayCount;
use pt_core::trace::TraceVariant;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, StageInputs, StageIo};
use pt_scene::{Bounds, Instance, LightKind, Mesh, Scene};
use pt_shaders::channels;
use pt_shaders::dimensions::MAX_CAUSTIC_SEGMENTS;
use pt_shaders::glam::Vec3;
use pt_shaders::records::NONE;

/// Photons in a row of the launch; `caustic_photons.trace` has the same.
const ROW: u32 = 1024;
/// More targets than these become one, the bounds of the scene: every photon looks at all of them.
const MAX_TARGETS: usize = 256;
/// Boxes are larger than what is in them by this part of their size, so that no photon begins on a surface.
const MARGIN: f32 = 1e-3;
/// Roughness of the glTF material below which its interface is smooth, as `MIRROR_ROUGHNESS` of the kernels.
const SMOOTH: f32 = 0.02;

/// What photons of `scene` are aimed at: the instances with smooth transmissive surfaces. None where no directional light is.
pub fn caustic_targets(scene: &Scene) -> Vec<CausticTarget> {
    if !scene.lights.iter().any(|light| matches!(light.kind, LightKind::Directional)) {
        return Vec::new();
    }
    let smooth = |&material: &u32| {
        let m = &scene.materials[material as usize];
        m.transmits() && (m.roughness < SMOOTH || m.metallic_roughness_texture.is_some())
    };
    let is_target = |instance: &&Instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        match &instance.material {
            Some(material) => smooth(material),
            None => mesh.triangle_materials.iter().any(&smooth),
        }
    };
    let instances: Vec<_> = (0..).zip(&scene.instances).filter(|(_, i)| is_target(i)).collect();
    let deforms = |instance: &Instance| scene.meshes[instance.mesh as usize].deformation.is_some();
    if instances.len() > MAX_TARGETS || instances.iter().any(|(_, i)| deforms(i)) {
        return scene.bounds().map(|bounds| target(NONE, bounds)).into_iter().collect();
    }
    let of = |(index, instance): &(u32, &Instance)| {
        mesh_bounds(&scene.meshes[instance.mesh as usize]).map(|bounds| target(*index, bounds))
    };
    instances.iter().filter_map(of).collect()
}

fn mesh_bounds(mesh: &Mesh) -> Option<Bounds> {
    Bounds::of(mesh.indices.iter().flatten().map(|&v| mesh.positions[v as usize]))
}

fn target(instance: u32, bounds: Bounds) -> CausticTarget {
    let margin = MARGIN * bounds.size().max_element() + 1e-6 * bounds.min.abs().max(bounds.max.abs());
    let margin = margin.max(Vec3::splat(f32::MIN_POSITIVE));
    CausticTarget { instance, low: bounds.min - margin, high: bounds.max + margin }
}

/// The passes of caustics: before direct lighting the photons of the frame, after it their light.
pub(crate) struct Caustics {
    grid: Kernel,
    photons: Kernel,
    gather: Kernel,
    target_count: u32,
    targets: Buffer,
    boxes: Buffer,
    head: Buffer,
    cells: Buffer,
    cell_count: u32,
}

impl Caustics {
    /// The images that the last pass accesses.
    pub(crate) const IO: StageIo = StageIo {
        reads: &[
            channels::RNG_SEED,
            channels::BASE_COLOR,
            channels::METALLIC_ROUGHNESS,
            channels::NORMAL,
            channels::VERTEX_NORMAL,
            channels::SHADING_POSITION,
            channels::VIEW_DIRECTION,
            channels::VISIBILITY,
            channels::BARYCENTRICS,
            channels::THROUGHPUT,
            channels::BOUNCE_THROUGHPUT,
        ],
        updates: &[channels::COLOR_HF, channels::COLOR_SPEC],
        ..StageIo::of("caustics")
    };

    /// The images that the passes before access: none.
    const PHOTONS: StageIo = StageIo::of("caustic photons");

    /// Compiles the kernels and takes the memory of the grid.
    pub(crate) fn new(
        device: &Device,
        variant: TraceVariant,
        params: &DirectParams,
        targets: &[CausticTarget],
    ) -> Result<Self> {
        let features = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
        ];
        let grid = Kernel::compute::<CausticsPush>(device, &kernels::CAUSTIC_GRID, &features[..1])?;
        let constants = variant.unseen().constants();
        let photons =
            Kernel::trace::<CausticsPush>(device, &kernels::CAUSTIC_PHOTONS, variant.backend, &constants)?;
        let gather = Kernel::compute::<CausticsPush>(device, &kernels::CAUSTICS, &features)?;
        Self::IO.check([&gather])?;
        // At most half of the cells are ever used.
        let cell_count = (2 * params.caustics_photons).next_power_of_two();
        let buffer = |name, bytes: usize| Buffer::new(device, name, bytes as u64, Location::Device);
        Ok(Self {
            grid,
            photons,
            gather,
            target_count: targets.len() as u32,
            targets: Buffer::from_slice(device, "caustic targets", targets)?,
            boxes: buffer("caustic boxes", targets.len() * size_of::<CausticBox>())?,
            head: buffer("caustic head", size_of::<CausticHead>())?,
            cells: buffer("caustic cells", cell_count as usize * size_of::<CausticCell>())?,
            cell_count,
        })
    }

    fn push(&self, params: &DirectParams, texture_lod_bias: f32) -> CausticsPush {
        CausticsPush {
            targets: self.targets.address(),
            boxes: self.boxes.address(),
            head: self.head.address(),
            cells: self.cells.address(),
            target_count: self.target_count,
            cell_mask: self.cell_count - 1,
            photons: params.caustics_photons,
            cell_size: params.caustics_cell,
            lod_scale: texture_lod_bias.exp2(),
            mixed: u32::from(params.partial_metal == PartialMetal::MixedParameters),
        }
    }

    /// Records the photons of a frame.
    pub(crate) fn record_photons(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
    ) -> Result<()> {
        let push = self.push(params, 0.0);
        let pass = inputs.pass(frame, "caustic grid", &self.grid, &Self::PHOTONS);
        let pass = pass.addresses(&self.targets).addresses_written(&self.boxes).addresses_written(&self.head);
        pass.streams_written(&self.cells).push(&push).dispatch([self.cell_count, 1, 1])?;
        let pass = inputs.pass(frame, Self::PHOTONS.stage, &self.photons, &Self::PHOTONS);
        let pass = pass.addresses(&self.boxes).addresses(&self.head).streams_updated(&self.cells);
        let rays = RayCount::AtMostPerThread(MAX_CAUSTIC_SEGMENTS + 1);
        let rows = params.caustics_photons.div_ceil(ROW);
        pass.touches_part().rays(rays).push(&push).dispatch([ROW, rows, 1])
    }

    /// Records the pass that adds their light to that of direct lighting.
    pub(crate) fn record_light(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
        texture_lod_bias: f32,
    ) -> Result<()> {
        let push = self.push(params, texture_lod_bias);
        let pass = inputs.pass(frame, Self::IO.stage, &self.gather, &Self::IO);
        let pass = pass.addresses(&self.head).addresses(&self.cells);
        pass.touches_part().push(&push).dispatch(inputs.split_threads())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_light_sampling::test_support::polygon;
    use pt_scene::{Light, Material};
    use pt_shaders::glam::Affine3A;

    /// `count` panes in a row of one metre each, and the sun.
    fn panes(count: u32, material: &Material) -> Scene {
        let mut scene = Scene::default();
        scene.lights.push(Light::directional("sun", Vec3::NEG_Y, Vec3::ONE));
        for i in 0..count {
            let place = Affine3A::from_translation(Vec3::X * i as f32);
            polygon(
                &mut scene,
                &[Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X],
                place,
                material.clone(),
            );
        }
        scene
    }

    #[test]
    fn photons_are_aimed_at_smooth_glass() {
        let glass = Material::solid("glass", 1.5);
        let rough = Material { roughness: 0.3, ..glass.clone() };
        let targets = caustic_targets(&panes(2, &glass));
        assert_eq!(targets.iter().map(|t| t.instance).collect::<Vec<_>>(), [0, 1]);
        for t in targets {
            assert!(t.low.cmplt(Vec3::ZERO).all() && t.high.cmpgt(Vec3::new(1.0, 0.0, 1.0)).all(), "{t:?}");
        }
        assert!(caustic_targets(&panes(2, &rough)).is_empty());
        assert!(caustic_targets(&panes(2, &Material::lambertian("wall", Vec3::ONE))).is_empty());
        let dark = Scene { lights: Vec::new(), ..panes(2, &glass) };
        assert!(caustic_targets(&dark).is_empty());
    }

    #[test]
    fn many_targets_are_one() {
        let glass = Material::solid("glass", 1.5);
        assert_eq!(caustic_targets(&panes(MAX_TARGETS as u32, &glass)).len(), MAX_TARGETS);
        let targets = caustic_targets(&panes(MAX_TARGETS as u32 + 1, &glass));
        assert_eq!(targets.iter().map(|t| t.instance).collect::<Vec<_>>(), [NONE]);
        assert!(targets[0].high.x > MAX_TARGETS as f32 + 1.0, "{:?}", targets[0]);
    }
}
