//! What an image shows: camera, environment, and which light it carries. EXR files say it in their metadata, in words that are equal
//! if and only if the images show the same.

use crate::params::FrameParams;
use pt_core::capture::keys;
use pt_reference::ReferenceParams;
use pt_scene::{Camera, Projection, Scene};
use pt_shaders::glam::Vec3;
use std::collections::BTreeMap;

/// Camera, environment and light of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    camera: String,
    environment: String,
    light: String,
}

/// Entries of the metadata, with what to say where two images differ in them.
const ENTRIES: [(&str, &str); 3] = [
    (keys::LIGHT, "carry different light"),
    (keys::CAMERA, "were rendered with different cameras"),
    (keys::ENVIRONMENT, "were rendered with different environments"),
];

impl Origin {
    /// Of a frame of the real-time stages; `camera`: where it is in that frame.
    pub fn of_frame(scene: &Scene, camera: &Camera, params: &FrameParams) -> Self {
        let lights = &params.lights;
        let kinds = [lights.sun, lights.positional, lights.emissive, lights.environment];
        Self::new(scene, camera, light(Some(params.indirect.bounces), kinds))
    }

    /// Of a path traced image.
    pub fn of_reference(scene: &Scene, camera: &Camera, params: &ReferenceParams) -> Self {
        let types = &params.light_types;
        let kinds = [types.sun, types.positional, types.emissive, types.environment];
        let bounces = params.max_bounces.map(|bounces| bounces as f32);
        Self::new(scene, camera, light(bounces, kinds))
    }

    fn new(scene: &Scene, camera: &Camera, light: String) -> Self {
        Self { camera: camera_text(camera), environment: environment_text(scene), light }
    }

    /// Which light the image carries.
    pub fn light(&self) -> &str {
        &self.light
    }

    /// Adds the entries to a file's metadata.
    pub fn describe(&self, metadata: &mut BTreeMap<String, String>) {
        for (key, value) in
            [(keys::CAMERA, &self.camera), (keys::ENVIRONMENT, &self.environment), (keys::LIGHT, &self.light)]
        {
            metadata.insert(key.into(), value.clone());
        }
    }
}

/// In which entries two files differ, as sentences about `a` and `b`. An entry that one of them lacks is not compared.
pub fn differences(
    a: (&str, &BTreeMap<String, String>),
    b: (&str, &BTreeMap<String, String>),
) -> Vec<String> {
    let differs = |&(key, what): &(&str, &str)| {
        let (there, here) = (a.1.get(key)?, b.1.get(key)?);
        (there != here).then(|| format!("{} and {} {what}: {there}, and {here}", a.0, b.0))
    };
    ENTRIES.iter().filter_map(differs).collect()
}

/// `bounces`: most scattering events after the first hit; `None` = no limit. `kinds`: sun, positional, emissive, environment.
fn light(bounces: Option<f32>, kinds: [bool; 4]) -> String {
    let bounces = match bounces {
        Some(0.0) => "direct light only".to_owned(),
        Some(0.5) => "direct light and 1 bounce of diffuse light at every other row".to_owned(),
        Some(1.0) => "direct light and 1 bounce".to_owned(),
        Some(n) => format!("direct light and up to {n} bounces"),
        None => "direct light and all bounces".to_owned(),
    };
    let names = ["sun", "positional", "emissive", "environment"];
    let on: Vec<_> = names.iter().zip(kinds).filter(|(_, on)| *on).map(|(name, _)| *name).collect();
    match on.len() {
        4 => bounces,
        0 => format!("{bounces}, from no lights"),
        _ => format!("{bounces}, from {} lights", on.join(", ")),
    }
}

/// Without the name: the same view under another name is the same.
fn camera_text(camera: &Camera) -> String {
    let axes = camera.world_from_camera.matrix3;
    let projection = match camera.projection {
        Projection::Perspective { yfov } => format!("vertical field of view {} degrees", yfov.to_degrees()),
        Projection::Orthographic { ymag } => format!("parallel projection, {} m high", 2.0 * ymag),
    };
    let lens = match camera.lens_radius {
        0.0 => String::new(),
        radius => format!(", lens of radius {radius} m in focus at {} m", camera.focus_distance),
    };
    format!(
        "{projection}, at {}, looks along {}, up {}{lens}",
        point(camera.world_from_camera.translation.into()),
        point((-axes.z_axis).into()),
        point(axes.y_axis.into()),
    )
}

fn environment_text(scene: &Scene) -> String {
    let environment = &scene.environment;
    format!(
        "{}x{} texels, rotation {} degrees, intensity {}, content {}",
        environment.image.width,
        environment.image.height,
        environment.rotation.to_degrees() + 0.0,
        environment.intensity,
        environment.fingerprint()
    )
}

fn point(p: Vec3) -> String {
    // Adding 0 turns -0 into 0.
    let [x, y, z] = p.to_array().map(|v| v + 0.0);
    format!("{x},{y},{z}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{ReferenceSettings, resolve, resolve_reference};

    fn metadata(origin: &Origin) -> BTreeMap<String, String> {
        let mut metadata = BTreeMap::new();
        origin.describe(&mut metadata);
        metadata
    }

    #[test]
    fn the_same_view_is_the_same_and_other_light_is_not() {
        let scene = pt_scene::builtin("cornell").unwrap();
        let camera = scene.cameras[0].clone();
        let reference = |line: &str| {
            let sets: Vec<_> = line.split_whitespace().map(|set| format!("reference.{set}")).collect();
            let params = resolve_reference(ReferenceSettings::default(), None, &sets).unwrap().reference;
            Origin::of_reference(&scene, &camera, &params)
        };
        let with_bounces = |bounces: &str| {
            let set = format!("indirect.bounces={bounces}");
            Origin::of_frame(&scene, &camera, &resolve(None, &[set], false).unwrap())
        };
        assert_eq!(with_bounces("3"), reference("max_bounces=3"));
        assert_eq!(with_bounces("1"), reference("max_bounces=1"));
        assert_eq!(with_bounces("1").light(), "direct light and 1 bounce");
        assert!(with_bounces("0.5").light().contains("every other row"));
        assert_eq!(Origin::of_frame(&scene, &camera, &resolve(None, &[], false).unwrap()), with_bounces("1"));
        let frame = with_bounces("0");
        assert_eq!(frame, reference("max_bounces=0"));
        assert_eq!(frame.light(), "direct light only");
        assert_eq!(reference("").light(), "direct light and all bounces");
        assert_eq!(
            reference("max_bounces=8 light_types.sun=false").light(),
            "direct light and up to 8 bounces, from positional, emissive, environment lights"
        );
        let compared = differences(("a", &metadata(&frame)), ("b", &metadata(&reference(""))));
        assert_eq!(
            compared,
            ["a and b carry different light: direct light only, and direct light and all bounces"]
        );
    }

    #[test]
    fn other_cameras_and_environments_are_named() {
        let scene = pt_scene::builtin("cornell").unwrap();
        let params = resolve(None, &[], false).unwrap();
        let camera = scene.cameras[0].clone();
        let renamed = Camera { name: "other".into(), ..camera.clone() };
        let origin = |scene: &Scene, camera: &Camera| metadata(&Origin::of_frame(scene, camera, &params));
        let first = origin(&scene, &camera);
        assert_eq!(first, origin(&scene, &renamed));
        let mut moved = camera.clone();
        moved.world_from_camera.translation.x += 0.01;
        let found = differences(("a", &first), ("b", &origin(&scene, &moved)));
        assert!(found.len() == 1 && found[0].contains("different cameras"), "{found:?}");
        let mut lit = scene.clone();
        lit.environment.image.texels[0].x += 0.5;
        let found = differences(("a", &first), ("b", &origin(&lit, &camera)));
        assert!(found.len() == 1 && found[0].contains("different environments"), "{found:?}");
        assert!(differences(("a", &first), ("b", &BTreeMap::new())).is_empty(), "files of other programs");
    }
}
