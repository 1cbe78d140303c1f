use glam::{Affine3A, Quat, Vec3};
use std::f64::consts::TAU;

/// Rigid motion of an instance of a built-in scene, relative to its transform at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Turns steadily.
    Spin {
        /// Transform at time 0.
        rest: Affine3A,
        /// Unit axis, world space.
        axis: Vec3,
        /// A point on the axis, world space.
        center: Vec3,
        /// Angular velocity, degrees per second, right-handed about `axis`.
        deg_per_s: f64,
    },
    /// Swings to and fro like a pendulum.
    Sway {
        /// Transform in the middle of the swing, where it is at time 0.
        rest: Affine3A,
        /// Unit axis, world space.
        axis: Vec3,
        /// The point it hangs from, world space.
        pivot: Vec3,
        /// Largest angle, degrees.
        amplitude_deg: f64,
        /// Seconds of a full swing, > 0.
        period_s: f64,
    },
}

impl Motion {
    /// World-from-object transform at time `t` (seconds).
    pub fn at(&self, t: f64) -> Affine3A {
        match *self {
            Self::Spin { rest, axis, center, deg_per_s } => {
                // Reduced before the cast to f32: the angle stays exact however long the clock has run.
                turn(axis, center, (deg_per_s * t).rem_euclid(360.0).to_radians()) * rest
            }
            Self::Sway { rest, axis, pivot, amplitude_deg, period_s } => {
                let angle = amplitude_deg.to_radians() * (TAU * (t / period_s).fract()).sin();
                turn(axis, pivot, angle) * rest
            }
        }
    }
}

fn turn(axis: Vec3, center: Vec3, angle: f64) -> Affine3A {
    Affine3A::from_translation(center)
        * Affine3A::from_quat(Quat::from_axis_angle(axis, angle as f32))
        * Affine3A::from_translation(-center)
}
