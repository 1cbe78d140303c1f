//! Waves on a liquid: they bend the normals of its surface and leave the surface where it is.

use glam::{DVec2, DVec3};

/// Waves that run over a surface. Three plane waves of equal steepness, whose crests move as those of deep water do (Airy wave theory: the
/// square of the angular frequency is gravity times the wave number). The kernels have the same in `waves.glsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Root mean square of the slope, 0..=1; 0: the surface is flat.
    pub slope: f32,
    /// Length of the longest wave, metres, 0.001..=1e6.
    pub length: f32,
}

/// Directions of the waves in the XZ plane, radians from +X towards +Z.
const DIRECTIONS: [f64; 3] = [0.3, 1.5, -0.8];
/// Their lengths, as parts of the longest: no two have a common period.
const LENGTHS: [f64; 3] = [1.0, 0.618, 0.382];
const GRAVITY: f64 = 9.81;

impl Default for Waves {
    fn default() -> Self {
        Self { slope: 0.08, length: 0.5 }
    }
}

impl Waves {
    /// Gradient of the height at `position` (world space, metres) after `time` seconds.
    pub fn gradient(&self, position: DVec3, time: f64) -> DVec3 {
        // The slope of a sine of steepness s has the mean square s^2 / 2.
        let steepness = f64::from(self.slope) * (2.0f64 / 3.0).sqrt();
        let waves = DIRECTIONS.into_iter().zip(LENGTHS).map(|(angle, part)| {
            let direction = DVec2::from_angle(angle);
            let number = std::f64::consts::TAU / (part * f64::from(self.length));
            let phase =
                number * direction.dot(DVec2::new(position.x, position.z)) - (GRAVITY * number).sqrt() * time;
            steepness * phase.cos() * direction
        });
        let sum: DVec2 = waves.sum();
        DVec3::new(sum.x, 0.0, sum.y)
    }

    /// The unit normal of a surface whose own is `normal`: the height counts along the normal, its gradient in the plane of the surface
    /// (Mikkelsen 2020, "Surface Gradient-Based Bump Mapping Framework", JCGT 9(3)).
    pub fn bend(&self, normal: DVec3, position: DVec3, time: f64) -> DVec3 {
        let gradient = self.gradient(position, time);
        (normal - (gradient - gradient.dot(normal) * normal)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_root_mean_square_and_the_mean_is_flat() {
        let waves = Waves { slope: 0.2, length: 0.3 };
        let (mut sum, mut squares) = (DVec3::ZERO, 0.0);
        let count = 200_000;
        for i in 0..count {
            let i = f64::from(i);
            let p = DVec3::new((i * 0.618_034).fract() * 97.0, 0.0, (i * 0.754_878).fract() * 89.0);
            let g = waves.gradient(p, 1.7);
            sum += g;
            squares += g.length_squared();
        }
        assert!((sum / f64::from(count)).length() < 2e-3);
        assert!(((squares / f64::from(count)).sqrt() - 0.2).abs() < 2e-3);
    }

    #[test]
    fn the_gradient_is_that_of_a_height() {
        // A field is a gradient where its curl is 0.
        let waves = Waves { slope: 0.3, length: 0.5 };
        let at = |x: f64, z: f64| waves.gradient(DVec3::new(x, 0.0, z), 0.4);
        let h = 1e-5;
        for (x, z) in [(0.1, 0.2), (1.3, -0.7), (-4.0, 2.5)] {
            let dz_dx = (at(x + h, z).z - at(x - h, z).z) / (2.0 * h);
            let dx_dz = (at(x, z + h).x - at(x, z - h).x) / (2.0 * h);
            assert!((dz_dx - dx_dz).abs() < 1e-6, "{dz_dx} {dx_dz}");
        }
    }
}
