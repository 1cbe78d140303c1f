//! How much light each of many lights can give in a box: exact rejection, and bounds of the irradiance.
//!
//! All tests are about the vectors from points of a light's box to points of a cluster's box. They are again a box, the Minkowski
//! difference of the two.

use super::ClusterBox;
use crate::LightBounds;
use glam::{DVec3, Vec3};
use pt_scene::Bounds;
use std::f32::consts::PI;

/// Lights that are looked at together, so that the compiler uses vector instructions.
pub(super) const LANES: usize = 8;
/// Relative rounding of box corners, which are transformed in single precision here and on the GPU.
const CORNER_ROUNDING: f32 = 8.0 * f32::EPSILON;
/// Rounding of unit vectors, cosines and dot products.
const DIRECTION_ROUNDING: f32 = 1e-6;
/// Points of a cluster that are nearer to a light than this share of the half diagonal of the cluster's box do not count for the
/// bound: without a limit every light inside the box would have an infinite bound, however weak, and the lights could not be ranked.
/// A ball of that radius is less than a thousandth of the box.
const NEAREST: f32 = 1.0 / 16.0;

/// What the lights give in one box.
#[derive(Default)]
pub(super) struct Estimates {
    /// The most irradiance that a light gives at a point of the box; 0: no point of the light's box emits towards the box; infinite
    /// if nothing is known of the light. One for each light, and zeros up to a multiple of [`LANES`].
    pub most: Vec<f32>,
    /// Irradiance at a typical distance, finite.
    pub typical: Vec<f32>,
}

/// Lights, in arrays.
pub(super) struct Emitters {
    groups: Vec<Group>,
    /// Lights whose emission has a limit that is not a plane.
    cones: Vec<Cone>,
    /// Lights of which the bounds or the power are not finite.
    unknown: Vec<usize>,
    /// Distant lights, and the irradiance of a surface that faces them.
    distant: Vec<(usize, f32)>,
    /// Lights that are not dark.
    pub lit: usize,
}

#[derive(Clone, Default)]
struct Group {
    center: [[f32; LANES]; 3],
    half: [[f32; LANES]; 3],
    axis: [[f32; LANES]; 3],
    /// Largest radiant intensity; 0 for a dark light.
    intensity: [f32; LANES],
    /// Square of the distance at which the irradiance reaches that of the light's surface.
    nearest2: [f32; LANES],
    /// 0 for a plain triangle, which obeys the cosine law; infinite for all others.
    offset: [f32; LANES],
}

struct Cone {
    light: usize,
    axis: DVec3,
    /// Of the largest angle between axis and emission.
    cos: f64,
    sin: f64,
}

impl Emitters {
    pub(super) fn new<'a>(lights: impl ExactSizeIterator<Item = &'a LightBounds>) -> Self {
        let mut all = Self {
            groups: vec![Group::default(); lights.len().div_ceil(LANES)],
            cones: Vec::new(),
            unknown: Vec::new(),
            distant: Vec::new(),
            lit: 0,
        };
        for (index, light) in lights.enumerate() {
            if light.power <= 0.0 {
                continue;
            }
            all.lit += 1;
            if light.is_distant() {
                all.distant.push((index, light.irradiance.min(f32::MAX)));
                continue;
            }
            let Some(emission) = Emission::of(light) else {
                all.unknown.push(index);
                continue;
            };
            all.groups[index / LANES].set(index % LANES, light, &emission);
            all.cones.extend(emission.cone(index, light.axis));
        }
        all
    }

    /// Fills `estimates` for one box.
    pub(super) fn estimate(&self, cluster: &ClusterBox, estimates: &mut Estimates) {
        let Estimates { most, typical } = estimates;
        for values in [&mut *most, &mut *typical] {
            values.resize(self.groups.len() * LANES, 0.0);
        }
        let lanes = most.as_chunks_mut::<LANES>().0.iter_mut().zip(typical.as_chunks_mut::<LANES>().0);
        let groups = self.groups.iter().zip(lanes);
        if let Some(receiver) = Receiver::new(cluster) {
            groups.for_each(|(group, (most, typical))| group.estimate(&receiver, most, typical));
            for cone in self.cones.iter().filter(|cone| !cone.reaches(&receiver, &self.groups)) {
                (most[cone.light], typical[cone.light]) = (0.0, 0.0);
            }
        } else {
            // A box of which nothing is known: only the strength tells lights apart.
            groups
                .for_each(|(group, (most, typical))| (*most, *typical) = (group.intensity, group.intensity));
        }
        for &(light, irradiance) in &self.distant {
            (most[light], typical[light]) = (irradiance, irradiance);
        }
        for &light in &self.unknown {
            (most[light], typical[light]) = (f32::INFINITY, 0.0);
        }
    }
}

/// Angles and intensity of a light.
struct Emission {
    intensity: f32,
    /// Largest angle between axis and emission, radians.
    angle: f64,
    is_plane: bool,
}

impl Emission {
    /// `None` for a light with values that are not finite.
    fn of(light: &LightBounds) -> Option<Self> {
        let Bounds { min, max } = light.bounds;
        let known = [min, max, max - min, light.axis].iter().all(|v| v.is_finite())
            && light.power.is_finite()
            && !light.cos_spread.is_nan()
            && !light.cos_emission.is_nan();
        let angle_of = |cos: f32| f64::from(cos - DIRECTION_ROUNDING).clamp(-1.0, 1.0).acos();
        // Triangles, and points into all directions, say exactly 0.
        let is_lambertian = light.cos_emission == 0.0;
        // The integral of the widest ramp that a spot light can have, a third of its cone, gives the largest intensity.
        let solid_angle = match is_lambertian {
            true => PI,
            false => 2.0 / 3.0 * PI * (1.0 - light.cos_emission).max(DIRECTION_ROUNDING),
        };
        known.then(|| Self {
            intensity: (light.power / solid_angle).clamp(f32::MIN_POSITIVE, f32::MAX),
            angle: angle_of(light.cos_spread) + angle_of(light.cos_emission),
            is_plane: is_lambertian && light.cos_spread >= 1.0,
        })
    }

    fn cone(&self, light: usize, axis: Vec3) -> Option<Cone> {
        let (sin, cos) = self.angle.sin_cos();
        let limited = !self.is_plane && self.angle < std::f64::consts::PI;
        limited.then(|| Cone { light, axis: axis.as_dvec3(), cos, sin })
    }
}

/// A cluster's box as the tests take it.
struct Receiver {
    center: Vec3,
    half: Vec3,
    nearest2: f32,
}

impl Receiver {
    fn new(cluster: &ClusterBox) -> Option<Self> {
        let Bounds { min, max } = cluster.bounds;
        let known = min.is_finite() && max.is_finite() && (max - min).is_finite();
        let (center, half) = middle(&cluster.bounds);
        known.then(|| Self { center, half, nearest2: (NEAREST * half).length_squared() })
    }
}

/// Centre and half size of a box, with room for the rounding of its corners.
fn middle(b: &Bounds) -> (Vec3, Vec3) {
    let rounding = CORNER_ROUNDING * b.min.abs().max(b.max.abs()).max_element();
    (0.5 * b.min + 0.5 * b.max, 0.5 * (b.max - b.min).abs() + rounding)
}

/// In contrast to `f32::max` it says nothing about NaN, so that it is one instruction.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

impl Group {
    fn set(&mut self, lane: usize, light: &LightBounds, emission: &Emission) {
        let (center, half) = middle(&light.bounds);
        for k in 0..3 {
            self.center[k][lane] = center[k];
            self.half[k][lane] = half[k];
            self.axis[k][lane] = light.axis[k];
        }
        // No irradiance exceeds pi x radiance, that is power / area, and the largest triangle in a box has half the area vector of
        // its faces. Thin triangles have less area, hence a higher limit, which they reach only very near to them.
        let [x, y, z] = light.bounds.size().to_array();
        let area = 0.5 * Vec3::new(y * z, z * x, x * y).length();
        self.intensity[lane] = emission.intensity;
        self.nearest2[lane] = area / PI;
        self.offset[lane] = if emission.is_plane { 0.0 } else { f32::INFINITY };
    }

    fn estimate(&self, receiver: &Receiver, most: &mut [f32; LANES], typical: &mut [f32; LANES]) {
        let (center, half) = (receiver.center.to_array(), receiver.half.to_array());
        let zero = [0.0f32; LANES];
        let (mut near2, mut far2, mut size, mut along) = (zero, zero, zero, self.offset);
        for k in 0..3 {
            for i in 0..LANES {
                let (c, h) = (center[k] - self.center[k][i], half[k] + self.half[k][i]);
                let gap = larger(c.abs() - h, 0.0);
                near2[i] += gap * gap;
                far2[i] += c * c + h * h;
                size[i] += c.abs() + h;
                along[i] += c * self.axis[k][i] + h * self.axis[k][i].abs();
            }
        }
        for i in 0..LANES {
            // The largest distance of a point of the cluster in front of the light's plane.
            let along = along[i] + DIRECTION_ROUNDING * size[i];
            let cos = along / near2[i].sqrt();
            // NaN, in contact, becomes 1.
            let strength = self.intensity[i] * if cos < 1.0 { cos } else { 1.0 };
            let limit2 = larger(near2[i], larger(self.nearest2[i], receiver.nearest2));
            let (bound, middle) = (larger(strength / limit2, f32::MIN_POSITIVE), strength / far2[i]);
            let dark = (along <= 0.0) | (self.intensity[i] <= 0.0);
            most[i] = if dark { 0.0 } else { bound };
            typical[i] = if dark | (middle == f32::INFINITY) { 0.0 } else { middle };
        }
    }
}

impl Cone {
    /// Whether the difference of the boxes reaches into the cone; true also where that is not certain.
    fn reaches(&self, receiver: &Receiver, groups: &[Group]) -> bool {
        let (group, lane) = (&groups[self.light / LANES], self.light % LANES);
        let of_light = |values: &[[f32; LANES]; 3]| Vec3::from(values.map(|v| v[lane])).as_dvec3();
        let center = receiver.center.as_dvec3() - of_light(&group.center);
        let half = receiver.half.as_dvec3() + of_light(&group.half);
        if self.cos >= 0.0 {
            // The plane that touches the cone on the side of the box, and the one across its axis.
            let aside = center - center.dot(self.axis) * self.axis;
            let tangent = self.axis * self.sin - aside.normalize_or_zero() * self.cos;
            [tangent, self.axis].iter().all(|u| u.dot(center) + u.abs().dot(half) >= 0.0)
        } else {
            // Outside of the cone is a cone too. It is convex: it contains the box if it contains the corners.
            let dark = |corner: DVec3| -corner.dot(self.axis) > -self.cos * corner.length();
            let corner = |i: u32| {
                center + half * DVec3::from([0, 1, 2].map(|k| f64::from((i >> k & 1) as i32 * 2 - 1)))
            };
            !(0..8).map(corner).all(dark)
        }
    }
}
