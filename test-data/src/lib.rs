//! Test scenes and environments that are not part of the repository: the folder `shared` beside the checkout.
//!
//! A test that needs the folder is ignored where it is missing. The build script of its crate calls [`declare`], which sets
//! `cfg(shared)`, and the test says
//!
//! ```ignore
//! #[test]
//! #[cfg_attr(not(shared), ignore = "needs ../shared")]
//! fn a_skinned_fox() {
//!     let fox = pt_test_data::shared("scenes/Fox/Fox.glb");
//! }
//! ```
//!
//! With `PT_REQUIRE_SHARED=1` the tests are compiled to run even where the folder is missing, and fail there.
//!
//! Tests that open a page in a browser do the same with [`declare_browser`], `cfg(browser)`, [`browser`] and `PT_REQUIRE_BROWSER=1`.

#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};

/// Environment variable: `1` makes a missing folder a failure.
const REQUIRE: &str = "PT_REQUIRE_SHARED";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared")
}

/// For build scripts: sets `cfg(shared)` where the folder is there or required.
///
/// Cargo runs a build script each time when it watches a file that is missing. So a missing folder is not watched, and one that
/// appears is noticed when `PT_REQUIRE_SHARED` changes.
pub fn declare() {
    println!("cargo::rustc-check-cfg=cfg(shared)");
    let there = folder().is_dir();
    if there {
        // One file stands for all: Cargo searches a watched folder to its last file.
        println!(
            "cargo::rerun-if-changed={}",
            folder().join("environments/royal_esplanade_1k.hdr").display()
        );
    } else {
        println!("cargo::rerun-if-env-changed={REQUIRE}");
    }
    if there || std::env::var_os(REQUIRE).is_some_and(|value| value == "1") {
        println!("cargo::rustc-cfg=shared");
    }
}

/// A file or folder of the shared data.
///
/// # Panics
/// When it is missing, so that the test fails.
pub fn shared(name: &str) -> PathBuf {
    let path = folder().join(name);
    assert!(path.exists(), "{} is missing; {REQUIRE}=1 makes that a failure", path.display());
    path
}

/// Environment variable: `1` makes a missing browser a failure.
const REQUIRE_BROWSER: &str = "PT_REQUIRE_BROWSER";

/// Names of browsers that speak the Chrome DevTools protocol, the leanest first.
const BROWSERS: [&str; 5] =
    ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

fn find_browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let all = BROWSERS.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    all.into_iter().find(|program| program.is_file())
}

/// For build scripts: sets `cfg(browser)` where a browser is there or required. A browser that is installed later is noticed when
/// `PATH` or `PT_REQUIRE_BROWSER` changes.
pub fn declare_browser() {
    println!("cargo::rustc-check-cfg=cfg(browser)");
    println!("cargo::rerun-if-env-changed={REQUIRE_BROWSER}");
    println!("cargo::rerun-if-env-changed=PATH");
    if let Some(browser) = find_browser() {
        println!("cargo::rerun-if-changed={}", browser.display());
        println!("cargo::rustc-cfg=browser");
    } else if std::env::var_os(REQUIRE_BROWSER).is_some_and(|value| value == "1") {
        println!("cargo::rustc-cfg=browser");
    }
}

/// The program of a browser for tests.
///
/// # Panics
/// When there is none, so that the test fails.
pub fn browser() -> PathBuf {
    let Some(browser) = find_browser() else {
        panic!("no browser: scripts/setup-browser.sh installs one; {REQUIRE_BROWSER}=1 makes that a failure");
    };
    browser
}
