//! Shadow statistics in a hash table: every ray is counted for its cluster, light and side, once, in an entry that no other has; what finds no
//! room is not counted at all, and counts as never asked.

use crate::common::kernels;
use crate::common::records::{SampleRecord, SamplerPush};
use glam::Vec3;
use pt_core::rng::pcg;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Kernel, Location, Recorder, SceneResources};
use pt_light_sampling::SamplerChoice;
use pt_light_sampling::records::StatisticsTable;
use pt_light_sampling::test_support::{Uploaded, all_kinds};
use pt_shaders::records::LightSampler;
use std::collections::HashMap;

/// As in `statistics.glsl`.
const PROBES: u32 = 4;
const LEAST_LIT_SHARE: f32 = 0.1;
/// As in `shadow_counts.comp`.
const LIGHTS: u32 = 61;
const NONE: u32 = u32::MAX;

/// What tells the cluster, light and side of a pair from others.
fn key(pair: u32) -> u32 {
    let (cluster, light) = (pair / LIGHTS, pair % LIGHTS);
    let side = 2 * (pair % 3) + (pair / 3) % 2;
    pcg(light.wrapping_add(pcg(cluster * 6 + side))) | 1
}

/// Where the key may be.
fn probes(key: u32, slots: u32) -> impl Iterator<Item = u32> {
    (0..PROBES).map(move |i| pcg(key).wrapping_add(i) & (slots - 1))
}

/// Rays that reached the light of each key, and rays that did not.
fn expected(pairs: u32, rays: u32, odd_alone: bool) -> HashMap<u32, [u32; 2]> {
    let mut counts: HashMap<u32, [u32; 2]> = HashMap::new();
    for i in 0..rays {
        let pair = pcg(i) % pairs;
        if !odd_alone || pair % 2 == 1 {
            counts.entry(key(pair)).or_default()[usize::from(i % 4 != 0)] += 1;
        }
    }
    counts
}

struct Statistics<'d> {
    device: &'d TestDevice,
    uploaded: Uploaded,
    kernel: Kernel,
    slots: u32,
    pairs: u32,
}

impl<'d> Statistics<'d> {
    /// A table of that many entries, in which the last frame alone counts.
    fn new(device: &'d TestDevice, slots: u32, pairs: u32) -> Self {
        let mut uploaded = Uploaded::new(device, all_kinds(), TraceBackend::Compute);
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        let choice = SamplerChoice {
            statistics_table: StatisticsTable::Sparse,
            statistics_frames: 1,
            statistics_interval: 1,
            ..LightSampler::ClusterStats.into()
        };
        lights.prepare(device, scene, gpu, Some(choice)).unwrap();
        let kernel = Kernel::compute::<SamplerPush>(device, &kernels::SHADOW_COUNTS, &[]).unwrap();
        Self { device, uploaded, kernel, slots, pairs }
    }

    /// A frame that counts rays, and what is known of the pairs after it.
    fn frame(&mut self, rays: u32, odd_alone: bool) -> Vec<SampleRecord> {
        let size = u64::from(self.pairs) * size_of::<SampleRecord>() as u64;
        let samples = Buffer::new(self.device, "samples", size, Location::Device).unwrap();
        let mut recorder = Recorder::new(self.device).unwrap();
        let mut frame = recorder.begin().unwrap();
        let Uploaded { scene, gpu, lights } = &mut self.uploaded;
        lights.update(&mut frame, scene, gpu).unwrap();
        // Kernels take the first entries for all there are.
        gpu.record_mut().shadow_count_slots = self.slots;
        gpu.update(&mut frame, scene).unwrap();
        for (family, count) in [(0, rays), (1, self.pairs)].into_iter().filter(|(_, count)| *count > 0) {
            let push = SamplerPush {
                family,
                count,
                seed: self.pairs,
                parameter: f32::from(u8::from(odd_alone)),
                vector: Vec3::ZERO,
            };
            let pass = frame.pass("shadow counts", &self.kernel).write("samples", &samples).push(&push);
            self.uploaded.gpu.bind(pass).dispatch([count, 1, 1]).unwrap();
        }
        frame.submit().unwrap();
        samples.read().unwrap()
    }
}

fn counts(record: &SampleRecord) -> [u32; 2] {
    [record.value.x as u32, record.value.y as u32]
}

/// Entries of the keys. Panics unless each key has one entry, where it may be, and each entry one key.
fn slots_of(known: &[SampleRecord], slots: u32) -> HashMap<u32, u32> {
    let (mut by_key, mut by_slot) = (HashMap::new(), HashMap::new());
    for (pair, record) in (0..).zip(known) {
        if record.word == NONE {
            continue;
        }
        assert!(probes(key(pair), slots).any(|slot| slot == record.word), "pair {pair}: {record:?}");
        assert_eq!(*by_slot.entry(record.word).or_insert(key(pair)), key(pair), "an entry of two keys");
        assert_eq!(*by_key.entry(key(pair)).or_insert(record.word), record.word, "two entries of a key");
    }
    by_key
}

/// How many pairs have no entry. Panics if one of them has room for one.
fn lost_pairs(known: &[SampleRecord], slots: u32) -> usize {
    let taken: Vec<u32> = slots_of(known, slots).into_values().collect();
    let lost = (0..).zip(known).filter(|(_, record)| record.word == NONE);
    lost.inspect(|(pair, _)| {
        let free = probes(key(*pair), slots).find(|slot| !taken.contains(slot));
        assert_eq!(free, None, "pair {pair} has room");
    })
    .count()
}

/// With room for all, no ray is lost and none is counted for another light, whatever the order of the threads is.
#[test]
fn every_ray_is_counted_for_its_light() {
    const PAIRS: u32 = 3000;
    const RAYS: u32 = 60_000;
    let device = TestDevice::open();
    let mut statistics = Statistics::new(&device, 1 << 22, PAIRS);
    let known = statistics.frame(RAYS, false);
    let expected = expected(PAIRS, RAYS, false);
    let slots = slots_of(&known, 1 << 22);
    assert_eq!(slots.len(), expected.len());
    for (pair, record) in (0..).zip(&known) {
        assert_eq!(counts(record), expected[&key(pair)], "pair {pair}");
    }
}

/// A full table: a key that finds no entry has all its places taken by others, and its rays are not counted for anybody. The others' counts
/// stay exact.
#[test]
fn what_finds_no_room_is_counted_for_nobody() {
    const PAIRS: u32 = 400;
    const RAYS: u32 = 20_000;
    const SLOTS: u32 = 128;
    let device = TestDevice::open();
    let mut statistics = Statistics::new(&device, SLOTS, PAIRS);
    let known = statistics.frame(RAYS, false);
    let expected = expected(PAIRS, RAYS, false);
    let slots = slots_of(&known, SLOTS);
    let lost = lost_pairs(&known, SLOTS);
    for (pair, record) in (0..).zip(&known).filter(|(_, record)| record.word != NONE) {
        assert_eq!(counts(record), expected[&key(pair)], "pair {pair}");
    }
    assert!(lost > 100 && slots.len() > 100, "{lost} lost, {} have an entry", slots.len());
    // In the next frame they are the history.
    for (pair, record) in (0..).zip(statistics.frame(0, false)) {
        let [reached, hidden] = expected[&key(pair)].map(|count| count as f32);
        let has_entry = slots.contains_key(&key(pair));
        let share = if has_entry { (reached / (reached + hidden)).max(LEAST_LIT_SHARE) } else { 1.0 };
        assert!((record.pdf - share).abs() < 2e-3, "pair {pair}: {} of {share}", record.pdf);
    }
}

/// Entries that no ray asks for become free; a key that stands behind one is found all the same and does not get a second entry.
#[test]
fn free_entries_hide_no_others() {
    const PAIRS: u32 = 100;
    const RAYS: u32 = 20_000;
    const SLOTS: u32 = 128;
    let device = TestDevice::open();
    let mut statistics = Statistics::new(&device, SLOTS, PAIRS);
    let first = statistics.frame(RAYS, false);
    // Not so full that all places of a key are taken, but by bad luck.
    assert!(lost_pairs(&first, SLOTS) < 20);
    let all = slots_of(&first, SLOTS);
    // The even ones are asked for no more, and are gone after the next frame.
    statistics.frame(RAYS, true);
    let known = statistics.frame(RAYS, true);
    let odd = slots_of(&known, SLOTS);
    let expected = expected(PAIRS, RAYS, true);
    let mut behind_free = 0;
    for (pair, record) in (0..).zip(&known) {
        if pair % 2 == 0 {
            assert!(record.word == NONE || expected.contains_key(&key(pair)), "pair {pair} is still there");
            continue;
        }
        let Some(&slot) = all.get(&key(pair)) else { continue };
        assert_eq!(record.word, slot, "pair {pair} has moved");
        assert_eq!(counts(record), expected[&key(pair)], "pair {pair}");
        let mut before = probes(key(pair), SLOTS).take_while(|probe| *probe != slot);
        behind_free += usize::from(before.any(|probe| !odd.values().any(|taken| *taken == probe)));
    }
    assert!(behind_free > 3, "{behind_free} keys stand behind a free entry");
}
