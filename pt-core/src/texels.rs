//! Texels and the numbers that they stand for.

use crate::half_codes;
use half::f16;
use pt_shaders::channels::Format;

/// Values of texels, `format.components()` per texel.
pub(crate) fn decode_f32(format: Format, bytes: &[u8]) -> Vec<f32> {
    let u16s = |scale: f32| {
        bytes.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]])) * scale).collect()
    };
    match format {
        Format::R32F | Format::Rg32F | Format::Rgba32F => {
            bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
        }
        Format::Rgba16F => bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect(),
        Format::Rg16Unorm | Format::Rgba16Unorm => u16s(1.0 / 65535.0),
        Format::R16Uint => u16s(1.0),
        Format::Rg8Unorm | Format::Rgba8Unorm => bytes.iter().map(|&b| f32::from(b) / 255.0).collect(),
        Format::Rgba8Root => bytes.iter().map(|&b| (f32::from(b) / 255.0).powi(2)).collect(),
        Format::Half(code) => half_codes::decode(code, bytes),
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
            bytes.chunks_exact(4).map(|b| bytemuck::pod_read_unaligned::<u32>(b) as f32).collect()
        }
    }
}

/// Values of texels as integers; `None` if they are none.
pub(crate) fn decode_u32(format: Format, bytes: &[u8]) -> Option<Vec<u32>> {
    match format {
        Format::R16Uint => {
            Some(bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect())
        }
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
            Some(bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect())
        }
        _ => None,
    }
}

/// Bytes of texels from values, `format.components()` per texel.
pub(crate) fn encode_f32(format: Format, values: &[f32]) -> Vec<u8> {
    let unorm = |max: f32| move |v: &f32| (v.clamp(0.0, 1.0) * max).round();
    match format {
        Format::R32F | Format::Rg32F | Format::Rgba32F => bytemuck::cast_slice(values).to_vec(),
        Format::Rgba16F => values.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes()).collect(),
        Format::Rg16Unorm | Format::Rgba16Unorm => {
            values.iter().map(unorm(65535.0)).flat_map(|v| (v as u16).to_le_bytes()).collect()
        }
        Format::Rg8Unorm | Format::Rgba8Unorm => values.iter().map(unorm(255.0)).map(|v| v as u8).collect(),
        Format::Rgba8Root => {
            values.iter().map(|v| v.max(0.0).sqrt()).map(|v| unorm(255.0)(&v) as u8).collect()
        }
        Format::Half(code) => half_codes::encode(code, values),
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
            values.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect()
        }
        Format::R16Uint => values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
    }
}
