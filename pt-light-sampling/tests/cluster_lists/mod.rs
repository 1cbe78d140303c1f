//! Lists of lights per cluster: nothing that shines is lost, what is left out is caught, updates equal new lists.

mod emitters;
mod scenes;

use emitters::{EXACT, Emitter, Random, closed, point, random_boxes};
use pt_light_sampling::LightBounds;
use pt_light_sampling::cluster_lists::{ClusterBox, ClusterLists, ListLimits, MAX_CATCH_ALL, MIN_CATCH_ALL};
use pt_scene::Bounds;
use pt_scene::glam::Vec3;

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

/// However far a cluster is from everything, a distant light counts there with its irradiance, also where nothing is known of the box.
#[test]
fn distant_lights_count_everywhere() {
    let distant = |irradiance: f32| LightBounds { irradiance, ..point(Vec3::ZERO, 1.0) };
    let lights =
        [point(Vec3::ZERO, 1.0), distant(1e-3), distant(1e-9), LightBounds { power: 0.0, ..distant(1.0) }];
    let near = closed(Bounds { min: Vec3::ZERO, max: Vec3::ONE });
    let far = closed(Bounds { min: Vec3::splat(1e6), max: Vec3::splat(1e6 + 1.0) });
    let unknown = closed(Bounds { min: Vec3::NAN, max: Vec3::NAN });
    let boxes = vec![near, far, unknown];
    let lists = ClusterLists::new(boxes.clone(), &lights, &[], EXACT, None);
    for cluster in 0..3 {
        assert_eq!((lists.fixed.list(cluster), lists.catch_all[cluster]), (&[0, 1, 2][..], 0.0));
    }
    let lists = ClusterLists::new(boxes, &lights, &[], ListLimits::default(), None);
    assert_eq!([0, 1].map(|cluster| lists.fixed.list(cluster)), [&[0, 1][..], &[1]]);
    assert_eq!(lists.catch_all[..2], [MIN_CATCH_ALL; 2]);
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

#[test]
fn threads_do_not_matter() {
    let mut r = Random(90_000);
    let lights: Vec<LightBounds> = (0..500).map(|_| Emitter::random(&mut r).bounds(r.next())).collect();
    let boxes = random_boxes(&mut r, 200);
    let may_change: Vec<bool> = (0..500).map(|i| i % 3 == 0).collect();
    let limits = ListLimits { min_share: 1e-3, max_per_cluster: 40, max_entries: 4000 };
    let visible = |cluster: u32, light: u32| !(cluster + light).is_multiple_of(5);
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
