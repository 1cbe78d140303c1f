//! Stages of a frame: who reads what nobody writes, which histories are kept, what a reset forgets.

use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FramePlan, FrameSizes, Kept, Kernel, StageIo};
use pt_shaders::channels::{ACCUMULATED, COLOR, COLOR_HF, FLAT_COLOR, MOTION, NORMAL, VIEW_DEPTH};

mod kernels {
    #![allow(dead_code, reason = "each test file runs some of them")]
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}
mod records {
    include!("common/records.rs");
}

const LIGHT: StageIo = StageIo { writes: &[COLOR_HF], ..StageIo::of("light") };
const COMPOSITE: StageIo = StageIo { reads: &[COLOR_HF], writes: &[COLOR], ..StageIo::of("composite") };
const FILTER: StageIo =
    StageIo { reads: &[COLOR], reads_previous: &[COLOR], writes: &[FLAT_COLOR], ..StageIo::of("filter") };
const MEAN: StageIo = StageIo { reads: &[FLAT_COLOR], updates: &[ACCUMULATED], ..StageIo::of("mean") };

fn plan(stages: &[StageIo]) -> Result<FramePlan, pt_core::Error> {
    let mut plan = FramePlan::new(FrameSizes::same([6, 4]));
    stages.iter().try_for_each(|io| plan.stage(io))?;
    Ok(plan)
}

#[test]
fn a_reader_without_a_writer_is_named() {
    let message = |stages: &[StageIo]| plan(stages).unwrap_err().to_string();
    let alone = message(&[COMPOSITE]);
    assert_eq!(alone, "stage \"composite\" reads \"color_hf\", which no stage before it writes");
    assert!(message(&[COMPOSITE, LIGHT]).contains("composite"), "the order counts");
    plan(&[LIGHT, COMPOSITE]).unwrap();

    let device = TestDevice::open();
    let previous = StageIo { reads_previous: &[MOTION], ..StageIo::of("reprojection") };
    let error = plan(&[LIGHT, previous]).unwrap().allocate(&device).err().unwrap().to_string();
    assert!(error.contains("reprojection") && error.contains("motion"), "{error}");
}

#[test]
fn previous_images_are_there_where_they_are_read() {
    let device = TestDevice::open();
    let bytes = |stages: &[StageIo]| plan(stages).unwrap().allocate(&device).unwrap().bytes();
    let texels = shared(&device, &[LIGHT]).bytes();
    assert_eq!(bytes(&[LIGHT, COMPOSITE]), 2 * texels);
    assert_eq!(bytes(&[LIGHT, COMPOSITE, FILTER]), 4 * texels, "color twice");
    assert_eq!(bytes(&[LIGHT, COMPOSITE, FILTER, MEAN]), 5 * texels, "a carried image once");
}

fn shared(device: &TestDevice, stages: &[StageIo]) -> ChannelImages {
    let mut plan = plan(stages).unwrap();
    plan.keep([FLAT_COLOR]);
    plan.allocate_planes(device, &plan, 0, Kept::Outputs).unwrap().remove(0)
}

#[test]
fn images_share_memory_where_one_is_written_after_another_was_read() {
    let device = TestDevice::open();
    let texels = shared(&device, &[LIGHT]).bytes();
    let flat = StageIo { reads: &[COLOR], writes: &[FLAT_COLOR], ..StageIo::of("flat") };
    assert_eq!(shared(&device, &[LIGHT, COMPOSITE, flat]).bytes(), 2 * texels, "light, then the flat frame");
    let late = StageIo { reads: &[COLOR_HF, COLOR], writes: &[FLAT_COLOR], ..StageIo::of("late") };
    assert_eq!(shared(&device, &[LIGHT, COMPOSITE, late]).bytes(), 3 * texels, "light is read to the end");
    // Last frame's colour is read by the stage that writes the flat frame, so that this one is where the light was.
    assert_eq!(shared(&device, &[LIGHT, COMPOSITE, FILTER]).bytes(), 3 * texels, "colour twice");
    let first = StageIo { reads_previous: &[COLOR], writes: &[COLOR_HF], ..StageIo::of("first") };
    assert_eq!(shared(&device, &[first, COMPOSITE, flat]).bytes(), 2 * texels, "one colour is enough");
}

#[test]
fn passes_that_the_declarations_do_not_know_of_are_refused() {
    let device = TestDevice::open();
    let normals = StageIo { writes: &[NORMAL], ..StageIo::of("normals") };
    let shading = StageIo { reads: &[NORMAL], ..StageIo::of("shading") };
    let io = StageIo { reads_previous: &[VIEW_DEPTH], writes: &[VIEW_DEPTH], ..StageIo::of("depth") };
    let images = shared(&device, &[normals, shading, io]);
    assert_eq!(
        images.bytes(),
        2 * shared(&device, &[normals]).bytes(),
        "normals are where the depth will be"
    );
    let history = Kernel::compute::<()>(&device, &kernels::HISTORY, &[]).unwrap();
    let mut recorder = pt_core::Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let late = |name: &str, frame: &mut pt_core::Frame<'_>| {
        let pass = frame.pass(name, &history).touches(&images, &io);
        pass.sample("sampled", images.current(NORMAL)).dispatch([6, 4, 1]).unwrap_err().to_string()
    };
    let error = late("both", &mut frame);
    assert!(error.contains("accesses that memory by another name"), "{error}");
    let fill = Kernel::compute::<records::TestPush>(&device, &kernels::FILL, &[]).unwrap();
    let written = StageIo { writes: &[VIEW_DEPTH], ..StageIo::of("fill") };
    let pass = frame.pass("fill", &fill).touches(&images, &written);
    pass.push(&records::TestPush { offset: 0.0 }).dispatch([6, 4, 1]).unwrap();
    let error = late("too late", &mut frame);
    assert!(error.contains("it reads \"normal\", whose memory something else has taken"), "{error}");
    frame.submit().unwrap();
}

#[test]
fn one_reset_forgets_all_histories() {
    let device = TestDevice::open();
    let stages = [LIGHT, COMPOSITE, FILTER, MEAN];
    let mut images = plan(&stages).unwrap().allocate(&device).unwrap();
    let names: Vec<_> = images.histories().map(|id| id.full_name()).collect();
    assert_eq!(names, ["color", "accumulated"]);
    let next = |images: &mut ChannelImages| {
        images.begin_frame();
        images.has_history()
    };
    assert!(!next(&mut images) && next(&mut images) && next(&mut images));
    images.reset_history();
    assert!(!next(&mut images) && next(&mut images));
    images.reset_history();
    images.resume_history();
    assert!(next(&mut images), "filled from outside");
}

#[test]
fn what_a_replay_has_to_load() {
    let missing = |stages: &[StageIo]| -> Vec<String> {
        let plan = FramePlan::new(FrameSizes::same([6, 4]));
        plan.missing(stages).into_iter().map(|id| id.full_name()).collect()
    };
    assert_eq!(missing(&[COMPOSITE, FILTER, MEAN]), ["color_hf"]);
    assert_eq!(missing(&[FILTER, MEAN]), ["color"]);
    assert_eq!(missing(&[MEAN]), ["flat_color"], "what is carried is no input");
}

#[test]
fn declarations_say_no_more_than_kernels_do() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<records::TestPush>(&device, &kernels::FILL, &[]).unwrap();
    StageIo { writes: &[VIEW_DEPTH], ..StageIo::of("fill") }.check([&kernel]).unwrap();
    let error = StageIo { reads: &[MOTION], ..StageIo::of("fill") }.check([&kernel]).unwrap_err();
    assert_eq!(error.to_string(), "stage \"fill\" declares \"motion\", which none of its kernels touches");
}

#[test]
fn passes_report_images_that_nobody_declared() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<records::TestPush>(&device, &kernels::FILL, &[]).unwrap();
    let images = plan(&[LIGHT]).unwrap().allocate(&device).unwrap();
    let mut recorder = pt_core::Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let io = StageIo { writes: &[VIEW_DEPTH], ..StageIo::of("fill") };
    let pass = frame.pass("fill", &kernel).touches(&images, &io).push(&records::TestPush { offset: 0.0 });
    let error = pass.dispatch([6, 4, 1]).unwrap_err().to_string();
    assert!(error.contains("\"view_depth\" is not allocated"), "{error}");
    frame.submit().unwrap();
}
