//! KTX2 files in the codecs of Basis Universal.

use basisu::{DecodeFlags, TargetFormat, Transcoder};

/// A KTX2 file in one of the Basis Universal codecs.
pub(crate) fn transcode(bytes: &[u8], width: u32, height: u32) -> Result<Vec<u8>, String> {
    let failed = |e: basisu::Error| format!("the KTX2 file can't be transcoded: {e:?}");
    check_ktx2(bytes, width, height)?;
    let transcoder = Transcoder::new(bytes).map_err(failed)?;
    if transcoder.layer_count() > 1 || transcoder.face_count() > 1 || transcoder.is_video() {
        return Err("is a KTX2 array, cube map or video; only 2D textures are supported".into());
    }
    let texels = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(failed)?;
    if texels.len() as u64 != u64::from(width) * u64::from(height) * 4 {
        return Err(format!("{} bytes for {width}x{height}", texels.len()));
    }
    Ok(texels)
}

/// The transcoder trusts the offsets of the header and allocates what the level index asks for (KTX 2.0, sections 3.3 to 3.9).
fn check_ktx2(bytes: &[u8], width: u32, height: u32) -> Result<(), String> {
    let word =
        |at: usize| bytes.get(at..at + 4).map(|w| u64::from(u32::from_le_bytes([w[0], w[1], w[2], w[3]])));
    let long = |at: usize| Some(word(at)? | word(at + 4)? << 32);
    let inside =
        |offset: u64, length: u64| offset.checked_add(length).is_some_and(|end| end <= bytes.len() as u64);
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    let level = |at: usize| Some(inside(long(at)?, long(at + 8)?) && long(at + 16)? <= 16 * blocks);
    let fits = || {
        let levels = word(40)?.max(1);
        let index = levels <= 32 && (0..levels as usize).all(|i| level(80 + 24 * i) == Some(true));
        let tables =
            inside(word(48)?, word(52)?) && inside(word(56)?, word(60)?) && inside(long(64)?, long(72)?);
        Some(index && tables)
    };
    if fits() == Some(true) { Ok(()) } else { Err("the KTX2 file's header does not fit its content".into()) }
}
