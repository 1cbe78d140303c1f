//! `pt bench frame`, `stage` and `all` measure the passes of the frame.

pub mod file;
mod measure;
mod table;

use crate::args::values::{assignment, named};
use crate::args::{CameraArgs, DeviceArgs};
use crate::frame::FrameStage;
use crate::inputs::Inputs;
use crate::origin::Origin;
use crate::params::{check_frame, resolve};
use crate::session::{Session, check_host_memory, fold_seed, open_scene};
use anyhow::{Context, Result, ensure};
use clap::Args;
use file::{BenchFile, FORMAT, Yardsticks};
use measure::{Plan, Whole};
use pt_core::capture::keys;
use pt_core::harness::copy_bandwidth;
use pt_core::trace::RayKind;
use pt_core::trace::bench::{BenchOptions, rates};
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::ImageSize;
use pt_import::LoadOptions;
use pt_scene::gpu::{camera_record, mesh_geometry, placements};
use pt_shaders::NamedEnum;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What the benchmarks of the frame share.
#[derive(Clone, Debug, Args)]
pub struct BenchFrameArgs {
    /// glTF or GLB file, or the name of a built-in scene.
    #[arg(long, value_name = "S", default_value = "gallery")]
    pub scene: String,
    /// Read buffers and images that are not beside or below the scene file, too.
    #[arg(long)]
    pub allow_outside: bool,
    /// The camera.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Size of the picture.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    pub size: ImageSize,
    /// Timed frames of a round, after 4 warm-up frames. They are the same in each round.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub frames: u32,
    /// Rounds. `pt bench compare` needs at least 3 for its intervals.
    #[arg(long, value_name = "R", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,
    /// Seed of all random numbers.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Initial values of the knobs: the name of a built-in profile, or a TOML file.
    #[arg(long, value_name = "NAME|FILE")]
    pub profile: Option<String>,
    /// Set one knob; overrides the profile; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment)]
    pub set: Vec<String>,
    /// Leave out the bandwidth of a copy and the rates of rays, which take seconds to measure.
    #[arg(long)]
    pub times_only: bool,
    /// Also write the result with all times to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Add the times to those of earlier runs in the JSON file, if it exists. Runs of two programs in turns show differences that are smaller
    /// than those between whole runs.
    #[arg(long, requires = "json")]
    pub append: bool,
    /// Device and trace backend.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// `pt bench stage`
#[derive(Clone, Debug, Args)]
pub struct BenchStageArgs {
    /// The stage. denoise, checkerboard and post run on a recorded frame, without rays; the others within the frame.
    #[arg(value_name = "NAME", value_parser = named::<FrameStage>())]
    pub stage: FrameStage,
    /// What the benchmarks of the frame share.
    #[command(flatten)]
    pub frame: BenchFrameArgs,
}

/// Which part of the frame is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subject {
    /// The frame with all passes.
    Frame,
    /// A stage.
    Stage(FrameStage),
    /// The frame, then each stage that needs no rays on its own.
    All,
}

/// Memory of the host that a pixel takes: the images of a recorded frame, on a CPU device also those of both frames.
const BYTES_PER_PIXEL: u64 = 800;
/// Windows in which the rates of rays are measured; the best counts, as in `pt bench trace`.
const RATE_WINDOWS: u32 = 5;

/// Runs the command.
///
/// # Errors
/// Unknown names, a stage that the frame has not, a device that can't do it, a file that can't be written.
pub fn run(args: &BenchFrameArgs, subject: Subject, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.json {
        Inputs::default().with("the scene", [&args.scene]).check([path])?;
        check_writable(path)?;
        if args.append {
            // What the file holds is known before anything is measured.
            read_earlier(path)?;
        }
    }
    let params = resolve(args.profile.as_deref(), &args.set, false)?;
    check_frame(&params, false)?;
    let size: [u32; 2] = args.size.into();
    check_host_memory("a frame", size, BYTES_PER_PIXEL)?;
    let options = LoadOptions { allow_outside: args.allow_outside, ..LoadOptions::default() };
    let scene = open_scene(&args.scene, &options)?;
    let mut session = Session::open(&args.device, &args.camera, scene)?;
    let plan =
        Plan { size, frames: args.frames, rounds: args.rounds, seed: fold_seed(args.seed), params: &params };

    let mut whole = Whole::new(&mut session, plan)?;
    let mut parts = Vec::new();
    let replayed = |stage: FrameStage| stage.replayed().filter(|&from| whole.can_replay(from)).map(|_| stage);
    let alone: Vec<FrameStage> = match subject {
        Subject::Frame => Vec::new(),
        Subject::Stage(stage) => replayed(stage).into_iter().collect(),
        Subject::All => FrameStage::VALUES.iter().copied().filter_map(replayed).collect(),
    };
    match subject {
        Subject::Stage(_) if !alone.is_empty() => whole.warm_up(&mut session)?,
        Subject::Stage(stage) => parts.push(whole.measure(&mut session, Some(stage))?),
        _ => parts.push(whole.measure(&mut session, None)?),
    }
    for stage in alone {
        parts.push(whole.replay(&session, stage)?);
    }
    if let (Subject::Stage(stage), Some(part)) = (subject, parts.first()) {
        ensure!(
            !part.passes.is_empty(),
            "{}: the frame with these knobs has no pass of this stage; pt bench frame lists all",
            stage.name()
        );
    }
    session.check_validation()?;
    let yardsticks = (!args.times_only).then(|| yardsticks(args, &session, size, &parts)).transpose()?;
    let mut described = BTreeMap::new();
    Origin::of_frame(&session.scene, &session.camera.at(0.0), &params).describe(&mut described);
    let info = session.device.info();
    let file = BenchFile {
        format: FORMAT,
        command: command_line(),
        version: env!("CARGO_PKG_VERSION").into(),
        device: info.name.clone(),
        driver: info.driver_line(),
        backend: session.gpu.backend().to_string(),
        scene: session.scene.name.clone(),
        fingerprint: session.scene.fingerprint(),
        camera: described.remove(keys::CAMERA).unwrap_or_default(),
        size,
        frame_size: whole.frame_size(),
        seed: args.seed,
        warm_up: pt_core::harness::WARM_UP,
        frames: args.frames,
        rounds: vec![args.rounds],
        profile: args.profile.clone(),
        set: args.set.clone(),
        yardsticks,
        parts,
    };
    write!(out, "{file}")?;
    if let Some(path) = &args.json {
        let earlier = args.append.then(|| read_earlier(path)).transpose()?.flatten();
        let file = match earlier {
            Some(earlier) => file
                .behind(earlier)
                .with_context(|| format!("{}: holds another benchmark", path.display()))?,
            None => file,
        };
        write_atomic(path, serde_json::to_string(&file)?.as_bytes())?;
    }
    Ok(true)
}

/// What the passes are compared with: the device's copy bandwidth, and the rates of the kinds of rays that the passes trace.
fn yardsticks(
    args: &BenchFrameArgs,
    session: &Session,
    size: [u32; 2],
    parts: &[file::Part],
) -> Result<Yardsticks> {
    let copy = copy_bandwidth(&session.device, size, args.frames)?;
    let traced = |kind: &RayKind| {
        parts
            .iter()
            .flat_map(|part| &part.passes)
            .any(|pass| pass.rays.is_some_and(|rays| rays.kind == *kind))
    };
    let kinds: Vec<_> = RayKind::ALL.into_iter().filter(traced).collect();
    let geometry = (&mesh_geometry(&session.scene)[..], &placements(&session.scene)[..]);
    let camera = camera_record(&session.camera.at(0.0), size);
    let options = BenchOptions { size, windows: RATE_WINDOWS, seed: 0 };
    let rays = (session.gpu.backend(), &kinds[..]);
    Ok(Yardsticks {
        copy_gb_per_s: copy.gb_per_s,
        copy: copy.fastest,
        mrays_per_s: rates(&session.device, geometry, &camera, rays, options)?,
    })
}

/// The file that a run is added to, if there is one.
fn read_earlier(path: &Path) -> Result<Option<BenchFile>> {
    if path.exists() { Ok(Some(BenchFile::read(path)?)) } else { Ok(None) }
}

/// The command that was given, for a shell.
fn command_line() -> String {
    let quoted =
        |word: String| match word.chars().all(|c| c.is_ascii_alphanumeric() || "-_./=,:@+".contains(c)) {
            true if !word.is_empty() => word,
            _ => format!("'{}'", word.replace('\'', r"'\''")),
        };
    let words = std::env::args_os().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    std::iter::once("pt".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
