//! Files with the way of a camera: `pt view` records them, `--camera-path` plays them.

use anyhow::{Context, Result, ensure};
use pt_image::atomic_file::write_atomic;
use pt_scene::{Camera, CameraKey, CameraPath};
use pt_shaders::glam::Vec3;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// Vertical field of view, degrees.
    vfov: f32,
    stations: Vec<Station>,
}

/// A station of the way; the camera goes smoothly through all of them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Station {
    /// Scene time, seconds.
    time: f64,
    /// Position of the camera, metres.
    position: [f32; 3],
    /// The point that it looks at, metres.
    target: [f32; 3],
}

/// Reads a way. The camera rests before its first station and after its last one.
///
/// # Errors
/// A file that can't be read, is none of these, or has fewer than two stations or times that do not rise.
pub fn read(path: &Path) -> Result<Camera> {
    let name = path.display();
    let bytes = pt_image::atomic_file::read(path)?;
    let file: File = serde_json::from_slice(&bytes).with_context(|| format!("camera path {name}"))?;
    let vfov_is_right = file.vfov > 0.0 && file.vfov < 180.0;
    ensure!(vfov_is_right, "camera path {name}: vfov is {}, expected degrees between 0 and 180", file.vfov);
    let key = |s: &Station| CameraKey {
        time: s.time,
        position: Vec3::from(s.position),
        target: Vec3::from(s.target),
    };
    for (i, station) in file.stations.iter().enumerate() {
        ensure!(
            station.position != station.target,
            "camera path {name}: position and target of station {i} are the same point"
        );
    }
    let way = CameraPath::new(file.stations.iter().map(key).collect());
    let way =
        way.with_context(|| format!("camera path {name}: it needs two stations or more, with rising times"))?;
    Ok(Camera::on_path("path", way, file.vfov.to_radians()))
}

/// Writes a way. `vfov`: vertical field of view, degrees.
///
/// # Errors
/// A file that can't be written.
pub fn write(path: &Path, vfov: f32, keys: &[CameraKey]) -> Result<()> {
    let station = |key: &CameraKey| Station {
        time: key.time,
        position: key.position.to_array(),
        target: key.target.to_array(),
    };
    let file = File { vfov, stations: keys.iter().map(station).collect() };
    Ok(write_atomic(path, serde_json::to_string_pretty(&file)?.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_goes_through_its_stations() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("way.json");
        let key = |i: u8| CameraKey {
            time: 3.0 + f64::from(i) / 60.0,
            position: Vec3::new(0.1 * f32::from(i), 1.0 / 3.0, 2.0),
            target: Vec3::new(0.0, f32::from(i), -1.0),
        };
        let keys: Vec<_> = (0..5).map(key).collect();
        write(&path, 47.3, &keys).unwrap();
        let camera = read(&path).unwrap();
        assert_eq!(camera.path.as_ref().unwrap().keys(), keys);
        assert_eq!(camera.projection, pt_scene::Projection::Perspective { yfov: 47.3f32.to_radians() });
        for key in &keys {
            assert_eq!(camera.at(key.time).position(), key.position, "the clock is that of the scene");
        }
        assert_eq!(camera.at(0.0).position(), keys[0].position, "it rests before");
    }

    #[test]
    fn what_is_no_way_is_refused_in_words() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("way.json");
        let station = r#"{"time":0,"position":[0,0,0],"target":[0,0,-1]}"#;
        for (text, says) in [
            ("{}".to_owned(), "vfov"),
            (format!(r#"{{"vfov":50,"stations":[{station}]}}"#), "two stations"),
            (format!(r#"{{"vfov":50,"stations":[{station},{station}]}}"#), "rising times"),
            (format!(r#"{{"vfov":200,"stations":[{station}]}}"#), "between 0 and 180"),
            (
                r#"{"vfov":50,"stations":[{"time":0,"position":[0,0,0],"target":[0,0,0]}]}"#.into(),
                "same point",
            ),
        ] {
            std::fs::write(&path, text).unwrap();
            let message = format!("{:#}", read(&path).unwrap_err());
            assert!(message.contains(says) && message.contains("way.json"), "{message}");
        }
    }
}
