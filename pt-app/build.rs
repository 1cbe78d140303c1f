//! Tells the tests whether the shared test data are there, the Python modules of the example, Slurm, an X server without a screen, and whether file systems can be mounted; and the program its git revision.

use std::path::Path;
use std::process::Command;

fn main() {
    pt_test_data::declare();
    println!("cargo::rustc-check-cfg=cfg(python_openexr)");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/python/numpy/version.py");
    println!("cargo::rerun-if-changed=build.rs");
    if Path::new(file).exists() {
        println!("cargo::rerun-if-changed={file}");
        println!("cargo::rustc-cfg=python_openexr");
    }
    println!("cargo::rustc-check-cfg=cfg(slurm)");
    // As Debian installs it. Its daemons need root.
    let programs = ["/usr/sbin/slurmctld", "/usr/sbin/slurmd", "/usr/sbin/munged", "/usr/bin/sbatch"];
    if programs.iter().all(|program| Path::new(program).exists()) && is_root() {
        println!("cargo::rerun-if-changed={}", programs[0]);
        println!("cargo::rustc-cfg=slurm");
    }
    println!("cargo::rustc-check-cfg=cfg(xvfb)");
    if Path::new("/usr/bin/Xvfb").exists() {
        println!("cargo::rerun-if-changed=/usr/bin/Xvfb");
        println!("cargo::rustc-cfg=xvfb");
    }
    println!("cargo::rustc-check-cfg=cfg(tmpfs)");
    if can_mount() {
        println!("cargo::rustc-cfg=tmpfs");
    }
    println!(
        "cargo::rustc-env=PT_REVISION={}",
        git(&["describe", "--always", "--abbrev=12", "--exclude=*", "--dirty"])
    );
    // A commit, and a change of the program itself, give another revision.
    let log = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]);
    for path in ["src", &log].into_iter().filter(|path| Path::new(path).exists()) {
        println!("cargo::rerun-if-changed={path}");
    }
}

/// What git prints; empty where there is no git or no repository.
fn git(args: &[&str]) -> String {
    let output = Command::new("git").args(args).output().ok().filter(|output| output.status.success());
    output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default()
}

/// Whether a process may mount a file system of its own: containers and kernels forbid it to some.
fn can_mount() -> bool {
    let mount = [
        "--user",
        "--map-root-user",
        "--mount",
        "sh",
        "-c",
        "mount -t tmpfs tmpfs /tmp && command -v nsenter",
    ];
    Command::new("unshare").args(mount).output().is_ok_and(|output| output.status.success())
}

fn is_root() -> bool {
    #[cfg(unix)]
    let owner = std::fs::metadata("/proc/self").map(|own| std::os::unix::fs::MetadataExt::uid(&own));
    #[cfg(not(unix))]
    let owner: std::io::Result<u32> = Ok(1);
    owner.is_ok_and(|user| user == 0)
}
