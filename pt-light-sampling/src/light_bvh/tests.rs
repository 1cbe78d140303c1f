use super::cone::angle;
use super::*;
use glam::Vec3;
use pt_core::rng::random4;
use pt_scene::Bounds;

fn light(i: u32, stream: u32) -> LightBounds {
    let [x, y, z, kind] = random4([i & 0xffff, i >> 16], stream, 0, 1);
    let [u, v, w, power] = random4([i & 0xffff, i >> 16], stream, 1, 1);
    let at = Vec3::new(x, 0.2 * y, z) * 30.0;
    let size = if kind < 0.3 { Vec3::ZERO } else { 0.5 * Vec3::new(u, v, w) };
    LightBounds {
        bounds: Bounds { min: at, max: at + size },
        axis: (Vec3::new(u, v, w) - 0.5).normalize_or(Vec3::Y),
        cos_spread: if kind < 0.5 { -1.0 } else { 1.0 },
        cos_emission: if kind > 0.8 { 0.7 } else { 0.0 },
        power: 0.01 + power,
        irradiance: 0.0,
    }
}

fn lights(count: u32, stream: u32) -> Vec<LightBounds> {
    (0..count).map(|i| light(i, stream)).collect()
}

/// The light at the end of a trail, and its depth.
fn follow(bvh: &LightBvh, mut trail: u64) -> (u32, u32) {
    let (mut link, mut depth) = (bvh.nodes[0].link, 0);
    while link & LIGHT_BVH_LEAF == 0 {
        link = bvh.nodes[(link + (trail & 1) as u32) as usize].link;
        trail >>= 1;
        depth += 1;
    }
    assert_eq!(trail, 0);
    (link & !LIGHT_BVH_LEAF, depth)
}

/// Every trail leads to its light, and the number of nodes is that of a binary tree; returns the depth.
fn check_trails(bvh: &LightBvh) -> u32 {
    let leaves = (0..).zip(&bvh.trails).filter(|(_, trail)| **trail != NO_TRAIL);
    let depths: Vec<u32> = leaves
        .map(|(light, trail)| {
            let (found, depth) = follow(bvh, *trail);
            assert_eq!(found, light);
            depth
        })
        .collect();
    assert_eq!(bvh.nodes.len(), LightBvh::max_nodes(depths.len()));
    depths.into_iter().max().unwrap_or(0)
}

/// Each node against the lights below it, one by one.
fn check_bounds(bvh: &LightBvh, lights: &[LightBounds]) {
    let total: f32 = lights.iter().map(|light| light.power).sum();
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); bvh.nodes.len()];
    for i in (0..bvh.nodes.len()).rev() {
        let node = &bvh.nodes[i];
        below[i] = match node.link & LIGHT_BVH_LEAF {
            0 => [node.link, node.link + 1].iter().flat_map(|&child| below[child as usize].clone()).collect(),
            _ => vec![(node.link & !LIGHT_BVH_LEAF) as usize],
        };
        let lit: Vec<&LightBounds> = below[i].iter().map(|&l| &lights[l]).filter(|l| l.power > 0.0).collect();
        let power: f32 = lit.iter().map(|light| light.power).sum();
        let known = Unpacked::of(node);
        // Eight digits.
        assert!((known.power - power / total).abs() <= 4e-3 * known.power, "{node:?}: {power} of {total}");
        let Some(lower) = lit.iter().map(|light| light.bounds.min).reduce(Vec3::min) else {
            assert_eq!(known.power, 0.0);
            continue;
        };
        let upper = lit.iter().map(|light| light.bounds.max).fold(lower, Vec3::max);
        let (middle, half) = (known.center.as_dvec3(), known.extent.as_dvec3());
        let (lower, upper) = (lower.as_dvec3(), upper.as_dvec3());
        assert!((middle - half).cmple(lower).all() && (middle + half).cmpge(upper).all(), "{node:?}");
        let needed = (upper - middle).max(middle - lower);
        assert!((half - needed).max_element() <= 0.01 * needed.max_element(), "{node:?}");
        let [spread, emission] = known.half_sines.map(|sine| 2.0 * sine.asin());
        let axis = known.axis;
        for light in &lit {
            assert!(
                angle(axis, light.axis) + light.cos_spread.acos() <= spread + 3e-4
                    || spread > std::f32::consts::PI - 1e-3,
                "{node:?} {light:?}"
            );
            assert!(emission >= light.cos_emission.acos());
        }
        // Not much wider than needed: a leaf is its light.
        if let ([light], true) = (&lit[..], node.link & LIGHT_BVH_LEAF != 0) {
            assert!(
                spread - light.cos_spread.acos() < 0.05 && emission - light.cos_emission.acos() < 0.03,
                "{node:?}"
            );
        }
    }
}

#[test]
fn trees_of_few_lights() {
    for count in 0..6 {
        let lights = lights(count, 0);
        let bvh = LightBvh::new(&lights).unwrap();
        assert_eq!(bvh.nodes.len(), LightBvh::max_nodes(lights.len()));
        assert!(check_trails(&bvh) < 5);
        if count > 0 {
            check_bounds(&bvh, &lights);
        }
    }
    assert_eq!(Unpacked::of(&LightBvh::new(&[]).unwrap().nodes[0]).power, 0.0);
}

/// Lights that are dark or no lights have no leaf; the others are as if they were not there.
#[test]
fn what_is_no_light_is_left_out() {
    let good = lights(20, 1);
    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    let broken = [
        LightBounds { power: 0.0, ..good[0] },
        LightBounds { irradiance: 1.0, ..good[0] },
        LightBounds { power: -1.0, ..good[0] },
        LightBounds { power: f32::NAN, ..good[0] },
        LightBounds { power: f32::INFINITY, ..good[0] },
        LightBounds { axis: nan, ..good[0] },
        LightBounds { axis: Vec3::ZERO, ..good[0] },
        LightBounds { cos_spread: f32::NAN, ..good[0] },
        LightBounds { cos_emission: f32::NAN, ..good[0] },
        LightBounds { bounds: Bounds { min: nan, max: nan }, ..good[0] },
        LightBounds { bounds: Bounds { min: Vec3::ONE, max: Vec3::ZERO }, ..good[0] },
        LightBounds { bounds: Bounds { min: Vec3::ZERO, max: Vec3::INFINITY }, ..good[0] },
    ];
    let all: Vec<LightBounds> = good.iter().chain(&broken).copied().collect();
    let bvh = LightBvh::new(&all).unwrap();
    assert_eq!(bvh.nodes, LightBvh::new(&good).unwrap().nodes);
    assert!(bvh.trails[20..].iter().all(|trail| *trail == NO_TRAIL));
    check_trails(&bvh);
    assert_eq!(LightBvh::new(&broken).unwrap().nodes.len(), 1);
}

/// Lights that no plane parts, and lights of which each is much nearer to the origin than the one before.
#[test]
fn depth_is_bounded() {
    let same = vec![light(3, 2); 1000];
    let bvh = LightBvh::new(&same).unwrap();
    assert_eq!(check_trails(&bvh), 10);
    check_bounds(&bvh, &same);
    let line = (-120..60).flat_map(|e| [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * 2f32.powi(e)));
    let line: Vec<LightBounds> = line
        .map(|at| LightBounds { bounds: Bounds { min: at, max: at }, power: 1.0, ..light(0, 0) })
        .collect();
    let bvh = LightBvh::new(&line).unwrap();
    let depth = check_trails(&bvh);
    assert!((30..=MAX_DEPTH).contains(&depth), "{depth}");
}

#[test]
fn refit_gives_the_bounds_of_the_moved_lights() {
    let first = lights(3000, 3);
    let mut bvh = LightBvh::new(&first).unwrap();
    check_bounds(&bvh, &first);
    let fresh = bvh.clone();
    // All have moved, some have gone dark or lost their place.
    let mut moved = lights(3000, 4);
    moved.iter_mut().step_by(7).for_each(|light| light.power = 0.0);
    moved[1000..1100].iter_mut().for_each(|light| light.power = 0.0);
    assert!(bvh.refit(&moved));
    assert_eq!(bvh.trails, fresh.trails);
    assert_ne!(bvh.nodes, fresh.nodes);
    check_bounds(&bvh, &moved);
    // Back again: to the bit.
    assert!(bvh.refit(&first));
    assert_eq!(bvh, fresh);
    // A tree without the dark lights can't show them.
    let mut without = LightBvh::new(&moved).unwrap();
    let before = without.clone();
    assert!(!without.refit(&first) && !without.refit(&first[1..]));
    assert_eq!(without, before);
}

#[test]
fn threads_do_not_matter() {
    let lights = lights(20_000, 5);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| LightBvh::new(&lights).unwrap())
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert!(check_trails(&one) < 40);
}
