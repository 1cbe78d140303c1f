//! `extras.pt_effect` of a node: an effect at its place.

use glam::{Affine3A, Vec3};
use gltf::json::scene::Node;
use pt_scene::{Beam, Drift, Effects, FogVolume, Look, Particle, SceneError, Sprite};
use serde::Deserialize;
use serde_json::value::RawValue;
use std::collections::HashMap;

use crate::document::Document;

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    /// Round its origin.
    Particle,
    /// From its origin along its +Y.
    Beam,
    /// In its XY plane, centred, without a texture.
    Sprite,
    /// A box, centred; its edges are along the axes of the world.
    Fog,
}

/// Lengths and directions are those of the node, the gradient that of the world.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Extras {
    kind: Kind,
    /// Of a particle or beam.
    radius: Option<f32>,
    /// Of a beam.
    length: Option<f32>,
    /// Width and height of a sprite; width, height and depth of fog.
    size: Option<Vec<f32>>,
    /// Of fog at its lower corner, 1/m.
    density: Option<f32>,
    #[serde(default)]
    gradient: [f32; 3],
    #[serde(default)]
    radiance: [f32; 3],
    #[serde(default)]
    opacity: f32,
    #[serde(default)]
    velocity: [f32; 3],
    period: Option<f64>,
    #[serde(default)]
    phase: f64,
}

/// Adds the effect that a node at the JSON path `at` asks for.
pub(crate) fn add(
    document: &Document,
    node: &Node,
    world: &Affine3A,
    at: &str,
    effects: &mut Effects,
) -> Result<(), SceneError> {
    // Other programs put whatever they like there. The values are read as text, so that a number without a finite value counts as ours too.
    let object = node.extras.as_ref().and_then(|extras| serde_json::from_str(extras.get()).ok());
    let object: HashMap<String, Box<RawValue>> = object.unwrap_or_default();
    let Some(value) = object.get("pt_effect") else { return Ok(()) };
    let one = serde_json::from_str(value.get()).map_err(|error| error.to_string());
    let one = one.and_then(|e| effect(&e, world));
    let one = one.and_then(|one| one.check(0).map(|()| one));
    let one = one.map_err(|what| document.invalid(format!("{at}.extras.pt_effect"), what))?;
    effects.particles.extend(one.particles);
    effects.beams.extend(one.beams);
    effects.sprites.extend(one.sprites);
    effects.fog.extend(one.fog);
    Ok(())
}

fn effect(e: &Extras, world: &Affine3A) -> Result<Effects, String> {
    let mut effects = Effects::default();
    let look = Look { radiance: e.radiance.into(), opacity: e.opacity };
    let velocity = world.transform_vector3(e.velocity.into());
    let drift = Drift { velocity, period: e.period.unwrap_or(f64::INFINITY), phase: e.phase };
    let scale = world.matrix3.determinant().abs().cbrt();
    let needs = |what: &str, value: Option<f32>| value.ok_or(format!("{what} is missing"));
    let position = Vec3::from(world.translation);
    match e.kind {
        Kind::Particle => {
            let radius = scale * needs("radius", e.radius)?;
            effects.particles.push(Particle { position, radius, look, drift });
        }
        Kind::Beam => {
            let end = world.transform_point3(needs("length", e.length)? * Vec3::Y);
            let radius = scale * needs("radius", e.radius)?;
            effects.beams.push(Beam { ends: [position, end], radius, look, drift });
        }
        Kind::Sprite => {
            let Some([width, height]) = e.size.as_deref() else {
                return Err("size is not [width, height]".into());
            };
            let half_sides =
                [0.5 * width * Vec3::X, 0.5 * height * Vec3::Y].map(|side| world.transform_vector3(side));
            effects.sprites.push(Sprite { position, half_sides, texture: None, look, drift });
        }
        Kind::Fog => {
            let Some(&[x, y, z]) = e.size.as_deref() else {
                return Err("size is not [width, height, depth]".into());
            };
            let axes =
                [x * Vec3::X, y * Vec3::Y, z * Vec3::Z].map(|axis| world.transform_vector3(0.5 * axis));
            if axes.iter().any(|axis| axis.abs().max_element() < 0.999 * axis.length()) {
                return Err("the box of fog is turned; its edges must be along the axes of the world".into());
            }
            let half = axes.iter().map(|axis| axis.abs()).sum::<Vec3>();
            effects.fog.push(FogVolume {
                corners: [position - half, position + half],
                density: needs("density", e.density)?,
                gradient: e.gradient.into(),
                radiance: e.radiance.into(),
                drift,
            });
        }
    }
    Ok(effects)
}
