//! Host twin of lights/light_bvh.glsl, in double precision but for the division of a branch into steps.

use crate::light_bvh::Unpacked;
use crate::{LightBvh, NO_TRAIL};
use glam::{DVec2, DVec3, Vec3};
use pt_core::rng::pcg;
use pt_shaders::records::{LIGHT_BVH_LEAF, LightBvhNode};
use std::f64::consts::{FRAC_1_PI, PI};

const MIN_STEPS: u32 = 1 << 23;
const MIN_IMPORTANCE: f64 = 1e-30;
const COSINE_ROUNDING: f64 = 1e-3;
const DEFENSIVE_SHARE: f64 = 0.1;
const SPECULAR: f64 = 0.05;

/// A shading point as the importance of a node sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBvhPoint {
    position: DVec3,
    normal: DVec3,
    mirror: DVec3,
    mirror_sharpness: f64,
    gaussian: bool,
}

impl LightBvhPoint {
    /// `view`: unit, to the viewer. `gaussian`: importance by spherical Gaussians rather than by bounds alone.
    pub fn new(position: Vec3, normal: Vec3, view: Vec3, roughness: f32, gaussian: bool) -> Self {
        let [position, normal, view] = [position, normal, view].map(Vec3::as_dvec3);
        let alpha = f64::from(roughness).powi(2).max(0.05);
        let cos = view.dot(normal);
        let mirror_sharpness = 0.5 / (alpha * alpha * cos.max(0.1));
        Self { position, normal, mirror: 2.0 * cos * normal - view, mirror_sharpness, gaussian }
    }

    /// Importance of a node.
    pub fn importance(&self, node: &LightBvhNode) -> f64 {
        let node = Unpacked::of(node);
        if node.power <= 0.0 {
            return 0.0;
        }
        let (d, extent) = (node.center.as_dvec3() - self.position, node.extent.as_dvec3());
        let above = self.normal.dot(d) + self.normal.abs().dot(extent);
        if above <= 0.0 {
            return 0.0;
        }
        let half_sine = node.half_sines.map(f64::from);
        let spread = DVec2::new(
            1.0 - 2.0 * half_sine[0].powi(2),
            2.0 * half_sine[0] * (1.0 - half_sine[0].powi(2)).sqrt(),
        );
        let cos_emission = 1.0 - 2.0 * half_sine[1].powi(2);
        let axis = node.axis.as_dvec3();
        let (distance2, radius2) = (d.length_squared(), extent.length_squared());
        let (mut cos_surface, mut cos_light) = (1.0, 1.0);
        if distance2 > radius2 {
            let scale = distance2.sqrt().recip();
            let sin2 = radius2 / distance2;
            let radius = DVec2::new((1.0 - sin2).sqrt(), sin2.sqrt());
            cos_surface = less(with_sine(self.normal.dot(d) * scale), radius).x;
            cos_light = less(less(with_sine(-axis.dot(d) * scale), spread), radius).x;
            if cos_light - cos_emission < -COSINE_ROUNDING {
                return 0.0;
            }
        }
        let nearest = (d.abs() - extent).max(DVec3::ZERO).length();
        if nearest > 0.0 {
            cos_surface = cos_surface.min(above / nearest);
            let front = (axis.abs().dot(extent) - axis.dot(d)).max(0.0);
            if spread.x >= 0.0 {
                cos_light = cos_light.min(front / nearest * spread.x + spread.y);
            }
        }
        let solid_angle =
            PI * (2.0 * (1.0 - spread.x) + 0.5 * (1.0 - cos_emission * cos_emission) * (1.0 + spread.x));
        let intensity = f64::from(node.power) / solid_angle.max(1e-4);
        let squared = distance2.max(radius2).max(1e-12);
        let mut value = FRAC_1_PI * intensity * cos_surface.max(0.0) * cos_light.max(0.0) / squared;
        if self.gaussian {
            value = self.by_gaussians(&node, radius2) + DEFENSIVE_SHARE * value;
        }
        value.clamp(MIN_IMPORTANCE, 1.0 / MIN_IMPORTANCE)
    }

    fn by_gaussians(&self, node: &Unpacked, radius2: f64) -> f64 {
        let d = (node.center.as_dvec3() - self.position) + node.mean.as_dvec3() * node.extent.as_dvec3();
        let distance2 = d.length_squared().max(1e-20);
        let variance = (f64::from(node.deviation).powi(2) * radius2 / 3.0).max(1e-20);
        let sharpness = (distance2 / variance).clamp(1e-3, 1e4);
        let direction = d / distance2.sqrt();
        let towards = -node.lobe.as_dvec3();
        let r = f64::from(node.lobe_length).min(0.99);
        let emission = r * (3.0 - r * r) / (1.0 - r * r);
        let sum = sharpness * direction + emission * towards;
        let k = sum.length().max(1e-3);
        let axis = sum / k;
        let peak = product_log(direction, sharpness, towards, emission, k).exp();
        let arriving = f64::from(node.power) * norm(sharpness) * norm(emission.max(1e-3)) * peak
            / (norm(k) * (distance2 + variance));
        let diffuse = FRAC_1_PI * clamped_cosine(self.normal.dot(axis), k);
        let m = (k * axis + self.mirror_sharpness * self.mirror).length().max(1e-3);
        let specular = norm(k) * norm(self.mirror_sharpness) / norm(m)
            * product_log(axis, k, self.mirror, self.mirror_sharpness, m).exp();
        arriving * (diffuse + SPECULAR * specular)
    }
}

fn less(a: DVec2, b: DVec2) -> DVec2 {
    if a.x >= b.x { DVec2::X } else { DVec2::new(a.dot(b), a.y * b.x - a.x * b.y) }
}

fn with_sine(cosine: f64) -> DVec2 {
    DVec2::new(cosine, (1.0 - cosine * cosine).max(0.0).sqrt())
}

fn norm(sharpness: f64) -> f64 {
    0.5 * FRAC_1_PI * sharpness / (1.0 - (-2.0 * sharpness).exp())
}

fn product_log(a: DVec3, sharpness_a: f64, b: DVec3, sharpness_b: f64, sum: f64) -> f64 {
    -sharpness_a * sharpness_b * a.distance_squared(b) / (sum + sharpness_a + sharpness_b)
}

/// Mean of the clamped cosine over a normalised Gaussian whose axis has the cosine `cosine`.
fn clamped_cosine(cosine: f64, sharpness: f64) -> f64 {
    let e = (-2.0 * sharpness).exp();
    let mean_cosine = (1.0 + e) / (1.0 - e) - 1.0 / sharpness;
    let x = mean_cosine * cosine;
    0.5 * (x + (x * x + 0.25 * (1.0 - mean_cosine * mean_cosine).max(0.0)).sqrt())
}

/// How many of `steps` go to the first child; `None` if neither child may contribute.
fn first_steps(children: &[LightBvhNode], point: &LightBvhPoint, steps: u32) -> Option<u32> {
    let (a, b) = (point.importance(&children[0]), point.importance(&children[1]));
    match (a > 0.0, b > 0.0) {
        (false, false) => None,
        (false, true) => Some(0),
        (true, false) => Some(steps),
        (true, true) => Some(((a / (a + b) * f64::from(steps)) as u32).clamp(1, steps - 1)),
    }
}

/// Steps as far as they are divided further.
fn refilled(mut steps: u32) -> u32 {
    while steps < MIN_STEPS {
        steps <<= 8;
    }
    steps
}

/// A light and its probability.
pub fn light_bvh_pick(bvh: &LightBvh, point: &LightBvhPoint, bits: [u32; 2]) -> Option<(u32, f64)> {
    let nodes = bvh.nodes();
    let mut link = nodes[0].link;
    if point.importance(&nodes[0]) <= 0.0 {
        return None;
    }
    let (mut steps, mut place, mut used, mut pmf) = (1u32 << 31, bits[0] >> 1, 0, 1.0);
    while link & LIGHT_BVH_LEAF == 0 {
        let children = &nodes[link as usize..][..2];
        let first = first_steps(children, point, steps)?;
        let second = place >= first;
        let taken = if second { steps - first } else { first };
        place -= if second { first } else { 0 };
        pmf *= f64::from(taken) / f64::from(steps);
        steps = taken;
        while steps < MIN_STEPS {
            let word = if used < 4 { bits[1] >> (8 * used) } else { pcg(bits[1].wrapping_add(used)) };
            steps <<= 8;
            place = place << 8 | word & 255;
            used += 1;
        }
        link = children[usize::from(second)].link;
    }
    Some((link & !LIGHT_BVH_LEAF, pmf))
}

/// Probability with which [`light_bvh_pick`] returns a light.
pub fn light_bvh_pmf(bvh: &LightBvh, point: &LightBvhPoint, light: u32) -> f64 {
    let nodes = bvh.nodes();
    let mut trail = bvh.trails().get(light as usize).copied().unwrap_or(NO_TRAIL);
    if trail == NO_TRAIL || point.importance(&nodes[0]) <= 0.0 {
        return 0.0;
    }
    let (mut link, mut steps, mut pmf) = (nodes[0].link, 1u32 << 31, 1.0);
    while link & LIGHT_BVH_LEAF == 0 {
        let children = &nodes[link as usize..][..2];
        let Some(first) = first_steps(children, point, steps) else { return 0.0 };
        let second = trail & 1 != 0;
        let taken = if second { steps - first } else { first };
        if taken == 0 {
            return 0.0;
        }
        pmf *= f64::from(taken) / f64::from(steps);
        steps = refilled(taken);
        link = children[usize::from(second)].link;
        trail >>= 1;
    }
    pmf
}

/// Probabilities of all lights, from one traversal; second: the probability of no light, of branches where neither child may
/// contribute although their parent may.
pub fn light_bvh_pmfs(bvh: &LightBvh, point: &LightBvhPoint) -> (Vec<f64>, f64) {
    let nodes = bvh.nodes();
    let (mut pmfs, mut none) = (vec![0.0; bvh.trails().len()], 0.0);
    if point.importance(&nodes[0]) <= 0.0 {
        return (pmfs, 1.0);
    }
    let mut stack = vec![(nodes[0].link, 1u32 << 31, 1.0)];
    while let Some((link, steps, pmf)) = stack.pop() {
        if link & LIGHT_BVH_LEAF != 0 {
            pmfs[(link & !LIGHT_BVH_LEAF) as usize] = pmf;
            continue;
        }
        let children = &nodes[link as usize..][..2];
        let Some(first) = first_steps(children, point, steps) else {
            none += pmf;
            continue;
        };
        for (child, taken) in children.iter().zip([first, steps - first]) {
            if taken > 0 {
                stack.push((child.link, refilled(taken), pmf * (f64::from(taken) / f64::from(steps))));
            }
        }
    }
    (pmfs, none)
}
