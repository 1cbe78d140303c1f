//! What builders of light lists and trees need to know of a local light: where it is, where it shines, how strong it is.

use crate::emissive::EmissiveTriangle;
use crate::luminance;
use crate::punctual::solid_angle;
use glam::Vec3;
use pt_scene::{Bounds, Light, LightKind, Scene};
use std::f64::consts::PI;

/// A local light: an emissive triangle, a point light or a spot light, or a quad of the environment, which is infinitely far away.
///
/// A direction w can receive light only when the angle between w and `axis` is at most acos(`cos_spread`) + acos(`cos_emission`)
/// (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", section 4.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// Box of the points that emit, world space, metres.
    pub bounds: Bounds,
    /// Axis of the cone of the emitter's normals, unit length.
    pub axis: Vec3,
    /// Cosine of that cone's half angle: 1 for a triangle, -1 where all normals occur.
    pub cos_spread: f32,
    /// Cosine of the angle to its normal up to which a point emits: 0 for a triangle, the outer angle's cosine for a spot light.
    pub cos_emission: f32,
    /// Luminous flux: radiant watts weighted by Rec. 709 luminance, as [`crate::light_powers`] has them. 0: the light is dark.
    pub power: f32,
    /// Luminance of the irradiance that a distant light gives to a surface that faces it; 0 for a light that has a place. A distant light
    /// has no box: its directions are in the cone about `axis`, with the half angle of `cos_spread`, and `power` is what falls on the scene's
    /// bounding sphere.
    pub irradiance: f32,
}

impl LightBounds {
    /// Whether the light is infinitely far away. One without light counts as one that has a place.
    pub fn is_distant(&self) -> bool {
        self.irradiance > 0.0
    }
}

/// The local lights of a scene where they are now, without the environment: the emissive triangles, then the point and spot lights in the
/// scene's order, dark ones too. In [`crate::LightLists::local`] the quads of a listed environment stand between them.
pub fn local_lights(scene: &Scene, emissives: &[EmissiveTriangle]) -> Vec<LightBounds> {
    let triangles = emissives.iter().map(|t| triangle(scene, t));
    let punctual = scene.lights.iter().filter(|light| light.kind != LightKind::Directional);
    triangles.chain(punctual.map(self::punctual)).collect()
}

/// An emissive triangle where its instance is now. One that deforms has the bounds of the pose that the mesh holds.
pub fn triangle(scene: &Scene, t: &EmissiveTriangle) -> LightBounds {
    let instance = &scene.instances[t.instance as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    let [a, b, c] =
        mesh.triangle(t.triangle as usize).map(|p| instance.world_from_object.transform_point3(p));
    let double_sided = scene.materials[instance.material_at(mesh, t.triangle as usize) as usize].double_sided;
    let mirrored = instance.world_from_object.matrix3.determinant() < 0.0;
    let normal = (b - a).cross(c - a).normalize_or_zero() * if mirrored { -1.0 } else { 1.0 };
    // A triangle without area has no normal: any direction may be lit once it gains some.
    let all = double_sided || normal == Vec3::ZERO || mesh.deformation.is_some();
    LightBounds {
        bounds: Bounds { min: a.min(b).min(c), max: a.max(b).max(c) },
        axis: if normal == Vec3::ZERO { Vec3::Y } else { normal },
        cos_spread: if all { -1.0 } else { 1.0 },
        cos_emission: 0.0,
        power: (PI * t.weight) as f32 * if double_sided { 2.0 } else { 1.0 },
        irradiance: 0.0,
    }
}

/// A point or spot light.
pub fn punctual(light: &Light) -> LightBounds {
    let radius = Vec3::splat(light.radius);
    let flux = solid_angle(light.kind).unwrap_or(0.0) * luminance(light.intensity);
    let (axis, cos_spread, cos_emission) = match light.kind {
        LightKind::Spot { outer, .. } => (light.direction.normalize_or(Vec3::NEG_Y), 1.0, outer.cos()),
        _ => (Vec3::Y, -1.0, 0.0),
    };
    LightBounds {
        bounds: Bounds { min: light.position - radius, max: light.position + radius },
        axis,
        cos_spread,
        cos_emission,
        power: flux as f32,
        irradiance: 0.0,
    }
}
