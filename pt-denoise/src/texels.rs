//! Texel encoding for recorded inputs: the inverse of [`pt_core::Image::read_f32`] and [`pt_core::Image::read_u32`].

use half::f16;
use pt_shaders::channels::Format;

/// Bytes of texels from values, `format.components()` per texel. Normalised formats clamp to 0..1 and round to nearest,
/// integers clamp to their range and truncate; NaN gives 0 there.
pub fn encode(format: Format, values: &[f32]) -> Vec<u8> {
    let unorm = |max: f32| move |v: &f32| (v.clamp(0.0, 1.0) * max).round();
    match format {
        Format::R32F | Format::Rg32F | Format::Rgba32F => bytemuck::cast_slice(values).to_vec(),
        Format::Rgba16F => values.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes()).collect(),
        Format::Rg16Unorm | Format::Rgba16Unorm => {
            values.iter().map(unorm(65535.0)).flat_map(|v| (v as u16).to_le_bytes()).collect()
        }
        Format::Rgba8Unorm => values.iter().map(unorm(255.0)).map(|v| v as u8).collect(),
        Format::R32Uint | Format::Rg32Uint => values.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect(),
        Format::R16Uint => values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
    }
}

/// Bytes of texels of the integer formats; bits above the format's are dropped. Other formats take the numbers as values.
pub fn encode_u32(format: Format, values: &[u32]) -> Vec<u8> {
    match format {
        Format::R32Uint | Format::Rg32Uint => bytemuck::cast_slice(values).to_vec(),
        Format::R16Uint => values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
        _ => encode(format, &values.iter().map(|&v| v as f32).collect::<Vec<_>>()),
    }
}
