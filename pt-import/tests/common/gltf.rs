//! Small glTF files made in code.

use pt_import::{LoadOptions, load, load_bytes};
use pt_scene::{Scene, SceneError};
use pt_test_data::shared;
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const I8: u32 = 5120;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A GLB in the making: binary data that grows, and the JSON round it.
pub struct Glb {
    pub json: Value,
    pub binary: Vec<u8>,
}

/// Little-endian bytes of anything that has them.
pub fn bytes<T: Copy, const N: usize>(values: &[T], le: fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&v| le(v)).collect()
}

impl Glb {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "buffers": [{}], "bufferViews": [], "accessors": [],
            "meshes": [], "nodes": [], "scenes": [{"nodes": []}]
        });
        Self { json, binary: Vec::new() }
    }

    /// Appends to an array at the top of the JSON and returns the index.
    pub fn push(&mut self, array: &str, value: Value) -> usize {
        let list = self.json[array].as_array_mut().expect("an array");
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, data: &[u8], stride: Option<usize>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": data.len()});
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.binary.extend_from_slice(data);
        self.push("bufferViews", view)
    }

    /// An accessor over a buffer view of its own.
    pub fn accessor(&mut self, data: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(data, None);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count,
                "min": [0, 0, 0], "max": [1, 1, 1]}),
        )
    }

    pub fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let components = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        self.accessor(&bytes(values, f32::to_le_bytes), F32, kind, values.len() / components)
    }

    /// A mesh of one primitive on a node of the first scene.
    pub fn show(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({"primitives": [primitive]}));
        let node = self.push("nodes", json!({"mesh": mesh}));
        self.json["scenes"][0]["nodes"].as_array_mut().expect("an array").push(node.into());
        node
    }

    /// The bytes of the file.
    pub fn file(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"][0] == json!({}) {
            json["buffers"][0] = json!({"byteLength": self.binary.len()});
        }
        json.as_object_mut().expect("an object").retain(|_, value| *value != json!([]));
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut data = self.binary.clone();
        data.resize(data.len().next_multiple_of(4), 0);
        let word = |n: usize| (n as u32).to_le_bytes();
        let total = 12 + 8 + text.len() + 8 + data.len();
        [
            b"glTF",
            &word(2)[..],
            &word(total),
            &word(text.len()),
            b"JSON",
            &text,
            &word(data.len()),
            b"BIN\0",
            &data,
        ]
        .concat()
    }

    pub fn load_with(&self, options: &LoadOptions) -> Result<Scene, SceneError> {
        load_bytes(self.file(), "test.glb", options)
    }

    pub fn load(&self) -> Result<Scene, SceneError> {
        self.load_with(&plain())
    }

    /// The scene, which must load without any notice.
    pub fn load_clean(&self) -> Scene {
        let scene = self.load().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.notices, [""; 0]);
        scene
    }

    /// The one line of an error, which must name the file.
    pub fn refusal(&self) -> String {
        let text = self.load().expect_err("must be refused").to_string();
        assert!(text.starts_with("test.glb: ") && !text.contains('\n'), "{text}");
        text
    }
}

/// Without the sky that unlit scenes get.
pub fn plain() -> LoadOptions {
    LoadOptions { default_sky: false, ..LoadOptions::default() }
}

/// A file of the shared scenes.
pub fn shared_scene(file: &str, options: &LoadOptions) -> Scene {
    load(shared("scenes").join(file), options).unwrap_or_else(|e| panic!("{e}"))
}
