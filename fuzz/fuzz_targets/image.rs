//! Image files of textures: PNG, JPEG, WebP, DDS or KTX2 by their first bytes; with mips of small ones.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pt_scene::{Texture, TextureUsage};

fuzz_target!(|bytes: &[u8]| {
    match pt_import::decode_texture("fuzz", bytes, TextureUsage::Normal, 1 << 16) {
        Ok(texture) => {
            texture.texel(texture.width - 1, texture.height - 1);
            if texture.width * texture.height <= 1 << 12 {
                let last = texture.mips().pop().expect("a chain has a level");
                assert!(!last.texels.is_empty());
            }
        }
        Err(error) => assert!(!error.contains('\n')),
    }
});
