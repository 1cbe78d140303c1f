//! DDS files: block-compressed textures with their mip levels.

use std::io::Cursor;

use ddsfile::{AlphaMode, D3D10ResourceDimension, Dds, DxgiFormat, NewDxgiParams};

use pt_scene::BlockFormat;
use pt_scene::MAX_TEXTURE_SIDE;

/// A block-compressed 2D texture as a DDS file holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct DdsTexture {
    /// Texels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
    pub height: u32,
    /// How it is compressed.
    pub format: BlockFormat,
    /// The header says that the colour is sRGB-encoded. The use of the texture decides, not this flag.
    pub srgb: bool,
    /// From the finest mip level on, each as long as [`BlockFormat::level_bytes`] says.
    pub levels: Vec<Vec<u8>>,
}

const fn four_cc(name: &[u8; 4]) -> u32 {
    u32::from_le_bytes(*name)
}

fn format(dds: &Dds) -> Result<(BlockFormat, bool), String> {
    let Some(header) = &dds.header10 else {
        let code = dds.header.spf.fourcc.as_ref().map_or(0, |code| code.0);
        return match code {
            _ if code == four_cc(b"DXT1") => Ok((BlockFormat::Bc1, false)),
            _ if code == four_cc(b"DXT2") || code == four_cc(b"DXT3") => Ok((BlockFormat::Bc2, false)),
            _ if code == four_cc(b"DXT4") || code == four_cc(b"DXT5") => Ok((BlockFormat::Bc3, false)),
            _ if code == four_cc(b"ATI1") || code == four_cc(b"BC4U") => Ok((BlockFormat::Bc4, false)),
            _ if code == four_cc(b"ATI2") || code == four_cc(b"BC5U") => Ok((BlockFormat::Bc5, false)),
            _ => Err(format!("DDS pixel format {code:#x} is not supported, only BC1 to BC7")),
        };
    };
    Ok(match header.dxgi_format {
        DxgiFormat::BC1_UNorm | DxgiFormat::BC1_Typeless => (BlockFormat::Bc1, false),
        DxgiFormat::BC1_UNorm_sRGB => (BlockFormat::Bc1, true),
        DxgiFormat::BC2_UNorm | DxgiFormat::BC2_Typeless => (BlockFormat::Bc2, false),
        DxgiFormat::BC2_UNorm_sRGB => (BlockFormat::Bc2, true),
        DxgiFormat::BC3_UNorm | DxgiFormat::BC3_Typeless => (BlockFormat::Bc3, false),
        DxgiFormat::BC3_UNorm_sRGB => (BlockFormat::Bc3, true),
        DxgiFormat::BC4_UNorm | DxgiFormat::BC4_Typeless => (BlockFormat::Bc4, false),
        DxgiFormat::BC5_UNorm | DxgiFormat::BC5_Typeless => (BlockFormat::Bc5, false),
        DxgiFormat::BC6H_UF16 | DxgiFormat::BC6H_Typeless => (BlockFormat::Bc6h, false),
        DxgiFormat::BC7_UNorm | DxgiFormat::BC7_Typeless => (BlockFormat::Bc7, false),
        DxgiFormat::BC7_UNorm_sRGB => (BlockFormat::Bc7, true),
        other => return Err(format!("DDS format {other:?} is not supported, only unsigned BC1 to BC7")),
    })
}

impl DdsTexture {
    /// Reads a DDS file with a single 2D image in one of the formats of [`BlockFormat`].
    ///
    /// # Errors
    /// What is wrong, in one line without the file's name. Memory is bounded by the length of `bytes`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let dds = Dds::read(Cursor::new(bytes)).map_err(|e| format!("is no DDS file: {e}"))?;
        let (format, srgb) = format(&dds)?;
        let (width, height) = (dds.header.width, dds.header.height);
        if !(1..=MAX_TEXTURE_SIDE).contains(&width) || !(1..=MAX_TEXTURE_SIDE).contains(&height) {
            return Err(format!("{width}x{height} is outside 1x1 .. {MAX_TEXTURE_SIDE}x{MAX_TEXTURE_SIDE}"));
        }
        let flat = dds.header10.as_ref().is_none_or(|header| {
            header.array_size == 1
                && header.resource_dimension == D3D10ResourceDimension::Texture2D
                && !header.misc_flag.contains(ddsfile::MiscFlag::TEXTURECUBE)
        });
        if !flat || dds.header.depth.is_some_and(|depth| depth > 1) || !dds.header.caps2.is_empty() {
            return Err("is a DDS array, cube map or volume; only 2D textures are supported".into());
        }
        let count = dds.header.mip_map_count.unwrap_or(1).max(1);
        if count > width.max(height).ilog2() + 1 {
            return Err(format!("{count} mip levels for {width}x{height}"));
        }
        let mut rest = &dds.data[..];
        let mut levels = Vec::with_capacity(count as usize);
        for i in 0..count {
            let extent = [width, height].map(|side| (side >> i).max(1));
            let Some((level, behind)) = rest.split_at_checked(format.level_bytes(extent)) else {
                return Err(format!("the DDS file is cut short in mip level {i}"));
            };
            levels.push(level.to_vec());
            rest = behind;
        }
        Ok(Self { width, height, format, srgb, levels })
    }

    /// The file, with a DX10 header.
    ///
    /// # Errors
    /// A size that the format can't express.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let format = match (self.format, self.srgb) {
            (BlockFormat::Bc1, false) => DxgiFormat::BC1_UNorm,
            (BlockFormat::Bc1, true) => DxgiFormat::BC1_UNorm_sRGB,
            (BlockFormat::Bc2, false) => DxgiFormat::BC2_UNorm,
            (BlockFormat::Bc2, true) => DxgiFormat::BC2_UNorm_sRGB,
            (BlockFormat::Bc3, false) => DxgiFormat::BC3_UNorm,
            (BlockFormat::Bc3, true) => DxgiFormat::BC3_UNorm_sRGB,
            (BlockFormat::Bc4, _) => DxgiFormat::BC4_UNorm,
            (BlockFormat::Bc5, _) => DxgiFormat::BC5_UNorm,
            (BlockFormat::Bc6h, _) => DxgiFormat::BC6H_UF16,
            (BlockFormat::Bc7, false) => DxgiFormat::BC7_UNorm,
            (BlockFormat::Bc7, true) => DxgiFormat::BC7_UNorm_sRGB,
        };
        let mut dds = Dds::new_dxgi(NewDxgiParams {
            width: self.width,
            height: self.height,
            depth: None,
            format,
            mipmap_levels: Some(self.levels.len() as u32),
            array_layers: None,
            caps2: None,
            is_cubemap: false,
            resource_dimension: D3D10ResourceDimension::Texture2D,
            alpha_mode: AlphaMode::Straight,
        })
        .map_err(|e| e.to_string())?;
        dds.data = self.levels.concat();
        let mut bytes = Vec::with_capacity(dds.data.len() + 148);
        dds.write(&mut bytes).map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}
