//! What the command line takes and refuses.

mod bench;

use std::path::PathBuf;

use clap::{CommandFactory, Parser};
use pt_app::aov::AovSelection;
use pt_app::args::{CameraChoice, LookAt};
use pt_app::cli::Cli;
use pt_app::commands::bench::{BenchArgs, BenchCommand};
use pt_app::commands::info::InfoArgs;
use pt_app::commands::render::RenderArgs;
use pt_core::trace::TraceBackend;
use pt_image::image_file::{ImageSize, OutputFormat};
use pt_scene::{AnimationEnd, BadTexels, PhysicalSky};

#[derive(Debug, Parser)]
struct Render {
    #[command(flatten)]
    args: RenderArgs,
}

fn render(line: &str) -> Result<RenderArgs, String> {
    let words = ["render"].into_iter().chain(line.split_whitespace());
    Render::try_parse_from(words).map(|render| render.args).map_err(|error| error.to_string())
}

fn refused(line: &str) -> String {
    render(&format!("{line} cornell -o a.png")).unwrap_err()
}

#[test]
fn the_command_tree_is_sound() {
    Cli::command().debug_assert();
    Render::command().debug_assert();
}

#[test]
fn treatments_of_files_are_chosen() {
    let load = |line: &str| render(&format!("{line} cornell -o a.png")).unwrap().frame.scene.load_options();
    let options = load("");
    assert_eq!((options.bad_texels, options.animation_end), (BadTexels::Refuse, AnimationEnd::Loop));
    assert!(!options.allow_outside);
    let options = load("--env e.hdr --env-clamp --animation-end hold --allow-outside");
    assert_eq!((options.bad_texels, options.animation_end), (BadTexels::Clamp, AnimationEnd::Hold));
    assert!(options.allow_outside);
    assert!(refused("--env-clamp").contains("--env"));
    assert!(refused("--animation-end stop").contains("expected loop or hold"));
}

#[test]
fn a_sky_is_given_by_its_sun() {
    let sky =
        |line: &str| render(&format!("{line} cornell -o a.png")).unwrap().frame.scene.load_options().sky;
    assert_eq!(sky(""), None);
    assert_eq!(sky("--sky 30,-70"), Some(PhysicalSky::new(30.0, -70.0, 3.0, 0.2).unwrap()));
    assert_eq!(sky("--sky 30,-70,2,0.5"), Some(PhysicalSky::new(30.0, -70.0, 2.0, 0.5).unwrap()));
    assert!(refused("--sky -4,0").contains("the sun is below the horizon at an elevation of -4 degrees"));
    assert!(refused("--sky 30,0,12").contains("turbidity 12 is out of range; give 1 to 10"));
    assert!(refused("--sky NaN,0").contains("elevation (degrees) NaN is out of range"));
    assert!(refused("--sky 30,0,3,2").contains("albedo of the ground 2 is out of range"));
    assert!(refused("--sky noon").contains("expected ELEVATION,AZIMUTH[,TURBIDITY[,ALBEDO]]"));
    assert!(refused("--sky 30,0 --env e.hdr").contains("cannot be used with"));
}

#[test]
fn render_defaults() {
    let args = render("cornell -o out/a.png").unwrap();
    assert_eq!(args.frame.scene.file, "cornell");
    assert_eq!(args.output, [PathBuf::from("out/a.png")]);
    assert_eq!(args.frame.size, ImageSize { width: 1280, height: 720 });
    assert_eq!(
        (args.frames, args.frame.seed, args.frame.scene.time, args.frame.scene.fps),
        (1, 0, 0.0, 60.0)
    );
    assert_eq!(
        (args.frame.scene.load.env_rotation, args.frame.scene.load.env_intensity, args.frame.camera.vfov),
        (0.0, 1.0, 50.0)
    );
    assert_eq!(args.frame.device.backend, TraceBackend::Auto);
    assert!(!args.frame.accumulate && !args.frame.device.validation && args.frame.set.is_empty());
    assert!(
        args.frame.camera.camera.is_none()
            && args.frame.camera.look.is_none()
            && args.aov.is_none()
            && args.timings.is_none()
    );
}

#[test]
fn render_takes_every_flag() {
    let args = render(
        "a.gltf --env sky.hdr --env-rotation -30 --env-intensity 2.5 --size 640x360 --frames 8 --accumulate \
         --look -1,2,3,0,0,-4.5 --vfov 40 --time 1.5 --fps 24 --seed 18446744073709551615 --backend rt-pipeline \
         --device llvm --profile fast --set post.output=display --set a.b=-1 --aov normal,view_depth \
         --timings t.json --validation -o a.exr",
    )
    .unwrap();
    assert_eq!(args.frame.scene.load.env, Some("sky.hdr".into()));
    assert_eq!((args.frame.scene.load.env_rotation, args.frame.scene.load.env_intensity), (-30.0, 2.5));
    assert_eq!(args.frame.size, ImageSize { width: 640, height: 360 });
    assert_eq!(args.frame.camera.look, Some(LookAt { eye: [-1.0, 2.0, 3.0], target: [0.0, 0.0, -4.5] }));
    assert_eq!(
        (args.frame.camera.vfov, args.frame.scene.time, args.frame.scene.fps, args.frame.seed),
        (40.0, 1.5, 24.0, u64::MAX)
    );
    assert_eq!(args.frame.device.backend, TraceBackend::RtPipeline);
    assert_eq!(args.frame.set, ["post.output=display", "a.b=-1"]);
    assert_eq!(args.aov, Some(AovSelection::Named(vec!["normal".into(), "view_depth".into()])));
    assert_eq!(args.timings, Some("t.json".into()));
    assert!(args.frame.accumulate && args.frame.device.validation && args.frames == 8);
    assert_eq!(
        (args.frame.device.device.as_deref(), args.frame.profile.as_deref()),
        (Some("llvm"), Some("fast"))
    );
    let camera =
        |text: &str| render(&format!("a.glb -o a.exr --camera {text}")).unwrap().frame.camera.camera.unwrap();
    assert_eq!(camera("2"), CameraChoice::Index(2));
    assert_eq!(camera("Front"), CameraChoice::Name("Front".into()));
    assert_eq!(render("a.glb -o a.exr --aov all").unwrap().aov, Some(AovSelection::All));
}

#[test]
fn render_refuses_what_cannot_be() {
    for size in ["0x0", "0x10", "10x0", "100000x100000", "16385x1"] {
        let message = refused(&format!("--size {size}"));
        assert!(message.contains(&format!("image size {size} is out of range")), "{message}");
    }
    for size in ["640", "640x", "x360", "640*360", "99999999999999999999x1"] {
        assert!(refused(&format!("--size {size}")).contains("expected WIDTHxHEIGHT"), "{size}");
    }
    for look in ["1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,3,4,5,nan", "1,2,3,4,5,", "a,b,c,d,e,f"] {
        assert!(refused(&format!("--look {look}")).contains("six finite numbers"), "{look}");
    }
    assert!(refused("--look 1,2,3,1,2,3").contains("the same point"));
    assert!(refused("--look 1,2,3,4,5,6 --camera 0").contains("cannot be used with"));
    assert!(refused("--vfov 40").contains("--look"));
    for vfov in ["0", "180", "-5", "nan"] {
        assert!(
            refused(&format!("--look 1,2,3,4,5,6 --vfov {vfov}")).contains("between 0 and 180"),
            "{vfov}"
        );
    }
    let backend = refused("--backend cuda");
    for known in ["auto", "compute", "ray-query", "rt-pipeline", "rt-reorder"] {
        assert!(backend.contains(known), "{backend}");
    }
    assert!(refused("--frames 0").contains("0 is not in 1.."));
    assert!(refused("--fps 0").contains("above 0"));
    assert!(refused("--time inf").contains("finite"));
    assert!(refused("--env-intensity -1").contains("0 or more"));
    assert!(refused("--env-rotation north").contains("finite"));
    assert!(refused("--set exposure").contains("stage.key=value"));
    assert!(refused("--set =1").contains("stage.key=value"));
    assert!(refused("--aov normal,,albedo").contains("separated by commas"));
    assert!(render("cornell").unwrap_err().contains("--output"));
    assert!(render("-o a.png").unwrap_err().contains("<SCENE>"));
}

#[test]
fn outputs_are_checked_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let check = |line: &str| {
        let outputs = render(&format!("cornell {line}")).unwrap().check_outputs();
        outputs.map(|o| o.iter().map(|o| o.format()).collect::<Vec<_>>()).map_err(|e| e.to_string())
    };
    assert_eq!(check(&format!("-o {}", at("a.png"))), Ok(vec![OutputFormat::Png]));
    assert_eq!(check(&format!("-o {} --aov all", at("a.exr"))), Ok(vec![OutputFormat::Exr]));
    let refused = |line: String, expected: &str| {
        let message = check(&line).unwrap_err();
        assert!(message.contains(expected), "{message}");
    };
    refused(format!("-o {}", at("a.bmp")), "use one of: png, jpg, exr");
    refused(format!("-o {}", at("missing/a.png")), "does not exist, create it first");
    refused(format!("-o {} --aov all", at("a.png")), "--aov needs an EXR output");
    refused(format!("-o {} --timings {}", at("a.png"), at("missing/t.json")), "does not exist");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the checks leave nothing behind");
}

#[test]
fn help_is_grouped_and_shows_defaults() {
    let help = Render::command().render_long_help().to_string();
    for part in
        ["Output:", "Scene:", "Camera:", "Frame:", "Device:", "[default: 1280x720]", "[default: auto]"]
    {
        assert!(help.contains(part), "{part} is not in\n{help}");
    }
}

#[test]
fn the_smaller_commands() {
    #[derive(Debug, Parser)]
    struct Info {
        #[command(flatten)]
        args: InfoArgs,
    }
    #[derive(Debug, Parser)]
    struct Bench {
        #[command(flatten)]
        args: BenchArgs,
    }
    assert!(Info::try_parse_from(["info", "--json"]).unwrap().args.json);
    let bench = Bench::try_parse_from(["bench", "trace", "gallery", "--json", "rows.json"]).unwrap();
    let BenchCommand::Trace(trace) = bench.args.command else { panic!("another benchmark") };
    assert_eq!((trace.scene.as_str(), trace.json), ("gallery", Some("rows.json".into())));
    Bench::try_parse_from(["bench", "rays", "gallery"]).unwrap_err();
}
