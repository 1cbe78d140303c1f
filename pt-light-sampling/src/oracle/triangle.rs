//! Host twins of lights/triangle_sampling.glsl. Where the kernels invert equations, these search by bisection.

use super::sampling::sample_triangle;
use glam::{DVec2, DVec3};
use pt_shaders::records::AreaSampling;

/// A point of a triangle as a shading point sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// Weights of the second and third corner.
    pub barycentrics: DVec2,
    /// Unit, from the shading point.
    pub direction: DVec3,
    /// Metres.
    pub distance: f64,
    /// Density per solid angle at the shading point.
    pub pdf: f64,
}

/// Solid angle of the triangle with these corners, relative to the point that sees it (Van Oosterom and Strackee 1983, eq. 8).
pub fn triangle_solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let volume = a.dot((b - a).cross(c - a)).abs();
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// Integral of the clamped cosine over the triangle with these corners, relative to the receiver with this normal: the part above the
/// horizon by Lambert's formula for polygons (Lambert 1760).
pub fn triangle_irradiance(normal: DVec3, corners: [DVec3; 3]) -> f64 {
    let mut above = Vec::with_capacity(4);
    for (from, to) in (0..3).map(|i| (corners[i], corners[(i + 1) % 3])) {
        let (h0, h1) = (from.dot(normal), to.dot(normal));
        if h0 >= 0.0 {
            above.push(from);
        }
        if (h0 < 0.0) != (h1 < 0.0) {
            above.push(from + (to - from) * (h0 / (h0 - h1)));
        }
    }
    let edge = |i: usize| {
        let (from, to) = (above[i], above[(i + 1) % above.len()]);
        let across = from.cross(to - from);
        let angle = across.length().atan2(from.dot(to));
        if angle > 0.0 { 0.5 * angle * across.normalize().dot(normal) } else { 0.0 }
    };
    (0..above.len()).map(edge).sum::<f64>().abs()
}

/// The argument in [0, 1] at which a rising function reaches `value`.
fn bisect(value: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..44 {
        let middle = 0.5 * (low + high);
        if f(middle) < value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// A triangle relative to its shading point.
struct Seen {
    a: DVec3,
    e1: DVec3,
    e2: DVec3,
}

impl Seen {
    fn corners(&self) -> [DVec3; 3] {
        [self.a, self.a + self.e1, self.a + self.e2]
    }

    fn at(&self, barycentrics: DVec2) -> DVec3 {
        self.a + barycentrics.x * self.e1 + barycentrics.y * self.e2
    }

    fn solid_angle(&self) -> f64 {
        let [a, b, c] = self.corners();
        triangle_solid_angle(a, b, c)
    }

    /// Solid angle between the edge from a to b and the point at `t` on the edge from a to c.
    fn solid_angle_up_to(&self, t: f64) -> f64 {
        let [a, b, _] = self.corners();
        triangle_solid_angle(a, b, a + t * self.e2)
    }

    /// 1 - cos of the angle from b to the point with share `u` of the way from b to the point at `t`.
    fn one_minus_cos(&self, t: f64, u: f64) -> f64 {
        let b = (self.a + self.e1).normalize();
        let p = self.a + self.e1 + u * (t * self.e2 - self.e1);
        0.5 * (p.normalize() - b).length_squared()
    }

    /// Barycentrics that are uniform in solid angle, by the map of Arvo 1995.
    fn spherical_to_barycentrics(&self, xi: DVec2) -> DVec2 {
        let t = bisect(xi.x * self.solid_angle(), |t| self.solid_angle_up_to(t));
        let u = bisect(xi.y * self.one_minus_cos(t, 1.0), |u| self.one_minus_cos(t, u));
        DVec2::new(1.0 - u, u * t)
    }

    fn barycentrics_to_spherical(&self, barycentrics: DVec2) -> DVec2 {
        let u = 1.0 - barycentrics.x;
        let t = (barycentrics.y / u.max(1e-300)).min(1.0);
        DVec2::new(
            self.solid_angle_up_to(t) / self.solid_angle(),
            self.one_minus_cos(t, u) / self.one_minus_cos(t, 1.0),
        )
    }

    /// Values at the corners of the linear function that stands for the cosine.
    fn cosine_weights(&self, normal: DVec3) -> DVec3 {
        let [a, b, c] = self.corners().map(DVec3::normalize);
        let cos = |v: DVec3| v.normalize().dot(normal).max(0.0);
        let corners = DVec3::new(cos(a), cos(b), cos(c));
        let middles = DVec3::new(cos(a + b), cos(b + c), cos(c + a));
        corners + (middles.element_sum() / 3.0 - corners.element_sum() / 3.0).max(0.0)
    }
}

/// Density on the unit square, linear in the barycentrics of the triangle a (0, 1), b (y = 0), c (1, 1) in (x, sqrt(y)).
fn warp_pdf(weights: DVec3, xi: DVec2) -> f64 {
    let r = xi.y.sqrt();
    let linear = weights.dot(DVec3::new(r * (1.0 - xi.x), 1.0 - r, r * xi.x));
    3.0 * linear / weights.element_sum()
}

fn warp(weights: DVec3, xi: DVec2) -> DVec2 {
    let v = xi.y * weights.element_sum();
    let r = if v < weights.y {
        bisect(v / weights.y, |r| r * r * (3.0 - 2.0 * r))
    } else {
        ((weights.element_sum() - v) / (weights.x + weights.z)).cbrt()
    };
    let ends = [weights.x, weights.z].map(|end| (1.0 - r) * weights.y + r * end);
    let cdf = |x: f64| x * (ends[0] + 0.5 * x * (ends[1] - ends[0]));
    DVec2::new(bisect(xi.x * cdf(1.0), cdf), r * r)
}

/// A point of the triangle v0, v0 + e1, v0 + e2; `None` when the shading point does not see it, or with [`AreaSampling::Projected`]
/// when it is below the horizon.
pub fn sample_triangle_point(
    method: AreaSampling,
    position: DVec3,
    normal: DVec3,
    v0: DVec3,
    [e1, e2]: [DVec3; 2],
    xi: DVec2,
) -> Option<TrianglePoint> {
    let seen = Seen { a: v0 - position, e1, e2 };
    let weights = seen.cosine_weights(normal);
    let barycentrics = match method {
        AreaSampling::Uniform => sample_triangle(xi),
        AreaSampling::Spherical => seen.spherical_to_barycentrics(xi),
        AreaSampling::Projected if weights.element_sum() > 0.0 => {
            seen.spherical_to_barycentrics(warp(weights, xi))
        }
        AreaSampling::Projected => return None,
    };
    let d = seen.at(barycentrics);
    let pdf = triangle_point_pdf(method, position, normal, v0, [e1, e2], position + d);
    (pdf > 0.0).then(|| TrianglePoint { barycentrics, direction: d.normalize(), distance: d.length(), pdf })
}

/// Density of [`sample_triangle_point`] for a point of the triangle that something else found.
pub fn triangle_point_pdf(
    method: AreaSampling,
    position: DVec3,
    normal: DVec3,
    v0: DVec3,
    [e1, e2]: [DVec3; 2],
    point: DVec3,
) -> f64 {
    let seen = Seen { a: v0 - position, e1, e2 };
    let across = e1.cross(e2);
    let volume = seen.a.dot(across).abs();
    if volume.is_nan() || volume <= 0.0 {
        return 0.0;
    }
    match method {
        AreaSampling::Uniform => 2.0 * (point - position).length().powi(3) / volume,
        AreaSampling::Spherical => 1.0 / seen.solid_angle(),
        AreaSampling::Projected => {
            let weights = seen.cosine_weights(normal);
            if weights.element_sum() <= 0.0 {
                return 0.0;
            }
            let d = point - v0;
            let on_plane = DVec2::new(d.cross(e2).dot(across), e1.cross(d).dot(across));
            let xi = seen.barycentrics_to_spherical(on_plane / across.length_squared());
            warp_pdf(weights, xi) / seen.solid_angle()
        }
    }
}
