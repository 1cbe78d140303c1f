//! Texel formats of screen-space images.

/// Texel format. Only formats that every Vulkan device with `shaderStorageImageExtendedFormats` can store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// One 32-bit float.
    R32F,
    /// Two 32-bit floats.
    Rg32F,
    /// Four 32-bit floats.
    Rgba32F,
    /// Four 16-bit floats.
    Rgba16F,
    /// Two 16-bit unsigned normalised numbers.
    Rg16Unorm,
    /// Four 16-bit unsigned normalised numbers.
    Rgba16Unorm,
    /// Two 8-bit unsigned normalised numbers.
    Rg8Unorm,
    /// Four 8-bit unsigned normalised numbers.
    Rgba8Unorm,
    /// Four numbers in 0..1, of each its square root as an 8-bit unsigned normalised number: steps are finer where the numbers are small.
    /// Kernels take roots and squares themselves (`base_color.glsl`).
    Rgba8Root,
    /// Four numbers as half floats, in a code that kernels write and read themselves (`history_code.glsl` of pt-denoise).
    Half(HalfCode),
    /// One 32-bit unsigned integer.
    R32Uint,
    /// Two 32-bit unsigned integers.
    Rg32Uint,
    /// Four 32-bit unsigned integers.
    Rgba32Uint,
    /// One 16-bit unsigned integer.
    R16Uint,
}

/// What four half floats stand for. Roots hold numbers up to 4e9 with the same share of error as half floats, and fourth roots numbers up to 1e19. Roots have the signs of
/// their numbers; that of -1 is -1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HalfCode {
    /// Red, green and blue as roots, and a variance or another number as its fourth root.
    Light,
    /// Two pairs of a mean as its root and a variance as its fourth root. Means of squares would say less: for light without noise the difference of the two would be
    /// their rounding, a standard deviation of several percent of the mean.
    Moments,
    /// Four numbers as roots.
    Roots,
    /// Two numbers as roots, a whole number up to 2048 as it is, and a variance as its fourth root.
    Chroma,
}

/// What one of the half floats stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HalfPart {
    /// Itself.
    Plain,
    /// Its square.
    Root,
    /// Its fourth power.
    FourthRoot,
}

impl HalfCode {
    /// Component `k` of 0 to 3.
    pub const fn part(self, k: usize) -> HalfPart {
        match (self, k) {
            (Self::Chroma, 2) => HalfPart::Plain,
            (Self::Light | Self::Chroma, 3) | (Self::Moments, 1 | 3) => HalfPart::FourthRoot,
            _ => HalfPart::Root,
        }
    }
}

impl Format {
    /// GLSL layout qualifier.
    pub const fn glsl_qualifier(self) -> &'static str {
        match self {
            Self::R32F => "r32f",
            Self::Rg32F => "rg32f",
            Self::Rgba32F => "rgba32f",
            Self::Rgba16F | Self::Half(_) => "rgba16f",
            Self::Rg16Unorm => "rg16",
            Self::Rgba16Unorm => "rgba16",
            Self::Rg8Unorm => "rg8",
            Self::Rgba8Unorm | Self::Rgba8Root => "rgba8",
            Self::R32Uint => "r32ui",
            Self::Rg32Uint => "rg32ui",
            Self::Rgba32Uint => "rgba32ui",
            Self::R16Uint => "r16ui",
        }
    }

    /// GLSL storage image type.
    pub const fn glsl_image(self) -> &'static str {
        if self.is_uint() { "uimage2D" } else { "image2D" }
    }

    /// Whether texels are unsigned integers.
    pub const fn is_uint(self) -> bool {
        matches!(self, Self::R32Uint | Self::Rg32Uint | Self::Rgba32Uint | Self::R16Uint)
    }

    /// Number of components.
    pub const fn components(self) -> u32 {
        match self {
            Self::R32F | Self::R32Uint | Self::R16Uint => 1,
            Self::Rg32F | Self::Rg16Unorm | Self::Rg8Unorm | Self::Rg32Uint => 2,
            Self::Rgba32F | Self::Rgba16F | Self::Rgba16Unorm | Self::Rgba8Unorm | Self::Rgba8Root => 4,
            Self::Half(_) | Self::Rgba32Uint => 4,
        }
    }

    /// Bytes per texel.
    pub const fn bytes(self) -> u32 {
        match self {
            Self::R16Uint | Self::Rg8Unorm => 2,
            Self::R32F | Self::R32Uint | Self::Rg16Unorm | Self::Rgba8Unorm | Self::Rgba8Root => 4,
            Self::Rg32F | Self::Rg32Uint | Self::Rgba16F | Self::Half(_) | Self::Rgba16Unorm => 8,
            Self::Rgba32F | Self::Rgba32Uint => 16,
        }
    }
}
