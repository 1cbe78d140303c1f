//! The frame contract: every screen-space image that crosses a stage seam, declared once.
//!
//! The table generates the GLSL declarations (`channels.glsl`: image `ch_NAME`, and `ch_NAME_prev` for channels with a
//! history), the images that pt-core allocates, the layers of `--aov` and the table that `pt passes` prints.
//!
//! Extents: [`ExtentClass::Split`] holds the two half-width checkerboard fields side by side (even field left, odd field
//! right), [`ExtentClass::Flat`] is the full frame in scan-line order, [`ExtentClass::Output`] the picture, which is larger than
//! the frame when it is upscaled.

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
    /// Four 8-bit unsigned normalised numbers.
    Rgba8Unorm,
    /// One 32-bit unsigned integer.
    R32Uint,
    /// Two 32-bit unsigned integers.
    Rg32Uint,
    /// One 16-bit unsigned integer.
    R16Uint,
}

impl Format {
    /// GLSL layout qualifier.
    pub const fn glsl_qualifier(self) -> &'static str {
        match self {
            Self::R32F => "r32f",
            Self::Rg32F => "rg32f",
            Self::Rgba32F => "rgba32f",
            Self::Rgba16F => "rgba16f",
            Self::Rg16Unorm => "rg16",
            Self::Rgba16Unorm => "rgba16",
            Self::Rgba8Unorm => "rgba8",
            Self::R32Uint => "r32ui",
            Self::Rg32Uint => "rg32ui",
            Self::R16Uint => "r16ui",
        }
    }

    /// GLSL storage image type.
    pub const fn glsl_image(self) -> &'static str {
        if self.is_uint() { "uimage2D" } else { "image2D" }
    }

    /// Whether texels are unsigned integers.
    pub const fn is_uint(self) -> bool {
        matches!(self, Self::R32Uint | Self::Rg32Uint | Self::R16Uint)
    }

    /// Number of components.
    pub const fn components(self) -> u32 {
        match self {
            Self::R32F | Self::R32Uint | Self::R16Uint => 1,
            Self::Rg32F | Self::Rg16Unorm | Self::Rg32Uint => 2,
            Self::Rgba32F | Self::Rgba16F | Self::Rgba16Unorm | Self::Rgba8Unorm => 4,
        }
    }

    /// Bytes per texel.
    pub const fn bytes(self) -> u32 {
        match self {
            Self::R16Uint => 2,
            Self::R32F | Self::R32Uint | Self::Rg16Unorm | Self::Rgba8Unorm => 4,
            Self::Rg32F | Self::Rg32Uint | Self::Rgba16F | Self::Rgba16Unorm => 8,
            Self::Rgba32F => 16,
        }
    }
}

/// Which size a channel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtentClass {
    /// Two checkerboard fields side by side: `2 * ceil(W/2)` by `H`.
    Split,
    /// The full frame: `W` by `H`.
    Flat,
    /// The picture: the size of the frame, or larger when it is upscaled.
    Output,
}

/// One image of the frame contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name in Rust, GLSL (`ch_` + name), AOV files and documents.
    pub name: &'static str,
    /// Texel format.
    pub format: Format,
    /// Size class.
    pub extent: ExtentClass,
    /// Whether last frame's content is kept (GLSL: `ch_` + name + `_prev`).
    pub history: bool,
    /// Unit and space of the stored value.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

macro_rules! channels {
    ($($id:ident: $name:literal, $format:ident, $extent:ident, $history:literal, $unit:literal, $meaning:literal;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "variants carry the constants' names")]
        #[repr(usize)]
        enum Index { $($id),* }
        $(
            #[doc = concat!($meaning, " Unit: ", $unit, ".")]
            pub const $id: ChannelId = ChannelId(Index::$id as usize);
        )*
        /// The table itself, in binding order.
        pub const CHANNELS: &[Channel] = &[$(Channel {
            name: $name, format: Format::$format, extent: ExtentClass::$extent, history: $history,
            unit: $unit, meaning: $meaning,
        }),*];
    };
}

/// Index into [`CHANNELS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ChannelId(usize);

impl ChannelId {
    /// Position in [`CHANNELS`].
    pub const fn index(self) -> usize {
        self.0
    }

    /// The table entry.
    pub const fn channel(self) -> &'static Channel {
        &CHANNELS[self.0]
    }

    /// All channels in table order.
    pub fn all() -> impl Iterator<Item = ChannelId> {
        (0..CHANNELS.len()).map(ChannelId)
    }

    /// Finds a channel by its name.
    pub fn by_name(name: &str) -> Option<ChannelId> {
        CHANNELS.iter().position(|c| c.name == name).map(ChannelId)
    }

    /// Name of the storage image in GLSL.
    pub fn glsl_name(self) -> String {
        format!("ch_{}", self.channel().name)
    }

    /// Name in GLSL of the image that holds last frame's content.
    pub fn glsl_name_prev(self) -> String {
        format!("ch_{}_prev", self.channel().name)
    }
}

channels! {
    RNG_SEED: "rng_seed", Rg32Uint, Split, true, "-",
        "Arguments of the random numbers drawn at this pixel: x = flat pixel (x | y << 16), y = frame index.";
    VISIBILITY: "visibility", Rg32Uint, Split, true, "-",
        "Visibility buffer of the shaded surface: x = instance index (0xffffffff: none), y = triangle of its mesh.";
    BARYCENTRICS: "barycentrics", Rg32F, Split, true, "-",
        "Barycentric weights of the triangle's second and third vertex.";
    CLUSTER: "cluster", R16Uint, Split, true, "-",
        "Light-list cluster of the surface; 0xffff: none.";
    BASE_COLOR: "base_color", Rgba16Unorm, Split, true, "linear reflectance",
        "rgb = base colour, a = specular factor.";
    METALLIC_ROUGHNESS: "metallic_roughness", Rg16Unorm, Split, true, "-",
        "x = metalness, y = perceptual roughness (alpha = roughness^2).";
    NORMAL: "normal", R32Uint, Split, true, "world space, octahedral 2 x 16 bit",
        "Shading normal (normal map applied), on the viewer's side; 0 = no surface.";
    VERTEX_NORMAL: "vertex_normal", R32Uint, Split, true, "world space, octahedral 2 x 16 bit",
        "Interpolated vertex normal, flipped to the viewer's side; 0 = no surface.";
    VIEW_DEPTH: "view_depth", R32F, Split, true, "m",
        "Euclidean distance from the camera; negative for surfaces seen by reflection or refraction; 1e4 = sky.";
    MOTION: "motion", Rgba32F, Split, false, "UV of the full frame; m; 1/m",
        "xy = previous minus current screen position, z = previous minus current distance, w = 1 / depth range of the pixel's footprint.";
    SHADING_POSITION: "shading_position", Rgba32F, Split, false, "m, world space",
        "xyz = position, w = bits of (material index + 1); w = 0: no surface.";
    VIEW_DIRECTION: "view_direction", Rg32Uint, Split, false, "world space, octahedral 2 x 16 bit",
        "x = ray direction into the surface, y = checkerboard flags (1 primary, 2 reflection, 4 refraction).";
    THROUGHPUT: "throughput", Rgba16F, Split, false, "-; m",
        "rgb = path throughput from the camera to the shaded surface, a = optical path length.";
    BOUNCE_THROUGHPUT: "bounce_throughput", Rgba16F, Split, false, "-; rad",
        "rgb = throughput of the bounce path, a = half cone angle of the pixel.";
    TRANSPARENT: "transparent", Rgba32F, Split, false, "linear radiance",
        "Premultiplied layer in front of the shaded surface: emission (alpha 0), environment (alpha 1).";
    COLOR_HF: "color_hf", Rgba32F, Split, false, "linear radiance / albedo",
        "Direct diffuse light: irradiance / pi.";
    COLOR_SPEC: "color_spec", Rgba32F, Split, false, "linear radiance / max(0.01, F0)",
        "Direct specular light, demodulated by the specular reflectance at normal incidence.";
    COLOR: "color", Rgba32F, Split, false, "linear radiance",
        "Composited radiance, a = checkerboard flags.";
    FLAT_COLOR: "flat_color", Rgba32F, Flat, false, "linear radiance",
        "Interleaved radiance.";
    FLAT_MOTION: "flat_motion", Rg32F, Flat, false, "UV of the full frame",
        "Interleaved motion: previous minus current screen position.";
    ACCUMULATED: "accumulated", Rgba32F, Flat, false, "linear radiance",
        "Running mean of the frames so far (--accumulate), a = number of frames.";
    DISPLAY: "display", Rgba8Unorm, Output, false, "sRGB display",
        "Exposed, tone-mapped and sRGB-encoded picture.";
    DISPLAY_HDR: "display_hdr", Rgba16F, Output, false, "PQ codes of Rec. 2020, or scRGB",
        "Exposed, tone-mapped and encoded picture for an HDR display.";
}

/// Descriptor set that the channel images are declared in.
pub const CHANNEL_SET: u32 = 1;

/// GLSL declarations of all channels (`channels.glsl`). A kernel uses the ones it touches; reflection drops the rest.
pub fn glsl() -> String {
    let mut text = String::from("// Generated from the channel table of pt-shaders.\n");
    for id in ChannelId::all() {
        let (c, binding) = (id.channel(), id.index() * 2);
        let mut declare = |binding: usize, name: String| {
            text.push_str(&format!(
                "layout(set = {CHANNEL_SET}, binding = {binding}, {}) uniform {} {name};\n",
                c.format.glsl_qualifier(),
                c.format.glsl_image(),
            ));
        };
        declare(binding, id.glsl_name());
        if c.history {
            declare(binding + 1, id.glsl_name_prev());
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        for id in ChannelId::all() {
            assert_eq!(ChannelId::by_name(id.channel().name), Some(id));
        }
        assert_eq!(ChannelId::by_name("no_such_channel"), None);
    }

    #[test]
    fn declarations_follow_the_table() {
        let text = glsl();
        assert!(text.contains("rg32ui) uniform uimage2D ch_visibility;"));
        assert!(text.contains("ch_visibility_prev;"));
        assert!(!text.contains("ch_motion_prev"));
    }
}
