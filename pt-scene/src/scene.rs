use glam::Affine3A;
use pt_core::phases::Phase;

use std::sync::Arc;

use crate::animation::{Pose, Rig};
use crate::light::shines;
use crate::transform::visible;
use crate::{
    AnimationInfo, Bounds, Camera, Environment, ExtensionUse, Light, Material, Mesh, Motion, Shows, Texture,
};

/// Everything that is to be rendered.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// File name or name of the built-in scene.
    pub name: String,
    /// Shapes, in object space.
    pub meshes: Vec<Mesh>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// Surfaces, named by triangles.
    pub materials: Vec<Material>,
    /// Images, named by materials.
    pub textures: Vec<Texture>,
    /// Punctual lights, world space. Emissive triangles are found through materials.
    pub lights: Vec<Light>,
    /// Cameras of the file, in its order; may be empty, see [`Scene::default_camera`].
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away.
    pub environment: Environment,
    /// Windows and other openings that it shines through; may be empty. Samplers look at the first [`crate::MAX_PORTALS`].
    pub portals: Vec<crate::Portal>,
    /// Particles, sprites, beams and fog.
    pub effects: crate::Effects,
    /// Animations of the file.
    pub animations: Vec<AnimationInfo>,
    /// The nodes that move instances, lights and joints; `None` when nothing does.
    pub rig: Option<Arc<Rig>>,
    /// Where the rig's nodes are, since the last [`Scene::set_time`].
    pub pose: Pose,
    /// Where they were in the previous frame.
    pub pose_prev: Pose,
    /// Seconds, of the last [`Scene::set_time`]: waves and cameras that surfaces show go by it.
    pub time: f64,
    /// What the importer left out or changed, one sentence each.
    pub notices: Vec<String>,
    /// How long the steps of loading took; empty for scenes made by code.
    pub load_phases: Vec<Phase>,
    /// Names of the scenes in the file that this one was chosen from.
    pub scenes: Vec<String>,
    /// Names of the material variants in the file.
    pub variants: Vec<String>,
    /// Extensions that the file uses.
    pub extensions: Vec<ExtensionUse>,
}

/// A mesh in the world, now and in the previous frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Name from the file, for messages.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Transform now; invertible, may mirror.
    pub world_from_object: Affine3A,
    /// Transform in the previous frame, for motion vectors.
    pub world_from_object_prev: Affine3A,
    /// How it moves; [`Scene::set_time`] applies it.
    pub motion: Option<Motion>,
    /// The node of [`Scene::rig`] that carries it, if that moves; [`Scene::set_time`] applies it.
    pub attachment: Option<Attachment>,
    /// Stands in for the materials of all triangles, so that shapes of several colours are stored once. Only where
    /// neither it nor the mesh's own materials look at alpha.
    pub material: Option<u32>,
}

/// Hangs an instance on a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// Index of the node.
    pub node: u32,
    /// Node-from-object transform.
    pub offset: Affine3A,
}

impl Instance {
    /// An instance that stands still.
    pub fn new(name: &str, mesh: u32, world_from_object: Affine3A) -> Self {
        Self {
            name: name.into(),
            mesh,
            world_from_object,
            world_from_object_prev: world_from_object,
            motion: None,
            attachment: None,
            material: None,
        }
    }

    /// Material of a triangle of `mesh`, which must be the instance's own.
    pub fn material_at(&self, mesh: &Mesh, triangle: usize) -> u32 {
        self.material.unwrap_or(mesh.triangle_materials[triangle])
    }

    /// Whether light passes through all of it (KHR_materials_transmission).
    pub fn transmits(&self, mesh: &Mesh, materials: &[Material]) -> bool {
        match self.material {
            Some(material) => materials[material as usize].transmits(),
            None => mesh.transmits(materials),
        }
    }

    /// An instance that moves, at time 0.
    pub fn moving(name: &str, mesh: u32, motion: Motion) -> Self {
        Self { motion: Some(motion), ..Self::new(name, mesh, motion.at(0.0)) }
    }

    /// Whether neither it nor any vertex of `mesh`, which must be the instance's own, ever moves.
    pub fn is_static(&self, mesh: &Mesh) -> bool {
        self.motion.is_none() && self.attachment.is_none() && mesh.deformation.is_none()
    }
}

/// Counts of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Triangles in memory.
    pub triangles: usize,
    /// Triangles counted once per instance.
    pub instanced_triangles: usize,
    /// Of these, emitting ones.
    pub emissive_triangles: usize,
    /// Of these, masked or blended ones.
    pub masked_triangles: usize,
    /// Bytes of texels as the host holds them: compressed ones with their mip levels, others without.
    pub texture_bytes: usize,
}

impl Scene {
    /// Whether anything but its cameras changes with the time: an instance, a vertex, a light, or what a surface shows.
    pub fn is_animated(&self) -> bool {
        self.rig.as_ref().is_some_and(|rig| rig.is_animated())
            || self.instances.iter().any(|instance| instance.motion.is_some())
            || self.lights.iter().any(|light| light.motion.is_some())
            || self.materials.iter().any(|material| material.waves.is_some())
            || self.effects.is_animated()
            || self.shown_cameras().any(|camera| camera.path.is_some() || camera.motion.is_some())
    }

    /// The cameras whose views surfaces show.
    pub fn shown_cameras(&self) -> impl Iterator<Item = &Camera> {
        self.materials.iter().filter_map(|material| match material.shows {
            Shows::Camera(camera) => self.cameras.get(camera as usize),
            _ => None,
        })
    }

    /// Bounding box of all instances where they are now; `None` without any vertex.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.instances.iter().flat_map(|instance| {
            let mesh = &self.meshes[instance.mesh as usize];
            let corners = mesh.indices.iter().flatten();
            corners.map(|&v| instance.world_from_object.transform_point3(mesh.positions[v as usize]))
        }))
    }

    /// Moves instances, lights and the joints of deforming meshes to where they are at `now`, and the instances' previous
    /// transforms to where they were at `previous` (seconds); lights blink too, see [`Light::at`]. Cameras are evaluated by
    /// [`Camera::at`], vertices on the device or by [`Scene::pose_meshes`].
    pub fn set_time(&mut self, now: f64, previous: f64) {
        self.time = now;
        (self.effects.time, self.effects.time_prev) = (now, previous);
        for light in &mut self.lights {
            *light = light.at(now);
        }
        for instance in &mut self.instances {
            match &instance.motion {
                Some(motion) => {
                    instance.world_from_object = motion.at(now);
                    instance.world_from_object_prev = motion.at(previous);
                }
                None => instance.world_from_object_prev = instance.world_from_object,
            }
        }
        let Some(rig) = &self.rig else { return };
        rig.evaluate(now, &mut self.pose);
        rig.evaluate(previous, &mut self.pose_prev);
        for instance in &mut self.instances {
            if let Some(Attachment { node, offset }) = instance.attachment {
                let place = |pose: &Pose| visible(pose.world[node as usize] * offset);
                instance.world_from_object = place(&self.pose);
                instance.world_from_object_prev = place(&self.pose_prev);
            }
        }
        for light in &mut self.lights {
            if let Some(world) = light.node.map(|node| self.pose.world[node as usize]) {
                light.position = world.translation.into();
                light.direction = shines(&world);
            }
        }
        for deformation in self.meshes.iter_mut().filter_map(|mesh| mesh.deformation.as_mut()) {
            deformation.set_pose(&self.pose);
        }
    }

    /// Puts the vertices of deforming meshes where they are now, for everything that reads them on the CPU: bounds, the automatic
    /// camera, acceleration structures that are built, the reference.
    pub fn pose_meshes(&mut self) {
        self.meshes.iter_mut().for_each(Mesh::pose);
    }

    /// The camera of this index in the list of the file, where it is placed first; of a scene made by code, in its own list.
    pub fn camera(&self, index: usize) -> Option<&Camera> {
        let mut cameras = self.cameras.iter().enumerate();
        cameras.find(|(i, camera)| camera.index.unwrap_or(*i) == index).map(|(_, camera)| camera)
    }

    /// Whether nothing lights the scene: no punctual light, no emissive triangle, a black environment.
    pub fn is_unlit(&self) -> bool {
        self.lights.is_empty() && self.environment.is_black() && self.statistics().emissive_triangles == 0
    }

    /// Counts.
    pub fn statistics(&self) -> Statistics {
        let mut s = Statistics {
            triangles: self.meshes.iter().map(Mesh::triangle_count).sum(),
            texture_bytes: self.textures.iter().map(Texture::bytes).sum(),
            ..Statistics::default()
        };
        // Instances share meshes: the triangles of each are gone through once.
        let emits = |&&material: &&u32| self.materials[material as usize].is_emissive();
        let own_emissive: Vec<_> =
            self.meshes.iter().map(|mesh| mesh.triangle_materials.iter().filter(emits).count()).collect();
        for instance in &self.instances {
            let mesh = &self.meshes[instance.mesh as usize];
            s.instanced_triangles += mesh.triangle_count();
            s.emissive_triangles += match &instance.material {
                None => own_emissive[instance.mesh as usize],
                Some(material) if emits(&material) => mesh.triangle_count(),
                Some(_) => 0,
            };
            s.masked_triangles += mesh.triangle_count() - mesh.first_masked;
        }
        s
    }
}
