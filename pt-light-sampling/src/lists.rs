use crate::alias::AliasTable;
use crate::cluster_lists::changing_lights;
use crate::emissive::{self, EmissiveTriangle, Twin};
use crate::light_bounds::{self, LightBounds, local_lights};
use crate::places::Places;
use crate::{EnvironmentQuads, environment, punctual};
use glam::{UVec2, Vec2, Vec3};
use pt_scene::{Light, Scene};
use pt_shaders::records::{EmissiveRecord, LightRecord, LightTablesRecord, NONE, SceneRecord};
use std::f64::consts::PI;
use std::ops::Range;

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

fn records(scene: &Scene, suns: &Places, positional: &Places) -> Vec<LightRecord> {
    let positional = positional.arranged(punctual::positional(scene));
    punctual::records(&suns.arranged(punctual::suns(scene)), &positional)
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
    /// The directional lights, then the positional ones, each by their places: a light keeps its place as long as it exists
    /// ([`Light::id`]), and places without a light are dark.
    pub lights: Vec<LightRecord>,
    /// How many of `lights` are directional.
    pub sun_count: u32,
    suns: Places,
    positional: Places,
    /// Emissive triangles with their weights, by instance and triangle.
    pub emissives: Vec<EmissiveTriangle>,
    /// Emissive triangles that are not listed because their like is.
    pub twins: Vec<Twin>,
    /// Distribution over `emissives`; `None` when there are none.
    pub emissive_alias: Option<AliasTable>,
    /// Those of `emissives` that can move, as indices.
    pub moving: Vec<u32>,
    /// The local lights where they are now: the emissive triangles, the quads of the environment if it is listed, then the point and spot
    /// lights by their places. The index of a light stays the same as long as it exists.
    pub local: Vec<LightBounds>,
    /// Which of `local` may change from frame to frame.
    pub may_change: Vec<bool>,
    /// Whether any of the emissive triangles is on a mesh that deforms: the host does not know where its vertices are.
    pub(crate) deforms: bool,
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
        let suns = Places::new(punctual::suns(scene));
        let positional = Places::new(punctual::positional(scene));
        let lights = records(scene, &suns, &positional);
        let (emissives, twins) = emissive::triangles(scene);
        let weights: Vec<f64> = emissives.iter().map(|t| t.weight).collect();
        let environment = &scene.environment;
        let environment_alias = AliasTable::new(&environment::weights(environment));
        let (sin, cos) = environment.rotation.sin_cos();
        let local = local_lights(scene, &emissives);
        let moving = moving(scene, &emissives);
        let deformed = |&i: &u32| {
            let mesh = scene.instances[emissives[i as usize].instance as usize].mesh;
            scene.meshes[mesh as usize].deformation.is_some()
        };
        Self {
            deforms: moving.iter().any(deformed),
            may_change: changing_lights(scene, &emissives),
            moving,
            local_alias: by_power(&local),
            local,
            lights,
            sun_count: suns.count() as u32,
            suns,
            positional,
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

    /// Makes the quads of the environment local lights, or takes them out; whether that has changed anything. The indices of the point and spot
    /// lights, which follow the quads, change with it.
    pub fn list_environment(&mut self, scene: &Scene, listed: bool) -> bool {
        if listed == self.environment_quads.is_some() {
            return false;
        }
        let before = self.quad_range();
        self.environment_quads = listed.then(|| EnvironmentQuads::new(&scene.environment));
        // Intensity and rotation of the environment are whatever the caller sets in a frame.
        self.may_change.splice(before.clone(), self.quad_range().map(|_| true));
        self.local.splice(before, quads(&self.environment_quads, scene, self.disc));
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
        self.suns.update(punctual::suns(scene));
        self.positional.update(punctual::positional(scene));
        let lights = records(scene, &self.suns, &self.positional);
        let changed = lights != self.lights;
        self.sun_count = self.suns.count() as u32;
        self.lights = lights;
        changed
    }

    /// Brings the local lights to where they are now; what has changed. After [`LightLists::update_lights`].
    pub fn update_local(&mut self, scene: &Scene) -> LocalChange {
        let mut change = LocalChange::default();
        let positional = self.positional.arranged(punctual::positional(scene));
        let dark = Light::point("", Vec3::ZERO, Vec3::ZERO);
        let bounds = |light: Option<&Light>| light_bounds::punctual(light.unwrap_or(&dark));
        let first = self.first_positional();
        while self.local.len() < first + positional.len() {
            change = LocalChange { moved: true, power: true };
            self.local.push(bounds(None));
            self.may_change.push(true);
        }
        for (place, light) in positional.iter().enumerate() {
            self.may_change[first + place] = self.positional.has_changed(place)
                || light.is_some_and(|light| light.motion.is_some() || light.node.is_some());
        }
        let triangles = self
            .moving
            .iter()
            .map(|&i| (i as usize, light_bounds::triangle(scene, &self.emissives[i as usize])));
        let punctual = (first..).zip(positional.into_iter().map(bounds));
        let quads = self.quad_range().zip(quads(&self.environment_quads, scene, self.disc));
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

    /// Indices of the quads of the environment among the local lights. They come before the point and spot lights, whose number may change from
    /// frame to frame.
    pub fn quad_range(&self) -> Range<usize> {
        self.emissives.len()..self.first_positional()
    }

    /// Index of the first point or spot light among the local lights.
    pub fn first_positional(&self) -> usize {
        self.emissives.len() + self.quad_count()
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

    /// How many lights there are.
    pub(crate) fn fill_counts(&self, record: &mut LightTablesRecord) {
        record.light_count = self.lights.len() as u32;
        record.sun_count = self.sun_count;
        record.local_light_count = if self.local_alias.is_some() { self.local.len() as u32 } else { 0 };
    }

    /// Number of emissive triangles, environment size, rotation and intensity.
    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        record.emissive_count = self.emissives.len() as u32;
        record.environment_size = UVec2::from_array(self.environment_size);
        record.environment_rotation = Vec2::from_array(self.environment_rotation);
        record.environment_intensity = self.environment_intensity;
        record.environment_quad_count = self.quad_count() as u32;
        let grid = self.environment_quads.as_ref().map_or([1; 2], EnvironmentQuads::grid);
        record.environment_grid = UVec2::from_array(grid);
    }
}
