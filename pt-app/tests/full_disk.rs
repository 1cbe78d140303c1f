//! A disk that becomes full while `pt study` runs, merges or reports: one line, nothing half-written, and the work goes on with more room.
//!
//! A study runs on a small file system in memory. Merging and reporting need no device, so that a limit on the size of files will do, which every
//! machine has; drivers of CPU devices do not survive it.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// Four cells.
const STUDY: &str = r#"
# What a study is for is in its file, and the file is in study.json, so that a few sentences make that larger than the first limit. These are such
# sentences: they have no other purpose than to be there, and to be long, and to be copied, and they are still not quite long enough, but the record
# of the variants, of the device and of the metrics adds the rest.
scenes = ["plane"]
sizes = ["32x24"]
backends = ["compute"]
seeds = 2
frames = 2
spp = 2
metrics = ["relmse"]
set = { indirect.bounces = 0, reference.max_bounces = 0 }

[[axis]]
name = "placebo"
values = ["a", "b"]
"#;

fn pt(folder: &Path, line: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

fn succeeds(folder: &Path, line: &str) {
    let done = pt(folder, line);
    assert!(done.status.success(), "pt {line}: {done:?}");
}

/// Files of at most `kib` KiB can be written. The signal is ignored, so that writing fails instead.
fn limited(folder: &Path, line: &str, kib: u32) -> Output {
    let script = format!("trap '' XFSZ; ulimit -f {kib}; exec \"$0\" {line}");
    let mut shell = Command::new("bash");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_pt")]).current_dir(folder).output().unwrap()
}

/// All files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type().unwrap().is_dir() {
            true => found.extend(files(&entry.path())),
            false => found.push(entry.path()),
        }
    }
    found
}

/// No part of a file is there, and what is there can be read.
fn nothing_is_half_written(folder: &Path) {
    for file in files(folder) {
        let name = file.display();
        assert!(!name.to_string().ends_with(".tmp"), "{name}");
        match file.extension().and_then(|e| e.to_str()) {
            Some("json") => {
                drop(serde_json::from_slice::<serde_json::Value>(&fs::read(&file).unwrap()).unwrap())
            }
            Some("jsonl") => {
                let text = fs::read_to_string(&file).unwrap();
                assert!(text.ends_with('\n'), "{name}");
                for line in text.lines() {
                    serde_json::from_str::<serde_json::Value>(line).unwrap();
                }
            }
            Some("exr" | "png") => drop(pt_image::image_file::LinearImage::read(&file).unwrap()),
            Some("html") => {
                assert!(fs::read_to_string(&file).unwrap().trim_end().ends_with("</html>"), "{name}")
            }
            _ => {}
        }
    }
}

/// The file that a command could not write, by its extension; `None`: it succeeded. What is in `out` is whole.
fn refused(done: &Output, out: &Path) -> Option<String> {
    nothing_is_half_written(out);
    let said = String::from_utf8_lossy(&done.stderr);
    if done.status.success() {
        return None;
    }
    // The progress comes before it.
    let errors: Vec<&str> = said.lines().filter(|line| !line.starts_with("cell ")).collect();
    assert_eq!((done.status.code(), errors.len()), (Some(2), 1), "{said}");
    println!("{}", errors[0]);
    let (what, cause) = errors[0].split_once("cannot write ").unwrap().1.split_once(": ").unwrap();
    assert!(cause.starts_with("No space left") || cause.starts_with("File too large"), "{said}");
    assert!(errors[0].starts_with("error: ") && !said.contains(".tmp"), "{said}");
    Some(Path::new(what).extension().unwrap().to_string_lossy().into_owned())
}

/// Runs a command with more and more room until it succeeds; the files that it could not write.
fn with_more_and_more_room(at: &Path, out: &str, line: &str) -> Vec<String> {
    let limits = [1, 2, 4, 8, 16, 32, 64, 128, 256];
    limits.iter().map_while(|&kib| refused(&limited(at, line, kib), &at.join(out))).collect()
}

/// A file system in memory, which only this process and the commands of [`Disk::run`] see.
struct Disk {
    holder: Child,
    at: PathBuf,
}

impl Disk {
    /// At the folder `disk` in `at`.
    fn mount(at: &Path) -> Self {
        fs::create_dir(at.join("disk")).unwrap();
        let script = "mount -t tmpfs -o size=4k tmpfs disk && echo mounted && read";
        let mut holder = Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "bash", "-c", script])
            .current_dir(at)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = String::new();
        BufReader::new(holder.stdout.as_mut().unwrap()).read_line(&mut said).unwrap();
        let disk = Self { holder, at: at.into() };
        assert_eq!(said, "mounted\n");
        disk
    }

    /// The folder as this process sees it; what is there can be read.
    fn path(&self) -> PathBuf {
        let seen = self.at.canonicalize().unwrap();
        Path::new(&format!("/proc/{}/root", self.holder.id()))
            .join(seen.strip_prefix("/").unwrap())
            .join("disk")
    }

    /// Runs pt with a disk of `kib` KiB.
    fn run(&self, line: &str, kib: u32) -> Output {
        let script = format!("cd {:?} && mount -o remount,size={kib}k disk && exec \"$0\" {line}", self.at);
        let holder = self.holder.id().to_string();
        let mut enter = Command::new("nsenter");
        enter.args([
            "--target",
            &holder,
            "--user",
            "--mount",
            "--preserve-credentials",
            "bash",
            "-c",
            &script,
        ]);
        enter.arg(env!("CARGO_BIN_EXE_pt")).output().unwrap()
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // The end of its input ends the holder, and with it the file system.
        drop(self.holder.stdin.take());
        let _ = self.holder.wait();
    }
}

#[test]
#[cfg_attr(not(tmpfs), ignore = "needs unshare and nsenter, and a kernel that lets them mount")]
fn a_study_goes_on_when_the_disk_has_room_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("study.toml"), STUDY).unwrap();
    succeeds(at, "study study.toml -o whole");
    let disk = Disk::mount(at);
    let out = disk.path().join("out");
    let mut files = Vec::new();
    for kib in [4, 24, 40, 48, 64, 80, 256] {
        let resume = if out.join("study.json").exists() { "--resume" } else { "" };
        let done = disk.run(&format!("study study.toml -o disk/out {resume}"), kib);
        files.extend(refused(&done, &out));
    }
    for file in ["exr", "jsonl", "html"] {
        assert!(files.iter().any(|refused| refused == file), "{file} is not among {files:?}");
    }
    let bytes = |folder: &Path| fs::read(folder.join("results.jsonl")).unwrap();
    assert!(bytes(&out) == bytes(&at.join("whole")), "the bytes of a study with room");
    assert!(out.join("report.html").exists());
}

#[test]
fn merging_and_reporting_go_on_when_the_disk_has_room_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("study.toml"), STUDY).unwrap();
    for shard in [1, 2] {
        succeeds(at, &format!("study study.toml --cache cache --shard {shard}/2 -o shard{shard}"));
    }
    succeeds(at, "study merge shard1 shard2 -o whole");
    let files = with_more_and_more_room(at, "merged", "study merge shard1 shard2 -o merged");
    for file in ["json", "jsonl", "html"] {
        assert!(files.iter().any(|refused| refused == file), "{file} is not among {files:?}");
    }
    let bytes = |name: &str| fs::read(at.join(name).join("results.jsonl")).unwrap();
    assert!(bytes("merged") == bytes("whole"));

    // An old report stays as it is until there is room.
    let report = at.join("whole/report.html");
    fs::write(&report, "<html>old</html>").unwrap();
    assert_eq!(refused(&limited(at, "study report whole", 1), &at.join("whole")).as_deref(), Some("html"));
    assert_eq!(fs::read_to_string(&report).unwrap(), "<html>old</html>");
    succeeds(at, "study report whole");
    assert!(fs::read(&report).unwrap().len() > 10_000);
    // A shard cannot be the whole.
    let done = pt(at, "study merge shard1 shard2 -o shard1");
    assert!(String::from_utf8_lossy(&done.stderr).contains("shard1: is a shard and the output"), "{done:?}");
}
