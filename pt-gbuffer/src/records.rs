//! Push constants of this crate's kernels, for host and GPU.

use pt_shaders::glam::Vec2;

pt_shaders::gpu_struct! {
    /// Push constants of `camera_interior.trace`.
    pub struct CameraInteriorPush {
        /// Device address of the list that is written: `uvec4`.
        pub camera_solids: u64,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `primary_rays.trace`.
    pub struct PrimaryPush {
        /// Device address of the solids that the camera is inside of; 0: no scene with solids.
        pub camera_solids: u64,
        /// Sub-pixel offset of the whole frame, pixels in [-0.5, 0.5].
        pub jitter: Vec2,
        /// 1: every pixel draws its own offset instead.
        pub jitter_per_pixel: u32,
        /// 2^bias on texture gradients.
        pub lod_scale: f32,
        /// Instances that the rays see.
        pub mask: u32,
        /// Alignment.
        pub pad: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `effects.comp`.
    pub struct EffectsPush {
        /// Sub-pixel offset of the whole frame, pixels in [-0.5, 0.5].
        pub jitter: Vec2,
        /// 1: every pixel has drawn its own offset instead.
        pub jitter_per_pixel: u32,
        /// Alignment.
        pub pad: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `replaced_motion.comp`.
    pub struct ReplacedMotionPush {
        /// Sub-pixel offset of this frame, pixels.
        pub jitter: Vec2,
        /// Of the last one.
        pub jitter_prev: Vec2,
        /// 1: every pixel has drawn its own offset instead.
        pub jitter_per_pixel: u32,
        /// Alignment.
        pub pad: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `reflect_refract.trace`.
    pub struct ReflectRefractPush {
        /// How many passes of the frame came before.
        pub bounce: u32,
        /// Instances that the rays see.
        pub mask: u32,
        /// 2^bias on texture gradients.
        pub lod_scale: f32,
        /// Roughness below which a metal is a mirror and glass is smooth.
        pub mirror_roughness: f32,
        /// Roughness up to which glass is seen through.
        pub glass_roughness: f32,
        /// 1: in odd frames the fields of reflection and refraction change places.
        pub alternate_fields: u32,
        /// 1: thin sheets refract at the shading normal and at the triangle's.
        pub double_refraction: u32,
        /// `KIND_*` bits of the punctual lights whose highlights rough glass shows.
        pub light_kinds: u32,
        /// Which plane the frame is of, if it has planes.
        pub plane: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Push constants of `godrays.trace` and `godrays_filter.comp`.
    pub struct GodraysPush {
        /// Extinction coefficient, 1 / m.
        pub density: f32,
        /// Share of it that scatters.
        pub albedo: f32,
        /// Mean cosine of the scattering angle.
        pub anisotropy: f32,
        /// Where the medium ends, metres from the camera.
        pub max_distance: f32,
        /// Steps of the march.
        pub steps: u32,
        /// Instances that stop sunlight.
        pub mask: u32,
        /// `GLASS_SHADOWS_*`.
        pub glass_shadows: u32,
    }
}
