use glam::{Affine3A, Vec3};
use pt_core::phases::Phase;

use std::sync::Arc;

use crate::animation::{Pose, Rig, visible};
use crate::light::shines;
use crate::{
    AlphaMode, AnimationInfo, Camera, Environment, ExtensionUse, Light, LightKind, Lobes, MAX_PRIORITY,
    Material, Mesh, Motion, Projection, SceneError, Texture,
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
    /// Cameras of the file; may be empty, see [`Scene::default_camera`].
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away.
    pub environment: Environment,
    /// Animations of the file.
    pub animations: Vec<AnimationInfo>,
    /// The nodes that move instances, lights and joints; `None` when nothing does.
    pub rig: Option<Arc<Rig>>,
    /// Where the rig's nodes are, since the last [`Scene::set_time`].
    pub pose: Pose,
    /// Where they were in the previous frame.
    pub pose_prev: Pose,
    /// What the loader left out or changed, one sentence each.
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

/// An axis-aligned box, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The middle.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Edge lengths.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
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
    /// Bounding box of all instances where they are now; `None` without any vertex.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut points = self.instances.iter().flat_map(|instance| {
            let mesh = &self.meshes[instance.mesh as usize];
            let corners = mesh.indices.iter().flatten();
            corners.map(|&v| instance.world_from_object.transform_point3(mesh.positions[v as usize]))
        });
        let first = points.next()?;
        Some(
            points.fold(Bounds { min: first, max: first }, |b, p| Bounds {
                min: b.min.min(p),
                max: b.max.max(p),
            }),
        )
    }

    /// Moves instances, lights and the joints of deforming meshes to where they are at `now`, and the instances' previous
    /// transforms to where they were at `previous` (seconds); lights blink too, see [`Light::at`]. Cameras are evaluated by
    /// [`Camera::at`], vertices on the device or by [`Scene::pose_meshes`].
    pub fn set_time(&mut self, now: f64, previous: f64) {
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

    /// The first camera of the scene, or one that frames it by the rule of [`crate::automatic_camera`].
    pub fn default_camera(&self) -> Camera {
        self.cameras.first().cloned().unwrap_or_else(|| crate::automatic_camera(self))
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
        for instance in &self.instances {
            let mesh = &self.meshes[instance.mesh as usize];
            let emits = |&t: &usize| self.materials[instance.material_at(mesh, t) as usize].is_emissive();
            s.instanced_triangles += mesh.triangle_count();
            s.emissive_triangles += (0..mesh.triangle_count()).filter(emits).count();
            s.masked_triangles += mesh.triangle_count() - mesh.first_masked;
        }
        s
    }

    /// Checks every invariant that consumers rely on: indices in range, arrays of equal length, finite and physical
    /// values, masked triangles sorted to the end. Run by [`crate::load`].
    pub fn validate(&self) -> Result<(), SceneError> {
        let fail = |what: String| SceneError::Inconsistent { scene: self.name.clone(), what };
        self.meshes.iter().try_for_each(|mesh| mesh.check(&self.materials, &fail))?;
        for instance in &self.instances {
            if instance.mesh as usize >= self.meshes.len() {
                return Err(fail(format!(
                    "instance {}: mesh {} does not exist",
                    instance.name, instance.mesh
                )));
            }
            if let Some(material) = instance.material {
                let masked = self.materials.get(material as usize).is_none_or(Material::is_masked);
                let mesh = &self.meshes[instance.mesh as usize];
                if masked || mesh.first_masked < mesh.triangle_count() {
                    return Err(fail(format!(
                        "instance {}: material {material} cannot stand in for others",
                        instance.name
                    )));
                }
            }
            for transform in [instance.world_from_object, instance.world_from_object_prev] {
                if !is_invertible(&transform) {
                    return Err(fail(format!(
                        "instance {}: transform is not finite and invertible",
                        instance.name
                    )));
                }
            }
        }
        if self.bounds().is_some_and(|b| b.min.abs().max(b.max.abs()).max_element() > MAX_COORDINATE) {
            return Err(fail(format!("it reaches farther out than {MAX_COORDINATE:e} m")));
        }
        for m in &self.materials {
            check_material(m, self.textures.len()).map_err(fail)?;
            if m.priority > MAX_PRIORITY || m.exterior.is_some_and(|e| e as usize >= self.materials.len()) {
                let what = format!(
                    "material {}: priority {} or exterior {:?} is out of range",
                    m.name, m.priority, m.exterior
                );
                return Err(fail(what));
            }
        }
        self.textures.iter().try_for_each(|t| t.check().map_err(fail))?;
        self.lights.iter().try_for_each(|light| check_light(light).map_err(fail))?;
        self.cameras.iter().try_for_each(|camera| check_camera(camera).map_err(fail))?;
        self.environment.check().map_err(|what| fail(format!("environment: {what}")))
    }
}

/// Farthest that anything may be from the origin, metres: the areas that trees are built by stay far from overflow.
pub(crate) const MAX_COORDINATE: f32 = 1e12;

/// Finite, with a determinant that leaves room for an inverse in single precision.
pub(crate) fn is_invertible(transform: &Affine3A) -> bool {
    let determinant = transform.matrix3.determinant();
    transform.is_finite() && determinant.is_normal() && transform.inverse().is_finite()
}

fn check_material(m: &Material, textures: usize) -> Result<(), String> {
    let unit = |slot: &str, x: f32| {
        if (0.0..=1.0).contains(&x) {
            Ok(())
        } else {
            Err(format!("material {}: {slot} {x} is not in 0..1", m.name))
        }
    };
    unit("metallic", m.metallic)?;
    unit("roughness", m.roughness)?;
    unit("transmission", m.transmission)?;
    unit("specular", m.specular)?;
    if let AlphaMode::Mask { cutoff } = m.alpha_mode
        && !(cutoff >= 0.0 && cutoff.is_finite())
    {
        return Err(format!("material {}: alpha cutoff {cutoff} is negative or not finite", m.name));
    }
    let physical = m.base_color.is_finite()
        && m.base_color.min_element() >= 0.0
        && m.emissive.is_finite()
        && m.emissive.min_element() >= 0.0
        && m.specular_color.is_finite()
        && m.specular_color.min_element() >= 0.0
        && m.attenuation_color.is_finite()
        && m.attenuation_color.min_element() >= 0.0
        && m.attenuation_distance > 0.0
        && m.thickness >= 0.0
        && m.thickness.is_finite()
        && m.normal_scale.is_finite()
        && m.ior >= 1.0
        && m.ior.is_finite();
    if let Some(lobes) = &m.lobes {
        check_lobes(lobes, &unit)?;
    }
    if !physical {
        return Err(format!("material {}: a factor is negative, not finite, or below its range", m.name));
    }
    for (slot, texture) in m.textures() {
        if texture.texture as usize >= textures || texture.uv_set > 1 || !texture.transform.is_finite() {
            return Err(format!(
                "material {}: {slot} names texture {} and UV set {}",
                m.name, texture.texture, texture.uv_set
            ));
        }
    }
    Ok(())
}

fn check_lobes(l: &Lobes, unit: &impl Fn(&str, f32) -> Result<(), String>) -> Result<(), String> {
    unit("clearcoat", l.clearcoat)?;
    unit("clearcoat roughness", l.clearcoat_roughness)?;
    unit("sheen colour", l.sheen_color.min_element())?;
    unit("sheen colour", l.sheen_color.max_element())?;
    unit("sheen roughness", l.sheen_roughness)?;
    unit("anisotropy strength", l.anisotropy_strength)?;
    unit("iridescence", l.iridescence)?;
    let not_negative = |x: f32| (0.0..f32::INFINITY).contains(&x);
    let physical = l.clearcoat_normal_scale.is_finite()
        && l.sheen_color.is_finite()
        && l.anisotropy_rotation.is_finite()
        && l.iridescence_ior >= 1.0
        && l.iridescence_ior.is_finite()
        && not_negative(l.iridescence_thickness_min)
        && not_negative(l.iridescence_thickness_max)
        && not_negative(l.dispersion);
    if physical { Ok(()) } else { Err(format!("a value of an extension lobe is out of range: {l:?}")) }
}

fn check_light(light: &Light) -> Result<(), String> {
    let cone = match light.kind {
        LightKind::Spot { inner, outer } => {
            (0.0..outer).contains(&inner) && outer <= std::f32::consts::FRAC_PI_2 + 1e-4
        }
        LightKind::Point | LightKind::Directional => true,
    };
    let physical = light.intensity.is_finite()
        && light.intensity.min_element() >= 0.0
        && light.position.is_finite()
        && light.direction.is_normalized()
        && (0.0..f32::INFINITY).contains(&light.radius)
        && (0.0..std::f32::consts::FRAC_PI_2).contains(&light.angular_radius);
    if cone && physical {
        Ok(())
    } else {
        Err(format!("light {}: a value is out of range: {light:?}", light.name))
    }
}

fn check_camera(camera: &Camera) -> Result<(), String> {
    let projection = match camera.projection {
        Projection::Perspective { yfov } => yfov > 0.0 && yfov < std::f32::consts::PI,
        Projection::Orthographic { ymag } => ymag > 0.0 && ymag.is_finite(),
    };
    let m = camera.world_from_camera.matrix3;
    let rigid = camera.world_from_camera.is_finite() && (m.determinant() - 1.0).abs() < 1e-3;
    let lens = camera.lens_radius >= 0.0 && camera.lens_radius.is_finite() && camera.focus_distance > 0.0;
    if projection && rigid && lens {
        Ok(())
    } else {
        Err(format!("camera {}: a value is out of range: {camera:?}", camera.name))
    }
}
