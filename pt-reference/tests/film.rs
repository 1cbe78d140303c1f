//! The sums of a pixel do not drift, however many samples there are.

use crate::common::records::ListPush;
use crate::common::{kernels, run};
use glam::{DVec3, Vec3};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, Kernel, Location};
use pt_reference::records::FilmPixel;

const PIXELS: u32 = 64;
const SAMPLES: u32 = 100_000;

fn sample(pixel: u32, k: u32) -> Vec3 {
    let [x, y, z, _] = random4([pixel, 0], k, 0, 0);
    4.0 * Vec3::new(x, y, z)
}

#[test]
fn a_hundred_thousand_samples_lose_nothing() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<ListPush>(&device, &kernels::FILM_SUMS, &[]).unwrap();
    let size = u64::from(PIXELS) * size_of::<FilmPixel>() as u64;
    let results = Buffer::new(&device, "results", size, Location::Device).unwrap();
    let push = ListPush { count: PIXELS, per_thread: SAMPLES };
    let results: Vec<FilmPixel> =
        run(&device, &kernel, &push, PIXELS, &results, |pass| pass.write("results", &results));
    let (mut worst, mut worst_plain) = (0.0f64, 0.0f64);
    for (pixel, film) in (0..).zip(&results) {
        let (mut sum, mut square, mut plain) = (DVec3::ZERO, DVec3::ZERO, Vec3::ZERO);
        for x in (0..SAMPLES).map(|k| sample(pixel, k)) {
            sum += x.as_dvec3();
            square += (x * x).as_dvec3();
            plain += x;
        }
        let off = |value: DVec3, exact: DVec3| ((value - exact) / exact).abs().max_element();
        worst = worst
            .max(off(film.sum.as_dvec3() + film.sum_rest.as_dvec3(), sum))
            .max(off(film.square.as_dvec3() + film.square_rest.as_dvec3(), square));
        worst_plain = worst_plain.max(off(plain.as_dvec3(), sum));
    }
    println!("worst relative error of {SAMPLES} samples: {worst:.1e}, of a plain sum {worst_plain:.1e}");
    assert!(worst < 1e-9, "{worst}");
    assert!(worst_plain > 1e-6, "the test would not see a plain sum: {worst_plain}");
}
