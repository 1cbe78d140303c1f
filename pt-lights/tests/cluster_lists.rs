//! Lists of lights per cluster: nothing that shines is lost, what is left out is caught, updates equal new lists.

use pt_core::rng::pcg4d;
use pt_core::trace::{BvhQuality, NativeScene};
use pt_lights::cluster_lists::{
    ClusterBox, ClusterLists, ListLimits, ListUpdate, MAX_CATCH_ALL, MIN_CATCH_ALL, VisibilityEstimate,
    changing_lights, cluster_boxes,
};
use pt_lights::{AliasTable, EmissiveTriangle, LightBounds, LightLists, local_lights};
use pt_scene::glam::{DVec3, Vec3};
use pt_scene::gpu::{mesh_geometry, placements};
use pt_scene::{Bounds, Clusters, Light, Scene, builtin};
use pt_shaders::records::Ray;

/// Nothing is left out but what exact tests reject.
const EXACT: ListLimits = ListLimits { min_share: 0.0, max_per_cluster: usize::MAX, max_entries: usize::MAX };

/// Reproducible random numbers.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 += 1;
        pcg4d([self.0, 0, 0, 5])[0] as f32 / u32::MAX as f32
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> Vec3 {
        (self.vec3() - 0.5).normalize_or(Vec3::Y)
    }

    fn inside(&mut self, b: &Bounds) -> Vec3 {
        // Also in the faces, edges and corners.
        let t = self.vec3().to_array().map(|t| (1.5 * t - 0.25).clamp(0.0, 1.0));
        b.min + Vec3::from(t) * b.size()
    }
}

/// A light and how it really shines.
#[derive(Clone, Copy)]
enum Emitter {
    Triangle {
        corners: [Vec3; 3],
        both_sides: bool,
    },
    Sphere {
        center: Vec3,
        radius: f32,
    },
    Spot {
        center: Vec3,
        radius: f32,
        axis: Vec3,
        outer: f32,
    },
    /// Any cone of normals and of emission round them, as nodes of light trees have it.
    Cones {
        bounds: Bounds,
        axis: Vec3,
        spread: f32,
        emission: f32,
    },
}

impl Emitter {
    fn random(r: &mut Random) -> Self {
        let center = 10.0 * r.vec3();
        let size = if r.next() < 0.5 { 0.1 } else { 4.0 * r.next() };
        let radius = if r.next() < 0.5 { 0.0 } else { 0.3 * size };
        match (r.next() * 8.0) as u32 {
            0..3 => Self::Triangle {
                corners: [0; 3].map(|_| center + size * (r.vec3() - 0.5)),
                both_sides: r.next() < 0.1,
            },
            // In the plane of an axis, as lamps at a ceiling are.
            3 => {
                let corners = [0; 3].map(|_| (center + size * (r.vec3() - 0.5)).with_y(center.y));
                Self::Triangle { corners, both_sides: false }
            }
            4 => Self::Sphere { center, radius },
            5 | 6 => Self::Spot {
                center,
                radius,
                axis: r.direction(),
                outer: std::f32::consts::FRAC_PI_2 * r.next(),
            },
            _ => {
                let half = 0.5 * size * r.vec3();
                Self::Cones {
                    bounds: Bounds { min: center - half, max: center + half },
                    axis: r.direction(),
                    spread: 3.0 * r.next(),
                    emission: 1.5 * r.next(),
                }
            }
        }
    }

    fn bounds(&self, power: f32) -> LightBounds {
        let of = |bounds, axis, cos_spread, cos_emission| LightBounds {
            bounds,
            axis,
            cos_spread,
            cos_emission,
            power,
        };
        let ball = |center: Vec3, radius: f32| Bounds { min: center - radius, max: center + radius };
        match *self {
            Self::Triangle { corners: [a, b, c], both_sides } => {
                let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
                let bounds = Bounds { min: a.min(b).min(c), max: a.max(b).max(c) };
                of(bounds, normal, if both_sides { -1.0 } else { 1.0 }, 0.0)
            }
            Self::Sphere { center, radius } => of(ball(center, radius), Vec3::Y, -1.0, 0.0),
            Self::Spot { center, radius, axis, outer } => of(ball(center, radius), axis, 1.0, outer.cos()),
            Self::Cones { bounds, axis, spread, emission } => of(bounds, axis, spread.cos(), emission.cos()),
        }
    }

    /// Whether some point of it, drawn at random, emits towards `x`.
    fn lights(&self, x: Vec3, r: &mut Random) -> bool {
        let within = |from: Vec3, axis: Vec3, angle: f32| {
            let to: DVec3 = (x - from).as_dvec3();
            to.normalize_or_zero().dot(axis.as_dvec3()) > f64::from(angle).cos()
        };
        match *self {
            Self::Triangle { corners: [a, b, c], both_sides } => {
                let [u, v] = [r.next(), r.next()];
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let y = a + u * (b - a) + v * (c - a);
                let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero();
                both_sides || (x - y).as_dvec3().dot(normal) > 1e-6
            }
            Self::Sphere { .. } => true,
            Self::Spot { center, radius, axis, outer } => {
                within(center + radius * r.direction(), axis, outer)
            }
            Self::Cones { bounds, axis, spread, emission } => {
                within(r.inside(&bounds), axis, spread + emission)
            }
        }
    }
}

fn closed(bounds: Bounds) -> ClusterBox {
    ClusterBox { bounds, open: false }
}

fn random_boxes(r: &mut Random, count: usize) -> Vec<ClusterBox> {
    let of = |_| {
        let min = 10.0 * r.vec3();
        // Flat ones and points too.
        let size = 3.0 * r.vec3() * Vec3::from(r.vec3().to_array().map(|x| f32::from(x > 0.2)));
        closed(Bounds { min, max: min + size })
    };
    (0..count).map(of).collect()
}

#[test]
fn lights_that_reach_a_cluster_are_listed_or_caught() {
    let mut r = Random(0);
    let emitters: Vec<Emitter> = (0..200).map(|_| Emitter::random(&mut r)).collect();
    let lights: Vec<LightBounds> = emitters.iter().map(|e| e.bounds(10f32.powf(4.0 * r.next()))).collect();
    let boxes = random_boxes(&mut r, 60);
    let exact = ClusterLists::new(boxes.clone(), &lights, &[], EXACT, None);
    assert!(exact.catch_all.iter().all(|&p| p == 0.0));
    let limits = ListLimits { min_share: 1e-2, max_per_cluster: 30, max_entries: 1000 };
    let limited = ClusterLists::new(boxes.clone(), &lights, &[], limits, None);
    let (mut reached, mut rejected, mut unlit) = (0, 0, 0);
    for (cluster, of) in boxes.iter().enumerate() {
        for (light, emitter) in (0..).zip(&emitters) {
            let lit = (0..300).any(|_| {
                let x = r.inside(&of.bounds);
                emitter.lights(x, &mut r)
            });
            let listed = exact.fixed.position(cluster, light).is_some();
            reached += usize::from(lit);
            unlit += usize::from(!lit);
            rejected += usize::from(!listed);
            assert!(listed || !lit, "light {light} is missing in cluster {cluster}");
            let found = limited.fixed.position(cluster, light).is_some() || limited.catch_all[cluster] > 0.0;
            assert!(found || !lit, "light {light} is lost in cluster {cluster}");
        }
    }
    println!("{reached} pairs lit, {unlit} not as far as samples tell, of these {rejected} rejected");
    // The tests reject most of what there is to reject.
    assert!(unlit > 1000 && rejected * 10 > unlit * 9, "{rejected} of {unlit}");
    assert!(limited.catch_all.iter().any(|&p| p > 0.0));
}

/// What a sampler needs: list and power together pick every light that the lists or the power have, with a total of 1.
#[test]
fn lists_and_catch_all_fit_together() {
    let mut r = Random(70_000);
    let lights: Vec<LightBounds> = (0..300).map(|_| Emitter::random(&mut r).bounds(r.next())).collect();
    let boxes = random_boxes(&mut r, 40);
    for limits in [
        EXACT,
        ListLimits { max_per_cluster: 10, ..EXACT },
        ListLimits { max_entries: 500, ..EXACT },
        ListLimits { max_per_cluster: 0, ..EXACT },
        ListLimits { min_share: 1e-2, ..EXACT },
        ListLimits { min_share: 2.0, ..EXACT },
    ] {
        let may_change: Vec<bool> = (0..lights.len()).map(|i| i % 7 == 0).collect();
        let lists = ClusterLists::new(boxes.clone(), &lights, &may_change, limits, None);
        assert_eq!((lists.count(), lists.catch_all.len()), (40, 40));
        for (part, changes) in [(&lists.fixed, false), (&lists.changing, true)] {
            assert_eq!(part.offsets.len(), 41);
            assert_eq!(*part.offsets.last().unwrap() as usize, part.entries.len());
            assert!(part.entries.len() <= limits.max_entries);
            for cluster in 0..40 {
                let list = part.list(cluster);
                assert!(list.len() <= limits.max_per_cluster);
                assert!(list.is_sorted_by(|a, b| a < b), "{list:?}");
                assert!(list.iter().all(|&l| may_change[l as usize] == changes));
                assert!((0..).zip(list).all(|(i, &l)| part.position(cluster, l) == Some(i)));
            }
        }
        for (cluster, &p) in lists.catch_all.iter().enumerate() {
            let empty = lists.fixed.list(cluster).is_empty() && lists.changing.list(cluster).is_empty();
            let in_range = (MIN_CATCH_ALL..=MAX_CATCH_ALL).contains(&p);
            assert!(if empty { p == 0.0 || p == 1.0 } else { p == 0.0 || in_range }, "{p}");
        }
    }
}

fn point(position: Vec3, power: f32) -> LightBounds {
    Emitter::Sphere { center: position, radius: 0.0 }.bounds(power)
}

#[test]
fn the_strongest_stay() {
    // Seven lights at the same distance, and one that is as strong as the strongest but far away.
    let mut lights: Vec<LightBounds> =
        [3.0, 9.0, 1.0, 7.0, 5.0, 8.0, 2.0].map(|power| point(Vec3::X * 3.0, power)).into();
    lights.push(point(Vec3::X * 30.0, 9.0));
    let unit = Bounds { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) };
    let far = Bounds { min: unit.min - 60.0 * Vec3::X, max: unit.max - 60.0 * Vec3::X };
    let boxes = vec![closed(unit), closed(far)];
    let limited = |limits| ClusterLists::new(boxes.clone(), &lights, &[], limits, None);
    let lists = limited(ListLimits { max_per_cluster: 3, ..EXACT });
    assert_eq!(lists.fixed.list(0), [1, 3, 5]);
    // (3 + 1 + 5 + 2 + 0.09) of 35.09.
    assert!((lists.catch_all[0] - 0.316).abs() < 0.005, "{}", lists.catch_all[0]);
    // The entries that count most in their own cluster stay, however dim the cluster is.
    let lists = limited(ListLimits { max_entries: 8, ..EXACT });
    assert_eq!(lists.fixed.list(0), [0, 1, 3, 4, 5]);
    assert_eq!(lists.fixed.list(1), [1, 3, 5]);
    let lists = limited(ListLimits { min_share: 0.01, ..EXACT });
    assert_eq!(lists.fixed.list(0), [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(lists.catch_all[0], MIN_CATCH_ALL);
    assert_eq!((lists.fixed.list(1).len(), lists.catch_all[1]), (8, 0.0));
}

#[test]
fn dark_lights_are_nowhere_and_count_for_nothing() {
    let lights = [0.0, 1.0, -1.0, 1e-44].map(|power| point(Vec3::ONE, power));
    let boxes = vec![closed(Bounds { min: Vec3::ZERO, max: Vec3::ONE })];
    let lists = ClusterLists::new(boxes.clone(), &lights, &[], EXACT, None);
    assert_eq!((lists.fixed.list(0), lists.catch_all[0]), (&[1, 3][..], 0.0));
    let lists = ClusterLists::new(boxes, &lights, &[], ListLimits::default(), None);
    assert_eq!((lists.fixed.list(0), lists.catch_all[0]), (&[1][..], MIN_CATCH_ALL));
}

#[test]
fn unusual_input_loses_no_light() {
    let unit = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
    let limits = ListLimits::default();
    // No lights; no clusters.
    let none = ClusterLists::new(vec![closed(unit)], &[], &[], limits, None);
    assert_eq!((none.fixed.list(0), none.catch_all[0]), (&[][..], 0.0));
    assert_eq!(ClusterLists::new(Vec::new(), &[point(Vec3::ONE, 1.0)], &[], limits, None).count(), 0);
    // A strong light, and lights of which nothing is known.
    let lost = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38];
    let mut lights: Vec<LightBounds> = vec![point(Vec3::ONE, 1e6)];
    let up = |at: Vec3| {
        let corners = [Vec3::ZERO, Vec3::Z, Vec3::X].map(|p| at + p);
        Emitter::Triangle { corners, both_sides: false }.bounds(1.0)
    };
    lights.extend(lost[..3].iter().map(|&x| up(Vec3::new(0.0, x, 0.0))));
    lights.push(LightBounds { axis: Vec3::NAN, ..up(5.0 * Vec3::Y) });
    lights.push(LightBounds { power: f32::NAN, ..up(-5.0 * Vec3::Y) });
    lights.push(LightBounds { power: f32::INFINITY, ..up(-5.0 * Vec3::Y) });
    lights.push(LightBounds { cos_emission: f32::NAN, ..up(-5.0 * Vec3::Y) });
    // Farther apart than single precision has numbers for.
    lights.push(LightBounds {
        bounds: Bounds { min: Vec3::splat(-3e38), max: Vec3::splat(3e38) },
        ..lights[0]
    });
    let lists = ClusterLists::new(vec![closed(unit)], &lights, &[], limits, None);
    assert_eq!((lists.fixed.list(0).len(), lists.catch_all[0]), (lights.len(), 0.0));
    // They also stay before all others when there is little room.
    let short = ListLimits { max_per_cluster: 8, ..limits };
    let lists = ClusterLists::new(vec![closed(unit)], &lights, &[], short, None);
    assert_eq!(lists.fixed.list(0), [1, 2, 3, 4, 5, 6, 7, 8]);
    // Boxes of which nothing is known.
    let lights: Vec<LightBounds> =
        (0..20).map(|i| LightBounds { power: i as f32, ..up(Vec3::Y * i as f32) }).collect();
    for x in lost {
        let bounds = Bounds { min: Vec3::splat(-x), max: Vec3::splat(x) };
        let lists = ClusterLists::new(vec![closed(bounds)], &lights, &[], limits, None);
        assert_eq!((lists.fixed.list(0).len(), lists.catch_all[0]), (19, 0.0), "{x}");
    }
    // A box without size, and a light in it.
    let at = Bounds { min: Vec3::ZERO, max: Vec3::ZERO };
    let lights = [point(Vec3::ZERO, 1e-3), point(Vec3::X, 1e6), up(Vec3::ZERO), up(Vec3::Y)];
    let lists = ClusterLists::new(vec![closed(at)], &lights, &[], limits, None);
    assert_eq!(lists.fixed.list(0)[..2], [0, 1]);
    assert_eq!(lists.fixed.position(0, 3), None);
}

#[test]
fn points_beyond_an_open_box_are_caught() {
    let down = |y: f32| {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Z].map(|p| p + y * Vec3::Y);
        Emitter::Triangle { corners, both_sides: false }.bounds(1.0)
    };
    let bounds = Bounds { min: Vec3::Y, max: Vec3::new(1.0, 2.0, 1.0) };
    let boxes = [false, true].map(|open| ClusterBox { bounds, open });
    let lists = ClusterLists::new(boxes.into(), &[down(3.0), down(0.0)], &[], EXACT, None);
    assert_eq!([0, 1].map(|c| lists.fixed.list(c)), [[0], [0]]);
    assert_eq!(lists.catch_all, [0.0, MIN_CATCH_ALL]);
}

struct Prepared {
    scene: Scene,
    emissives: Vec<EmissiveTriangle>,
    clusters: Clusters,
    boxes: Vec<ClusterBox>,
    may_change: Vec<bool>,
}

impl Prepared {
    fn new(scene: Scene, clusters: usize) -> Self {
        let emissives = LightLists::new(&scene).emissives;
        let clusters = Clusters::new(&scene, clusters);
        let boxes = cluster_boxes(&scene, &clusters);
        let may_change = changing_lights(&scene, &emissives);
        Self { scene, emissives, clusters, boxes, may_change }
    }

    fn lights(&self) -> Vec<LightBounds> {
        local_lights(&self.scene, &self.emissives)
    }

    fn lists(&self, limits: ListLimits) -> ClusterLists {
        ClusterLists::new(self.boxes.clone(), &self.lights(), &self.may_change, limits, None)
    }
}

#[test]
fn boxes_have_all_points_that_may_be_shaded() {
    let still = Prepared::new(builtin("lamps").unwrap(), 64);
    for (of, contents) in still.boxes.iter().zip(still.clusters.contents(&still.scene)) {
        assert!(contents.bounds.is_none_or(|b| of.bounds == b && !of.open));
        assert!(of.bounds.size().is_finite());
    }
    let moving = Prepared::new(builtin("flicker").unwrap(), 64);
    let mut open = 0;
    for (c, of) in (0..).zip(&moving.boxes) {
        let cell = moving.clusters.cell(c);
        assert_eq!(of.open, !(cell.min.is_finite() && cell.max.is_finite()));
        assert!(of.open || of.bounds == cell);
        assert!(of.bounds.size().is_finite() && of.bounds.size().min_element() > 0.0);
        open += usize::from(of.open);
    }
    assert!(open > 0 && open < 64, "{open}");
    // Everything that moves stays within the boxes for a while.
    let mut scene = moving.scene.clone();
    for frame in 0..60 {
        scene.set_time(f64::from(frame) / 10.0, 0.0);
        for instance in &scene.instances {
            for &p in &scene.meshes[instance.mesh as usize].positions {
                let p = instance.world_from_object.transform_point3(p);
                let b = moving.boxes[moving.clusters.find(p) as usize].bounds;
                assert!(p.cmpge(b.min).all() && p.cmple(b.max).all(), "{}: {p}", instance.name);
            }
        }
    }
    // A scene without anything.
    let nothing = Prepared::new(Scene::default(), 64);
    assert_eq!((nothing.boxes.len(), nothing.lights().len()), (1, 0));
    assert!(nothing.boxes[0].bounds.size().is_finite() && nothing.boxes[0].open);
    assert_eq!(nothing.lists(ListLimits::default()).catch_all, [0.0]);
}

/// The orbiter and the pendulum move, the alarm blinks on its place: in every frame the lists equal new ones, and have the lights
/// that are lit.
#[test]
fn updates_equal_new_lists() {
    let mut flicker = Prepared::new(builtin("flicker").unwrap(), 128);
    let limits = ListLimits { min_share: 1e-2, max_per_cluster: 200, max_entries: 20_000 };
    let mut lists = flicker.lists(limits);
    let first_punctual = flicker.emissives.len() as u32;
    let alarm = first_punctual + 1;
    assert_eq!(flicker.scene.lights[1].name, "alarm");
    let (mut on, mut off) = (0, 0);
    for frame in 1..40 {
        let time = f64::from(frame) / 20.0;
        flicker.scene.set_time(time, time - 0.05);
        let lights = flicker.lights();
        assert_eq!(lists.update(&lights, &flicker.may_change, None), ListUpdate::Changing);
        assert!(lists == flicker.lists(limits), "{time} s");
        assert_eq!(lists.update(&lights, &flicker.may_change, None), ListUpdate::Nothing);
        let listed = (0..lists.count()).filter(|&c| lists.changing.position(c, alarm).is_some()).count();
        let lit = lights[alarm as usize].power > 0.0;
        assert_eq!(listed > 0, lit, "{time} s");
        on += usize::from(lit);
        off += usize::from(!lit);
        // Whatever cluster the orbiter is in, it is listed there.
        let orbiter = lights[first_punctual as usize].bounds.center();
        assert!(lists.changing.position(flicker.clusters.find(orbiter) as usize, first_punctual).is_some());
    }
    assert!(on > 5 && off > 5, "{on} frames on, {off} off");
    // Another light changes, one more appears, one goes: all is new.
    let mut lights = flicker.lights();
    let fixed = flicker.may_change.iter().position(|&c| !c).unwrap();
    lights[fixed].power *= 2.0;
    let check = |lists: &mut ClusterLists, lights: &[LightBounds], may_change: &[bool]| {
        assert_eq!(lists.update(lights, may_change, None), ListUpdate::All);
        let new = ClusterLists::new(flicker.boxes.clone(), lights, may_change, limits, None);
        // Without the lights themselves, of which some are not numbers.
        let parts = |l: &ClusterLists| (l.fixed.clone(), l.changing.clone(), l.catch_all.clone());
        assert!(parts(lists) == parts(&new), "{} lights", lights.len());
    };
    check(&mut lists, &lights, &flicker.may_change);
    lights.push(point(Vec3::ONE, 5.0));
    check(&mut lists, &lights, &flicker.may_change);
    let mut may_change = flicker.may_change.clone();
    may_change.push(true);
    check(&mut lists, &lights, &may_change);
    check(&mut lists, &[], &[]);
    // Values that are not numbers are no change by themselves.
    let lights = [point(Vec3::NAN, f32::NAN)];
    check(&mut lists, &lights, &[]);
    assert_eq!(lists.update(&lights, &[], None), ListUpdate::Nothing);
}

#[test]
fn lights_that_may_change_are_told_apart() {
    let flicker = Prepared::new(builtin("flicker").unwrap(), 1);
    let name = |t: &EmissiveTriangle| flicker.scene.instances[t.instance as usize].name.as_str();
    for (t, &changes) in flicker.emissives.iter().zip(&flicker.may_change) {
        assert_eq!(changes, name(t) == "pendulum", "{}", name(t));
    }
    let mut scene = flicker.scene.clone();
    scene.lights.insert(0, Light::directional("sun", Vec3::NEG_Y, Vec3::ONE));
    scene.lights.push(Light::point("still", Vec3::ZERO, Vec3::ONE));
    let may_change = changing_lights(&scene, &flicker.emissives);
    assert_eq!(may_change[flicker.emissives.len()..], [true, true, true, true, true, false]);
    assert_eq!(may_change.len(), local_lights(&scene, &flicker.emissives).len());
}

#[test]
fn threads_do_not_matter() {
    let mut r = Random(90_000);
    let lights: Vec<LightBounds> = (0..500).map(|_| Emitter::random(&mut r).bounds(r.next())).collect();
    let boxes = random_boxes(&mut r, 200);
    let may_change: Vec<bool> = (0..500).map(|i| i % 3 == 0).collect();
    let limits = ListLimits { min_share: 1e-3, max_per_cluster: 40, max_entries: 4000 };
    let visible = |cluster: u32, light: u32| (cluster + light) % 5 > 0;
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ClusterLists::new(boxes.clone(), &lights, &may_change, limits, Some(&visible)))
    };
    let one = with(1);
    assert!(one == with(3));
    assert!(one.fixed.entries.len() > 1000 && one.changing.entries.len() > 1000);
    for cluster in 0..200 {
        let hidden = |&l: &u32| !visible(cluster as u32, l);
        assert!(!one.fixed.list(cluster).iter().any(hidden));
    }
}

fn print_sizes(name: &str, lists: &ClusterLists) {
    let clusters = lists.count();
    let mut lengths: Vec<usize> =
        (0..clusters).map(|c| lists.fixed.list(c).len() + lists.changing.list(c).len()).collect();
    lengths.sort_unstable();
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    println!(
        "{name}: {clusters} clusters, {} + {} entries, lengths {} / {} / {}, mean catch-all {:.4}",
        lists.fixed.entries.len(),
        lists.changing.entries.len(),
        lengths[0],
        lengths[clusters / 2],
        lengths[clusters - 1],
        mean(&lists.catch_all),
    );
}

#[test]
fn built_in_scenes_have_short_lists() {
    for (name, longest) in [("lamps", 936), ("flicker", 645), ("gallery", 1024)] {
        let scene = Prepared::new(builtin(name).unwrap(), 512);
        let exact = scene.lists(EXACT);
        let lists = scene.lists(ListLimits::default());
        print_sizes(&format!("{name}, {} lights, exact", scene.lights().len()), &exact);
        print_sizes(&format!("{name}, default limits"), &lists);
        let entries = |lists: &ClusterLists| lists.fixed.entries.len() + lists.changing.entries.len();
        let all = scene.lights().len() * lists.count();
        assert!(entries(&exact) < all * 3 / 4, "{name}: {} of {all}", entries(&exact));
        assert!(entries(&lists) <= entries(&exact));
        for c in 0..lists.count() {
            let length = lists.fixed.list(c).len() + lists.changing.list(c).len();
            assert!((1..=longest).contains(&length), "{name}: {length}");
        }
    }
}

/// A cluster of the flat of rooms sees the lamps of its own room and few others.
#[test]
fn visibility_shortens_lists() {
    let lamps = Prepared::new(builtin("lamps").unwrap(), 128);
    let estimate =
        VisibilityEstimate::new(&lamps.scene, &lamps.clusters, &lamps.boxes, &lamps.emissives).unwrap();
    let visible = |cluster, light| estimate.visible(cluster, light);
    let lights = lamps.lights();
    let limits = ListLimits::default();
    let all = lamps.lists(limits);
    let start = std::time::Instant::now();
    let seen = ClusterLists::new(lamps.boxes.clone(), &lights, &lamps.may_change, limits, Some(&visible));
    println!("visibility of {} pairs: {:.2?}", all.fixed.entries.len(), start.elapsed());
    print_sizes("lamps, without visibility", &all);
    print_sizes("lamps, with visibility", &seen);
    let (before, after) = (all.fixed.entries.len(), seen.fixed.entries.len());
    assert!(after * 2 < before, "{after} of {before}");
    // At points on the surfaces, the lists have nearly all of the light that arrives there.
    let native = NativeScene::new(&mesh_geometry(&lamps.scene), &placements(&lamps.scene), BvhQuality::Fast);
    let native = native.unwrap();
    let mut r = Random(120_000);
    let (mut arrives, mut listed, mut points) = (0.0, 0.0, 0);
    for (position, normal) in surface_points(&lamps.scene, 400, &mut r) {
        let cluster = lamps.clusters.find(position) as usize;
        points += 1;
        for (light, emitter) in (0..).zip(&lights) {
            let to = emitter.bounds.center() + 1e-4 * emitter.axis - position;
            let (cos, cos_emitter) = (to.normalize().dot(normal), -to.normalize().dot(emitter.axis));
            let origin = position + 1e-4 * normal;
            let ray = Ray { origin, t_min: 0.0, direction: to - 1e-4 * normal + Vec3::ZERO, t_max: 1.0 };
            if cos > 0.0 && cos_emitter > 0.0 && !native.occluded(&ray, u32::MAX, None) {
                let irradiance = emitter.power * cos * cos_emitter / to.length_squared().max(1e-2);
                arrives += irradiance;
                if seen.fixed.position(cluster, light).is_some() {
                    listed += irradiance;
                }
            }
        }
    }
    println!("{points} points: the lists have {:.2} % of the light", 100.0 * listed / arrives);
    assert!(arrives > 0.0 && listed > 0.98 * arrives, "{listed} of {arrives}");
    // What is hidden is not worth many samples.
    assert!(seen.catch_all.iter().all(|&p| (MIN_CATCH_ALL..0.2).contains(&p)), "{:?}", seen.catch_all);
}

/// Points on surfaces that stand still, and the normals there.
fn surface_points(scene: &Scene, count: usize, r: &mut Random) -> Vec<(Vec3, Vec3)> {
    let mut triangles = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let place = |p| instance.world_from_object.transform_point3(p);
        triangles.extend((0..mesh.triangle_count()).map(|t| mesh.triangle(t).map(place)));
    }
    let areas: Vec<f64> =
        triangles.iter().map(|[a, b, c]| f64::from((b - a).cross(c - a).length())).collect();
    let table = AliasTable::new(&areas).unwrap();
    let point = |_| {
        let [a, b, c] = triangles[table.pick((r.next() * u32::MAX as f32) as u32, r.next().min(0.999))];
        let [u, v] = [r.next(), r.next()];
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        (a + u * (b - a) + v * (c - a), (b - a).cross(c - a).normalize())
    };
    (0..count).map(point).collect()
}

/// Nothing hides a light in a scene without opaque surfaces that stand still.
#[test]
fn what_moves_hides_nothing() {
    let mut scene = builtin("flicker").unwrap();
    let still = |scene: &Scene| {
        let prepared = Prepared::new(scene.clone(), 16);
        let estimate =
            VisibilityEstimate::new(scene, &prepared.clusters, &prepared.boxes, &prepared.emissives).unwrap();
        let lights = prepared.lights().len() as u32;
        let count =
            (0..prepared.boxes.len() as u32).map(|c| (0..lights).filter(|&l| estimate.visible(c, l)).count());
        (count.sum::<usize>(), prepared.boxes.len() * lights as usize)
    };
    let (seen, pairs) = still(&scene);
    assert!(seen < pairs, "{seen} of {pairs}");
    scene.instances.retain(|i| i.motion.is_some());
    let (seen, pairs) = still(&scene);
    assert_eq!(seen, pairs);
}
