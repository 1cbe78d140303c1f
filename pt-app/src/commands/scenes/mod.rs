//! `pt scenes` lists the built-in scenes, or the content of one scene.

mod stats;
mod text;

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use clap::{ArgGroup, Args};
use pt_scene::BUILTIN;
use serde_json::{Value, json};

use crate::args::LoadArgs;
use crate::inputs::gltf_json;
use crate::session::open_scene;
use stats::{ExtensionStats, SceneStats};
use text::extension_line;

/// `pt scenes`
#[derive(Clone, Debug, Args)]
#[command(group(ArgGroup::new("scene").args(["file", "stats"])))]
#[command(mut_group("LoadArgs", |options| options.requires("scene")))]
pub struct ScenesArgs {
    /// Print the content of this scene: a glTF or GLB file, or the name of a built-in scene [default: list the built-in scenes]
    #[arg(value_name = "SCENE")]
    pub file: Option<String>,
    /// The same as SCENE.
    #[arg(long, value_name = "SCENE")]
    pub stats: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Number of clusters to divide the scene into, 1 to 4096.
    #[arg(long, value_name = "N", default_value_t = pt_scene::Clusters::DEFAULT as u32, value_parser = clap::value_parser!(u32).range(1..=pt_scene::Clusters::MAX as i64), requires = "scene")]
    pub clusters: u32,
    /// How the scene is loaded.
    #[command(flatten)]
    pub load: LoadArgs,
}

/// Runs the command.
///
/// # Errors
/// A scene that cannot be loaded, standard output that cannot be written.
pub fn run(args: &ScenesArgs, out: &mut impl Write) -> Result<bool> {
    match args.file.as_ref().or(args.stats.as_ref()) {
        Some(scene) => stats(scene, args, out)?,
        None if args.json => writeln!(out, "{}", serde_json::to_string_pretty(&list())?)?,
        None => {
            let width = BUILTIN.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
            for (name, description) in BUILTIN {
                writeln!(out, "{name:width$}  {description}")?;
                writeln!(out, "{:width$}  cameras: {}", "", cameras(name).join(", "))?;
            }
        }
    }
    Ok(true)
}

fn cameras(name: &str) -> Vec<String> {
    let cameras = pt_scene::builtin(name).map(|scene| scene.cameras).unwrap_or_default();
    cameras.into_iter().map(|camera| camera.name).collect()
}

fn list() -> Value {
    let entry = |&(name, description): &(&str, &str)| json!({ "name": name, "description": description, "cameras": cameras(name) });
    BUILTIN.iter().map(entry).collect()
}

fn stats(name: &str, args: &ScenesArgs, out: &mut impl Write) -> Result<()> {
    let scene = match open_scene(name, &args.load.load_options()) {
        Ok(scene) => scene,
        Err(error) => {
            // Which extensions a refused file names is what its owner wants to know.
            let extensions = named_extensions(Path::new(name));
            if args.json && !extensions.is_empty() {
                let document = json!({ "scene": name, "error": error.to_string(), "extensions": extensions });
                writeln!(out, "{}", serde_json::to_string_pretty(&document)?)?;
            } else {
                for e in &extensions {
                    writeln!(out, "{:12} {}", "extension", extension_line(e))?;
                }
            }
            return Err(error);
        }
    };
    let stats = SceneStats::of(&scene, args.clusters as usize);
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&stats)?)?;
        Ok(())
    } else {
        stats.print(out)
    }
}

/// The extensions that a refused file names; none where its JSON cannot be found.
fn named_extensions(file: &Path) -> Vec<ExtensionStats> {
    let bytes = std::fs::read(file).unwrap_or_default();
    let root: Value = serde_json::from_slice(gltf_json(&bytes)).unwrap_or_default();
    let names = |key: &str| -> Vec<String> {
        let list = root.get(key).and_then(Value::as_array).into_iter().flatten();
        list.filter_map(Value::as_str).map(str::to_owned).collect()
    };
    let required = names("extensionsRequired");
    let mut all: Vec<ExtensionStats> = Vec::new();
    for name in names("extensionsUsed").into_iter().chain(required.clone()) {
        if all.iter().all(|e| e.name != name) {
            all.push(ExtensionStats::of(&name, required.contains(&name)));
        }
    }
    all
}
