//! Host twin of bsdf/thin_film.glsl.

use super::dielectric;
use super::layers::schlick;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// Gaussians of the sensitivities X, Y, Z and of the second lobe of X in Fourier space: value, position, variance (Belcour and Barla 2017).
const GAUSSIANS: [[f64; 3]; 4] = [
    [5.4856e-13, 1.6810e6, 4.3278e9],
    [4.4201e-13, 1.7953e6, 9.3046e9],
    [5.2481e-13, 2.2084e6, 6.6121e9],
    [9.7470e-14, 2.2399e6, 4.5282e9],
];

fn response(way: f64, shift: DVec3) -> DVec3 {
    let rec709_from_xyz = DMat3::from_cols(
        DVec3::new(3.2404542, -0.9692660, 0.0556434),
        DVec3::new(-1.5371385, 1.8760108, -0.2040259),
        DVec3::new(-0.4985314, 0.0415560, 1.0572252),
    );
    let phase = TAU * way;
    let of = |k: usize, shift: f64| {
        let [value, position, variance] = GAUSSIANS[k];
        value * (TAU * variance).sqrt() * (position * phase + shift).cos() * (-variance * phase * phase).exp()
    };
    let xyz = DVec3::new(of(0, shift.x) + of(3, shift.x), of(1, shift.y), of(2, shift.z));
    rec709_from_xyz * (xyz / 1.0685e-7)
}

/// Reflectance of a base with `f0` under a film of that index and thickness (nm).
pub fn fresnel(f0: DVec3, film_ior: f64, thickness: f64, cos_theta: f64) -> DVec3 {
    let t = (thickness / 30.0).clamp(0.0, 1.0);
    let ior = 1.0 + (film_ior - 1.0) * t * t * (3.0 - 2.0 * t);
    let sin2_film = (1.0 - cos_theta * cos_theta) / (ior * ior);
    if sin2_film >= 1.0 {
        return DVec3::ONE;
    }
    let cos_film = (1.0 - sin2_film).sqrt();
    let outer = dielectric::fresnel(cos_theta, ior);
    let root = f0.clamp(DVec3::ZERO, DVec3::splat(0.9999)).map(f64::sqrt);
    let base_ior = (DVec3::ONE + root) / (DVec3::ONE - root);
    let ratio = (base_ior - ior) / (base_ior + ior);
    let inner = schlick(ratio * ratio, 1.0, cos_film);
    let shift = base_ior.map(|base| if ior < 1.0 { 0.0 } else { PI } + if base < ior { PI } else { 0.0 });
    let way = 2.0 * ior * thickness * 1e-9 * cos_film;

    let both = (outer * inner).min(DVec3::splat(0.9999));
    let series = (1.0 - outer).powi(2) * inner / (DVec3::ONE - both);
    let mut sum = series + outer;
    let mut term = series - (1.0 - outer);
    for m in [1.0, 2.0] {
        term *= both.map(f64::sqrt);
        sum += term * 2.0 * response(m * way, m * shift);
    }
    sum.clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without thickness, or with the index of air, nothing but the base is there; a film of the base's own index changes nothing either.
    #[test]
    fn no_film_is_the_base() {
        // All is exact but for the rounding.
        const TOLERANCE: f64 = 1e-12;
        for cos in [1.0, 0.7, 0.3] {
            let f0 = DVec3::new(0.9, 0.5, 0.04);
            for (ior, thickness) in [(1.5, 0.0), (2.0, 0.0), (1.0, 400.0)] {
                let bare = fresnel(f0, ior, thickness, cos);
                let off = (bare - schlick(f0, 1.0, cos)).abs().max_element();
                assert!(off < TOLERANCE, "index {ior}, {thickness} nm: {bare}");
            }
        }
        // Head on: elsewhere the outer reflectance is Fresnel's, that of the base is Schlick's.
        let same = fresnel(DVec3::splat(0.04), 1.5, 400.0, 1.0);
        assert!((same - 0.04).abs().max_element() < TOLERANCE, "{same}");
    }

    /// Thick films lose their colours: the phases of the wavelengths cancel. What is left is the incoherent sum.
    #[test]
    fn thick_films_are_grey() {
        let f0 = DVec3::splat(0.5);
        let spread = |c: DVec3| c.max_element() - c.min_element();
        assert!(spread(fresnel(f0, 1.6, 350.0, 1.0)) > 0.05);
        let thick = fresnel(f0, 1.6, 20_000.0, 1.0);
        assert!(spread(thick) < 1e-6, "{thick}");
        let (outer, inner) = ((0.6f64 / 2.6).powi(2), 0.0);
        let root = 0.5f64.sqrt();
        let base = (1.0 + root) / (1.0 - root);
        let inner = inner + ((base - 1.6) / (base + 1.6)).powi(2);
        let sum = outer + (1.0 - outer).powi(2) * inner / (1.0 - outer * inner);
        assert!((thick.x - sum).abs() < 1e-6, "{thick} {sum}");
    }
}
