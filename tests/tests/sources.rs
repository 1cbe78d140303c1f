//! No test is forgotten: every file of tests is compiled.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// The tests of a crate are modules of one program, `tests/main.rs`. Cargo finds this file alone.
#[test]
fn every_file_of_tests_is_a_module() {
    let mut modules = 0;
    for member in entries(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..")) {
        let folder = member.join("tests");
        if !folder.is_dir() || !member.join("Cargo.toml").is_file() {
            continue;
        }
        let main = fs::read_to_string(folder.join("main.rs"))
            .unwrap_or_else(|e| panic!("{}: {e}", folder.join("main.rs").display()));
        for path in entries(&folder) {
            let is_module = path.extension() == Some(OsStr::new("rs")) || path.join("mod.rs").is_file();
            let stem = path.file_stem().and_then(OsStr::to_str).unwrap();
            if is_module && stem != "main" {
                let line = format!("mod {stem};");
                assert!(
                    main.lines().any(|l| l == line),
                    "{}: tests/main.rs has no \"{line}\"",
                    path.display()
                );
                modules += 1;
            }
        }
    }
    assert!(modules > 100, "{modules} modules: the crates were not found");
}
