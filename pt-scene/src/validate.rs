//! The invariants of a [`Scene`].

use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;

use crate::transform::{MAX_COORDINATE, is_invertible};
use crate::{
    AlphaMode, Camera, Instance, Light, LightKind, Lobes, MAX_PRIORITY, Material, Projection, Scene,
    SceneError, Shows,
};

/// Cameras that surfaces can show; the GPU record has 16 bits for them.
const MAX_SHOWN_CAMERAS: usize = 0xffff;

/// An element of one of a scene's lists, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Of `Scene::meshes`.
    Mesh(usize),
    /// Of `Scene::instances`.
    Instance(usize),
    /// Of `Scene::materials`.
    Material(usize),
    /// Of `Scene::textures`.
    Texture(usize),
    /// Of `Scene::lights`.
    Light(usize),
    /// Of `Scene::cameras`.
    Camera(usize),
    /// The environment.
    Environment,
    /// The effects.
    Effects,
}

/// What breaks an invariant, and how.
#[derive(Debug)]
pub struct Flaw {
    /// Where.
    pub part: Part,
    /// What is wrong there.
    pub what: String,
}

impl Scene {
    /// Checks every invariant that consumers rely on: indices in range, arrays of equal length, finite and physical
    /// values, masked triangles sorted to the end. Run by importers.
    ///
    /// # Errors
    /// [`SceneError::Inconsistent`] for the first part that breaks one.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.check().map_err(|flaw| self.inconsistent(&flaw))
    }

    /// A flaw as an error that names the part.
    pub fn inconsistent(&self, Flaw { part, what }: &Flaw) -> SceneError {
        let part = match *part {
            Part::Mesh(i) => format!("mesh {}", self.meshes[i].name),
            Part::Instance(i) => format!("instance {}", self.instances[i].name),
            Part::Material(i) => format!("material {}", self.materials[i].name),
            Part::Texture(i) => format!("texture {}", self.textures[i].name),
            Part::Light(i) => format!("light {}", self.lights[i].name),
            Part::Camera(i) => format!("camera {}", self.cameras[i].name),
            Part::Environment => "environment".into(),
            Part::Effects => "effects".into(),
        };
        SceneError::Inconsistent { scene: self.name.clone(), what: format!("{part}: {what}") }
    }

    /// As [`Scene::validate`], for importers, which know where in a file a part came from.
    ///
    /// # Errors
    /// The first flaw.
    pub fn check(&self) -> Result<(), Flaw> {
        fn each<T>(
            list: &[T],
            part: fn(usize) -> Part,
            check: impl Fn(&T) -> Result<(), String>,
        ) -> Result<(), Flaw> {
            list.iter()
                .enumerate()
                .try_for_each(|(i, item)| check(item).map_err(|what| Flaw { part: part(i), what }))
        }
        each(&self.meshes, Part::Mesh, |mesh| mesh.check(&self.materials))?;
        each(&self.instances, Part::Instance, |instance| self.check_instance(instance))?;
        each(&self.materials, Part::Material, |m| self.check_material(m))?;
        each(&self.textures, Part::Texture, |texture| texture.check())?;
        each(&self.lights, Part::Light, check_light)?;
        each(&self.cameras, Part::Camera, check_camera)?;
        self.effects.check(self.textures.len()).map_err(|what| Flaw { part: Part::Effects, what })?;
        self.environment.check().map_err(|what| Flaw { part: Part::Environment, what })
    }

    fn check_instance(&self, instance: &Instance) -> Result<(), String> {
        let Some(mesh) = self.meshes.get(instance.mesh as usize) else {
            return Err(format!("mesh {} does not exist", instance.mesh));
        };
        if let Some(material) = instance.material {
            let masked = self.materials.get(material as usize).is_none_or(Material::is_masked);
            if masked || mesh.first_masked < mesh.triangle_count() {
                return Err(format!("material {material} cannot stand in for others"));
            }
        }
        let transforms = [instance.world_from_object, instance.world_from_object_prev];
        if !transforms.iter().all(is_invertible) {
            return Err("its transform is not finite and invertible".into());
        }
        let mut corners = mesh.indices.iter().flatten().map(|&v| mesh.positions[v as usize]);
        let near = |p| instance.world_from_object.transform_point3(p).abs().max_element() <= MAX_COORDINATE;
        match corners.all(near) {
            true => Ok(()),
            false => Err(format!("it reaches farther out than {MAX_COORDINATE:e} m")),
        }
    }

    fn check_material(&self, m: &Material) -> Result<(), String> {
        unit("metallic", m.metallic)?;
        unit("roughness", m.roughness)?;
        unit("transmission", m.transmission)?;
        unit("specular", m.specular)?;
        if let AlphaMode::Mask { cutoff } = m.alpha_mode {
            not_negative("alpha cutoff", [cutoff])?;
        }
        not_negative("base colour", m.base_color.to_array())?;
        not_negative("emission", m.emissive.to_array())?;
        not_negative("specular colour", m.specular_color.to_array())?;
        not_negative("attenuation colour", m.attenuation_color.to_array())?;
        if m.attenuation_distance.is_nan() || m.attenuation_distance <= 0.0 {
            return Err(format!("attenuation distance {} is not positive", m.attenuation_distance));
        }
        not_negative("thickness", [m.thickness])?;
        within("normal scale", [m.normal_scale], f32::MIN..=f32::MAX)?;
        within("index of refraction", [m.ior], 1.0..=f32::MAX)?;
        if let Some(lobes) = &m.lobes {
            check_lobes(lobes)?;
        }
        for (slot, texture) in m.textures() {
            let exists = (texture.texture as usize) < self.textures.len() && texture.uv_set <= 1;
            if !exists || !texture.transform.is_finite() {
                let (index, set) = (texture.texture, texture.uv_set);
                return Err(format!(
                    "{slot} names texture {index} and UV set {set}, or its transform is not finite"
                ));
            }
        }
        if let Some(waves) = m.waves {
            unit("slope of the waves", waves.slope)?;
            within("length of the waves", [waves.length], 1e-3..=1e6)?;
        }
        if let Shows::Camera(camera) = m.shows
            && camera as usize >= self.cameras.len().min(MAX_SHOWN_CAMERAS)
        {
            return Err(format!(
                "camera {camera} does not exist, or is not among the first {MAX_SHOWN_CAMERAS}"
            ));
        }
        if m.priority > MAX_PRIORITY {
            return Err(format!("priority {} is more than {MAX_PRIORITY}", m.priority));
        }
        match m.exterior.filter(|&material| material as usize >= self.materials.len()) {
            Some(missing) => Err(format!("exterior material {missing} does not exist")),
            None => Ok(()),
        }
    }
}

fn within(
    what: &str,
    values: impl IntoIterator<Item = f32>,
    range: RangeInclusive<f32>,
) -> Result<(), String> {
    let Some(wrong) = values.into_iter().find(|x| !range.contains(x)) else { return Ok(()) };
    Err(match (*range.start(), *range.end()) {
        (f32::MIN, f32::MAX) => format!("{what} {wrong} is not finite"),
        (f32::MIN_POSITIVE, f32::MAX..) => format!("{what} {wrong} is not above 0, or not finite"),
        (f32::MIN_POSITIVE, most) => format!("{what} {wrong} is not between 0 and {most}"),
        (least, f32::MAX) => format!("{what} {wrong} is less than {least} or not finite"),
        (least, most) => format!("{what} {wrong} is not in {least}..{most}"),
    })
}

fn unit(what: &str, x: f32) -> Result<(), String> {
    within(what, [x], 0.0..=1.0)
}

fn not_negative(what: &str, values: impl IntoIterator<Item = f32>) -> Result<(), String> {
    within(what, values, 0.0..=f32::MAX)
}

fn check_lobes(l: &Lobes) -> Result<(), String> {
    unit("clearcoat", l.clearcoat)?;
    unit("clearcoat roughness", l.clearcoat_roughness)?;
    within("clearcoat normal scale", [l.clearcoat_normal_scale], f32::MIN..=f32::MAX)?;
    within("sheen colour", l.sheen_color.to_array(), 0.0..=1.0)?;
    unit("sheen roughness", l.sheen_roughness)?;
    unit("anisotropy strength", l.anisotropy_strength)?;
    within("anisotropy rotation", [l.anisotropy_rotation], f32::MIN..=f32::MAX)?;
    unit("iridescence", l.iridescence)?;
    within("iridescence index of refraction", [l.iridescence_ior], 1.0..=f32::MAX)?;
    not_negative("iridescence thickness", [l.iridescence_thickness_min, l.iridescence_thickness_max])?;
    not_negative("dispersion", [l.dispersion])
}

fn check_light(light: &Light) -> Result<(), String> {
    let finite = f32::MIN..=f32::MAX;
    not_negative("intensity", light.intensity.to_array())?;
    within("position", light.position.to_array(), finite)?;
    not_negative("radius", [light.radius])?;
    let below_right_angle = 0.0..=FRAC_PI_2.next_down();
    within("angular radius (radians)", [light.angular_radius], below_right_angle)?;
    if !light.direction.is_normalized() {
        return Err(format!("direction {} has not length 1", light.direction));
    }
    match light.kind {
        LightKind::Spot { inner, outer } if !(0.0..outer).contains(&inner) || outer > FRAC_PI_2 + 1e-4 => {
            Err(format!(
                "the cone angles {inner} (inner) and {outer} (outer) are not in the order 0 <= inner < outer <= pi / 2"
            ))
        }
        _ => Ok(()),
    }
}

fn check_camera(camera: &Camera) -> Result<(), String> {
    let above_zero = f32::MIN_POSITIVE..=f32::MAX;
    match camera.projection {
        Projection::Perspective { yfov } => {
            within("vertical field of view (radians)", [yfov], f32::MIN_POSITIVE..=PI.next_down())?;
        }
        Projection::Orthographic { ymag } => within("half height of the view", [ymag], above_zero)?,
    }
    let m = camera.world_from_camera.matrix3;
    let is_rigid = camera.world_from_camera.is_finite() && (m.determinant() - 1.0).abs() < 1e-3;
    if !is_rigid {
        return Err("its transform is not finite or has a scale".into());
    }
    not_negative("lens radius", [camera.lens_radius])?;
    within("focus distance", [camera.focus_distance], f32::MIN_POSITIVE..=f32::INFINITY)
}
