//! `pt bake` compresses the textures of a scene into a folder of DDS files.

use crate::args::values::named;
use crate::output::check_folder;
use crate::progress::Progress;
use anyhow::{Result, bail};
use clap::Args;
use pt_import::bake::{BakedTexture, Outcome, bake};
use pt_import::{LoadOptions, Quality};
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// `pt bake`
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// glTF or GLB file.
    pub scene: PathBuf,
    /// Folder for the DDS files; created if missing; several scenes may share it.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Quality of the encoder; best takes three times as long and is up to 2 dB better.
    #[arg(long, value_name = "Q", value_parser = named::<Quality>(), default_value = Quality::Fast.name())]
    pub quality: Quality,
    /// Limit on the texels of an image.
    #[arg(long, value_name = "N", default_value_t = pt_import::DEFAULT_MAX_TEXTURE_PIXELS)]
    pub max_texture_pixels: u64,
    /// Read buffers and images of the scene that are not beside or below its file, too.
    #[arg(long)]
    pub allow_outside: bool,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// A scene or an image that can't be read, a folder that can't be written.
pub fn run(args: &BakeArgs, out: &mut impl Write) -> Result<bool> {
    check_folder(&args.output)?;
    let name = args.scene.to_string_lossy();
    if pt_scene::builtin(&name).is_some() && !args.scene.exists() {
        bail!("{name}: is a built-in scene; pt bake compresses the textures of a glTF file");
    }
    let started = Instant::now();
    let mut progress = None;
    let options = LoadOptions {
        max_texture_pixels: args.max_texture_pixels,
        allow_outside: args.allow_outside,
        ..LoadOptions::default()
    };
    let textures = bake(&args.scene, &args.output, args.quality, &options, |_, total| {
        progress.get_or_insert_with(|| Progress::counting(total as u32, "texture")).step();
    });
    if let Some(progress) = progress {
        progress.finish();
    }
    let textures = textures?;
    let sum = |bytes: fn(&BakedTexture) -> u64| textures.iter().map(bytes).sum::<u64>();
    let (before, after) = (sum(|t| t.bytes_before), sum(|t| t.bytes_after));
    if args.json {
        let rows: Vec<_> = textures
            .iter()
            .map(|t| {
                json!({
                    "texture": t.name,
                    "usage": usage(t),
                    "size": t.extent,
                    "outcome": outcome(t),
                    "file": t.file,
                    "bytes_before": t.bytes_before,
                    "bytes_after": t.bytes_after,
                    "psnr": t.psnr.filter(|psnr| psnr.is_finite()),
                })
            })
            .collect();
        let document = json!({ "textures": rows, "bytes_before": before, "bytes_after": after });
        writeln!(out, "{}", serde_json::to_string_pretty(&document)?)?;
        return Ok(true);
    }
    for t in &textures {
        let psnr = t.psnr.map_or(String::new(), |psnr| format!(", {psnr:.1} dB"));
        writeln!(
            out,
            "{} {}x{} {} {}{psnr}  {}",
            t.file,
            t.extent[0],
            t.extent[1],
            usage(t),
            outcome(t),
            t.name
        )?;
    }
    let count = |outcome| textures.iter().filter(|t| t.outcome == outcome).count();
    writeln!(
        out,
        "{} textures in {:.1} s: {} baked, {} rebuilt, {} unchanged; texture memory with mips {:.1} MiB -> {:.1} MiB",
        textures.len(),
        started.elapsed().as_secs_f64(),
        count(Outcome::Baked),
        count(Outcome::Rebuilt),
        count(Outcome::Unchanged),
        before as f64 / (1 << 20) as f64,
        after as f64 / (1 << 20) as f64,
    )?;
    Ok(true)
}

fn usage(t: &BakedTexture) -> &'static str {
    match t.usage {
        pt_scene::TextureUsage::Color => "color",
        pt_scene::TextureUsage::Cutout => "cutout",
        pt_scene::TextureUsage::Data => "data",
        pt_scene::TextureUsage::Normal => "normal",
    }
}

fn outcome(t: &BakedTexture) -> &'static str {
    match t.outcome {
        Outcome::Baked => "baked",
        Outcome::Unchanged => "unchanged",
        Outcome::Rebuilt => "rebuilt",
        Outcome::AlreadyCompressed => "already compressed",
    }
}
