//! The frame contract: every screen-space image that passes between stages, declared once; and the private images of
//! stages, declared the same way with [`stage_images!`](crate::stage_images!).
//!
//! A table generates the GLSL declarations, the images that pt-core allocates, the layers of `--aov` and of captures, and
//! the table that `pt passes` prints.

pub use crate::format::{Format, HalfCode, HalfPart};

/// Which size an image has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtentClass {
    /// Two checkerboard fields side by side, even field left, odd field right: `2 * ceil(W/2)` by `H`.
    Split,
    /// The full frame in scan-line order: `W` by `H`.
    Flat,
    /// The frame after temporal upscaling: that of the picture with TAAU, else the same as [`ExtentClass::Flat`].
    Resolved,
    /// The picture: the size of the frame, or larger when it is upscaled.
    Output,
    /// The sides of [`ExtentClass::Split`] divided, rounded up.
    SplitPart(u32),
    /// The sides of [`ExtentClass::Resolved`] divided, rounded up.
    ResolvedPart(u32),
}

/// How long the content of an image is valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifetime {
    /// Until the end of the frame: a frame writes the image before it reads it. Last frame's content is kept (GLSL: name + `_prev`)
    /// only if a stage reads it.
    Frame,
    /// Until the next reset of the histories: each frame updates the content of the last one in the same image.
    Carried,
}

/// How a layer of an EXR stores one word of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// A number, under this name.
    Float(&'static str, usize),
    /// An integer, under this name; in a float image its bits.
    Uint(&'static str, usize),
    /// A unit vector, octahedral 2 x 16 bit: X, Y, Z for viewers, and the word itself as `code` (uint), which is the one that is
    /// read back. 0 = no direction.
    Direction(usize),
}

/// How the texels of a channel are stored in an EXR: the column `stored` of the tables.
pub mod stored {
    use super::Stored::{self, Direction, Float, Uint};

    /// One integer.
    pub const X_UINT: &[Stored] = &[Uint("x", 0)];
    /// Two integers.
    pub const XY_UINT: &[Stored] = &[Uint("x", 0), Uint("y", 1)];
    /// Four integers.
    pub const XYZW_UINT: &[Stored] = &[Uint("x", 0), Uint("y", 1), Uint("z", 2), Uint("w", 3)];
    /// One number.
    pub const Z: &[Stored] = &[Float("Z", 0)];
    /// Two numbers.
    pub const XY: &[Stored] = &[Float("X", 0), Float("Y", 1)];
    /// Four numbers that are no colour.
    pub const XYZW: &[Stored] = &[Float("X", 0), Float("Y", 1), Float("Z", 2), Float("W", 3)];
    /// Colour and one more number.
    pub const RGBA: &[Stored] = &[Float("R", 0), Float("G", 1), Float("B", 2), Float("A", 3)];
    /// A packed direction.
    pub const DIRECTION: &[Stored] = &[Direction(0)];
    /// A packed direction, then flags.
    pub const DIRECTION_FLAGS: &[Stored] = &[Direction(0), Uint("flags", 1)];
    /// A position, then the bits of a material number.
    pub const POSITION_MATERIAL: &[Stored] =
        &[Float("X", 0), Float("Y", 1), Float("Z", 2), Uint("material", 3)];
}

/// One screen-space image: of the frame contract, or private to a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The stage that owns it; empty for channels of the frame contract.
    pub stage: &'static str,
    /// Name in Rust, GLSL, AOV files and documents.
    pub name: &'static str,
    /// Texel format.
    pub format: Format,
    /// Size class.
    pub extent: ExtentClass,
    /// How long its content is valid.
    pub lifetime: Lifetime,
    /// How it is stored in an EXR.
    pub stored: &'static [Stored],
    /// Unit and space of the value.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

/// An entry of a table.
#[derive(Clone, Copy, Debug)]
pub struct ChannelId {
    table: &'static [Channel],
    index: usize,
}

impl ChannelId {
    /// An entry of a table; tables are made by [`stage_images!`](crate::stage_images!).
    pub const fn new(table: &'static [Channel], index: usize) -> Self {
        Self { table, index }
    }

    /// The entry.
    pub const fn channel(self) -> &'static Channel {
        &self.table[self.index]
    }

    /// All channels of the frame contract in table order.
    pub fn all() -> impl Iterator<Item = ChannelId> {
        (0..CHANNELS.len()).map(|index| Self::new(CHANNELS, index))
    }

    /// Finds a channel of the frame contract by its name.
    pub fn by_name(name: &str) -> Option<ChannelId> {
        Self::all().find(|id| id.channel().name == name)
    }

    /// Whether it belongs to the frame contract rather than to a stage.
    pub fn is_contract(self) -> bool {
        self.channel().stage.is_empty()
    }

    /// The name that `--aov` and EXR layers take: `NAME`, or `STAGE.NAME` for a private image.
    pub fn full_name(self) -> String {
        match self.channel() {
            Channel { stage: "", name, .. } => (*name).into(),
            Channel { stage, name, .. } => format!("{stage}.{name}"),
        }
    }

    /// Name of the storage image in GLSL.
    pub fn glsl_name(self) -> String {
        let prefix = if self.is_contract() { "ch" } else { "im" };
        format!("{prefix}_{}", self.channel().name)
    }

    /// Name in GLSL of the storage image that holds last frame's content.
    pub fn glsl_name_prev(self) -> String {
        format!("{}_prev", self.glsl_name())
    }

    /// Name in GLSL under which it is sampled.
    pub fn glsl_sampler(self) -> String {
        format!("tex_{}", self.channel().name)
    }

    /// Name in GLSL under which last frame's content is sampled.
    pub fn glsl_sampler_prev(self) -> String {
        format!("{}_prev", self.glsl_sampler())
    }

    fn key(self) -> (&'static str, usize) {
        (self.channel().stage, self.index)
    }
}

impl PartialEq for ChannelId {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for ChannelId {}

impl PartialOrd for ChannelId {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// The frame contract in table order, then the stages by name.
impl Ord for ChannelId {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

impl std::hash::Hash for ChannelId {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

/// Makes the table of a stage's private images, a constant of each entry, and `glsl()`, the declarations for its kernels.
///
/// A row is `ID: "name", format, extent, lifetime, stored, "unit", "meaning";` with the variants of
/// [`Format`](crate::format::Format), [`ExtentClass`](crate::channels::ExtentClass) and
/// [`Lifetime`](crate::channels::Lifetime) and a constant of [`stored`](crate::channels::stored). Build scripts include the
/// file that calls it, so that kernels see the same table: image `im_NAME`, `im_NAME_prev`, and `tex_NAME`,
/// `tex_NAME_prev` to sample them.
#[macro_export]
macro_rules! stage_images {
    ($stage:literal; $($id:ident: $name:literal, $format:ident, $extent:ident $(($part:literal))?, $lifetime:ident,
        $stored:ident, $unit:literal, $meaning:literal;)*) => {
        $crate::image_table! { $stage; $($id: $name, $format, $extent $(($part))?, $lifetime, $stored, $unit, $meaning;)* }

        /// GLSL declarations of the table.
        pub fn glsl() -> String {
            $crate::channels::private_glsl(CHANNELS)
        }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! image_table {
    ($stage:literal; $($id:ident: $name:literal, $format:ident, $extent:ident $(($part:literal))?, $lifetime:ident,
        $stored:ident, $unit:literal, $meaning:literal;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "variants carry the constants' names")]
        #[repr(usize)]
        enum Index { $($id),* }
        $(
            #[doc = concat!($meaning, " Unit: ", $unit, ".")]
            pub const $id: $crate::channels::ChannelId =
                $crate::channels::ChannelId::new(CHANNELS, Index::$id as usize);
        )*
        /// The table itself, in binding order.
        pub const CHANNELS: &[$crate::channels::Channel] = &[$($crate::channels::Channel {
            stage: $stage,
            name: $name,
            format: $crate::channels::Format::$format,
            extent: $crate::channels::ExtentClass::$extent $(($part))?,
            lifetime: $crate::channels::Lifetime::$lifetime,
            stored: $crate::channels::stored::$stored,
            unit: $unit,
            meaning: $meaning,
        }),*];
    };
}

crate::image_table! { "";
    RNG_SEED: "rng_seed", Rg32Uint, Split, Frame, XY_UINT, "-",
        "Arguments of the random numbers drawn at this pixel: x = flat pixel (x | y << 16), y = frame index.";
    VISIBILITY: "visibility", Rg32Uint, Split, Frame, XY_UINT, "-",
        "Visibility buffer of the shaded surface: x = instance index (0xffffffff: none), y = triangle of its mesh.";
    BARYCENTRICS: "barycentrics", Rg32F, Split, Frame, XY, "-",
        "Barycentric weights of the triangle's second and third vertex.";
    CLUSTER: "cluster", R16Uint, Split, Frame, X_UINT, "-",
        "Light-list cluster of the surface; 0xffff: none.";
    BASE_COLOR: "base_color", Rgba16Unorm, Split, Frame, RGBA, "linear reflectance",
        "rgb = base colour, a = largest component of the F0 of the dielectric (0.04 for ior 1.5).";
    METALLIC_ROUGHNESS: "metallic_roughness", Rg16Unorm, Split, Frame, XY, "-",
        "x = metalness, y = perceptual roughness (alpha = roughness^2).";
    NORMAL: "normal", R32Uint, Split, Frame, DIRECTION, "world space, octahedral 2 x 16 bit",
        "Shading normal (normal map applied), on the viewer's side; 0 = no surface.";
    VERTEX_NORMAL: "vertex_normal", R32Uint, Split, Frame, DIRECTION, "world space, octahedral 2 x 16 bit",
        "Interpolated vertex normal, flipped to the viewer's side; 0 = no surface.";
    VIEW_DEPTH: "view_depth", R32F, Split, Frame, Z, "m",
        "Euclidean distance from the camera; negative for surfaces seen by reflection or refraction; 1e18 = sky.";
    MOTION: "motion", Rgba32F, Split, Frame, XYZW, "UV of the full frame; m; 1/m",
        "xy = previous minus current screen position, z = previous minus current distance, w = 1 / depth range of the pixel's footprint.";
    SHADING_POSITION: "shading_position", Rgba32F, Split, Frame, POSITION_MATERIAL, "m, world space",
        "xyz = position, w = bits of (material index + 1); w = 0: no surface.";
    VIEW_DIRECTION: "view_direction", Rg32Uint, Split, Frame, DIRECTION_FLAGS, "world space, octahedral 2 x 16 bit",
        "x = ray direction into the surface, y = checkerboard flags (1 primary, 2 reflection, 4 refraction).";
    THROUGHPUT: "throughput", Rgba16F, Split, Frame, RGBA, "-; log2 m",
        "rgb = path throughput from the camera to the shaded surface, a = log2 of the optical path length.";
    BOUNCE_THROUGHPUT: "bounce_throughput", Rgba16F, Split, Frame, RGBA, "-; rad",
        "rgb = throughput of the bounce path, a = half cone angle of the pixel.";
    TRANSPARENT: "transparent", Rgba32F, Split, Frame, RGBA, "linear radiance",
        "Premultiplied layer in front of the shaded surface: emission (alpha 0), environment (alpha 1).";
    INTERIOR: "interior", Rgba32Uint, Split, Frame, XYZW_UINT, "-",
        "Solids that the way to the shaded surface is inside of, up to four: medium + 1 << 8 | priority; 0: none.";
    COLOR_HF: "color_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo; m",
        "Direct diffuse light: irradiance / pi. a = mean distance of its lights: sum w / sum (w / d) over what arrived, w = luminance; 1e18 = infinitely far, 0 = no light.";
    COLOR_SPEC: "color_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0); m",
        "Specular light, direct and indirect, demodulated by the specular reflectance at normal incidence. a = length of the bounce ray, if it was drawn for the specular lobes; else mean distance of the direct lights, as in color_hf.";
    COLOR_LF_SH: "color_lf_sh", Rgba32F, Split, Frame, XYZW, "irradiance / albedo",
        "Indirect diffuse light: luma in spherical harmonics, xyz = l 1 along the axes, w = l 0.";
    COLOR_LF_COCG: "color_lf_cocg", Rg32F, Split, Frame, XY, "irradiance / albedo",
        "Indirect diffuse light: chroma without a direction, x = Co, y = Cg.";
    GRADIENT_SAMPLE: "gradient_sample", Rgba32F, SplitPart(3), Frame, XYZW, "-; linear radiance",
        "Gradient pixel of each 3 x 3 pixels of the flat frame (of 5 x 5 with denoise.antilag.stratum=5x5, in a part of the image): x = 1 + its number (0: there is none), y, z = luminance of its diffuse and specular light in the last frame.";
    COLOR: "color", Rgba32F, Split, Frame, RGBA, "linear radiance",
        "Composited radiance, a = checkerboard flags.";
    FLAT_COLOR: "flat_color", Rgba32F, Flat, Frame, RGBA, "linear radiance",
        "Interleaved radiance.";
    FLAT_MOTION: "flat_motion", Rg32F, Flat, Frame, XY, "UV of the full frame",
        "Interleaved motion: previous minus current screen position.";
    ACCUMULATED: "accumulated", Rgba32F, Flat, Carried, RGBA, "linear radiance",
        "Running mean of the frames so far (--accumulate), a = number of frames.";
    DISPLAY: "display", Rgba8Unorm, Output, Frame, RGBA, "sRGB display",
        "Exposed, tone-mapped and sRGB-encoded picture.";
    DISPLAY_HDR: "display_hdr", Rgba16F, Output, Frame, RGBA, "PQ codes of Rec. 2020, or scRGB",
        "Exposed, tone-mapped and encoded picture for an HDR display.";
}

crate::named_enum! {
    /// Formats of the channels that hold surfaces.
    pub enum GbufferFormat {
        /// Those of the table.
        Full = "full",
        /// Smaller ones: [`COMPACT`].
        Compact = "compact",
    }
}

/// Images that have another format than that of their tables in a kind of frame: a knob chooses it.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct OtherFormats {
    /// The specialisation constant by which kernels know. It is a boolean, and true in such a frame.
    pub constant: &'static str,
    /// The images with their formats.
    pub images: &'static [(ChannelId, Format)],
}

/// Channels that have a smaller format with `gbuffer.format=compact`.
pub static COMPACT: OtherFormats = OtherFormats {
    constant: "compact_gbuffer",
    images: &[
        (BASE_COLOR, Format::Rgba8Root),
        (METALLIC_ROUGHNESS, Format::Rg8Unorm),
        (MOTION, Format::Rgba16F),
    ],
};

impl GbufferFormat {
    /// The formats that are not those of the table.
    pub fn others(self) -> Option<&'static OtherFormats> {
        match self {
            Self::Full => None,
            Self::Compact => Some(&COMPACT),
        }
    }
}

/// Descriptor set that the images are declared in.
pub const CHANNEL_SET: u32 = 1;

/// First binding of private images: behind those of the frame contract, two a channel.
const FIRST_PRIVATE_BINDING: usize = 256;

/// GLSL declarations of the frame contract (`channels.glsl`). A kernel uses the ones it touches; reflection drops the rest.
pub fn glsl() -> String {
    let mut text = String::from("// Generated from the channel table of pt-shaders.\n");
    for (index, id) in ChannelId::all().enumerate() {
        for (binding, name) in (2 * index..).zip([id.glsl_name(), id.glsl_name_prev()]) {
            text.push_str(&image_declaration(id.channel(), binding, &name));
        }
    }
    text
}

/// GLSL declarations of a table of private images, see [`stage_images!`](crate::stage_images!).
pub fn private_glsl(table: &'static [Channel]) -> String {
    let mut text = String::from("// Generated from the stage's table of images.\n");
    for (index, channel) in table.iter().enumerate() {
        let id = ChannelId::new(table, index);
        let first = FIRST_PRIVATE_BINDING + 4 * index;
        for (binding, name) in (first..).zip([id.glsl_name(), id.glsl_name_prev()]) {
            text.push_str(&image_declaration(channel, binding, &name));
        }
        for (binding, name) in (first + 2..).zip([id.glsl_sampler(), id.glsl_sampler_prev()]) {
            let sampler = if channel.format.is_uint() { "usampler2D" } else { "sampler2D" };
            text.push_str(&format!(
                "layout(set = {CHANNEL_SET}, binding = {binding}) uniform {sampler} {name};\n"
            ));
        }
    }
    text
}

fn image_declaration(channel: &Channel, binding: usize, name: &str) -> String {
    let (qualifier, image) = (channel.format.glsl_qualifier(), channel.format.glsl_image());
    format!("layout(set = {CHANNEL_SET}, binding = {binding}, {qualifier}) uniform {image} {name};\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    mod private {
        stage_images! { "blur";
            HALF: "half", Rgba16F, ResolvedPart(2), Frame, RGBA, "linear radiance", "Every other pixel.";
            SUM: "sum", R32Uint, Flat, Carried, X_UINT, "-", "Frames so far.";
        }
    }

    #[test]
    fn names_are_unique_and_found() {
        for id in ChannelId::all() {
            assert_eq!(ChannelId::by_name(id.channel().name), Some(id));
        }
        assert_eq!(ChannelId::by_name("no_such_channel"), None);
    }

    #[test]
    fn bindings_do_not_overlap() {
        assert!(2 * CHANNELS.len() <= FIRST_PRIVATE_BINDING);
    }

    #[test]
    fn words_are_stored_once_each() {
        for id in ChannelId::all() {
            let channel = id.channel();
            let words: Vec<usize> = channel
                .stored
                .iter()
                .map(|part| match *part {
                    Stored::Float(_, word) | Stored::Uint(_, word) | Stored::Direction(word) => word,
                })
                .collect();
            assert_eq!(
                words,
                (0..channel.format.components() as usize).collect::<Vec<_>>(),
                "{}",
                channel.name
            );
        }
    }

    #[test]
    fn declarations_follow_the_table() {
        let text = glsl();
        assert!(text.contains("rg32ui) uniform uimage2D ch_visibility;"));
        assert!(text.contains("ch_visibility_prev;"));
        let text = private::glsl();
        assert!(text.contains("binding = 257, rgba16f) uniform image2D im_half_prev;"), "{text}");
        assert!(text.contains("binding = 262) uniform usampler2D tex_sum;"), "{text}");
    }

    #[test]
    fn private_images_are_told_from_channels() {
        let first = ChannelId::by_name("rng_seed").unwrap();
        assert_ne!(private::HALF, first);
        assert!(first < private::HALF && private::HALF < private::SUM);
        assert_eq!(private::HALF.full_name(), "blur.half");
        assert_eq!(private::SUM.channel().lifetime, Lifetime::Carried);
    }
}
