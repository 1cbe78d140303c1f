//! Prints what is in a scene: `pt-import SCENE` for a glTF file or a built-in scene, `pt-import --list` for the latter.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use pt_import::{LoadOptions, open};
use pt_scene::{BUILTIN, BadTexels, Scene};

/// Loads a scene the way every other program of the workbench does, and prints its statistics.
#[derive(Parser)]
struct Arguments {
    /// A .gltf or .glb file, or the name of a built-in scene.
    #[arg(required_unless_present = "list")]
    scene: Option<String>,
    /// Lat-long environment, .hdr or .exr.
    #[arg(long, value_name = "FILE")]
    env: Option<std::path::PathBuf>,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long, requires = "env")]
    env_clamp: bool,
    /// Reads buffers and images that are not beside or below the scene file, too.
    #[arg(long)]
    allow_outside: bool,
    /// Lists the built-in scenes.
    #[arg(long)]
    list: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.list {
        BUILTIN.iter().for_each(|(name, about)| println!("{name:10} {about}"));
    }
    let Some(name) = arguments.scene else { return ExitCode::SUCCESS };
    let options = LoadOptions {
        environment: arguments.env,
        bad_texels: BadTexels::clamp_if(arguments.env_clamp),
        allow_outside: arguments.allow_outside,
        ..LoadOptions::default()
    };
    let start = Instant::now();
    match open(&name, &options) {
        Ok(scene) => {
            print(&scene, start.elapsed().as_secs_f64());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("pt-import: {error}");
            ExitCode::from(2)
        }
    }
}

fn print(scene: &Scene, seconds: f64) {
    let s = scene.statistics();
    let moving = scene.instances.iter().filter(|i| i.motion.is_some()).count();
    println!("{:12} {} (loaded in {seconds:.2} s)", "scene", scene.name);
    println!(
        "{:12} {} in {} meshes, {} with instances",
        "triangles",
        s.triangles,
        scene.meshes.len(),
        s.instanced_triangles
    );
    println!("{:12} {} emissive, {} masked", "", s.emissive_triangles, s.masked_triangles);
    println!("{:12} {}, {moving} of them moving", "instances", scene.instances.len());
    println!("{:12} {}", "materials", scene.materials.len());
    println!(
        "{:12} {}, {:.1} MiB without mip levels",
        "textures",
        scene.textures.len(),
        s.texture_bytes as f64 / 1048576.0
    );
    let environment = &scene.environment;
    println!(
        "{:12} {}x{}{}",
        "environment",
        environment.image.width,
        environment.image.height,
        if environment.is_black() { ", black" } else { "" }
    );
    if let Some(bounds) = scene.bounds() {
        println!("{:12} {} .. {}", "bounds", bounds.min, bounds.max);
    }
    for light in &scene.lights {
        println!("{:12} {} {:?}, intensity {}", "light", light.name, light.kind, light.intensity);
    }
    let automatic = scene.cameras.is_empty().then(|| scene.default_camera());
    for camera in scene.cameras.iter().chain(&automatic) {
        let path =
            camera.path.as_ref().map_or(String::new(), |path| format!(", path of {:.0} s", path.duration()));
        println!(
            "{:12} {} at {:.3}, looks along {:.3}{path}",
            "camera",
            camera.name,
            camera.position(),
            camera.forward()
        );
    }
    scene.notices.iter().for_each(|notice| println!("{:12} {notice}", "notice"));
}
