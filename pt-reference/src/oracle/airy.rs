//! Reflectance of a thin film by Airy's summation (Born and Wolf, "Principles of Optics", section 7.6), wavelength by wavelength and for both
//! polarisations: what [`super::thin_film`] approximates.

use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// Rec. 709 primaries, white D65.
const REC709_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(3.2404542, -0.9692660, 0.0556434),
    DVec3::new(-1.5371385, 1.8760108, -0.2040259),
    DVec3::new(-0.4985314, 0.0415560, 1.0572252),
);

/// A smooth film on a base that absorbs nothing, in air.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// Reflectance of the base at normal incidence, without the film.
    pub f0: f64,
    /// Index of refraction of the film.
    pub ior: f64,
    /// Its thickness, nm.
    pub thickness: f64,
}

impl Film {
    /// Index of refraction of the base.
    pub fn base_ior(self) -> f64 {
        let root = self.f0.sqrt();
        (1.0 + root) / (1.0 - root)
    }

    /// Reflectance for unpolarised light of a wavelength in nm.
    pub fn reflectance(self, wavelength: f64, cos_theta: f64) -> f64 {
        let Self { ior, thickness, .. } = self;
        let base = self.base_ior();
        let sin2 = 1.0 - cos_theta * cos_theta;
        let cos_in = |ior: f64| (1.0 - sin2 / (ior * ior)).sqrt();
        let (cos_film, cos_base) = (cos_in(ior), cos_in(base));
        let phase = (TAU * 2.0 * ior * thickness * cos_film / wavelength).cos();
        let both = |outer: f64, inner: f64| {
            let mixed = 2.0 * outer * inner * phase;
            let product = outer * inner;
            (outer * outer + inner * inner + mixed) / (1.0 + product * product + mixed)
        };
        let s = both(amplitude(cos_theta, ior * cos_film), amplitude(ior * cos_film, base * cos_base));
        let p = both(amplitude(ior * cos_theta, cos_film), amplitude(base * cos_film, ior * cos_base));
        0.5 * (s + p)
    }
}

fn amplitude(a: f64, b: f64) -> f64 {
    (a - b) / (a + b)
}

/// Matching functions of the CIE 1931 observer: Wyman, Sloan, Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching
/// Functions", table 1 (the multi-lobe fit). Wavelength in nm.
fn colour_matching(wavelength: f64) -> DVec3 {
    let lobe = |height: f64, centre: f64, below: f64, above: f64| {
        let width = if wavelength < centre { below } else { above };
        height * (-0.5 * ((wavelength - centre) / width).powi(2)).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) - lobe(0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

/// Integrals over the visible spectrum, in steps of a nanometre.
pub struct Spectrum {
    /// Wavelengths and what they contribute to X, Y and Z; each sums to 1.
    weights: Vec<(f64, DVec3)>,
}

impl Default for Spectrum {
    fn default() -> Self {
        let mut weights: Vec<_> =
            (380..=780).map(|nm| (f64::from(nm), colour_matching(f64::from(nm)))).collect();
        let sum: DVec3 = weights.iter().map(|(_, weight)| *weight).sum();
        weights.iter_mut().for_each(|(_, weight)| *weight /= sum);
        Self { weights }
    }
}

impl Spectrum {
    /// X, Y and Z of a reflectance under light of the same power at all wavelengths; a constant of 1 has (1, 1, 1).
    fn xyz(&self, reflectance: impl Fn(f64) -> f64) -> DVec3 {
        self.weights.iter().map(|(wavelength, weight)| reflectance(*wavelength) * *weight).sum()
    }

    /// Linear Rec. 709 in which a constant reflectance of 1 is white.
    pub fn rgb(&self, reflectance: impl Fn(f64) -> f64) -> DVec3 {
        REC709_FROM_XYZ * self.xyz(reflectance) / (REC709_FROM_XYZ * DVec3::ONE)
    }

    /// As KHR_materials_iridescence has it: the mean over all phases of the film, `mean`, is white, and the deviations from it have the
    /// matrix for D65 without adaptation, so that they are 20 % too strong in red, and 5 % and 9 % too weak in green and blue.
    pub fn rgb_about(&self, mean: f64, reflectance: impl Fn(f64) -> f64) -> DVec3 {
        mean + REC709_FROM_XYZ * self.xyz(|wavelength| reflectance(wavelength) - mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{dielectric, layers::schlick, thin_film};

    #[test]
    fn closed_forms() {
        let base_ior: f64 = 2.25;
        let f0 = amplitude(1.0, base_ior).powi(2);
        for cos in [1.0, 0.7, 0.3] {
            // Films that are not there.
            let bare = dielectric::fresnel(cos, base_ior);
            for film in [Film { f0, ior: 1.0, thickness: 333.0 }, Film { f0, ior: 1.5, thickness: 0.0 }] {
                assert!((film.reflectance(550.0, cos) - bare).abs() < 1e-12, "{film:?}");
            }
            // Half a wave in the film changes nothing.
            let cos_film = (1.0 - (1.0 - cos * cos) / 1.5f64.powi(2)).sqrt();
            let half = Film { f0, ior: 1.5, thickness: 550.0 / (2.0 * 1.5 * cos_film) };
            assert!((half.reflectance(550.0, cos) - bare).abs() < 1e-12);
        }
        // A quarter of a wave whose index is the geometric mean takes the reflection away.
        let quarter = Film { f0, ior: 1.5, thickness: 550.0 / (4.0 * 1.5) };
        assert!(quarter.reflectance(550.0, 1.0) < 1e-12);
        let spectrum = Spectrum::default();
        assert!((spectrum.rgb(|_| 0.3) - 0.3).abs().max_element() < 1e-12);
        // A filter that lets pass what is longer than 600 nm is red, and what is left is the complement.
        let red = spectrum.rgb(|wavelength| if wavelength > 600.0 { 1.0 } else { 0.0 });
        let rest = spectrum.rgb(|wavelength| if wavelength > 600.0 { 0.0 } else { 1.0 });
        assert!(red.x > 0.6 && red.y < 0.1 && (red + rest - 1.0).abs().max_element() < 1e-12, "{red}");
    }

    /// Reflectances of the two interfaces as the model has them, for unpolarised light; and the sign of the interference.
    fn interfaces(film: Film, cos: f64) -> (f64, f64, f64) {
        let Film { ior, .. } = film;
        let cos_film = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
        let base = film.base_ior();
        let inner = schlick(DVec3::splat(amplitude(ior, base).powi(2)), 1.0, cos_film).x;
        (dielectric::fresnel(cos, ior), inner, if base < ior { 1.0 } else { -1.0 })
    }

    /// Airy's sum up to an order, of the model's unpolarised reflectances: what is left of the model without its Gaussians.
    fn series(film: Film, wavelength: f64, cos: f64, orders: i32) -> f64 {
        let (outer, inner, sign) = interfaces(film, cos);
        let cos_film = (1.0 - (1.0 - cos * cos) / (film.ior * film.ior)).sqrt();
        let turn = TAU * 2.0 * film.ior * film.thickness * cos_film / wavelength;
        let amplitude = (outer * inner).sqrt();
        let deviation = (1.0 - outer).powi(2) * inner / (1.0 - outer * inner) - (1.0 - outer);
        let term = |m: i32| 2.0 * deviation * (sign * amplitude).powi(m) * (f64::from(m) * turn).cos();
        mean(film, cos) + (1..=orders).map(term).sum::<f64>()
    }

    /// Over all phases.
    fn mean(film: Film, cos: f64) -> f64 {
        let (outer, inner, _) = interfaces(film, cos);
        outer + (1.0 - outer).powi(2) * inner / (1.0 - outer * inner)
    }

    /// Largest and mean difference.
    #[derive(Default)]
    struct Difference {
        largest: f64,
        sum: f64,
        count: f64,
    }

    impl Difference {
        fn add(&mut self, a: DVec3, b: DVec3) {
            let off = (a - b).abs();
            self.largest = self.largest.max(off.max_element());
            self.sum += off.element_sum();
            self.count += 3.0;
        }

        fn mean(&self) -> f64 {
            self.sum / self.count
        }
    }

    /// The model against Airy's summation, and what each of its simplifications does to the difference:
    ///
    /// * Gaussians stand for the eye's sensitivities, and orders of reflection beyond the second are left out (Belcour and Barla 2017);
    /// * amplitudes and phases are those of unpolarised reflectances, with Schlick's for the base (KHR_materials_iridescence): without effect
    ///   head on, but beyond Brewster's angle the two polarisations interfere with opposite signs, which the model cannot tell;
    /// * deviations from the mean are not adapted to the white (KHR_materials_iridescence): [`Spectrum::rgb_about`].
    #[test]
    fn the_model_differs_from_airy_by_its_published_simplifications() {
        let spectrum = Spectrum::default();
        println!(
            "angle   model - Airy      same white        Gaussians         orders > 2        polarisation, Schlick"
        );
        // Angles and limits of the largest and the mean difference from Airy, in the model's white.
        for (angle, largest, average) in [
            (0.0f64, 0.05, 0.004),
            (15.0, 0.05, 0.004),
            (30.0, 0.05, 0.0045),
            (45.0, 0.07, 0.008),
            (60.0, 0.2, 0.025),
            (75.0, 0.49, 0.07),
        ] {
            let cos = angle.to_radians().cos();
            let mut differences: [Difference; 5] = Default::default();
            for f0 in [0.04, 0.1, 0.2, 0.5, 0.9] {
                for ior in [1.2, 1.33, 1.5, 1.7, 2.0] {
                    for thickness in (100..=1000).step_by(50).map(f64::from) {
                        let film = Film { f0, ior, thickness };
                        let model = thin_film::fresnel(DVec3::splat(f0), ior, thickness, cos);
                        let airy = |wavelength: f64| film.reflectance(wavelength, cos);
                        let shown = |reflectance: &dyn Fn(f64) -> f64| {
                            spectrum.rgb_about(mean(film, cos), reflectance).clamp(DVec3::ZERO, DVec3::ONE)
                        };
                        let [two, all] = [2, 60].map(|orders| shown(&|w| series(film, w, cos, orders)));
                        let same_white = shown(&airy);
                        let pairs = [
                            (model, spectrum.rgb(airy)),
                            (model, same_white),
                            (model, two),
                            (two, all),
                            (all, same_white),
                        ];
                        differences.iter_mut().zip(pairs).for_each(|(d, (a, b))| d.add(a, b));
                    }
                }
            }
            let columns: Vec<_> =
                differences.iter().map(|d| format!("{:.4} ({:.4})", d.largest, d.mean())).collect();
            println!("{angle:5}   {}   largest (mean)", columns.join("   "));
            let [_, airy, gaussians, orders, polarisation] = &differences;
            assert!(
                airy.largest < largest && airy.mean() < average,
                "{angle}: {} {}",
                airy.largest,
                airy.mean()
            );
            // The model does what it says: two orders of the same reflectances, but for the Gaussians. They are off by up to 0.05 in X, Y and Z,
            // of which red is 3.2 X - 1.5 Y - 0.5 Z.
            assert!(gaussians.largest < 0.06 && gaussians.mean() < 0.0075, "{angle}: {}", gaussians.largest);
            // The rest is accounted for.
            let whole = gaussians.mean() + orders.mean() + polarisation.mean();
            assert!(airy.mean() <= whole, "{angle}: {} {whole}", airy.mean());
            assert!(angle > 0.0 || polarisation.largest < 1e-9, "{}", polarisation.largest);
        }
    }

    /// Half a turn of phase where the base is rarer than the film: the colours of soap bubbles and of oil on water are complements.
    #[test]
    fn phases() {
        let spectrum = Spectrum::default();
        let film = |f0| Film { f0, ior: 1.5, thickness: 300.0 };
        let deviation = |f0: f64| {
            let model = thin_film::fresnel(DVec3::splat(f0), 1.5, 300.0, 1.0) - mean(film(f0), 1.0);
            let exact = spectrum.rgb_about(0.0, |w| film(f0).reflectance(w, 1.0) - mean(film(f0), 1.0));
            // The Gaussians, as above.
            assert!((model - exact).abs().max_element() < 0.045, "{f0}: {model} {exact}");
            model
        };
        let [rarer, denser] = [0.001, 0.2].map(deviation);
        assert!((0..3).all(|c| rarer[c] * denser[c] < 0.0), "{rarer} {denser}");
    }
}
