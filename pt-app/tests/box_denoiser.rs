//! The stranger's task of the book, for real: a denoiser that is added to pt-denoise alone becomes a row of a study.

use std::path::Path;
use std::process::Command;

/// Builds pt-denoise and what depends on it anew, and renders tiny cells: about a minute.
#[test]
fn the_box_denoiser_becomes_a_row_of_a_study() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    // The folder of the program's profile is in the target folder that cargo uses now.
    let target = Path::new(env!("CARGO_BIN_EXE_pt")).ancestors().nth(2).unwrap();
    let done = Command::new(root.join("examples/box_denoiser/try.sh"))
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO_TERM_COLOR", "never")
        // `scripts/test.sh` sets it for this program. Build scripts of dependencies run again when it changes, and all that depends on them.
        .env_remove("RUSTC_BOOTSTRAP")
        .output()
        .unwrap();
    let (out, log) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{out}{log}");
    let row = out.lines().find(|line| line.starts_with("box "));
    assert!(row.is_some_and(|row| row.split_whitespace().nth(1) == Some("2")), "two seeds: {out}");
    let built: Vec<&str> =
        log.lines().filter_map(|line| line.trim().strip_prefix("Compiling ")?.split(' ').next()).collect();
    println!("built {built:?}");
    assert!(built.contains(&"pt-denoise") && built.contains(&"pt-app"), "{built:?}");
    // Most dependencies are built upon it, with the same features whatever else is built.
    assert!(!built.contains(&"proc-macro2"), "dependencies were built again: {built:?}");
}
