//! Projects an environment into the representation and compares its irradiance with the exact integral. Exit codes: 0 done,
//! 2 usage or environment.

#![forbid(unsafe_code)]

use anyhow::Result;
use clap::Parser;
use glam::{DVec3, Vec2};
use pt_core::console;
use pt_indirect::oracle::{ShLight, ycocg_from_rgb};
use pt_scene::{BadTexels, Environment};
use std::f64::consts::{PI, TAU};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Irradiance of the six axes from a lat-long environment: spherical harmonics up to l = 1 against the exact integral.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Lat-long radiance: hdr or exr.
    environment: PathBuf,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long)]
    env_clamp: bool,
}

const AXES: [(&str, DVec3); 6] = [
    ("+X", DVec3::X),
    ("-X", DVec3::NEG_X),
    ("+Y", DVec3::Y),
    ("-Y", DVec3::NEG_Y),
    ("+Z", DVec3::Z),
    ("-Z", DVec3::NEG_Z),
];

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let bad_texels = BadTexels::clamp_if(args.env_clamp);
    let (environment, notices) = Environment::read(&args.environment, bad_texels)?;
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

    writeln!(out, "{}: {width}x{height} texels; irradiance R G B", args.environment.display())?;
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
