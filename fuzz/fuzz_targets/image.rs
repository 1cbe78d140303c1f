//! Image files of textures: PNG, JPEG, WebP, DDS or KTX2 by their first bytes, as normal maps and as colours; with mips of small ones.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pt_scene::TextureUsage;

fuzz_target!(|bytes: &[u8]| {
    for usage in [TextureUsage::Normal, TextureUsage::Cutout] {
        match pt_import::decode_texture("fuzz", bytes, usage, 1 << 16) {
            Ok(texture) => {
                texture.texel(texture.width - 1, texture.height - 1);
                if texture.width * texture.height <= 1 << 12 {
                    let last = texture.mips().pop().expect("a chain has a level");
                    assert!(!last.texels.is_empty());
                }
            }
            Err(error) => assert!(!error.contains('\n')),
        }
    }
});
