use glam::Quat;

/// How a [`Sampler`] gets from one key to the next (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the last key.
    Step,
    /// Straight; rotations on the great circle between the keys (slerp).
    Linear,
    /// Cubic Hermite splines; every key has an in-tangent, a value and an out-tangent.
    CubicSpline,
}

/// A value over time. Before the first and after the last key it keeps the value of that key.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampler {
    times: Vec<f32>,
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

impl Sampler {
    /// A sampler with keys at `times` (seconds, rising; keys before 0 only matter as starts of what is under way at 0) and `width`
    /// numbers a value.
    ///
    /// # Errors
    /// In words: no keys, times that do not rise or are not finite, numbers that are not finite or not as many as the keys take.
    pub fn new(
        times: Vec<f32>,
        values: Vec<f32>,
        width: usize,
        interpolation: Interpolation,
    ) -> Result<Self, String> {
        let per_key = if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
        let rising = times.windows(2).all(|pair| pair[0] < pair[1]);
        if times.is_empty() || !rising || !times.iter().all(|t| t.is_finite()) {
            return Err("the times of the keys are not finite numbers that rise from key to key".into());
        }
        if Some(values.len()) != times.len().checked_mul(per_key) {
            return Err(format!(
                "{} keys take {per_key} numbers each, there are {}",
                times.len(),
                values.len()
            ));
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err("a value is not finite".into());
        }
        Ok(Self { times, values, width, interpolation })
    }

    /// Time of the last key, seconds; may be negative.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or_default().into()
    }

    /// Numbers a value has.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The value at `time`, number by number.
    pub fn sample(&self, time: f64, out: &mut [f32]) {
        let at = self.locate(time);
        for (c, out) in out.iter_mut().enumerate().take(self.width) {
            *out = match self.interpolation {
                Interpolation::CubicSpline => self.hermite(&at, c),
                Interpolation::Linear if at.s > 0.0 => {
                    let (a, b) = (self.value(at.key, 0)[c], self.value(at.key + 1, 0)[c]);
                    a + (b - a) * at.s
                }
                _ => self.value(at.key, 0)[c],
            };
        }
    }

    /// The value at `time` as a unit quaternion (x, y, z, w); the identity where it has no direction.
    pub fn sample_rotation(&self, time: f64) -> Quat {
        let at = self.locate(time);
        let key = |key: usize| unit(Quat::from_slice(self.value(key, 0)));
        match self.interpolation {
            Interpolation::CubicSpline => {
                unit(Quat::from_array(std::array::from_fn(|c| self.hermite(&at, c))))
            }
            Interpolation::Linear if at.s > 0.0 => slerp(key(at.key), key(at.key + 1), at.s),
            _ => key(at.key),
        }
    }

    /// `part`: 0 value (the only one but for splines, of which it is the middle), -1 in-tangent, 1 out-tangent.
    fn value(&self, key: usize, part: isize) -> &[f32] {
        let index = match self.interpolation {
            Interpolation::CubicSpline => (3 * key + 1).saturating_add_signed(part),
            _ => key,
        };
        &self.values[index * self.width..][..self.width]
    }

    fn hermite(&self, at: &Place, c: usize) -> f32 {
        let p0 = self.value(at.key, 0)[c];
        if at.s <= 0.0 {
            return p0;
        }
        let p1 = self.value(at.key + 1, 0)[c];
        let m0 = self.value(at.key, 1)[c] * at.span;
        let m1 = self.value(at.key + 1, -1)[c] * at.span;
        let (s, s2, s3) = (at.s, at.s * at.s, at.s * at.s * at.s);
        p0 * (2.0 * s3 - 3.0 * s2 + 1.0)
            + m0 * (s3 - 2.0 * s2 + s)
            + p1 * (3.0 * s2 - 2.0 * s3)
            + m1 * (s3 - s2)
    }

    fn locate(&self, time: f64) -> Place {
        let last = self.times.len() - 1;
        let key = self.times.partition_point(|&t| f64::from(t) <= time).saturating_sub(1);
        let start = f64::from(self.times[key]);
        if key == last || time <= start {
            return Place { key, s: 0.0, span: 0.0 };
        }
        let span = f64::from(self.times[key + 1]) - start;
        Place { key, s: ((time - start) / span) as f32, span: span as f32 }
    }
}

/// Between `key` and the next, `s` of the way in 0..1 (0: at the key), which takes `span` seconds.
struct Place {
    key: usize,
    s: f32,
    span: f32,
}

/// The short way on the great circle (Shoemake 1985). In double precision: glam's own takes an approximate angle, which is off by 1e-4.
fn slerp(a: Quat, b: Quat, s: f32) -> Quat {
    let (a, mut b, s) = (a.as_dquat(), b.as_dquat(), f64::from(s));
    let mut cos = a.dot(b);
    if cos < 0.0 {
        (b, cos) = (-b, -cos);
    }
    let angle = cos.min(1.0).acos();
    // Below that the sines are the angles to single precision.
    let (wa, wb) = if angle < 1e-3 {
        (1.0 - s, s)
    } else {
        (((1.0 - s) * angle).sin() / angle.sin(), (s * angle).sin() / angle.sin())
    };
    (a * wa + b * wb).normalize().as_quat()
}

/// A rotation of unit length; the identity for what has no direction.
pub fn unit(q: Quat) -> Quat {
    if q.length_squared() > 0.0 && q.is_finite() { q.normalize() } else { Quat::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    fn at(sampler: &Sampler, time: f64) -> f32 {
        let mut out = [0.0];
        sampler.sample(time, &mut out);
        out[0]
    }

    #[test]
    fn steps_hold_and_lines_connect() {
        let times = || vec![1.0, 2.0, 4.0];
        let step = Sampler::new(times(), vec![3.0, 5.0, -1.0], 1, Interpolation::Step).unwrap();
        let line = Sampler::new(times(), vec![3.0, 5.0, -1.0], 1, Interpolation::Linear).unwrap();
        for (time, stepped, linear) in [
            (-5.0, 3.0, 3.0),
            (1.0, 3.0, 3.0),
            (1.5, 3.0, 4.0),
            (2.0, 5.0, 5.0),
            (3.0, 5.0, 2.0),
            (9.0, -1.0, -1.0),
        ] {
            assert_eq!((at(&step, time), at(&line, time)), (stepped, linear), "at {time}");
        }
        assert_eq!(line.end(), 4.0);
    }

    #[test]
    fn splines_meet_values_and_tangents() {
        // x(t) = t^3 on [0, 2], and its mirror image after that: a cubic is met everywhere.
        let (v, slope) = (|t: f32| t.powi(3), |t: f32| 3.0 * t * t);
        let values = vec![9.0, v(0.0), slope(0.0), slope(2.0), v(2.0), 7.0];
        let spline = Sampler::new(vec![0.0, 2.0], values, 1, Interpolation::CubicSpline).unwrap();
        for i in 0..=20 {
            let t = i as f32 * 0.1;
            assert!((at(&spline, t.into()) - v(t)).abs() < 1e-5, "at {t}");
        }
        assert_eq!(at(&spline, -1.0), 0.0);
        assert_eq!(at(&spline, 5.0), 8.0);
    }

    #[test]
    fn rotations_take_the_short_way_at_even_speed() {
        let quarter = Quat::from_rotation_y(FRAC_PI_2);
        let values = [Quat::IDENTITY.to_array(), (-quarter).to_array()].concat();
        let turn = Sampler::new(vec![0.0, 1.0], values, 4, Interpolation::Linear).unwrap();
        for i in 0..=4 {
            let expected = Quat::from_rotation_y(FRAC_PI_4 * 0.5 * i as f32);
            // Twice the distance of unit quaternions, one way round or the other.
            let got = turn.sample_rotation(0.25 * f64::from(i));
            let angle = 2.0 * (got - expected).length().min((got + expected).length());
            assert!(angle < 1e-6, "{i}: {angle}");
        }
        // Values of another length, as integers decode to, are rotations all the same; a zero is none.
        let scaled = [[0.0, 0.0, 0.0, 0.0], (quarter * 0.99).to_array()].concat();
        let turn = Sampler::new(vec![0.0, 1.0], scaled, 4, Interpolation::Step).unwrap();
        assert_eq!(turn.sample_rotation(0.0), Quat::IDENTITY);
        assert!(turn.sample_rotation(1.0).angle_between(quarter) < 1e-3);
    }

    #[test]
    fn spline_rotations_are_unit() {
        let quarter = Quat::from_rotation_x(FRAC_PI_2).to_array();
        let values =
            [[0.0; 4], Quat::IDENTITY.to_array(), [1.0, 0.0, 0.0, 0.0], [0.0; 4], quarter, [0.0; 4]].concat();
        let turn = Sampler::new(vec![0.0, 2.0], values, 4, Interpolation::CubicSpline).unwrap();
        for i in 0..=10 {
            assert!((turn.sample_rotation(0.2 * f64::from(i)).length() - 1.0).abs() < 1e-6);
        }
        assert_eq!(turn.sample_rotation(2.5).to_array(), unit(Quat::from_array(quarter)).to_array());
    }

    #[test]
    fn broken_keys_are_refused() {
        let refused = |times: &[f32], values: &[f32], interpolation| {
            Sampler::new(times.to_vec(), values.to_vec(), 1, interpolation).unwrap_err()
        };
        assert!(refused(&[], &[], Interpolation::Step).contains("rise"));
        assert!(refused(&[1.0, 1.0], &[0.0, 0.0], Interpolation::Step).contains("rise"));
        assert!(refused(&[0.0, f32::NAN], &[0.0, 0.0], Interpolation::Step).contains("rise"));
        assert!(refused(&[0.0, 1.0], &[0.0], Interpolation::Linear).contains("2 keys"));
        assert!(refused(&[0.0, 1.0], &[0.0; 2], Interpolation::CubicSpline).contains("3 numbers"));
        assert!(refused(&[0.0], &[f32::INFINITY], Interpolation::Linear).contains("value is not finite"));
    }
}
