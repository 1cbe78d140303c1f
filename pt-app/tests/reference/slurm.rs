//! The script that renders a reference as a Slurm array, on a cluster of this machine alone.

use super::{SMALL, succeeds};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/slurm").join(name)
}

/// A cluster that is stopped when it is dropped.
struct Cluster {
    folder: tempfile::TempDir,
}

impl Cluster {
    fn start() -> Self {
        let cluster = Self { folder: tempfile::tempdir().unwrap() };
        let done = cluster.control("start");
        assert!(done.status.success(), "{done:?}");
        cluster
    }

    fn control(&self, what: &str) -> Output {
        Command::new(script("test_cluster.sh")).arg(what).arg(self.folder.path()).output().unwrap()
    }

    /// Runs a script of the folder with `line`; its exit code and what it said.
    fn submit(&self, at: &Path, name: &str, line: &str) -> (Option<i32>, String) {
        let mut program = Command::new(script(name));
        program.current_dir(at).args(line.split_whitespace());
        let done = program.env("SLURM_CONF", self.folder.path().join("slurm.conf")).output().unwrap();
        let said = [done.stdout, done.stderr].concat();
        (done.status.code(), String::from_utf8(said).unwrap())
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        self.control("stop");
    }
}

/// A program that stands for pt: of the two slices it kills the second one the first time, after a checkpoint.
fn killed_once(folder: &Path) -> PathBuf {
    let pt = env!("CARGO_BIN_EXE_pt");
    let device =
        std::env::var("PT_TEST_DEVICE").map_or(String::new(), |device| format!(" --device '{device}'"));
    let text = format!(
        r#"#!/bin/bash
options=()
[[ $1 != reference ]] || options=({device})
if [[ $* == *"--spp-range 5..10"* && ! -e {marker} ]]; then
    touch {marker}
    {pt} "$@" "${{options[@]}}" --time-limit 0.0001 --checkpoint-interval 0
    kill -9 $$
fi
exec {pt} "$@" "${{options[@]}}"
"#,
        marker = folder.join("was_killed").display()
    );
    program(&folder.join("pt"), &text)
}

/// A program that runs `pt study`: the second of two shards is killed the first time, once it has begun.
fn study_killed_once(folder: &Path) -> PathBuf {
    let pt = env!("CARGO_BIN_EXE_pt");
    let device =
        std::env::var("PT_TEST_DEVICE").map_or(String::new(), |device| format!(" --device '{device}'"));
    let text = format!(
        r#"#!/bin/bash
[[ $2 != merge ]] || exec {pt} "$@"
if [[ $* == *"--shard 2/2"* && ! -e {marker} ]]; then
    touch {marker}
    {pt} "$@"{device} &
    until [[ -e ${{*: -1}}/study.json ]] || ! kill -0 $! 2>/dev/null; do sleep 0.01; done
    kill -9 $!
    wait $!
    exit 1
fi
exec {pt} "$@"{device}
"#,
        marker = folder.join("study_was_killed").display()
    );
    program(&folder.join("pt-study"), &text)
}

/// Two variants with a denoiser's noise, two seeds, in a picture of 16 x 9 pixels.
const STUDY: &str = r#"
scenes = ["cornell"]
sizes = ["16x9"]
backends = ["compute"]
seeds = 2
frames = 2
spp = 4
metrics = ["relmse"]
set = { indirect.bounces = 0, reference.max_bounces = 0 }

[[axis]]
key = "denoise.variant"
values = ["off", "svgf"]
"#;

fn program(path: &Path, text: &str) -> PathBuf {
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    path.to_owned()
}

/// A slice that is killed goes on, the array has the bits of a render of the same slices on this machine, and a slice that fails leaves the
/// finished one where it is.
#[test]
#[cfg_attr(not(slurm), ignore = "needs Slurm and root: scripts/setup-slurm.sh installs it")]
fn an_array_of_slices_has_the_bits_of_local_ones() {
    let cluster = Cluster::start();
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let pt = killed_once(at);
    let render = format!("cornell {SMALL} --spp 10 --no-aov");
    let submit = format!("--slices 2 --pt {} --wait --", pt.display());
    let (code, said) = cluster.submit(at, "reference.sh", &format!("{submit} {render} -o array.exr"));
    let logs = || {
        let logs = fs::read_dir(at.join("array.exr.slices")).unwrap().map(|entry| entry.unwrap().path());
        logs.filter(|path| path.extension().is_some_and(|e| e == "txt"))
            .map(|path| fs::read_to_string(path).unwrap())
            .collect::<String>()
    };
    assert_eq!(code, Some(0), "{said}\n{}", logs());
    assert!(logs().contains("attempt 2 of 3") && at.join("was_killed").exists(), "{}", logs());
    for (name, range) in [("a", "0..5"), ("b", "5..10")] {
        succeeds(at, &format!("reference {render} --spp-range {range} -o {name}.exr"));
    }
    succeeds(at, "merge a.exr b.exr --no-aov -o local.exr");
    assert!(fs::read(at.join("array.exr")).unwrap() == fs::read(at.join("local.exr")).unwrap());

    // A scene that is not there: nothing is joined, and the folder with the logs is named.
    let (code, said) = cluster.submit(
        at,
        "reference.sh",
        &format!("--retries 0 {submit} missing.gltf --spp 4 -o other.exr"),
    );
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("other.exr.slices") && !at.join("other.exr").exists(), "{said}");
    // Other work does not take its folder.
    let (code, said) = cluster.submit(at, "reference.sh", &format!("{submit} cornell --spp 4 -o other.exr"));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("holds the parts of other work"), "{said}");

    // A study in two shards, one of which is killed and goes on: the bytes of the study on this machine.
    fs::write(at.join("mine.toml"), STUDY).unwrap();
    let line = format!(
        "--shards 2 --pt {} --wait -- mine.toml --cache array_references -o results",
        study_killed_once(at).display()
    );
    let (code, said) = cluster.submit(at, "study.sh", &line);
    let log = |name: &str| fs::read_to_string(at.join("results.shards").join(name)).unwrap_or_default();
    assert_eq!(code, Some(0), "{said}\n{}{}{}", log("log_0.txt"), log("log_1.txt"), log("log_join.txt"));
    assert!(log("log_1.txt").contains("attempt 2 of 3") && at.join("study_was_killed").exists(), "{said}");
    let mut local = vec!["study", "mine.toml", "--cache", "local_references", "-o", "local"];
    let device = std::env::var("PT_TEST_DEVICE");
    local.extend(device.iter().flat_map(|device| ["--device", device.as_str()]));
    let done = Command::new(env!("CARGO_BIN_EXE_pt")).current_dir(at).args(local).output().unwrap();
    assert!(done.status.success(), "{done:?}");
    let bytes = |folder: &str| fs::read(at.join(folder).join("results.jsonl")).unwrap();
    let (array, local) = (bytes("results"), bytes("local"));
    assert_eq!(array.iter().filter(|byte| **byte == b'\n').count(), 4, "cells");
    assert!(array == local, "the array has the bytes of the study on this machine");
    assert!(at.join("results/report.html").is_file());
}

/// Without a cluster, too: what is wrong is said in one line.
#[test]
fn wrong_submissions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pt = env!("CARGO_BIN_EXE_pt");
    for (name, line, part) in [
        ("reference.sh", "--slices many -- cornell --spp 4 -o a.exr", "'many' is no number"),
        ("reference.sh", "--slice 2 -- cornell --spp 4 -o a.exr", "unknown option '--slice'"),
        ("reference.sh", "--slices 2", "the arguments of pt are missing"),
        ("study.sh", "--shards", "--shards needs a value"),
    ] {
        let done = Command::new(script(name))
            .current_dir(folder.path())
            .args(["--pt", pt])
            .args(line.split_whitespace())
            .output()
            .unwrap();
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{name} {line}: {said}");
        assert!(said.contains(part) && said.lines().count() == 1, "{name} {line}: {said}");
    }
    for name in ["reference.sh", "study.sh", "test_cluster.sh"] {
        let done = Command::new(script(name)).arg("--help").output().unwrap();
        assert!(
            done.status.success()
                && String::from_utf8(done.stdout).unwrap().contains("usage: scripts/slurm/")
        );
    }
}
