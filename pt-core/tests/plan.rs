//! Stages of a frame: who reads what nobody writes, which histories are kept, what a reset forgets.

use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FramePlan, FrameSizes, Kernel, StageIo};
use pt_shaders::channels::{ACCUMULATED, COLOR, COLOR_HF, FLAT_COLOR, MOTION, VIEW_DEPTH};

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
    let texels = 6 * 4 * 16;
    assert_eq!(bytes(&[LIGHT, COMPOSITE]), 2 * texels);
    assert_eq!(bytes(&[LIGHT, COMPOSITE, FILTER]), 4 * texels, "color twice");
    assert_eq!(bytes(&[LIGHT, COMPOSITE, FILTER, MEAN]), 5 * texels, "a carried image once");
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
