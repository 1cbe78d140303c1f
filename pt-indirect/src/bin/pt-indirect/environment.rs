//! Irradiance of the six axes from an environment: spherical harmonics up to l = 1 against the exact integral.

use anyhow::Result;
use glam::{DVec3, Vec2};
use pt_core::console;
use pt_indirect::oracle::{ShLight, ycocg_from_rgb};
use pt_scene::{BadTexels, Environment};
use std::f64::consts::{PI, TAU};
use std::io::Write;
use std::path::Path;

const AXES: [(&str, DVec3); 6] = [
    ("+X", DVec3::X),
    ("-X", DVec3::NEG_X),
    ("+Y", DVec3::Y),
    ("-Y", DVec3::NEG_Y),
    ("+Z", DVec3::Z),
    ("-Z", DVec3::NEG_Z),
];

/// Prints the table. `clamp`: negative, infinite or undefined values are set to what can be used.
pub fn run(path: &Path, clamp: bool, out: &mut impl Write) -> Result<()> {
    let bad_texels = BadTexels::clamp_if(clamp);
    let (environment, notices) = Environment::read(path, bad_texels)?;
    notices.iter().for_each(|notice| console::print_warning(notice));
    let (width, height) = (environment.image.width, environment.image.height);
    let mut light = ShLight::default();
    let mut exact = [DVec3::ZERO; 6];
    for (row, texels) in environment.image.texels.chunks_exact(width as usize).enumerate() {
        let polar = |edge: usize| (PI * edge as f64 / f64::from(height)).cos();
        let solid_angle = TAU / f64::from(width) * (polar(row) - polar(row + 1));
        for (column, texel) in texels.iter().enumerate() {
            let uv = Vec2::new((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32);
            let direction = environment.direction(uv).as_dvec3();
            let power = texel.as_dvec3() * solid_angle;
            light = light + ShLight::encode(direction, power);
            for ((_, axis), sum) in AXES.iter().zip(&mut exact) {
                *sum += power * axis.dot(direction).max(0.0);
            }
        }
    }

    writeln!(out, "{}: {width}x{height} texels; irradiance R G B", path.display())?;
    writeln!(out, "axis {:>27}  {:>29}  {:>12}", "exact", "l <= 1", "luma error")?;
    for ((name, axis), exact) in AXES.into_iter().zip(exact) {
        let projected = light.irradiance(axis);
        let luma = |c| ycocg_from_rgb(c)[0];
        let rgb = |c: DVec3| format!("{:9.4} {:9.4} {:9.4}", c.x, c.y, c.z);
        // Of black there is no relative error.
        let error = match luma(exact) {
            0.0 => "-".into(),
            luma_exact => format!("{:+.1} %", 100.0 * (luma(projected) / luma_exact - 1.0)),
        };
        writeln!(out, "{name}   {}  {}  {error:>12}", rgb(exact), rgb(projected))?;
    }
    Ok(())
}
