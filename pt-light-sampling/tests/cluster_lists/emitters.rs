//! Lights that say how they really shine, and boxes.

use pt_core::rng::pcg4d;
use pt_light_sampling::LightBounds;
use pt_light_sampling::cluster_lists::{ClusterBox, ListLimits};
use pt_scene::Bounds;
use pt_scene::glam::{DVec3, Vec3};

/// Nothing is left out but what exact tests reject.
pub const EXACT: ListLimits =
    ListLimits { min_share: 0.0, max_per_cluster: usize::MAX, max_entries: usize::MAX };

/// Reproducible random numbers.
pub struct Random(pub u32);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 += 1;
        pcg4d([self.0, 0, 0, 5])[0] as f32 / u32::MAX as f32
    }

    pub fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    pub fn direction(&mut self) -> Vec3 {
        (self.vec3() - 0.5).normalize_or(Vec3::Y)
    }

    pub fn inside(&mut self, b: &Bounds) -> Vec3 {
        // Also in the faces, edges and corners.
        let t = self.vec3().to_array().map(|t| (1.5 * t - 0.25).clamp(0.0, 1.0));
        b.min + Vec3::from(t) * b.size()
    }
}

/// A light and how it really shines.
#[derive(Clone, Copy)]
pub enum Emitter {
    Triangle {
        corners: [Vec3; 3],
        both_sides: bool,
    },
    Sphere {
        center: Vec3,
        radius: f32,
    },
    Spot {
        center: Vec3,
        radius: f32,
        axis: Vec3,
        outer: f32,
    },
    /// Any cone of normals and of emission round them, as nodes of light trees have it.
    Cones {
        bounds: Bounds,
        axis: Vec3,
        spread: f32,
        emission: f32,
    },
}

impl Emitter {
    pub fn random(r: &mut Random) -> Self {
        let center = 10.0 * r.vec3();
        let size = if r.next() < 0.5 { 0.1 } else { 4.0 * r.next() };
        let radius = if r.next() < 0.5 { 0.0 } else { 0.3 * size };
        match (r.next() * 8.0) as u32 {
            0..3 => Self::Triangle {
                corners: [0; 3].map(|_| center + size * (r.vec3() - 0.5)),
                both_sides: r.next() < 0.1,
            },
            // In the plane of an axis, as lamps at a ceiling are.
            3 => {
                let corners = [0; 3].map(|_| (center + size * (r.vec3() - 0.5)).with_y(center.y));
                Self::Triangle { corners, both_sides: false }
            }
            4 => Self::Sphere { center, radius },
            5 | 6 => Self::Spot {
                center,
                radius,
                axis: r.direction(),
                outer: std::f32::consts::FRAC_PI_2 * r.next(),
            },
            _ => {
                let half = 0.5 * size * r.vec3();
                Self::Cones {
                    bounds: Bounds { min: center - half, max: center + half },
                    axis: r.direction(),
                    spread: 3.0 * r.next(),
                    emission: 1.5 * r.next(),
                }
            }
        }
    }

    pub fn bounds(&self, power: f32) -> LightBounds {
        let of = |bounds, axis, cos_spread, cos_emission| LightBounds {
            bounds,
            axis,
            cos_spread,
            cos_emission,
            power,
            irradiance: 0.0,
        };
        let ball = |center: Vec3, radius: f32| Bounds { min: center - radius, max: center + radius };
        match *self {
            Self::Triangle { corners: [a, b, c], both_sides } => {
                let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
                let bounds = Bounds { min: a.min(b).min(c), max: a.max(b).max(c) };
                of(bounds, normal, if both_sides { -1.0 } else { 1.0 }, 0.0)
            }
            Self::Sphere { center, radius } => of(ball(center, radius), Vec3::Y, -1.0, 0.0),
            Self::Spot { center, radius, axis, outer } => of(ball(center, radius), axis, 1.0, outer.cos()),
            Self::Cones { bounds, axis, spread, emission } => of(bounds, axis, spread.cos(), emission.cos()),
        }
    }

    /// Whether some point of it, drawn at random, emits towards `x`.
    pub fn lights(&self, x: Vec3, r: &mut Random) -> bool {
        let within = |from: Vec3, axis: Vec3, angle: f32| {
            let to: DVec3 = (x - from).as_dvec3();
            to.normalize_or_zero().dot(axis.as_dvec3()) > f64::from(angle).cos()
        };
        match *self {
            Self::Triangle { corners: [a, b, c], both_sides } => {
                let [u, v] = [r.next(), r.next()];
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let y = a + u * (b - a) + v * (c - a);
                let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero();
                both_sides || (x - y).as_dvec3().dot(normal) > 1e-6
            }
            Self::Sphere { .. } => true,
            Self::Spot { center, radius, axis, outer } => {
                within(center + radius * r.direction(), axis, outer)
            }
            Self::Cones { bounds, axis, spread, emission } => {
                within(r.inside(&bounds), axis, spread + emission)
            }
        }
    }
}

pub fn closed(bounds: Bounds) -> ClusterBox {
    ClusterBox { bounds, open: false }
}

pub fn random_boxes(r: &mut Random, count: usize) -> Vec<ClusterBox> {
    let of = |_| {
        let min = 10.0 * r.vec3();
        // Flat ones and points too.
        let size = 3.0 * r.vec3() * Vec3::from(r.vec3().to_array().map(|x| f32::from(x > 0.2)));
        closed(Bounds { min, max: min + size })
    };
    (0..count).map(of).collect()
}

pub fn point(position: Vec3, power: f32) -> LightBounds {
    Emitter::Sphere { center: position, radius: 0.0 }.bounds(power)
}
