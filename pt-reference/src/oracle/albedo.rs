//! Directional albedos of the lobes: by quadrature, and from the tables that are made of it.
//!
//! `cargo run --release -p pt-reference --example albedo_tables` writes them again.

use super::{ggx, mirror, sheen};
use glam::{DVec2, DVec3};
use pt_scene::bsdf_tables::table;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::sync::LazyLock;

/// Values of a table across (cosine).
const COLUMNS: usize = 32;
/// And along (roughness).
const ROWS: usize = 16;
/// Roughnesses for which there are means.
const MEANS: usize = 61;

/// Directional albedo of an isotropic GGX lobe with Schlick's Fresnel term: f0 x + f90 y, by quadrature over the visible normals.
pub fn ggx_quadrature(cos_theta: f64, alpha: f64) -> DVec2 {
    const AZIMUTHS: usize = 32;
    const HEIGHTS: usize = 256;
    let v = DVec3::new((1.0 - cos_theta * cos_theta).sqrt(), 0.0, cos_theta);
    let a = DVec2::splat(alpha);
    let mut sum = DVec2::ZERO;
    for j in 0..HEIGHTS {
        // The tail of the distribution is at 1: steps get small towards it.
        let t = 1.0 - (j as f64 + 0.5) / HEIGHTS as f64;
        let (y, step) = (1.0 - t.powi(4), 4.0 * t.powi(3));
        for i in 0..AZIMUTHS {
            let x = 0.5 * (i as f64 + 0.5) / AZIMUTHS as f64;
            let h = ggx::sample_vndf(v, a, DVec2::new(x, y));
            let l = mirror(v, h);
            if l.z > 0.0 {
                let f = (1.0 - v.dot(h).clamp(0.0, 1.0)).powi(5);
                sum += DVec2::new(1.0 - f, f) * (ggx::g2(a, v, l) / ggx::g1(a, v) * step);
            }
        }
    }
    sum / (AZIMUTHS * HEIGHTS) as f64
}

/// Directional albedo of a white sheen, by quadrature over the hemisphere.
pub fn charlie_quadrature(cos_theta: f64, alpha: f64) -> f64 {
    const AZIMUTHS: usize = 128;
    const HEIGHTS: usize = 256;
    let v = DVec3::new((1.0 - cos_theta * cos_theta).sqrt(), 0.0, cos_theta);
    let mut sum = 0.0;
    for j in 0..HEIGHTS {
        let t = (j as f64 + 0.5) / HEIGHTS as f64;
        let (z, step) = (t * t, 2.0 * t);
        let sin = (1.0 - z * z).sqrt();
        for i in 0..AZIMUTHS {
            let phi = PI * (i as f64 + 0.5) / AZIMUTHS as f64;
            sum += sheen::charlie(v, DVec3::new(sin * phi.cos(), sin * phi.sin(), z), alpha) * step;
        }
    }
    sum * TAU / (AZIMUTHS * HEIGHTS) as f64
}

/// Where the albedo of a GGX lobe stands in its table: it changes fast where the cosine is like alpha.
pub fn ggx_coordinate(cos_theta: f64, alpha: f64) -> f64 {
    (cos_theta / (cos_theta + 0.5 * alpha) * (1.0 + 0.5 * alpha)).sqrt()
}

/// Inverse of [`ggx_coordinate`].
fn ggx_cosine(coordinate: f64, alpha: f64) -> f64 {
    let t = coordinate * coordinate / (1.0 + 0.5 * alpha);
    (0.5 * alpha * t / (1.0 - t)).clamp(0.0, 1.0)
}

struct Tables {
    ggx: Vec<f64>,
    grazing: Vec<f64>,
    mean: Vec<f64>,
    charlie: Vec<f64>,
}

/// Made by quadrature.
fn compute() -> Tables {
    let grid = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let place = |k: usize, n: usize| k as f64 / (n - 1) as f64;
        (0..COLUMNS * ROWS).map(|k| f(place(k % COLUMNS, COLUMNS), place(k / COLUMNS, ROWS))).collect()
    };
    let ggx = grid(&|x, roughness| {
        let alpha = roughness * roughness;
        // In the limit of grazing incidence, and for a mirror, nothing is lost.
        if alpha == 0.0 || x == 0.0 { 1.0 } else { ggx_quadrature(ggx_cosine(x, alpha), alpha).element_sum() }
    });
    let grazing = grid(&|x, roughness| {
        let alpha = (roughness * roughness).max(1e-5);
        let e = ggx_quadrature((x * x).max(1e-6), alpha);
        (e.y / e.element_sum()).powf(0.2)
    });
    let charlie = grid(&|x, roughness| {
        charlie_quadrature((x * x).max(1e-6), (roughness * roughness).max(sheen::MIN_SHEEN_ALPHA))
    });
    let mut tables = Tables { ggx, grazing, mean: Vec::new(), charlie };
    // The means of the tables rather than of the exact functions: what is compensated then adds up to one.
    for k in 0..MEANS {
        const POINTS: usize = 512;
        let alpha = (k as f64 / (MEANS - 1) as f64).powi(2);
        // Midpoints in the squared cosine: the cosine-weighted mean.
        let point = |i: usize| tables.ggx(((i as f64 + 0.5) / POINTS as f64).sqrt(), alpha);
        let mean = (0..POINTS).map(point).sum::<DVec2>() / POINTS as f64;
        tables.mean.extend(mean.to_array());
    }
    tables
}

/// The text of the table file.
pub fn text() -> String {
    let Tables { ggx, grazing, mean, charlie } = compute();
    let mut text = String::from(
        "Directional albedos of lobes, written by the example albedo_tables. Rows: perceptual roughness 0..1.\n\
         ggx: sqrt(cos / (cos + alpha / 2) (1 + alpha / 2)) -> albedo of a white GGX lobe. grazing: sqrt(cos) -> fifth root of the part of it\n\
         that Schlick's (1 - v.h)^5 weights. mean: cosine-weighted means of both parts. charlie: sqrt(cos) -> albedo of a white sheen.\n",
    );
    for (name, values) in [("ggx", ggx), ("grazing", grazing), ("mean", mean), ("charlie", charlie)] {
        writeln!(text, "= {name}").expect("writing to a String");
        for row in values.chunks(16) {
            let cells: Vec<String> = row.iter().map(|cell| format!("{cell:.6}")).collect();
            writeln!(text, "{}", cells.join(" ")).expect("writing to a String");
        }
    }
    text
}

/// The committed tables.
static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables {
    ggx: table("ggx"),
    grazing: table("grazing"),
    mean: table("mean"),
    charlie: table("charlie"),
});

fn look_up(table: &[f64], x: f64, y: f64) -> f64 {
    let at =
        DVec2::new(x, y).clamp(DVec2::ZERO, DVec2::ONE) * DVec2::new((COLUMNS - 1) as f64, (ROWS - 1) as f64);
    let (column, row) = ((at.x as usize).min(COLUMNS - 2), (at.y as usize).min(ROWS - 2));
    let across = |k: usize| table[k] + (at.x - column as f64) * (table[k + 1] - table[k]);
    let k = row * COLUMNS + column;
    across(k) + (at.y - row as f64) * (across(k + COLUMNS) - across(k))
}

impl Tables {
    fn ggx(&self, cos_theta: f64, alpha: f64) -> DVec2 {
        let roughness = alpha.sqrt();
        let whole = look_up(&self.ggx, ggx_coordinate(cos_theta, alpha), roughness);
        let f90 = whole * look_up(&self.grazing, cos_theta.sqrt(), roughness).powi(5);
        DVec2::new(whole - f90, f90)
    }
}

/// [`ggx_quadrature`] from the table.
pub fn ggx(cos_theta: f64, alpha: f64) -> DVec2 {
    TABLES.ggx(cos_theta, alpha)
}

/// Cosine-weighted mean of [`ggx()`] over the hemisphere, from the table.
pub fn ggx_mean(alpha: f64) -> DVec2 {
    let at = alpha.sqrt().clamp(0.0, 1.0) * (MEANS - 1) as f64;
    let k = (at as usize).min(MEANS - 2);
    let entry = |k: usize| DVec2::new(TABLES.mean[2 * k], TABLES.mean[2 * k + 1]);
    entry(k).lerp(entry(k + 1), at - k as f64)
}

/// [`charlie_quadrature`] from the table.
pub fn charlie(cos_theta: f64, alpha: f64) -> f64 {
    look_up(&TABLES.charlie, cos_theta.sqrt(), alpha.sqrt())
}
