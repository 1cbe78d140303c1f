use glam::{Affine3A, Quat, Vec3};
use std::f64::consts::TAU;

/// Rigid motion of an instance or a light of a built-in scene, relative to its transform at rest.
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
    /// Slides to and fro along a straight line.
    Slide {
        /// Transform in the middle of the way, where it is at time 0.
        rest: Affine3A,
        /// From the middle to one end of the way, world space, metres.
        reach: Vec3,
        /// Seconds of the way there and back, > 0.
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
            Self::Slide { rest, reach, period_s } => {
                let along = (TAU * (t / period_s).fract()).sin() as f32;
                Affine3A::from_translation(along * reach) * rest
            }
        }
    }

    /// Stands still.
    pub fn rest(rest: Affine3A) -> Self {
        Self::Spin { rest, axis: Vec3::Y, center: Vec3::ZERO, deg_per_s: 0.0 }
    }
}

/// How a punctual light of a built-in scene changes with time. A pure function of it, like [`Motion`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightMotion {
    /// Where it goes; as in glTF the light is at the origin of this frame and shines along its -Z.
    pub path: Motion,
    /// Colour x intensity at its brightest, candela or lux.
    pub peak: Vec3,
    /// How the intensity goes up and down.
    pub blink: Blink,
}

/// A brightness over time, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blink {
    /// Always 1.
    Steady,
    /// On for `share` of each period, then off.
    Square {
        /// Seconds, > 0.
        period_s: f64,
        /// 0..1.
        share: f64,
        /// Part of a period by which it is ahead, 0..1.
        phase: f64,
    },
    /// Sine between 0 and 1, 0.5 and rising at time 0.
    Pulse {
        /// Seconds, > 0.
        period_s: f64,
    },
    /// A flame: smooth noise between `low` and 1.
    Flame {
        /// Values per second, > 0.
        rate_hz: f64,
        /// Smallest brightness, 0..1.
        low: f32,
        /// Another seed gives another flame.
        seed: u32,
    },
}

impl Blink {
    /// The brightness at time `t` (seconds).
    pub fn at(&self, t: f64) -> f32 {
        match *self {
            Self::Steady => 1.0,
            Self::Square { period_s, share, phase } => {
                if (t / period_s + phase).rem_euclid(1.0) < share {
                    1.0
                } else {
                    0.0
                }
            }
            Self::Pulse { period_s } => 0.5 + 0.5 * (TAU * (t / period_s).fract()).sin() as f32,
            Self::Flame { rate_hz, low, seed } => {
                let x = (t * rate_hz).rem_euclid(4096.0);
                let (cell, f) = (x.floor() as i32, x.fract() as f32);
                let value = |i: i32| crate::hash::hash(i & 4095, 0, seed);
                let s = f * f * (3.0 - 2.0 * f);
                low + (1.0 - low) * (value(cell) + s * (value(cell + 1) - value(cell)))
            }
        }
    }
}

fn turn(axis: Vec3, center: Vec3, angle: f64) -> Affine3A {
    Affine3A::from_translation(center)
        * Affine3A::from_quat(Quat::from_axis_angle(axis, angle as f32))
        * Affine3A::from_translation(-center)
}
