//! Knobs.

use crate::GodraysParams;
use pt_core::knobs;
use pt_core::random::RandomSource;
use pt_core::trace::TraceVariant;
use pt_shaders::channels::GbufferFormat;
pub use pt_shaders::dimensions::MAX_REFLECT_REFRACT;
use pt_shaders::named_enum;
use pt_shaders::records::{CameraRecord, Culling, FEATURE_OPACITY_TABLE, FEATURE_TEXTURE_FILTER};

named_enum! {
    /// Where in the pixel its ray goes.
    pub enum Jitter {
        /// The centre.
        None = "none",
        /// One offset for the whole frame: Halton (2, 3), period 128. What temporal anti-aliasing wants.
        Halton = "halton",
        /// One offset for the whole frame: R2 sequence, period 128.
        R2 = "r2",
        /// A random offset for every pixel: the box filter, when frames are averaged.
        Pixel = "pixel",
    }
}

named_enum! {
    /// Which way light takes through a thin sheet.
    pub enum ThinRefraction {
        /// Straight on (KHR_materials_transmission).
        Straight = "straight",
        /// Refracted twice, at the shading normal and at that of the triangle: normal maps distort what is behind.
        Double = "double",
    }
}

named_enum! {
    /// Motion of surfaces that are seen in mirrors and through glass.
    pub enum MotionOfReplaced {
        /// That of the mirror image in plane mirrors, of the surface itself through glass, else of the first surface.
        Surface = "surface",
        /// The place in the last frame that shows the same point, searched in the last frame's G-buffer.
        Search = "search",
    }
}

named_enum! {
    /// What a pixel does with glass, which reflects, transmits and has a diffuse base.
    pub enum Decomposition {
        /// One surface replaces it: the checkerboard fields share out reflection and the rest.
        Replacement = "replacement",
        /// Each lobe has a frame of its own, with guides, motion and histories; their colours are added.
        Planes = "planes",
    }
}

named_enum! {
    /// How textures are filtered over the footprint of a pixel.
    pub enum TextureFilter {
        /// By samplers, before shading.
        Hardware = "hardware",
        /// One texel is drawn with the weights of that filter; the mean over frames is filtered after shading.
        Stochastic = "stochastic",
    }
}

knobs! {
    /// Knobs of the G-buffer.
    pub struct GbufferParams {
        /// Position of the primary ray in its pixel: averaged frames need `pixel`, which gives a box filter, and temporal anti-aliasing
        /// needs `halton` or `r2`.
        pub jitter: Jitter = Jitter::Pixel, source "Halton 1960";
        /// Whether the camera's thin lens gives depth of field; without effect while the lens radius is 0.
        pub depth_of_field: bool = true, source "Cook et al. 1984";
        /// Thin lens radius, instead of the camera's own.
        pub lens_radius: Option<f32> = None, in 0.0..=1.0, unit "m", source "Cook et al. 1984";
        /// Distance in focus, instead of the camera's own.
        pub focus_distance: Option<f32> = None, in 1e-3..=1e6, unit "m", source "Cook et al. 1984";
        /// Bias on the texture level of detail; negative is sharper.
        pub texture_lod_bias: f32 = 0.0, in -8.0..=8.0, unit "mip levels";
        /// Maximum number of reflections and refractions: 2 is into a glass and out of it, and with 0 mirrors and glass are shaded as
        /// regular surfaces.
        pub reflect_refract: u32 = 2, in 0..=MAX_REFLECT_REFRACT;
        /// Perceptual roughness below which metals are mirrors and interfaces of glass are smooth.
        pub mirror_roughness: f32 = 0.02, in 0.0..=1.0;
        /// Perceptual roughness up to which rays pass through transmissive materials; rougher ones are shaded as regular surfaces, without
        /// the light that they transmit.
        pub glass_roughness: f32 = 1.0, in 0.0..=1.0, source "Walter et al. 2007";
        /// BIASED against the reference if `double`: which way light takes through smooth thin sheets.
        pub thin_refraction: ThinRefraction = ThinRefraction::Straight, source "KHR_materials_transmission";
        /// Where motion vectors of what mirrors and glass show lead to: `search` finds them in curved mirrors and through refraction too, and keeps
        /// last frame's positions for it.
        pub replaced_motion: MotionOfReplaced = MotionOfReplaced::Surface => structural;
        /// What stands for glass in the frame: `planes` has up to three surfaces a pixel, and runs all stages up to the interleave once for each, where the scene
        /// has glass.
        pub decomposition: Decomposition = Decomposition::Replacement, source "delta tree: RTXPT's stable planes" => structural;
        /// Whether reflection and refraction swap their checkerboard fields in every frame, so that each pixel gets both; for averaged frames
        /// without `checkerboard.blend_split`.
        pub alternate_fields: bool = false;
        /// Effects along a ray that are kept sorted by distance, of those that it meets; of more the farthest two are blended into one.
        pub effect_layers: u32 = 4, in 1..=16, source "Salvi and Vaidyanathan 2014" => structural;
        /// A medium that scatters sunlight.
        pub godrays: GodraysParams;
        /// Which rays go through the back faces of single-sided materials, at all stages of the frame.
        pub culling: Culling = Culling::Camera, source "glTF 2.0, section 3.9.6" => structural;
        /// Whether rays look up where alpha-tested triangles are opaque or transparent before they read the texture; the same surfaces stop them.
        pub opacity_table: bool = false, source "Gruen, Benthin and Woop 2020" => structural;
        /// How textures are filtered at all surfaces that a frame shades: `stochastic` reads one texel a texture, whose noise averaged frames or anti-aliasing
        /// must remove.
        pub texture_filter: TextureFilter = TextureFilter::Hardware, source "Pharr et al. 2024" => structural;
        /// Formats of the channels that hold surfaces: `compact` has base colour, metalness and roughness in 8 bits a number, and motion in half floats.
        pub format: GbufferFormat = GbufferFormat::Full => structural;
        /// Source of the random numbers of all stages of the frame.
        pub random: RandomSource = RandomSource::White, source "Jarzynski and Olano 2020; Ulichney 1993; Burley 2020" => structural;
    }
}

impl GbufferParams {
    /// Whether the frame has [`crate::ReplacedMotion`].
    pub fn searches_motion(&self) -> bool {
        self.reflect_refract > 0 && self.replaced_motion == MotionOfReplaced::Search
    }

    /// What the kernels of all stages of the frame are made for. `scene`: what they are for the scene.
    pub fn variant(&self, scene: TraceVariant) -> TraceVariant {
        let mut scene_features = scene.scene_features;
        if !self.opacity_table {
            scene_features &= !FEATURE_OPACITY_TABLE;
        }
        if self.texture_filter == TextureFilter::Stochastic {
            scene_features &= !FEATURE_TEXTURE_FILTER;
        }
        TraceVariant { random: self.random, culling: self.culling, scene_features, ..scene }
    }

    /// The camera with the lens that these knobs ask for.
    pub fn with_lens(&self, camera: CameraRecord) -> CameraRecord {
        let lens_radius = self.lens_radius.unwrap_or(camera.lens_radius);
        CameraRecord {
            lens_radius: if self.depth_of_field { lens_radius } else { 0.0 },
            focus_distance: self.focus_distance.unwrap_or(camera.focus_distance),
            ..camera
        }
    }
}
