//! Pixels of a flat frame, as the filters see them.

use pt_core::pack::unpack_unit_vector;

/// A colour.
pub type Rgb = [f64; 3];

/// What the G-buffer says about a pixel, in the units of the channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guided {
    /// Material index + 1; 0 = no surface.
    pub material: u32,
    /// Checkerboard flags.
    pub flags: u32,
    /// Signed distance.
    pub depth: f32,
    /// Channel `motion`.
    pub motion: [f32; 4],
    /// Packed shading normal; 0 = no surface.
    pub normal: u32,
    /// Packed vertex normal.
    pub vertex_normal: u32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Angle between the rays of neighbouring pixels.
    pub pixel_angle: f32,
}

impl Guided {
    /// Whether its two fields show different paths.
    pub(super) fn has_two_paths(&self) -> bool {
        self.flags.count_ones() > 1
    }

    /// Depth range of its footprint, metres.
    pub(super) fn depth_range(&self) -> f64 {
        1.0 / f64::from(self.motion[3]).max(1e-18)
    }
}

/// Light of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Diffuse.
    pub hf: [f32; 3],
    /// Specular.
    pub spec: [f32; 3],
}

/// Light between two passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accumulated {
    /// Diffuse.
    pub hf: Rgb,
    /// Specular.
    pub spec: Rgb,
    /// Variances of the luminance of both; -1: the light is missing.
    pub variance: [f64; 2],
}

impl Accumulated {
    /// No light is known.
    pub const MISSING: Self = Self { hf: [0.0; 3], spec: [0.0; 3], variance: [-1.0; 2] };
}

/// Limit of radiance whose square fp32 holds.
const MAX_RADIANCE: f64 = 1e15;

/// A sample that can be filtered; `None` if it is missing.
pub(super) fn usable(pixel: &Guided, light: &Light) -> Option<[Rgb; 2]> {
    let is_light = light.hf.iter().chain(&light.spec).all(|v| (0.0..=MAX_RADIANCE).contains(&f64::from(*v)));
    (pixel.material != 0 && is_light).then(|| [light.hf, light.spec].map(|c| c.map(f64::from)))
}

/// Rec. 709 luminance.
pub(super) fn luminance(c: Rgb) -> f64 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

/// A colour whose luminance is at most `limit`, which is none if it is 0.
pub(super) fn limited(c: Rgb, limit: f64) -> Rgb {
    let l = luminance(c);
    if limit > 0.0 && l > limit { c.map(|v| v * limit / l) } else { c }
}

/// Mean of luminances without the brightest.
pub(super) fn mean_without_brightest(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.pop();
    sorted.iter().sum::<f64>() / sorted.len().max(1) as f64
}

/// Cosine of the angle between packed directions.
pub(super) fn cosine(a: u32, b: u32) -> f64 {
    unpack_unit_vector(a).as_dvec3().dot(unpack_unit_vector(b).as_dvec3())
}

/// Whether two pixels, `offset` apart, show the same path.
pub(super) fn same_path(p: &Guided, q: &Guided, offset: [i64; 2]) -> bool {
    !(p.has_two_paths() || q.has_two_paths()) || (offset[0] + offset[1]) % 2 == 0
}

/// Weight by depth.
pub(super) fn depth_weight(p: &Guided, q: &Guided, pixels: f64, sigma: f64) -> f64 {
    let range = p.depth_range().max(q.depth_range());
    (-(f64::from(p.depth) - f64::from(q.depth)).abs() / (sigma * range * pixels)).exp()
}

/// Index of the pixel `offset` from pixel `i`, if it is inside.
pub(super) fn neighbour(size: [u32; 2], i: usize, offset: [i64; 2]) -> Option<usize> {
    let width = size[0] as usize;
    let at = [(i % width) as i64 + offset[0], (i / width) as i64 + offset[1]];
    let inside = (0..2).all(|k| (0..i64::from(size[k])).contains(&at[k]));
    inside.then(|| at[1] as usize * width + at[0] as usize)
}

/// What a pixel carries to the next frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct History {
    /// The pixel that it belongs to.
    pub pixel: Guided,
    /// Diffuse light.
    pub hf: Rgb,
    /// Specular light.
    pub spec: Rgb,
    /// Means of luminance and squared luminance, diffuse and specular.
    pub moments: [f64; 4],
    /// Frames; 0 = none.
    pub length: u32,
    /// The same of specular light, which may have a history of its own.
    pub spec_length: u32,
}
