//! Tells the tests whether the shared test data are there, and the Python modules of the example, and the program its git revision.

use std::process::Command;

fn main() {
    pt_test_data::declare();
    println!("cargo::rustc-check-cfg=cfg(python_openexr)");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/python/numpy/version.py");
    println!("cargo::rerun-if-changed=build.rs");
    if std::path::Path::new(file).exists() {
        println!("cargo::rerun-if-changed={file}");
        println!("cargo::rustc-cfg=python_openexr");
    }
    println!(
        "cargo::rustc-env=PT_REVISION={}",
        git(&["describe", "--always", "--abbrev=12", "--exclude=*", "--dirty"])
    );
    // A commit, and a change of the program itself, give another revision.
    let log = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]);
    for path in ["src", &log].into_iter().filter(|path| std::path::Path::new(path).exists()) {
        println!("cargo::rerun-if-changed={path}");
    }
}

/// What git prints; empty where there is no git or no repository.
fn git(args: &[&str]) -> String {
    let output = Command::new("git").args(args).output().ok().filter(|output| output.status.success());
    output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default()
}
