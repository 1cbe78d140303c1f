//! The sheen lobe.

use glam::DVec3;
use std::f64::consts::TAU;

/// Narrower sheens than this are taken for it.
pub const MIN_SHEEN_ALPHA: f64 = 0.01;

/// Logarithm of Lambda where it is a function of the cosine alone (Estevez and Kulla 2017, table 1).
fn charlie_lambda_log(x: f64, alpha: f64) -> f64 {
    let w = (1.0 - alpha).powi(2);
    let fit = |rough: f64, smooth: f64| w * smooth + (1.0 - w) * rough;
    fit(21.5473, 25.3245) / (1.0 + fit(3.82987, 3.32435) * x.powf(fit(0.19823, 0.16801)))
        + fit(-1.97760, -1.27393) * x
        + fit(-4.32054, -4.85967)
}

fn charlie_lambda(cos_theta: f64, alpha: f64) -> f64 {
    let x = cos_theta.max(1e-6);
    if x < 0.5 {
        charlie_lambda_log(x, alpha).exp()
    } else {
        (2.0 * charlie_lambda_log(0.5, alpha) - charlie_lambda_log(1.0 - x, alpha)).exp()
    }
}

/// BRDF x l.z of a white sheen (Estevez and Kulla 2017, eq. 2, 3).
pub fn charlie(v: DVec3, l: DVec3, alpha: f64) -> f64 {
    let h = (v + l).normalize();
    let d = (2.0 + 1.0 / alpha) * h.truncate().length().powf(1.0 / alpha) / TAU;
    let g = 1.0 / (1.0 + charlie_lambda(v.z, alpha) + charlie_lambda(l.z, alpha));
    d * g / (4.0 * v.z)
}
