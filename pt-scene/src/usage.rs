//! What textures are used for.

/// The use of a texture. It decides how texels are decoded, how mips are computed and how they are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TextureUsage {
    /// RGB is sRGB-encoded colour, alpha linear data of its own (or unused).
    Color,
    /// RGB is sRGB-encoded colour, alpha its linear coverage: mips weight colour by alpha.
    Cutout,
    /// Four linear values.
    Data,
    /// Tangent-space normal map: unit vectors, x and y as 2 t - 1 in R and G; z follows from them.
    Normal,
}

impl TextureUsage {
    /// Whether RGB is sRGB-encoded.
    pub fn is_srgb(self) -> bool {
        matches!(self, Self::Color | Self::Cutout)
    }
}
