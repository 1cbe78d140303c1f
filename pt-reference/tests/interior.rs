//! interior.glsl against its oracle, on random sequences of boundaries.

use crate::common::records::{InteriorEvent, InteriorResult, ListPush};
use crate::common::{kernels, run};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, Kernel, Location};
use pt_reference::oracle::interior::{Boundary, InteriorList, Solid};

const PATHS: u32 = 2048;
const STEPS: u32 = 24;

fn word(solid: Option<Solid>) -> u32 {
    solid.map_or(0, |s| (s.material + 1) << 8 | s.priority)
}

/// Eight solids, some with equal priorities and indices.
fn solid(x: f32) -> Solid {
    let k = (x * 8.0) as u32;
    Solid { material: k, priority: k / 3, ior: [1.5, 1.33, 1.5][k as usize % 3] }
}

/// Paths enter what they like and leave now and then what they are not inside of; more than four are nested often.
fn events() -> Vec<(Boundary, bool)> {
    (0..PATHS * STEPS)
        .map(|i| {
            let [a, b, c, d] = random4([i, 3], 0, 0, 0);
            let front = (c < 0.2).then(|| solid(d)).filter(|s| *s != solid(a));
            (Boundary { behind: solid(a), front }, b < if i % STEPS < 12 { 0.7 } else { 0.35 })
        })
        .collect()
}

#[test]
fn kernel_equals_the_oracle() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<ListPush>(&device, &kernels::INTERIOR_CASES, &[]).unwrap();
    let events = events();
    let records: Vec<_> = events
        .iter()
        .map(|(b, entering)| InteriorEvent {
            behind: word(Some(b.behind)),
            behind_ior: b.behind.ior,
            front: word(b.front),
            front_ior: b.front.map_or(1.0, |s| s.ior),
            entering: u32::from(*entering),
        })
        .collect();
    let buffer = Buffer::from_slice(&device, "events", &records).unwrap();
    let size = (records.len() * size_of::<InteriorResult>()) as u64;
    let results = Buffer::new(&device, "results", size, Location::Device).unwrap();
    let push = ListPush { count: PATHS, per_thread: STEPS };
    let results: Vec<InteriorResult> = run(&device, &kernel, &push, PATHS, &results, |pass| {
        pass.read("events", &buffer).write("results", &results)
    });
    let mut false_hits = 0;
    for (path, results) in events.chunks(STEPS as usize).zip(results.chunks(STEPS as usize)) {
        let mut list = InteriorList::default();
        for ((boundary, entering), result) in path.iter().zip(results) {
            let crossing = list.crossing(boundary, *entering);
            list.cross(boundary, *entering);
            let expected = InteriorResult {
                here: word(crossing.here),
                beyond: word(crossing.beyond),
                here_ior: crossing.here.map_or(1.0, |s| s.ior),
                beyond_ior: crossing.beyond.map_or(1.0, |s| s.ior),
                top: word(list.top()),
                false_hit: u32::from(crossing.is_false_hit()),
            };
            assert_eq!(*result, expected, "{boundary:?}, entering {entering}, {list:?}");
            false_hits += result.false_hit;
        }
    }
    assert!(false_hits > PATHS, "{false_hits}");
}
