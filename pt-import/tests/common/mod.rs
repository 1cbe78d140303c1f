//! What the integration tests share.
#![allow(dead_code, reason = "each test program uses a part")]

pub mod gltf;
pub mod textured;

use std::path::{Path, PathBuf};

/// Every .gltf and .glb below a folder, sorted.
pub fn scene_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
