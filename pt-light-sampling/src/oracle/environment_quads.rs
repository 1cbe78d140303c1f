//! Host twin of lights/environment_quads.glsl.

use super::lights::LightSample;
use crate::EnvironmentQuads;
use glam::DVec3;
use pt_core::rng::pcg4d;
use pt_scene::Environment;
use std::f64::consts::{PI, TAU};

/// A direction of a quad from two numbers in [0, 1).
pub fn sample_environment_quad(
    quads: &EnvironmentQuads,
    environment: &Environment,
    quad: u32,
    xi: [f32; 2],
) -> Option<LightSample> {
    if environment.intensity <= 0.0 {
        return None;
    }
    let record = quads.quads()[quad as usize];
    let cells = &quads.cells()[record.first as usize..];
    let [high, low] = xi.map(|xi| (xi * 65536.0) as u32);
    let number = high << 16 | low;
    let more = pcg4d([number, quad, 0, 0]).map(|word| (word >> 8) as f32 / 16_777_216.0);
    let entry = ((u64::from(number) * u64::from(record.size.x * record.size.y)) >> 32) as usize;
    let place = if more[0] < cells[entry].keep { entry as u32 } else { cells[entry].alias };
    let cell = [record.corner.x + place % record.size.x, record.corner.y + place / record.size.x];
    let [width, height] = quads.grid().map(f64::from);
    // cos(theta) is uniform between the borders of the cell.
    let border = |row: f64| (PI * row / height).cos();
    let (top, bottom) = (border(cell[1].into()), border(f64::from(cell[1]) + 1.0));
    // As in the kernel, rows below the horizon are mirror images.
    let share = f64::from(more[2]);
    let below = 2 * cell[1] >= quads.grid()[1];
    let cos = if below { bottom + share * (top - bottom) } else { top + share * (bottom - top) };
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let phi = TAU * ((f64::from(cell[0]) + f64::from(more[1])) / width - 0.5);
    let (s, c) = f64::from(environment.rotation).sin_cos();
    let (x, z) = (sin * phi.cos(), sin * phi.sin());
    let direction = DVec3::new(c * x + s * z, cos, c * z - s * x);
    Some(LightSample {
        direction,
        pdf: f64::from(cells[place as usize].pmf) / quads.cell_solid_angle(cell[1]),
        radiance: environment.radiance(direction.as_vec3()).as_dvec3(),
        delta: false,
        target: None,
    })
}
