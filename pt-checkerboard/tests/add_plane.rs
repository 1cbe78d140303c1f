//! Sums of planes against what they promise.

use pt_checkerboard::{AddPlane, Interleave};
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_shaders::channels::{FLAT_COLOR, FLAT_MOTION};

/// Light of three planes, and which of them gives the motion: a later one if it is brighter than all before it together, else the first one.
const CASES: [([f32; 3], usize); 6] = [
    ([5.0, 3.0, 1.0], 0),
    ([1.0, 8.0, 2.0], 1),
    ([1.0, 2.0, 8.0], 2),
    ([0.0, 4.0, 0.0], 1),
    ([0.0; 3], 0),
    ([6.0, 4.0, 5.0], 0),
];

#[test]
fn planes_are_added_and_the_brightest_moves() {
    let device = TestDevice::open();
    let size = [CASES.len() as u32, 1];
    let planes: Vec<ChannelImages> = (0..3)
        .map(|plane| {
            let images = ChannelImages::alone(&device, FrameSizes::same(size), &[Interleave::IO]).unwrap();
            // The sum keeps the alpha of the first plane.
            let color =
                CASES.map(|(light, _)| [light[plane], light[plane], light[plane], 1.0 + plane as f32]);
            let motion = CASES.map(|_| [plane as f32, -1.0]);
            images.current(FLAT_COLOR).write_f32(color.as_flattened()).unwrap();
            images.current(FLAT_MOTION).write_f32(motion.as_flattened()).unwrap();
            images
        })
        .collect();
    let stage = AddPlane::new(&device).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    for plane in &planes[1..] {
        stage.record(&mut frame, &StageInputs::new(&planes[0]), plane).unwrap();
    }
    frame.submit().unwrap();
    let color = planes[0].current(FLAT_COLOR).read_f32().unwrap();
    let motion = planes[0].current(FLAT_MOTION).read_f32().unwrap();
    for (i, (light, moves)) in CASES.into_iter().enumerate() {
        let sum = light.iter().sum::<f32>();
        assert_eq!(color[4 * i..4 * i + 4], [sum, sum, sum, 1.0], "{light:?}");
        assert_eq!(motion[2 * i..2 * i + 2], [moves as f32, -1.0], "{light:?}");
    }
}
