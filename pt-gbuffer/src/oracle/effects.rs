//! The effects along a ray: all of them sorted, each fog volume integrated in small steps.

use glam::DVec3;
use pt_scene::{Effects, FogVolume, Look};

/// Steps of a midpoint rule between two places at which something begins or ends.
const STEPS: usize = 64;

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Linear radiance.
    pub radiance: DVec3,
    /// Share of the light behind that is left.
    pub transmittance: f64,
}

impl Seen {
    /// What is seen when `behind` is.
    pub fn over(&self, behind: DVec3) -> DVec3 {
        self.radiance + self.transmittance * behind
    }

    fn add(&mut self, radiance: DVec3, opacity: f64) {
        self.radiance += self.transmittance * radiance;
        self.transmittance *= 1.0 - opacity;
    }
}

/// What a ray of unit direction meets up to `t_max`. Sprites count as if they had no texture.
pub fn along(effects: &Effects, origin: DVec3, direction: DVec3, t_max: f64) -> Seen {
    let mut met = bodies(effects, origin, direction, t_max);
    met.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut seen = Seen { radiance: DVec3::ZERO, transmittance: 1.0 };
    let mut from = 0.0;
    for (t, radiance, opacity) in met {
        add_fog(effects, origin, direction, [from, t], &mut seen);
        seen.add(radiance, opacity);
        from = t;
    }
    add_fog(effects, origin, direction, [from, t_max], &mut seen);
    seen
}

/// Distance, radiance and opacity of each particle, beam and sprite on the way.
fn bodies(effects: &Effects, origin: DVec3, direction: DVec3, t_max: f64) -> Vec<(f64, DVec3, f64)> {
    let round = |ends: [DVec3; 2], radius: f32, look: &Look| {
        let (t, distance) = nearest(origin, direction, ends);
        let part = 1.0 - (distance / f64::from(radius)).powi(2);
        (part > 0.0 && t < t_max).then(|| weighted(t, part * part, look))
    };
    let place = |p: glam::Vec3, drift: &pt_scene::Drift| (p + drift.at(effects.time)).as_dvec3();
    let particles = effects.particles.iter().filter_map(|e| {
        let center = place(e.position, &e.drift);
        round([center, center], e.radius, &e.look)
    });
    let beams =
        effects.beams.iter().filter_map(|e| round(e.ends.map(|end| place(end, &e.drift)), e.radius, &e.look));
    let sprites = effects.sprites.iter().filter_map(|e| {
        let [u, v] = e.half_sides.map(|side| side.as_dvec3());
        // origin + t direction = center + a u + b v, by Cramer's rule.
        let to = origin - place(e.position, &e.drift);
        let determinant = u.cross(v).dot(-direction);
        let t = u.cross(v).dot(to) / determinant;
        let (a, b) = (to.cross(v).dot(-direction) / determinant, u.cross(to).dot(-direction) / determinant);
        let inside = t > 0.0 && t < t_max && a.abs() <= 1.0 && b.abs() <= 1.0;
        inside.then(|| weighted(t, 1.0, &e.look))
    });
    particles.chain(beams).chain(sprites).collect()
}

fn weighted(t: f64, part: f64, look: &Look) -> (f64, DVec3, f64) {
    (t, part * look.radiance.as_dvec3(), part * f64::from(look.opacity))
}

/// Where a ray is nearest to a segment, and how near: the distance of the segment's points is a convex function, whose minimum is searched.
pub fn nearest(origin: DVec3, direction: DVec3, ends: [DVec3; 2]) -> (f64, f64) {
    let at = |s: f64| {
        let point = ends[0].lerp(ends[1], s);
        let t = (point - origin).dot(direction).max(0.0);
        (t, point.distance(origin + t * direction))
    };
    if ends[0] == ends[1] {
        return at(0.0);
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a).1 < at(b).1 { high = b } else { low = a }
    }
    at(0.5 * (low + high))
}

/// Entry and exit of the box of a fog volume; empty where the first is not less.
pub fn interval(fog: &FogVolume, time: f64, origin: DVec3, direction: DVec3) -> [f64; 2] {
    let [a, b] = fog.corners.map(|c| ((c + fog.drift.at(time)).as_dvec3() - origin) / direction);
    [a.min(b).max_element().max(0.0), a.max(b).min_element()]
}

fn add_fog(effects: &Effects, origin: DVec3, direction: DVec3, [from, to]: [f64; 2], seen: &mut Seen) {
    let fog: Vec<_> =
        effects.fog.iter().map(|fog| (fog, interval(fog, effects.time, origin, direction))).collect();
    let mut places: Vec<f64> = fog.iter().flat_map(|(_, ends)| *ends).map(|t| t.clamp(from, to)).collect();
    places.sort_by(f64::total_cmp);
    for pair in places.windows(2).filter(|pair| pair[0] < pair[1]) {
        let step = (pair[1] - pair[0]) / STEPS as f64;
        for i in 0..STEPS {
            let t = pair[0] + (i as f64 + 0.5) * step;
            let position = origin + t * direction;
            let (mut depth, mut light) = (0.0, DVec3::ZERO);
            for (fog, _) in fog.iter().filter(|(_, ends)| ends[0] < t && t < ends[1]) {
                let corner = (fog.corners[0] + fog.drift.at(effects.time)).as_dvec3();
                let density = f64::from(fog.density) + fog.gradient.as_dvec3().dot(position - corner);
                depth += step * density;
                light += step * density * fog.radiance.as_dvec3();
            }
            if depth > 0.0 {
                let opacity = -(-depth).exp_m1();
                seen.add(light * (opacity / depth), opacity);
            }
        }
    }
}
