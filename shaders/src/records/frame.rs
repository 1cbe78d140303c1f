//! What a frame is: its camera, its size, its random numbers.

use crate::{gpu_struct, named_enum};
use glam::{Mat4, UVec2, Vec2};

gpu_struct! {
    /// One view. Perspective: `half_extent` = tangent of half the field of view; orthographic: half the image in metres.
    pub struct CameraRecord {
        /// View space: camera looks along -Z, +Y up.
        pub view_from_world: Mat4,
        /// Inverse of `view_from_world`.
        pub world_from_view: Mat4,
        /// Half the image plane at distance 1 (perspective) or in metres (orthographic); x right, y up.
        pub half_extent: Vec2,
        /// Thin lens radius in metres; 0 = pinhole.
        pub lens_radius: f32,
        /// Distance to the plane in focus, along the view axis, in metres.
        pub focus_distance: f32,
        /// 0 = perspective, 1 = orthographic.
        pub projection: u32,
        /// Alignment.
        pub pad: [u32; 3],
    }
}

gpu_struct! {
    /// What every kernel of a frame may ask for.
    pub struct FrameRecord {
        /// This frame's camera.
        pub camera: CameraRecord,
        /// Last frame's camera (the same in the first frame).
        pub camera_prev: CameraRecord,
        /// Full frame in pixels.
        pub size: UVec2,
        /// Width of one checkerboard field: ceil(W / 2).
        pub field_width: u32,
        /// Frames since the start of the run.
        pub frame_index: u32,
        /// Seed of the run.
        pub seed: u32,
        /// Alignment.
        pub pad: [u32; 3],
    }
}

/// Width of one checkerboard field of a frame that is `width` wide.
pub const fn field_width(width: u32) -> u32 {
    width.div_ceil(2)
}

impl FrameRecord {
    /// A frame of `size` pixels, seen by `camera` and, in the last frame, by `camera_prev`.
    pub fn new(
        camera: CameraRecord,
        camera_prev: CameraRecord,
        size: [u32; 2],
        frame_index: u32,
        seed: u32,
    ) -> Self {
        let field_width = field_width(size[0]);
        Self { camera, camera_prev, size: size.into(), field_width, frame_index, seed, pad: [0; 3] }
    }
}

named_enum! {
    /// How `sampler.glsl` makes random numbers; `SAMPLER_*` in GLSL.
    pub enum SamplerKind: "SAMPLER" {
        /// A hash: all numbers are independent.
        Pcg = "pcg",
        /// Owen-scrambled Sobol points; pixels are independent.
        Sobol = "sobol",
        /// Owen-scrambled Sobol points over the whole image in the order of a scrambled Morton curve: the error is blue noise.
        BlueNoise = "blue-noise",
    }
}

named_enum! {
    /// Where the frame's stages take their random numbers from; `RANDOM_*` in GLSL.
    pub enum RandomSource: "RANDOM" {
        /// A hash: pixels, frames and dimensions are independent.
        White = "white",
        /// A blue-noise mask across the pixels: less of the error is left after a blur. Frames are independent.
        BlueNoise = "blue-noise",
        /// A scrambled Sobol sequence over the frames, moved by the mask from pixel to pixel: means of frames converge faster too.
        Sobol = "sobol",
    }
}

named_enum! {
    /// What is seen where a camera ray meets no surface; `BACKGROUND_*` in GLSL.
    pub enum Background: "BACKGROUND" {
        /// The environment.
        Environment = "environment",
        /// Nothing: radiance 0, alpha 0. Mirrors and glass show the environment all the same.
        Transparent = "transparent",
    }
}
