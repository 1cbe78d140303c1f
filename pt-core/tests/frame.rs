//! The frame recorder and kernels: declared accesses, reflected names, counters.

use pt_core::frame::{PassRays, RayCount};
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, ChannelImages, FramePlan, FrameSizes, Kernel, Location, Recorder, StageIo};
use pt_shaders::channels::{MOTION, VIEW_DEPTH};

mod records {
    include!("common/records.rs");
}
#[allow(dead_code, reason = "each test file runs some of them")]
mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}
use records::TestPush;

const READS: StageIo = StageIo { reads: &[VIEW_DEPTH], ..StageIo::of("reader") };
const WRITES: StageIo = StageIo { writes: &[VIEW_DEPTH], ..StageIo::of("writer") };
const UPDATES: StageIo = StageIo { updates: &[VIEW_DEPTH], ..StageIo::of("updater") };
const READS_PREVIOUS: StageIo = StageIo { reads_previous: &[VIEW_DEPTH], ..StageIo::of("history") };

struct Setup {
    images: ChannelImages,
    sums: Buffer,
    fill: Kernel,
    double: Kernel,
}

fn setup(device: &TestDevice) -> Setup {
    Setup {
        images: {
            let mut plan = FramePlan::new(FrameSizes::same([37, 11]));
            plan.given([MOTION]);
            plan.stage(&WRITES).unwrap();
            plan.stage(&READS_PREVIOUS).unwrap();
            plan.allocate(device).unwrap()
        },
        sums: Buffer::from_slice(device, "sums", &[0u32; 16]).unwrap(),
        fill: Kernel::compute::<TestPush>(device, &kernels::FILL, &[]).unwrap(),
        double: Kernel::compute::<()>(device, &kernels::DOUBLE_DEPTH, &[]).unwrap(),
    }
}

const EXTENT: [u32; 3] = [38, 11, 1];

#[test]
fn passes_see_each_others_writes() {
    let device = TestDevice::open();
    let s = setup(&device);
    let mut recorder = Recorder::new(&device).unwrap();
    for frame_index in 0..4 {
        let mut frame = recorder.begin().unwrap();
        frame.upload(&s.sums, bytemuck::bytes_of(&[0u32; 16])).unwrap();
        let offset = frame_index as f32;
        frame
            .pass("fill", &s.fill)
            .touches(&s.images, &WRITES)
            .push(&TestPush { offset })
            .dispatch(EXTENT)
            .unwrap();
        for _ in 0..2 {
            let pass = frame.pass("double", &s.double);
            pass.touches(&s.images, &UPDATES).update("sums", &s.sums).dispatch(EXTENT).unwrap();
        }
        frame.submit().unwrap();
    }
    let timings = recorder.finish().unwrap();
    assert_eq!(timings.iter().map(|t| t.frame).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert_eq!(timings[3].passes.len(), 4);
    assert_eq!((timings[3].created.pipelines, timings[3].created.allocations), (0, 0));

    let depth = s.images.current(VIEW_DEPTH).read_f32().unwrap();
    let expected: Vec<f32> =
        (0..11).flat_map(|y| (0..38).map(move |x| 4.0 * (x as f32 + 1000.0 * y as f32 + 3.0))).collect();
    assert_eq!(depth, expected);
    let total: u32 = s.sums.read::<u32>().unwrap().iter().sum();
    assert_eq!(total, expected.iter().map(|&d| (d / 2.0 + d) as u32).sum::<u32>());

    let table = recorder.pass_table();
    assert_eq!(table[2].reads, ["view_depth", "sums"]);
    assert_eq!(table[1].writes, ["view_depth"]);
}

/// Buffers that a pass goes through by address are in the table, those that it looks something up in are not; hazards are alike.
#[test]
fn streamed_buffers_are_in_the_table() {
    let device = TestDevice::open();
    let s = setup(&device);
    let [rays, light, looked_up] =
        ["rays", "light", "looked up"].map(|name| Buffer::from_slice(&device, name, &[0u32; 25]).unwrap());
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let push = TestPush { offset: 0.0 };
    let pass = frame.pass("fill", &s.fill).touches(&s.images, &WRITES).push(&push);
    let pass = pass.streams(&rays).streams_updated(&light).addresses(&looked_up);
    pass.dispatch(EXTENT).unwrap();
    let pass = frame.pass("again", &s.fill).touches(&s.images, &WRITES).push(&push);
    pass.streams_written(&rays).dispatch(EXTENT).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();
    let depth = 38 * 11 * 4;
    let [first, second] = recorder.pass_table() else { panic!("two passes") };
    assert_eq!(first.reads, ["rays", "light"]);
    assert_eq!(first.writes, ["view_depth", "light"]);
    assert_eq!(first.bytes, depth + 100 + 200);
    assert_eq!(
        (second.writes.as_slice(), second.bytes),
        (&["view_depth".into(), "rays".into()][..], depth + 100)
    );
}

/// The recorder keeps no more of a long run than of a short one.
#[test]
fn times_of_a_long_run_are_a_sample() {
    let device = TestDevice::open();
    let mut recorder = Recorder::new(&device).unwrap();
    for _ in 0..2500 {
        recorder.begin().unwrap().submit().unwrap();
    }
    let timings = recorder.finish().unwrap();
    assert_eq!((timings.len(), recorder.finished()), (2048, 2500));
    assert!(timings.is_sorted_by(|a, b| a.frame < b.frame));
    assert!(recorder.finish().unwrap().is_empty());
}

#[test]
fn histories_and_sampled_images() {
    let device = TestDevice::open();
    let mut s = setup(&device);
    let kernel = Kernel::compute::<()>(&device, &kernels::HISTORY, &[]).unwrap();
    let ramp: Vec<f32> = (0..11).flat_map(|_| (0..38).flat_map(|x| [x as f32, 0.0, 0.0, 0.0])).collect();
    s.images.current(MOTION).write_f32(&ramp).unwrap();
    s.images.begin_frame();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let push = TestPush { offset: 0.0 };
    frame.pass("fill", &s.fill).touches(&s.images, &WRITES).push(&push).dispatch(EXTENT).unwrap();
    frame.submit().unwrap();
    s.images.begin_frame();
    let mut frame = recorder.begin().unwrap();
    let pass = frame.pass("history", &kernel).touches(&s.images, &READS_PREVIOUS);
    let pass = pass.sample("sampled", s.images.current(MOTION));
    pass.touches(&s.images, &WRITES).dispatch(EXTENT).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();

    // Bilinear between x and x + 1, clamped at the right edge.
    let between = |x: u32| (x + (x + 1).min(37)) as f32 * 0.5;
    let expected = (0..11).flat_map(|y| (0..38).map(move |x| (x + 1000 * y) as f32 + between(x)));
    let depth = s.images.current(VIEW_DEPTH).read_f32().unwrap();
    for (found, expected) in depth.iter().zip(expected) {
        // Drivers filter with 8-bit weights.
        assert!((found - expected).abs() <= 1.0 / 256.0, "{found} for {expected}");
    }
}

#[test]
fn wrong_declarations_are_errors() {
    let device = TestDevice::open();
    let s = setup(&device);
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let push = TestPush { offset: 0.0 };
    let message = |result: pt_core::Result<()>| result.unwrap_err().to_string();

    let missing = message(frame.pass("p", &s.fill).push(&push).dispatch(EXTENT));
    assert!(missing.contains("\"ch_view_depth\" is not bound"), "{missing}");
    let misspelt = message(
        frame
            .pass("p", &s.fill)
            .touches(&s.images, &WRITES)
            .write("ch_view_deph", s.images.current(VIEW_DEPTH))
            .push(&push)
            .dispatch(EXTENT),
    );
    assert!(misspelt.contains("no binding \"ch_view_deph\"; it has ch_view_depth"), "{misspelt}");
    let wrong_access =
        message(frame.pass("p", &s.fill).touches(&s.images, &READS).push(&push).dispatch(EXTENT));
    assert!(wrong_access.contains("the kernel writes it"), "{wrong_access}");
    let half_access = message(
        frame.pass("p", &s.double).touches(&s.images, &WRITES).update("sums", &s.sums).dispatch(EXTENT),
    );
    assert!(half_access.contains("the kernel reads and writes it"), "{half_access}");
    let wrong_format = message(
        frame
            .pass("p", &s.fill)
            .write("ch_view_depth", s.images.current(MOTION))
            .push(&push)
            .dispatch(EXTENT),
    );
    assert!(wrong_format.contains("the image is Rgba32F"), "{wrong_format}");
    let wrong_kind =
        message(frame.pass("p", &s.fill).write("ch_view_depth", &s.sums).push(&push).dispatch(EXTENT));
    assert!(wrong_kind.contains("a buffer is bound"), "{wrong_kind}");
    let no_push = message(frame.pass("p", &s.fill).touches(&s.images, &WRITES).dispatch(EXTENT));
    assert!(no_push.contains("0 bytes of push constants given"), "{no_push}");
    frame.submit().unwrap();
}

#[test]
fn disagreeing_records_are_errors() {
    let device = TestDevice::open();
    let message = |r: pt_core::Result<Kernel>| r.err().expect("an error").to_string();
    let record = message(Kernel::compute::<()>(&device, &kernels::WRONG_RECORD, &[]));
    assert!(record.contains("FrameRecord: GLSL has member `seed` at byte 0"), "{record}");
    let push = message(Kernel::compute::<()>(&device, &kernels::FILL, &[]));
    assert!(push.contains("push constants have 4 bytes"), "{push}");
}

#[test]
fn host_visible_buffers_round_trip() {
    let device = TestDevice::open();
    let buffer = Buffer::new(&device, "upload", 16, Location::Upload).unwrap();
    buffer.write(4, bytemuck::bytes_of(&[1u32, 2, 3]));
    assert_eq!(&buffer.read::<u32>().unwrap()[1..], [1, 2, 3]);
}

/// The amount of work is written by one pass and read by the launch of the next one; what both did comes back with the frame, and so do numbers
/// of rays.
#[test]
fn launches_that_a_pass_decides() {
    let device = TestDevice::open();
    let work = Buffer::from_slice(&device, "work", &[0u32; 5]).unwrap();
    let copy = Buffer::new(&device, "copy of work", work.size(), Location::Readback).unwrap();
    let kernel = Kernel::compute::<TestPush>(&device, &kernels::COUNT_GROUPS, &[]).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    assert_eq!(recorder.ray_counts().unwrap(), []);
    recorder.count_rays().unwrap();
    for (rows, threads) in [(3u32, 24), (1, 32), (5, 72)] {
        let mut frame = recorder.begin().unwrap();
        let pass = frame.pass("decide", &kernel).push(&TestPush { offset: rows as f32 });
        let (most, count) = match rows {
            1 => (1, RayCount::AtMostThreads),
            _ => (3, RayCount::AtMostPerThread(3)),
        };
        pass.rays(count).update("work", &work).dispatch([1, 1, 1]).unwrap();
        let pass = frame.pass("count", &kernel).push(&TestPush { offset: 0.0 }).update("work", &work);
        // From the second word on: `rows` x 2 x 1 groups of 4.
        pass.rays(RayCount::Listed(work.clone(), 4)).dispatch_indirect([4, 5, 2], &work, 4).unwrap();
        frame.download(&work, &copy).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        assert_eq!(copy.mapped::<u32>(), [7, rows, 2, 1, threads]);
        let rays = |pass: &str, rays, is_upper_bound| PassRays { pass: pass.into(), rays, is_upper_bound };
        let counted = recorder.ray_counts().unwrap();
        assert_eq!(counted, [rays("decide", most, true), rays("count", rows.into(), false)]);
    }
}
