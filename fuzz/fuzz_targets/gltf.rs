//! glTF as JSON or GLB, told apart by the first bytes; everything is embedded, no file is opened.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};
use pt_import::{LoadOptions, load_bytes};

fuzz_target!(|bytes: &[u8]| -> Corpus {
    let options = LoadOptions {
        // Sizes are part of the input: what is allowed must fit in the fuzzer's own memory limit.
        max_geometry_bytes: 64 << 20,
        // Making the sky takes longer than reading most inputs.
        default_sky: false,
        ..LoadOptions::default()
    };
    match load_bytes(bytes.to_vec(), "fuzz.gltf", &options) {
        Ok(scene) => {
            let camera = scene.default_camera();
            assert!(camera.position().is_finite());
        }
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
    Corpus::Keep
});
