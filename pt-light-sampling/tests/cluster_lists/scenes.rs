//! Lists of the built-in scenes: where points are shaded, what changes with time, what is visible.

use super::emitters::{EXACT, Random, point};
use pt_core::trace::{BvhQuality, NativeScene};
use pt_light_sampling::cluster_lists::{
    ClusterBox, ClusterLists, ListLimits, ListUpdate, MIN_CATCH_ALL, VisibilityEstimate, changing_lights,
    cluster_boxes,
};
use pt_light_sampling::{AliasTable, EmissiveTriangle, LightBounds, LightLists, local_lights};
use pt_scene::glam::Vec3;
use pt_scene::gpu::{mesh_geometry, placements};
use pt_scene::{Clusters, Light, Scene, builtin};
use pt_shaders::records::Ray;

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

    fn centroid(&self, light: usize) -> Vec3 {
        let t = &self.emissives[light];
        let instance = &self.scene.instances[t.instance as usize];
        let corners = self.scene.meshes[instance.mesh as usize].triangle(t.triangle as usize);
        instance.world_from_object.transform_point3((corners[0] + corners[1] + corners[2]) / 3.0)
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
            let to = lamps.centroid(light as usize) + 1e-4 * emitter.axis - position;
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
