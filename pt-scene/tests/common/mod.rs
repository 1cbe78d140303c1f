//! What the integration tests share.
#![allow(dead_code, reason = "each test program uses a part")]

pub mod records;

use std::path::{Path, PathBuf};

/// The folder with test data beside the workspace; `None`, with a printed line, where it is missing.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(folder);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}
