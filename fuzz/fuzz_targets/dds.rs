//! DDS files: read, written and read again, decoded.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pt_import::DdsTexture;

fuzz_target!(|bytes: &[u8]| {
    match DdsTexture::from_bytes(bytes) {
        Ok(dds) => {
            let again = DdsTexture::from_bytes(&dds.to_bytes().expect("what was read can be written"));
            let again = again.expect("what was written can be read");
            assert_eq!((again.levels, again.format), (dds.levels.clone(), dds.format));
            if dds.width * dds.height < 1 << 16 {
                dds.format.decode([dds.width, dds.height], &dds.levels[0]);
            }
        }
        Err(error) => assert!(!error.contains('\n')),
    }
});
