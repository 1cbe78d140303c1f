use ash::vk;

/// Block compression of 4x4 texels, the formats of D3D 11 that hold unsigned values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockFormat {
    /// RGB and one bit of alpha, 8 bytes.
    Bc1,
    /// RGB and four bits of alpha, 16 bytes.
    Bc2,
    /// RGB and interpolated alpha, 16 bytes.
    Bc3,
    /// R, 8 bytes.
    Bc4,
    /// R and G, 16 bytes.
    Bc5,
    /// RGB in half floats that are not negative, 16 bytes.
    Bc6h,
    /// RGBA, 16 bytes.
    Bc7,
}

impl BlockFormat {
    /// Bytes of a block.
    pub fn block_bytes(self) -> usize {
        match self {
            Self::Bc1 | Self::Bc4 => 8,
            Self::Bc2 | Self::Bc3 | Self::Bc5 | Self::Bc6h | Self::Bc7 => 16,
        }
    }

    /// Bytes of an image; blocks at the right and lower edge may reach beyond it.
    pub fn level_bytes(self, [width, height]: [u32; 2]) -> usize {
        width.div_ceil(4) as usize * height.div_ceil(4) as usize * self.block_bytes()
    }

    /// The texels of one block, row by row, as RGBA8 in the encoding of the data. Channels that the format lacks are 0,
    /// alpha 255; values of BC6H are clamped to 0..1.
    ///
    /// # Panics
    /// When `block` is shorter than [`BlockFormat::block_bytes`].
    pub fn decode_block(self, block: &[u8]) -> [[u8; 4]; 16] {
        let block = &block[..self.block_bytes()];
        let mut rgba = [[0u8, 0, 0, 255]; 16];
        match self {
            Self::Bc1 => bcdec_rs::bc1(block, rgba.as_flattened_mut(), 16),
            Self::Bc2 => bcdec_rs::bc2(block, rgba.as_flattened_mut(), 16),
            Self::Bc3 => bcdec_rs::bc3(block, rgba.as_flattened_mut(), 16),
            Self::Bc7 => bcdec_rs::bc7(block, rgba.as_flattened_mut(), 16),
            Self::Bc4 => {
                let mut r = [0u8; 16];
                bcdec_rs::bc4(block, &mut r, 4, false);
                rgba.iter_mut().zip(r).for_each(|(t, r)| t[0] = r);
            }
            Self::Bc5 => {
                let mut rg = [[0u8; 2]; 16];
                bcdec_rs::bc5(block, rg.as_flattened_mut(), 8, false);
                rgba.iter_mut().zip(rg).for_each(|(t, rg)| t[..2].copy_from_slice(&rg));
            }
            Self::Bc6h => {
                let mut rgb = [[0f32; 3]; 16];
                bcdec_rs::bc6h_float(block, rgb.as_flattened_mut(), 12, false);
                let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                rgba.iter_mut().zip(rgb).for_each(|(t, rgb)| t[..3].copy_from_slice(&rgb.map(byte)));
            }
        }
        rgba
    }

    /// An image as RGBA8, see [`BlockFormat::decode_block`].
    ///
    /// # Panics
    /// When `blocks` is shorter than [`BlockFormat::level_bytes`].
    pub fn decode(self, [width, height]: [u32; 2], blocks: &[u8]) -> Vec<u8> {
        let (w, h) = (width as usize, height as usize);
        let mut out = vec![0u8; w * h * 4];
        let across = w.div_ceil(4);
        for (i, block) in
            blocks[..self.level_bytes([width, height])].chunks_exact(self.block_bytes()).enumerate()
        {
            let texels = self.decode_block(block);
            let (x, y) = (i % across * 4, i / across * 4);
            let columns = (w - x).min(4);
            for row in 0..(h - y).min(4) {
                let at = ((y + row) * w + x) * 4;
                out[at..at + columns * 4].copy_from_slice(texels[row * 4..row * 4 + columns].as_flattened());
            }
        }
        out
    }

    pub(super) fn vk(self, srgb: bool) -> vk::Format {
        match (self, srgb) {
            (Self::Bc1, false) => vk::Format::BC1_RGBA_UNORM_BLOCK,
            (Self::Bc1, true) => vk::Format::BC1_RGBA_SRGB_BLOCK,
            (Self::Bc2, false) => vk::Format::BC2_UNORM_BLOCK,
            (Self::Bc2, true) => vk::Format::BC2_SRGB_BLOCK,
            (Self::Bc3, false) => vk::Format::BC3_UNORM_BLOCK,
            (Self::Bc3, true) => vk::Format::BC3_SRGB_BLOCK,
            (Self::Bc4, _) => vk::Format::BC4_UNORM_BLOCK,
            (Self::Bc5, _) => vk::Format::BC5_UNORM_BLOCK,
            (Self::Bc6h, _) => vk::Format::BC6H_UFLOAT_BLOCK,
            (Self::Bc7, false) => vk::Format::BC7_UNORM_BLOCK,
            (Self::Bc7, true) => vk::Format::BC7_SRGB_BLOCK,
        }
    }
}
