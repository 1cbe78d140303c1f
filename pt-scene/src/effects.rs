//! Effects: particles, sprites, beams and fog. They are seen, blended over what is behind them, and take no other part in light transport: they
//! light nothing and cast no shadow.

use glam::Vec3;
use pt_shaders::records::MAX_FOG_VOLUMES;

/// How an effect moves: steadily, and after each period again from its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Metres per second.
    pub velocity: Vec3,
    /// Seconds after which it starts again, above 0; infinite: never.
    pub period: f64,
    /// Seconds that it has moved at time 0, 0 or more.
    pub phase: f64,
}

impl Default for Drift {
    fn default() -> Self {
        Self { velocity: Vec3::ZERO, period: f64::INFINITY, phase: 0.0 }
    }
}

impl Drift {
    /// Displacement from the start at `time` (seconds), metres.
    pub fn at(&self, time: f64) -> Vec3 {
        let age = time + self.phase;
        let age = if self.period.is_finite() { age.rem_euclid(self.period) } else { age };
        (self.velocity.as_dvec3() * age).as_vec3()
    }
}

/// What an effect does to the light of a ray where it is densest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Radiance that it adds.
    pub radiance: Vec3,
    /// Share of the light behind it that it stops, 0..=1.
    pub opacity: f32,
}

/// A round body that grows thinner from its middle to its rim: the look counts by (1 - (d / radius)^2)^2, d being the distance of the ray from the
/// centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Centre at the start of its drift, world space.
    pub position: Vec3,
    /// Metres, above 0.
    pub radius: f32,
    /// In its middle.
    pub look: Look,
    /// How it moves.
    pub drift: Drift,
}

/// A capsule, which grows thinner from its axis as a particle does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Ends of its axis at the start of its drift, world space.
    pub ends: [Vec3; 2],
    /// Metres, above 0.
    pub radius: f32,
    /// At its axis.
    pub look: Look,
    /// How it moves.
    pub drift: Drift,
}

/// A parallelogram, seen from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sprite {
    /// Centre at the start of its drift, world space.
    pub position: Vec3,
    /// From the centre to the middle of the right side and of the upper side, world space, metres.
    pub half_sides: [Vec3; 2],
    /// Index into `Scene::textures`; its alpha counts as a factor on the look, its colour on the radiance.
    pub texture: Option<u32>,
    /// Everywhere, without a texture.
    pub look: Look,
    /// How it moves.
    pub drift: Drift,
}

/// A box of fog. Its extinction is a linear function of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FogVolume {
    /// Two corners at the start of its drift, the lower coordinates first, world space.
    pub corners: [Vec3; 2],
    /// Extinction at the first corner, 1/m.
    pub density: f32,
    /// How the extinction changes, 1/m^2; it is nowhere in the box below 0.
    pub gradient: Vec3,
    /// Radiance of so much fog that nothing is seen through it.
    pub radiance: Vec3,
    /// How it moves.
    pub drift: Drift,
}

/// The effects of a scene, and the times at which they are shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effects {
    /// Round bodies.
    pub particles: Vec<Particle>,
    /// Parallelograms.
    pub sprites: Vec<Sprite>,
    /// Capsules.
    pub beams: Vec<Beam>,
    /// Boxes of fog, at most [`MAX_FOG_VOLUMES`].
    pub fog: Vec<FogVolume>,
    /// Seconds, now.
    pub time: f64,
    /// Seconds, in the previous frame.
    pub time_prev: f64,
}

/// Fastest drift, metres per second.
const MAX_SPEED: f32 = 1e6;
/// Radii and sides, metres: their fourth powers are normal numbers in fp32.
const SIZES: std::ops::RangeInclusive<f32> = 1e-6..=1e6;
/// Highest extinction, 1/m.
const MAX_DENSITY: f32 = 1e6;

impl Effects {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count() == 0 && self.fog.is_empty()
    }

    /// How many there are, without fog.
    pub fn count(&self) -> usize {
        self.particles.len() + self.sprites.len() + self.beams.len()
    }

    /// Whether any of them moves.
    pub fn is_animated(&self) -> bool {
        self.drifts().any(|drift| drift.velocity != Vec3::ZERO)
    }

    fn drifts(&self) -> impl Iterator<Item = &Drift> {
        let bodies = self.particles.iter().map(|e| &e.drift).chain(self.sprites.iter().map(|e| &e.drift));
        bodies.chain(self.beams.iter().map(|e| &e.drift)).chain(self.fog.iter().map(|e| &e.drift))
    }

    /// What is wrong with them in a scene of `textures` textures.
    ///
    /// # Errors
    /// The first flaw, in one line.
    pub fn check(&self, textures: usize) -> Result<(), String> {
        if self.fog.len() > MAX_FOG_VOLUMES as usize {
            return Err(format!("{} fog volumes, at most {MAX_FOG_VOLUMES} are possible", self.fog.len()));
        }
        for (i, e) in self.particles.iter().enumerate() {
            let sound = check_body(&[e.position], e.radius, &e.look, &e.drift);
            sound.map_err(|what| format!("particle {i}: {what}"))?;
        }
        for (i, e) in self.beams.iter().enumerate() {
            let sound = check_body(&e.ends, e.radius, &e.look, &e.drift);
            sound.map_err(|what| format!("beam {i}: {what}"))?;
        }
        for (i, e) in self.sprites.iter().enumerate() {
            let [u, v] = e.half_sides;
            let sound = check_body(&[e.position, u, v], 1.0, &e.look, &e.drift);
            sound.map_err(|what| format!("sprite {i}: {what}"))?;
            let area = u.cross(v).length();
            if !(area >= SIZES.start().powi(2) && u.length().max(v.length()) <= *SIZES.end()) {
                return Err(format!("sprite {i}: its sides {u} and {v} span no area or are above 1e6 m"));
            }
            if let Some(texture) = e.texture.filter(|&texture| texture as usize >= textures) {
                return Err(format!("sprite {i}: texture {texture} does not exist"));
            }
        }
        self.fog
            .iter()
            .enumerate()
            .try_for_each(|(i, e)| e.check().map_err(|what| format!("fog {i}: {what}")))
    }
}

impl FogVolume {
    /// Extinction at `position` (world space, at the start of the drift), 1/m.
    pub fn density_at(&self, position: Vec3) -> f32 {
        self.density + self.gradient.dot(position - self.corners[0])
    }

    fn check(&self) -> Result<(), String> {
        check_body(&self.corners, 1.0, &Look { radiance: self.radiance, opacity: 1.0 }, &self.drift)?;
        let [min, max] = self.corners;
        if !min.cmplt(max).all() {
            return Err(format!("its corner {min} is not below {max} on all axes"));
        }
        if !(self.density.is_finite() && self.gradient.is_finite()) {
            return Err("its density is not finite".into());
        }
        // A linear function is least and largest at corners: on each axis where it falls or rises.
        let falls = self.gradient.cmplt(Vec3::ZERO);
        let [least, most] = [Vec3::select(falls, max, min), Vec3::select(falls, min, max)];
        let rounding = 1e-5 * (self.density.abs() + self.gradient.abs().dot(max - min));
        for (corner, wrong) in
            [(least, self.density_at(least) < -rounding), (most, self.density_at(most) > MAX_DENSITY)]
        {
            if wrong {
                return Err(format!(
                    "its density is {} 1/m at {corner}, not in 0..1e6",
                    self.density_at(corner)
                ));
            }
        }
        Ok(())
    }
}

fn check_body(points: &[Vec3], radius: f32, look: &Look, drift: &Drift) -> Result<(), String> {
    let far = crate::MAX_COORDINATE;
    if !points.iter().all(|p| p.is_finite() && p.abs().max_element() <= far) {
        return Err(format!("a coordinate is not finite or above {far:e} m"));
    }
    if !SIZES.contains(&radius) {
        return Err(format!("radius {radius} m is not in 1e-6..1e6"));
    }
    let Look { radiance, opacity } = look;
    if !(radiance.cmpge(Vec3::ZERO).all() && radiance.cmple(Vec3::splat(crate::MAX_RADIANCE)).all()) {
        return Err(format!("radiance {radiance} is not in 0..{:e}", crate::MAX_RADIANCE));
    }
    if !(0.0..=1.0).contains(opacity) {
        return Err(format!("opacity {opacity} is not in 0..1"));
    }
    if !(drift.velocity.is_finite() && drift.velocity.length() <= MAX_SPEED) {
        return Err(format!("velocity {} is not finite or above {MAX_SPEED:e} m/s", drift.velocity));
    }
    if !(drift.period > 0.0 && drift.phase >= 0.0 && drift.phase.is_finite()) {
        return Err(format!(
            "period {} s is not above 0, or phase {} s is below 0",
            drift.period, drift.phase
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fog(density: f32, gradient: Vec3) -> FogVolume {
        let corners = [Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0)];
        FogVolume { corners, density, gradient, radiance: Vec3::ONE, drift: Drift::default() }
    }

    fn refusal(effects: Effects) -> String {
        let scene = crate::Scene { name: "test".into(), effects, ..crate::Scene::default() };
        scene.validate().unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        let with_fog = |fog: FogVolume| Effects { fog: vec![fog], ..Effects::default() };
        let says =
            |text: &str, part: &str| assert!(text.contains(part) && text.lines().count() == 1, "{text}");
        says(&refusal(with_fog(fog(-0.5, Vec3::ZERO))), "fog 0: its density is -0.5 1/m");
        // 1 + x - 0.5 z is negative at z = 4 alone.
        says(
            &refusal(with_fog(fog(1.0, Vec3::new(1.0, 0.0, -0.5)))),
            "fog 0: its density is -1 1/m at [0, 0, 4]",
        );
        says(&refusal(with_fog(fog(1.0, Vec3::splat(1e6)))), "7000001 1/m at [1, 2, 4], not in 0..1e6");
        says(&refusal(with_fog(fog(f32::NAN, Vec3::ZERO))), "its density is not finite");
        says(
            &refusal(Effects { fog: vec![fog(1.0, Vec3::ZERO); 9], ..Effects::default() }),
            "9 fog volumes, at most 8",
        );
        let look = Look { radiance: Vec3::ONE, opacity: 0.5 };
        let particle = Particle { position: Vec3::ZERO, radius: 0.1, look, drift: Drift::default() };
        let with = |particle: Particle| Effects { particles: vec![particle], ..Effects::default() };
        says(
            &refusal(with(Particle { position: Vec3::NAN, ..particle })),
            "particle 0: a coordinate is not finite",
        );
        says(&refusal(with(Particle { radius: 0.0, ..particle })), "radius 0 m is not");
        says(&refusal(with(Particle { look: Look { opacity: 1.5, ..look }, ..particle })), "opacity 1.5");
        says(
            &refusal(with(Particle { look: Look { radiance: -Vec3::ONE, ..look }, ..particle })),
            "radiance",
        );
        let sprite = Sprite {
            position: Vec3::ZERO,
            half_sides: [Vec3::X, Vec3::X],
            texture: Some(7),
            look,
            drift: Drift::default(),
        };
        let with = |sprite: Sprite| Effects { sprites: vec![sprite], ..Effects::default() };
        says(&refusal(with(sprite)), "sprite 0: its sides");
        says(&refusal(with(Sprite { half_sides: [Vec3::X, Vec3::Y], ..sprite })), "texture 7 does not exist");
        // As thin as it may be at a corner.
        let scene = crate::Scene {
            effects: with_fog(fog(1.0, Vec3::new(0.0, 0.0, -0.25))),
            ..crate::Scene::default()
        };
        scene.validate().unwrap();
    }

    #[test]
    fn a_drift_starts_again() {
        let drift = Drift { velocity: Vec3::X, period: 2.0, phase: 1.5 };
        assert_eq!(drift.at(0.0), 1.5 * Vec3::X);
        assert_eq!(drift.at(1.0), 0.5 * Vec3::X);
        assert_eq!(Drift { velocity: Vec3::X, ..Drift::default() }.at(3.0), 3.0 * Vec3::X);
    }
}
