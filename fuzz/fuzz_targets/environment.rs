//! Lat-long images: Radiance .hdr and OpenEXR, told apart by the first bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pt_scene::Environment;

fuzz_target!(|bytes: &[u8]| {
    match Environment::from_bytes(bytes, "fuzz.hdr") {
        Ok(environment) => assert!(environment.image.texels.iter().all(|t| t.is_finite())),
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
});
