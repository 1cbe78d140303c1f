//! Light at a smooth interface, in terms of angles: what bsdf/fresnel.glsl and smooth_surface.glsl are tested against.

use glam::DVec3;

/// Share of unpolarised light that an interface reflects, by Fresnel's equations. `eta`: index of refraction behind the
/// interface over the one in front of it; `theta`: angle of incidence in radians, [0, pi / 2).
pub fn fresnel(theta: f64, eta: f64) -> f64 {
    let sin_behind = theta.sin() / eta;
    if sin_behind >= 1.0 {
        return 1.0;
    }
    if theta < 1e-6 {
        return ((eta - 1.0) / (eta + 1.0)).powi(2);
    }
    let behind = sin_behind.asin();
    let s = (theta - behind).sin() / (theta + behind).sin();
    let p = (theta - behind).tan() / (theta + behind).tan();
    0.5 * (s * s + p * p)
}

/// Direction behind the interface (Snell's law); `None`: total internal reflection. `normal` is on the side that the unit
/// vector `direction` comes from.
pub fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let tangent = (direction - direction.dot(normal) * normal) / eta;
    let cos2 = 1.0 - tangent.length_squared();
    (cos2 >= 0.0).then(|| tangent - cos2.sqrt() * normal)
}

/// Reflectance of a smooth metal (Schlick 1994).
pub fn metal(base_color: DVec3, theta: f64) -> DVec3 {
    base_color + (DVec3::ONE - base_color) * (1.0 - theta.cos()).powi(5)
}

/// The throughputs of the two fields of a split glass: (reflection, transmission).
pub fn split(reflectance: f64, transmission: f64, base_color: DVec3) -> (DVec3, DVec3) {
    (DVec3::splat(2.0 * reflectance), 2.0 * (1.0 - reflectance) * transmission * base_color)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn reflectance_of_glass() {
        assert!((fresnel(0.0, 1.5) - 0.04).abs() < 1e-12);
        assert!((fresnel(FRAC_PI_2 - 1e-9, 1.5) - 1.0).abs() < 1e-6);
        // Hecht, Optics: 60 degrees on n = 1.5 reflects 17.7 % of one polarisation and 0.18 % of the other.
        assert!((fresnel(60.0_f64.to_radians(), 1.5) - 0.0892).abs() < 2e-4);
        // Beyond the critical angle of 41.8 degrees.
        assert_eq!(fresnel(42.0_f64.to_radians(), 1.0 / 1.5), 1.0);
        assert!(fresnel(41.0_f64.to_radians(), 1.0 / 1.5) < 0.5);
    }

    #[test]
    fn both_sides_reflect_alike_and_light_returns_the_way_it_came() {
        let theta: f64 = 0.9;
        let incident = DVec3::new(theta.sin(), 0.0, -theta.cos());
        let inside = refract(incident, DVec3::Z, 1.5).unwrap();
        let theta_inside = (-inside.z).acos();
        assert!((theta_inside.sin() * 1.5 - theta.sin()).abs() < 1e-12);
        assert!((fresnel(theta, 1.5) - fresnel(theta_inside, 1.0 / 1.5)).abs() < 1e-12);
        let back = refract(-inside, DVec3::NEG_Z, 1.0 / 1.5).unwrap();
        assert!(back.distance(-incident) < 1e-12);
        assert!(refract(-incident, DVec3::NEG_Z, 1.0 / 1.5).is_none());
    }
}
