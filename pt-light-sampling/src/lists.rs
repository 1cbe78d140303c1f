use crate::alias::AliasTable;
use crate::emissive::{self, EmissiveTriangle, Twin};
use crate::light_bounds::{self, LightBounds, local_lights};
use crate::{EnvironmentQuads, environment, punctual};
use glam::{UVec2, Vec2};
use pt_scene::{LightKind, Scene};
use pt_shaders::records::{EmissiveRecord, LightRecord, NONE, SceneRecord};
use std::f64::consts::PI;

/// How the local lights of a frame differ from those of the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LocalChange {
    /// Any of them, in any respect.
    pub moved: bool,
    /// The power of any of them.
    pub power: bool,
}

fn moving(scene: &Scene, emissives: &[EmissiveTriangle]) -> Vec<u32> {
    let moves = |t: &EmissiveTriangle| {
        let instance = &scene.instances[t.instance as usize];
        !instance.is_static(&scene.meshes[instance.mesh as usize])
    };
    (0..).zip(emissives).filter(|(_, t)| moves(t)).map(|(i, _)| i).collect()
}

fn by_power(local: &[LightBounds]) -> Option<AliasTable> {
    AliasTable::new(&local.iter().map(|light| light.power.into()).collect::<Vec<f64>>())
}

fn quads(quads: &Option<EnvironmentQuads>, scene: &Scene, disc: f64) -> impl Iterator<Item = LightBounds> {
    let quads = quads.iter().flat_map(|quads| (0..quads.quads().len()).map(move |quad| (quads, quad)));
    quads.map(move |(quads, quad)| quads.light(quad, &scene.environment, disc))
}

/// Everything that light samplers of a scene need, on the host: lists, probabilities and alias tables.
#[derive(Clone, Debug)]
pub struct LightLists {
    /// The directional lights, then the positional ones.
    pub lights: Vec<LightRecord>,
    /// How many of `lights` are directional.
    pub sun_count: u32,
    /// Emissive triangles with their weights, by instance and triangle.
    pub emissives: Vec<EmissiveTriangle>,
    /// Emissive triangles that are not listed because their like is.
    pub twins: Vec<Twin>,
    /// Distribution over `emissives`; `None` when there are none.
    pub emissive_alias: Option<AliasTable>,
    /// Those of `emissives` that can move, as indices.
    pub moving: Vec<u32>,
    /// The local lights where they are now; see [`local_lights`]. If the environment is listed, its quads follow.
    pub local: Vec<LightBounds>,
    /// Distribution over them by power; `None` when all are dark.
    pub local_alias: Option<AliasTable>,
    /// Distribution over the environment's texels, row by row; `None` when it is black.
    pub environment_alias: Option<AliasTable>,
    /// Width and height of the environment in texels.
    pub environment_size: [u32; 2],
    /// Cosine and sine of the environment's rotation.
    pub environment_rotation: [f32; 2],
    /// Factor on the environment's radiance; 0 when it is black.
    pub environment_intensity: f32,
    /// The environment as local lights, after [`LightLists::list_environment`].
    pub environment_quads: Option<EnvironmentQuads>,
    /// Area of the disc that the bounding sphere of the scene shows to distant lights, square metres.
    disc: f64,
}

fn disc(scene: &Scene) -> f64 {
    let radius = scene.bounds().map_or(1.0, |b| 0.5 * f64::from(b.size().length()));
    PI * radius * radius
}

impl LightLists {
    /// Lists the lights of a scene where its instances are now. Rigid motion leaves all probabilities right; triangles that
    /// are scaled or deformed later keep the probability of their first size, and stay unbiased: the density of a sample
    /// is made from this probability and the area that the triangle has by then.
    pub fn new(scene: &Scene) -> Self {
        let (lights, sun_count) = punctual::records(&scene.lights);
        let (emissives, twins) = emissive::triangles(scene);
        let weights: Vec<f64> = emissives.iter().map(|t| t.weight).collect();
        let environment = &scene.environment;
        let environment_alias = AliasTable::new(&environment::weights(environment));
        let (sin, cos) = environment.rotation.sin_cos();
        let local = local_lights(scene, &emissives);
        Self {
            moving: moving(scene, &emissives),
            local_alias: by_power(&local),
            local,
            lights,
            sun_count,
            emissive_alias: AliasTable::new(&weights),
            emissives,
            twins,
            environment_size: [environment.image.width, environment.image.height],
            environment_rotation: [cos, sin],
            environment_intensity: if environment_alias.is_some() { environment.intensity } else { 0.0 },
            environment_alias,
            environment_quads: None,
            disc: disc(scene),
        }
    }

    /// Makes the quads of the environment local lights, or takes them out; whether that has changed anything. The lights that were there keep
    /// their indices.
    pub fn list_environment(&mut self, scene: &Scene, listed: bool) -> bool {
        if listed == self.environment_quads.is_some() {
            return false;
        }
        self.environment_quads = listed.then(|| EnvironmentQuads::new(&scene.environment));
        let others = self.emissives.len() + self.lights.len() - self.sun_count as usize;
        self.local.truncate(others);
        self.local.extend(quads(&self.environment_quads, scene, self.disc));
        self.local_alias = by_power(&self.local);
        true
    }

    /// Lists the punctual lights anew; whether anything of them has changed. Rotation and intensity of the environment are those of the scene
    /// from now on.
    pub fn update_lights(&mut self, scene: &Scene) -> bool {
        let (sin, cos) = scene.environment.rotation.sin_cos();
        self.environment_rotation = [cos, sin];
        self.environment_intensity =
            if self.environment_alias.is_some() { scene.environment.intensity } else { 0.0 };
        let (lights, sun_count) = punctual::records(&scene.lights);
        let changed = lights != self.lights;
        (self.lights, self.sun_count) = (lights, sun_count);
        changed
    }

    /// Brings the local lights to where they are now; what has changed.
    pub fn update_local(&mut self, scene: &Scene) -> LocalChange {
        let mut change = LocalChange::default();
        let triangles = self
            .moving
            .iter()
            .map(|&i| (i as usize, light_bounds::triangle(scene, &self.emissives[i as usize])));
        let positional = scene.lights.iter().filter(|light| light.kind != LightKind::Directional);
        let punctual = (self.emissives.len()..).zip(positional.map(light_bounds::punctual));
        let first_quad = self.local.len() - self.quad_count();
        let quads = (first_quad..).zip(quads(&self.environment_quads, scene, self.disc));
        for (index, now) in triangles.chain(punctual).chain(quads) {
            let before = &mut self.local[index];
            change.power |= now.power != before.power;
            change.moved |= now != *before;
            *before = now;
        }
        if change.power {
            self.local_alias = by_power(&self.local);
        }
        change
    }

    /// How many of the local lights are quads of the environment.
    pub fn quad_count(&self) -> usize {
        self.environment_quads.as_ref().map_or(0, |quads| quads.quads().len())
    }

    /// The emissive triangles as the GPU sees them.
    pub fn emissive_records(&self) -> Vec<EmissiveRecord> {
        let Some(alias) = &self.emissive_alias else { return Vec::new() };
        let triangles = self.emissives.iter().zip(alias.entries());
        triangles
            .map(|(t, a)| {
                let EmissiveTriangle { instance, triangle, luminance, .. } = *t;
                EmissiveRecord { instance, triangle, pmf: a.pmf, luminance }
            })
            .collect()
    }

    /// From instance and triangle to the index in `emissives`, laid out as `SceneRecord::emissive_lookup` says.
    pub fn emissive_lookup(&self, scene: &Scene) -> Vec<u32> {
        let mut lookup = vec![NONE; scene.instances.len()];
        let listed = (0..).zip(&self.emissives).map(|(index, e)| (index, e.instance, e.triangle));
        let twins = self.twins.iter().map(|twin| (twin.index, twin.instance, twin.triangle));
        for (index, instance, triangle) in listed.chain(twins) {
            let instance = instance as usize;
            if lookup[instance] == NONE {
                lookup[instance] = lookup.len() as u32;
                let triangles = scene.meshes[scene.instances[instance].mesh as usize].triangle_count();
                lookup.resize(lookup.len() + triangles, NONE);
            }
            let entry = (lookup[instance] + triangle) as usize;
            lookup[entry] = index;
        }
        lookup
    }

    /// Counts, environment size, rotation and intensity.
    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        record.light_count = self.lights.len() as u32;
        record.sun_count = self.sun_count;
        record.emissive_count = self.emissives.len() as u32;
        record.local_light_count = if self.local_alias.is_some() { self.local.len() as u32 } else { 0 };
        record.environment_size = UVec2::from_array(self.environment_size);
        record.environment_rotation = Vec2::from_array(self.environment_rotation);
        record.environment_intensity = self.environment_intensity;
        record.environment_quad_count = self.quad_count() as u32;
        let grid = self.environment_quads.as_ref().map_or([1; 2], EnvironmentQuads::grid);
        record.environment_grid = UVec2::from_array(grid);
    }
}
