//! Image files of textures: PNG, JPEG, WebP, DDS or KTX2 by their first bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pt_scene::{Texture, TextureUsage};

fuzz_target!(|bytes: &[u8]| {
    match Texture::from_bytes("fuzz", bytes, TextureUsage::Normal, 1 << 16) {
        Ok(texture) => {
            texture.texel(texture.width - 1, texture.height - 1);
        }
        Err(error) => assert!(!error.contains('\n')),
    }
});
