//! The files that a command reads: none of them may be overwritten by what it writes.

use crate::args::{CameraArgs, SceneArgs};
use crate::output::stands_for;
use anyhow::{Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Files with what they are to the command, such as `the scene`.
#[derive(Debug, Default)]
pub struct Inputs {
    files: Vec<(&'static str, PathBuf)>,
}

impl Inputs {
    /// A scene with the files that it names, its environment, the way of the camera, and a profile.
    pub fn of_scene(args: &SceneArgs, camera: &CameraArgs, profile: Option<&str>) -> Self {
        let scene = Path::new(&args.file);
        let mut inputs = Self::default().with("the scene", [scene]);
        inputs = inputs.with("a file that the scene names", files_of(scene));
        inputs = inputs.with("the environment", args.load.env.as_deref());
        inputs = inputs.with("the way of the camera", camera.camera_path.as_deref());
        inputs.with("the profile", profile.map(Path::new))
    }

    /// Adds files.
    #[must_use]
    pub fn with<P: AsRef<Path>>(mut self, what: &'static str, paths: impl IntoIterator<Item = P>) -> Self {
        // Names of built-in scenes and profiles are no files.
        let real = paths.into_iter().filter_map(|path| path.as_ref().canonicalize().ok());
        self.files.extend(real.map(|path| (what, path)));
        self
    }

    /// Checks that no output is one of the files, and that no two outputs are the same. A run of `#` in the name of an output stands for
    /// the number of a frame.
    ///
    /// # Errors
    /// The first output that would overwrite something.
    pub fn check<P: AsRef<Path>>(&self, outputs: impl IntoIterator<Item = P>) -> Result<()> {
        let outputs: Vec<_> = outputs.into_iter().collect();
        for (i, output) in outputs.iter().enumerate() {
            let output = output.as_ref();
            if let Some((what, _)) = self.files.iter().find(|(_, file)| stands_for(output, file)) {
                bail!(
                    "cannot write {}: it is {what} and would be overwritten; give another name",
                    output.display()
                );
            }
            if outputs[..i].iter().any(|other| is_same(other.as_ref(), output)) {
                bail!("cannot write {}: it is given twice; give another name", output.display());
            }
        }
        Ok(())
    }
}

/// Whether two names of outputs, which need not exist, are of one file.
fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some((folder.canonicalize().ok()?, path.file_name()?.to_owned()))
    };
    a == b || place(a).is_some_and(|at| place(b) == Some(at))
}

/// Buffers and images that a glTF file names, if they are files; empty for what is no glTF file.
fn files_of(scene: &Path) -> Vec<PathBuf> {
    let bytes = if scene.is_file() { std::fs::read(scene).unwrap_or_default() } else { Vec::new() };
    let root: Value = serde_json::from_slice(gltf_json(&bytes)).unwrap_or_default();
    let folder = scene.parent().unwrap_or(Path::new(""));
    let lists = ["buffers", "images"].into_iter().filter_map(|key| root.get(key)?.as_array());
    let uris = lists.flatten().filter_map(|entry| entry.get("uri")?.as_str());
    uris.filter(|uri| !uri.starts_with("data:")).map(|uri| folder.join(decoded(uri))).collect()
}

/// The JSON of a glTF or GLB file. GLB: a header of 12 bytes, then length and type of the JSON chunk.
pub fn gltf_json(bytes: &[u8]) -> &[u8] {
    match bytes.get(..20) {
        Some(header) if header.starts_with(b"glTF") => {
            let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]) as usize;
            bytes[20..].get(..length).unwrap_or_default()
        }
        _ => bytes,
    }
}

/// Percent encoding undone where it is valid.
fn decoded(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        let hex = tail.get(..2).filter(|_| byte == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(code) => {
                bytes.push(code);
                rest = &tail[2..];
            }
            None => {
                bytes.push(byte);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn inputs_are_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a b.png"), "").unwrap();
        fs::write(at("sky_007.exr"), "").unwrap();
        let text = r#"{"images":[{"uri":"a%20b.png"},{"uri":"data:image/png;base64,"},{"uri":"gone.png"}]}"#;
        fs::write(at("scene.gltf"), text).unwrap();
        assert_eq!(files_of(&at("scene.gltf")), [at("a b.png"), at("gone.png")]);
        let inputs = Inputs::default()
            .with("the scene", [at("scene.gltf")])
            .with("a file that the scene names", files_of(&at("scene.gltf")))
            .with("the environment", [at("sky_007.exr")]);
        let refused = |name: &str| inputs.check([at(name)]).unwrap_err().to_string();
        assert!(refused("scene.gltf").contains("it is the scene and would be overwritten"));
        assert!(refused("a b.png").contains("a file that the scene names"));
        assert!(refused("sky_007.exr").contains("the environment"));
        assert!(refused("./sky_###.exr").contains("the environment"));
        fs::create_dir(at("sub")).unwrap();
        assert!(refused("sub/../sky_007.exr").contains("the environment"));
        for name in ["sky_##b.exr", "other.exr", "sub/sky_007.exr", "sub/sky_###.exr"] {
            inputs.check([at(name)]).unwrap();
        }
        for other in ["x.png", "./x.png", "sub/../x.png"] {
            let error = inputs.check([at("x.png"), at(other)]).unwrap_err().to_string();
            assert!(error.contains("given twice"), "{error}");
        }
        inputs.check([at("x.png"), at("sub/x.png")]).unwrap();
    }
}
