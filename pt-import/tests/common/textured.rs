//! A triangle with textures.

use std::path::{Path, PathBuf};

/// Writes a triangle with one material to `folder`: the elements of the file's images, textures and materials as JSON.
pub fn gltf(folder: &Path, images: &str, texture: &str, material: &str) -> PathBuf {
    let positions: Vec<u8> =
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(folder.join("triangle.bin"), positions).unwrap();
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "extensionsUsed": ["EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds", "KHR_texture_transform"],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
        "buffers": [{{"uri": "triangle.bin", "byteLength": 36}}], "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                        "min": [0, 0, 0], "max": [1, 1, 0]}}],
        "images": [{images}], "textures": [{texture}], "materials": [{material}]}}"#
    );
    let file = folder.join("scene.gltf");
    std::fs::write(&file, json).unwrap();
    file
}
