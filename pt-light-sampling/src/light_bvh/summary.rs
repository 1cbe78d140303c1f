use super::cone::{Cone, angle};
use super::packed::{pack_direction, pack_extent, pack_power, pack_share, unpack_direction, unpack_extent};
use crate::LightBounds;
use glam::Vec3;
use pt_shaders::constants::SKY_DISTANCE;
use pt_shaders::records::LightBvhNode;

/// What a node knows of its lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Summary {
    lower: Vec3,
    upper: Vec3,
    cone: Cone,
    cos_emission: f32,
    /// Share of the power of all lights.
    power: f32,
    /// Mean position of the power.
    mean: Vec3,
    /// Sum over the axes of its variance.
    variance: f32,
    /// Mean direction of the emission, weighted by power: the shorter, the more it spreads.
    lobe: Vec3,
}

impl Summary {
    /// Of one light; its power is multiplied by `scale`. `None` if it is dark, distant or no light that can be sampled.
    pub fn of(light: &LightBounds, scale: f64) -> Option<Self> {
        if light.is_distant() {
            return None;
        }
        let (lower, upper) = (light.bounds.min, light.bounds.max);
        let near = |corner: Vec3| corner.abs().cmple(Vec3::splat(SKY_DISTANCE)).all();
        let placed = near(lower) && near(upper) && lower.cmple(upper).all();
        let axis = light.axis.try_normalize()?;
        let shines = light.power > 0.0 && light.power.is_finite();
        if !(placed && shines && light.cos_spread.is_finite() && light.cos_emission.is_finite()) {
            return None;
        }
        let cos_spread = light.cos_spread.clamp(-1.0, 1.0);
        let cos = light.cos_emission.clamp(-1.0, 1.0);
        // Of a cosine lobe that ends at the angle of emission, averaged over the cone of normals.
        let mean_cosine = 2.0 / 3.0 * (1.0 + cos + cos * cos) / (1.0 + cos).max(1e-3);
        Some(Self {
            lower,
            upper,
            cone: Cone { axis, spread: cos_spread.acos() },
            cos_emission: cos,
            power: ((f64::from(light.power) * scale) as f32).max(f32::MIN_POSITIVE),
            mean: 0.5 * (lower + upper),
            // Of a triangle in its box: per axis between 1/24 and 1/18 of the squared edge length.
            variance: (upper - lower).length_squared() / 20.0,
            lobe: axis * (mean_cosine.min(1.0) * 0.5 * (1.0 + cos_spread)),
        })
    }

    pub fn union(&self, other: &Self) -> Self {
        let power = self.power + other.power;
        let share = other.power / power;
        let mean = self.mean.lerp(other.mean, share);
        let spread = |s: &Self| s.variance + s.mean.distance_squared(mean);
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
            cone: self.cone.union(other.cone),
            cos_emission: self.cos_emission.min(other.cos_emission),
            power,
            mean,
            variance: spread(self) * (1.0 - share) + spread(other) * share,
            lobe: self.lobe.lerp(other.lobe, share),
        }
    }

    /// As the GPU reads it. Box and cones are rounded up.
    pub fn record(&self, link: u32) -> LightBvhNode {
        let center = 0.5 * (self.lower + self.upper);
        let extent = pack_extent(center, self.lower, self.upper);
        let axis = pack_direction(self.cone.axis, 8);
        let spread = self.cone.spread + angle(self.cone.axis, unpack_direction(axis, 8));
        // Sines of half the angles. What is not exactly 0 gets a thousandth of a step more than its own rounding needs.
        let half_sine = |sine: f32| (sine.clamp(0.0, 1.0) * 255.0 + 1e-3).ceil().min(255.0) as u32;
        let half_sine = |sine: f32| if sine > 0.0 { half_sine(sine) } else { 0 };
        let spread = half_sine((0.5 * spread.min(std::f32::consts::PI)).sin());
        let emission = half_sine((0.5 * (1.0 - self.cos_emission)).max(0.0).sqrt());
        let half = unpack_extent(extent);
        let place = 0.5 * (self.mean - center) / half.max(Vec3::splat(f32::MIN_POSITIVE)) + 0.5;
        let [x, y, z] = place.to_array().map(pack_share);
        let deviation = (self.variance / half.length_squared().max(f32::MIN_POSITIVE)).sqrt();
        let length = self.lobe.length();
        let lobe = pack_direction(self.lobe.normalize_or(Vec3::Z), 5);
        let length_code = (length.clamp(0.0, 1.0) * 63.0).round() as u32;
        LightBvhNode {
            center,
            extent,
            link,
            cone: axis | spread << 16 | emission << 24,
            mean: x | y << 8 | z << 16 | pack_share(deviation) << 24,
            lobe: lobe | length_code << 10 | pack_power(self.power),
        }
    }
}

/// A node without a light that shines.
pub(super) fn dark(link: u32) -> LightBvhNode {
    LightBvhNode { link, ..bytemuck::Zeroable::zeroed() }
}
