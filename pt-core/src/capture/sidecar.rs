//! The JSON file beside a recorded frame: cameras, seed, knobs, device.

use pt_shaders::glam::{Mat4, Vec2};
use pt_shaders::records::{CameraRecord, FrameRecord};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A camera as kernels see it; see [`CameraRecord`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CapturedCamera {
    /// View from world, column by column.
    pub view_from_world: [f32; 16],
    /// Its inverse, column by column.
    pub world_from_view: [f32; 16],
    /// Half the image plane at distance 1 (perspective) or in metres (orthographic).
    pub half_extent: [f32; 2],
    /// Thin lens radius, metres.
    pub lens_radius: f32,
    /// Distance in focus, metres.
    pub focus_distance: f32,
    /// 0 = perspective, 1 = orthographic.
    pub projection: u32,
}

impl From<&CameraRecord> for CapturedCamera {
    fn from(camera: &CameraRecord) -> Self {
        Self {
            view_from_world: camera.view_from_world.to_cols_array(),
            world_from_view: camera.world_from_view.to_cols_array(),
            half_extent: camera.half_extent.into(),
            lens_radius: camera.lens_radius,
            focus_distance: camera.focus_distance,
            projection: camera.projection,
        }
    }
}

impl From<&CapturedCamera> for CameraRecord {
    fn from(camera: &CapturedCamera) -> Self {
        Self {
            view_from_world: Mat4::from_cols_array(&camera.view_from_world),
            world_from_view: Mat4::from_cols_array(&camera.world_from_view),
            half_extent: Vec2::from(camera.half_extent),
            lens_radius: camera.lens_radius,
            focus_distance: camera.focus_distance,
            projection: camera.projection,
            pad: [0; 3],
        }
    }
}

/// The JSON file beside a recorded frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sidecar {
    /// Version of the program that recorded it.
    pub version: String,
    /// Frames since the start of the run.
    pub frame: u32,
    /// Time in the scene's animation, seconds.
    pub time: f64,
    /// Full frame in pixels.
    pub size: [u32; 2],
    /// Seed of the run, as kernels see it.
    pub seed: u32,
    /// Where in its pixels the frame was sampled, from the centre, pixels.
    pub jitter: [f32; 2],
    /// Seconds since the last frame, for eye adaptation; `null`: no adaptation.
    pub time_step: Option<f32>,
    /// The frame's camera.
    pub camera: CapturedCamera,
    /// The last frame's camera.
    pub camera_previous: CapturedCamera,
    /// All knobs.
    pub params: serde_json::Value,
    /// Vulkan device.
    pub device: String,
    /// Driver's name and version.
    pub driver: String,
    /// Trace backend.
    pub backend: String,
    /// Whether the frame had histories of a frame before it.
    pub has_history: bool,
    /// Histories that the frame started with, recorded as layers `history.NAME`. Only in the first frame of a capture that does not
    /// begin with the first frame of its run.
    pub histories: Vec<String>,
    /// Buffers with state that the frame started with, by name, as hexadecimal bytes.
    pub state: BTreeMap<String, String>,
}

impl Sidecar {
    /// The uniforms that the frame was recorded with.
    pub fn record(&self) -> FrameRecord {
        let (camera, previous) = ((&self.camera).into(), (&self.camera_previous).into());
        FrameRecord::new(camera, previous, self.size, self.frame, self.seed)
    }
}

/// Bytes as hexadecimal digits.
pub fn to_hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Bytes from hexadecimal digits; `None` for any other text.
pub fn from_hex(text: &str) -> Option<Vec<u8>> {
    if !text.is_ascii() || !text.len().is_multiple_of(2) {
        return None;
    }
    (0..text.len()).step_by(2).map(|i| u8::from_str_radix(&text[i..i + 2], 16).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_come_back_bit_by_bit() {
        let camera = CameraRecord {
            view_from_world: Mat4::from_cols_array(&std::array::from_fn(|i| (i as f32 + 0.1).sin() * 1e-3)),
            world_from_view: Mat4::from_cols_array(&std::array::from_fn(|i| 1.0 / (i as f32 + 3.0))),
            half_extent: Vec2::new(0.1, 1.0 / 3.0),
            lens_radius: 1e-20,
            focus_distance: 16_777_217.0,
            projection: 1,
            pad: [0; 3],
        };
        let text = serde_json::to_string(&CapturedCamera::from(&camera)).unwrap();
        let back: CapturedCamera = serde_json::from_str(&text).unwrap();
        assert_eq!(CameraRecord::from(&back), camera);
    }

    #[test]
    fn hexadecimal_digits() {
        assert_eq!(to_hex(&[0, 171, 255]), "00abff");
        assert_eq!(from_hex("00abff"), Some(vec![0, 171, 255]));
        assert_eq!(from_hex("0"), None);
        assert_eq!(from_hex("zz"), None);
    }
}
