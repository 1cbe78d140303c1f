//! The command line that reproduces a picture.

use super::args::ViewArgs;
use crate::args::{CameraArgs, CameraChoice, LookAt, picture_flags};
use clap::parser::ValueSource;
use clap::{Args, Command};
use pt_view::protocol::Pose;
use std::ffi::OsString;

/// Options whose values the window may change: a hand-out says them anew. Those of `pt view` alone are left out, too.
const REPLACED: &[&str] = &[
    "file",
    "camera",
    "look",
    "vfov",
    "camera_path",
    "time",
    "hold",
    "profile",
    "set",
    "folder",
    "frames",
    "play",
];

/// The words of a command line of `pt view` that hold for `pt render` as they are: scene, size, seed, device and so on.
pub(super) fn kept_words(line: impl IntoIterator<Item = OsString>) -> Vec<String> {
    let command = ViewArgs::augment_args(Command::new("view"));
    // The first word is the program.
    let Ok(matches) = command.clone().try_get_matches_from(line.into_iter().skip(1)) else {
        return Vec::new();
    };
    let mut words = Vec::new();
    for arg in command.get_arguments() {
        let id = arg.get_id().as_str();
        let is_flag_of_knob = picture_flags().any(|name| name == id);
        if REPLACED.contains(&id)
            || is_flag_of_knob
            || matches.try_contains_id(id).is_err()
            || matches.value_source(id) != Some(ValueSource::CommandLine)
        {
            continue;
        }
        let Some(long) = arg.get_long() else { continue };
        words.push(format!("--{long}"));
        if arg.get_action().takes_values() {
            let values = matches.get_raw(id).into_iter().flatten();
            words.extend(values.map(|value| quoted(&value.to_string_lossy())));
        }
    }
    words
}

/// The camera of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum View {
    /// As the command line of the window says it.
    Asked(Vec<String>),
    /// A camera of the scene, by what `--camera` takes.
    OfScene(String),
    /// A camera that was moved.
    Free(Pose),
}

/// What a command line says of a picture.
pub(super) struct Picture<'a> {
    pub(super) scene: &'a str,
    pub(super) kept: &'a [String],
    pub(super) view: &'a View,
    /// Scene time of the first frame, seconds.
    pub(super) time: f64,
    pub(super) holds: bool,
    pub(super) frames: u32,
    /// Knobs that differ, as `--set` takes them.
    pub(super) sets: &'a [String],
}

impl Picture<'_> {
    /// The command line.
    pub(super) fn command(&self) -> String {
        let mut words = vec!["pt".to_owned(), "render".into(), quoted(self.scene)];
        words.extend_from_slice(self.kept);
        let numbers = |numbers: &[f32]| numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(",");
        match self.view {
            View::Asked(said) => words.extend_from_slice(said),
            View::OfScene(name) => words.extend(["--camera".into(), quoted(name)]),
            View::Free(Pose { eye, target, vfov }) => {
                let look = [*eye, *target].concat();
                words.extend([format!("--look={}", numbers(&look)), format!("--vfov={vfov}")]);
            }
        }
        if self.time != 0.0 {
            words.push(format!("--time={}", self.time));
        }
        if self.holds {
            words.push("--hold".into());
        }
        words.push(format!("--frames={}", self.frames));
        words.extend(self.sets.iter().map(|set| format!("--set {}", quoted(set))));
        words.push("-o picture.png".into());
        words.join(" ")
    }
}

/// The camera options of a command line of `pt view`, as they are.
pub(super) fn camera_words(camera: &CameraArgs) -> Vec<String> {
    let mut words = Vec::new();
    match &camera.camera {
        Some(CameraChoice::Index(index)) => words.push(format!("--camera={index}")),
        Some(CameraChoice::Name(name)) => words.push(format!("--camera={}", quoted(name))),
        None => {}
    }
    if let Some(LookAt { eye, target }) = camera.look {
        let look: Vec<_> = [eye, target].concat().iter().map(f32::to_string).collect();
        words.extend([format!("--look={}", look.join(",")), format!("--vfov={}", camera.vfov)]);
    }
    if let Some(path) = &camera.camera_path {
        words.push(format!("--camera-path={}", quoted(&path.to_string_lossy())));
    }
    words
}

/// For a POSIX shell.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::render::RenderArgs;

    fn kept(line: &str) -> Vec<String> {
        kept_words(line.split_whitespace().map(OsString::from))
    }

    #[test]
    fn what_the_window_can_not_change_is_kept() {
        let line = "pt view gallery --size 64x48 --seed 7 --validation --camera 1 --time 2 --frames 4 --tonemap reinhard \
                    --set lights.sun=false --profile realtime --env-rotation -30 --backend compute --bloom=gaussian --play";
        let mut words = kept(line);
        words.sort();
        assert_eq!(
            words,
            [
                "--backend",
                "--env-rotation",
                "--seed",
                "--size",
                "--validation",
                "-30",
                "64x48",
                "7",
                "compute"
            ]
        );
        assert!(kept("pt view gallery").is_empty());
    }

    #[test]
    fn a_command_line_says_the_picture_and_pt_takes_it() {
        let sets = ["lights.sun=false".to_owned(), "post.ev100=-2.5".into()];
        let pose = Pose { eye: [-1.5, 0.1, 1e-7], target: [0.0, 1.0, -3.0], vfov: 47.5 };
        let kept = kept("pt view gallery --size 64x48 --seed 7");
        let view = View::Free(pose);
        let picture = Picture {
            scene: "my scene.gltf",
            kept: &kept,
            view: &view,
            time: 1.25,
            holds: true,
            frames: 3,
            sets: &sets,
        };
        let command = picture.command();
        assert_eq!(
            command,
            "pt render 'my scene.gltf' --size 64x48 --seed 7 --look=-1.5,0.1,0.0000001,0,1,-3 --vfov=47.5 --time=1.25 --hold \
             --frames=3 --set lights.sun=false --set post.ev100=-2.5 -o picture.png"
        );
        let words = command.replace("'my scene.gltf'", "scene.gltf");
        let render = RenderArgs::augment_args(Command::new("render"));
        let matches = render.try_get_matches_from(words.split(' ').skip(1));
        assert!(matches.is_ok(), "{:?}", matches.err());
    }

    #[test]
    fn words_with_spaces_and_quotes_survive_a_shell() {
        assert_eq!(quoted("a b's"), "'a b'\\''s'");
        assert_eq!(quoted("plain-1.5,x=2"), "plain-1.5,x=2");
        assert_eq!(quoted(""), "''");
    }
}
