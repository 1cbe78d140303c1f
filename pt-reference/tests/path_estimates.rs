//! What the path tracer promises about its estimates: strategies agree, kinds of light add up, backends and slices too.

use crate::common::renders::{Stage, glowing_sphere};
use glam::{DVec3, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_image::image_file::{ImageState, LinearImage};
use pt_image::metrics::{Metric, Variances, compare_estimates};
use pt_reference::{
    Estimate, EstimateFile, EstimatePixel, LightTypes, ReferenceParams, SamplerKind, Strategy,
};
use pt_scene::{Camera, builtin};
use std::path::Path;

const SIZE: [u32; 2] = [48, 32];

/// One metric of an estimate against another one, as `pt compare` has it.
fn measure(a: &Estimate, b: &Estimate, metric: Metric) -> f64 {
    let plane = |e: &Estimate, of: fn(&EstimatePixel) -> Vec3| LinearImage {
        width: e.size[0],
        height: e.size[1],
        pixels: e.pixels.iter().map(|p| of(p).to_array()).collect(),
        state: ImageState::SceneReferred,
    };
    let [variance_a, variance_b] = [a, b].map(|e| plane(e, |p| p.variance));
    let variances = Variances { a: &variance_a, b: &variance_b };
    let [a, b] = [a, b].map(|e| plane(e, |p| p.mean));
    compare_estimates(&a, &b, Some(variances), &[metric]).unwrap()[0].value
}

#[test]
fn combined_strategies_beat_each_of_them_on_the_plates() {
    let device = TestDevice::open();
    let scene = builtin("veach").unwrap();
    let camera = scene.default_camera();
    let mut stage = Stage::new(&device, scene);
    let params = |strategy| ReferenceParams { strategy, max_bounces: Some(0), ..Default::default() };
    let truth = stage.render(&camera, SIZE, &params(Strategy::Both), 99, 1024);
    let error = |stage: &mut Stage<'_>, strategy| {
        measure(&stage.render(&camera, SIZE, &params(strategy), 1, 16), &truth, Metric::Mse)
    };
    let [both, lights, bsdf] =
        [Strategy::Both, Strategy::Lights, Strategy::Bsdf].map(|strategy| error(&mut stage, strategy));
    println!("veach, 16 spp, MSE: both {both:.3e}, lights {lights:.3e}, bsdf {bsdf:.3e}");
    assert!(both < lights && both < bsdf);
}

#[test]
fn kinds_of_light_add_up() {
    let device = TestDevice::open();
    let mut scene = builtin("lamps").unwrap();
    scene.lights.push(pt_scene::default_sun());
    scene.environment = pt_scene::default_sky();
    let camera = scene.default_camera();
    let mut stage = Stage::new(&device, scene);
    let none = LightTypes { sun: false, positional: false, emissive: false, environment: false };
    let mut render = |light_types, seed| {
        let params = ReferenceParams { light_types, max_bounces: Some(3), ..Default::default() };
        stage.render(&camera, SIZE, &params, seed, 32)
    };
    let whole = render(LightTypes::default(), 0);
    let parts = [
        render(LightTypes { sun: true, ..none }, 1),
        render(LightTypes { positional: true, ..none }, 2),
        render(LightTypes { emissive: true, ..none }, 3),
        render(LightTypes { environment: true, ..none }, 4),
    ];
    // Blocks of 16 x 16 pixels: within 3 standard errors, of 18 comparisons with a chance of 0.3 % each one may fail.
    let mut failed = 0;
    for block_y in 0..SIZE[1] / 16 {
        for block_x in 0..SIZE[0] / 16 {
            let sum = |estimate: &Estimate| {
                let inside = (0..256).map(|i| {
                    let (x, y) = (block_x * 16 + i % 16, block_y * 16 + i / 16);
                    estimate.pixels[(y * SIZE[0] + x) as usize]
                });
                inside.fold((DVec3::ZERO, DVec3::ZERO), |(mean, variance), p| {
                    (mean + p.mean.as_dvec3(), variance + p.variance.as_dvec3())
                })
            };
            let (a, var_a) = sum(&whole);
            let (b, var_b) =
                parts.iter().map(sum).fold((DVec3::ZERO, DVec3::ZERO), |(m, v), (dm, dv)| (m + dm, v + dv));
            let off = (a - b).abs() / (var_a + var_b).map(f64::sqrt).max(DVec3::splat(1e-12));
            failed += [off.x, off.y, off.z].iter().filter(|&&z| z > 3.0).count();
        }
    }
    assert!(failed <= 1, "{failed} blocks differ");
}

#[test]
fn backends_agree() {
    let device = TestDevice::open();
    for name in ["cornell", "kinds"] {
        let mut first: Option<Estimate> = None;
        for backend in TraceBackend::available(&device) {
            let scene = builtin(name).unwrap();
            let camera = scene.default_camera();
            let params = ReferenceParams { max_bounces: Some(4), ..Default::default() };
            let estimate = Stage::on(&device, scene, backend).render(&camera, [32, 24], &params, 5, 4);
            let first = first.get_or_insert_with(|| estimate.clone());
            let relmse = measure(&estimate, first, Metric::RelMse);
            println!("{name}: {backend} relMSE {relmse:.2e}");
            assert!(relmse <= 1e-4, "{name}: {backend} differs by relMSE {relmse}");
        }
    }
}

/// Steps that visit two nodes trace the same paths: with instances, and in a scene of one, which has kernels without a top level.
#[test]
fn gpu_traversal_has_the_same_bits() {
    let device = TestDevice::open();
    for name in ["cornell", "kinds", "room"] {
        let [cpu, gpu] = [false, true].map(|gpu| {
            let scene = builtin(name).unwrap();
            let camera = scene.default_camera();
            let params = ReferenceParams { max_bounces: Some(4), ..Default::default() };
            let device = device.with_gpu_traversal(gpu);
            Stage::on(&device, scene, TraceBackend::Compute).render(&camera, [32, 24], &params, 5, 4)
        });
        assert!(cpu == gpu, "{name}: relMSE {}", measure(&gpu, &cpu, Metric::RelMse));
    }
}

#[test]
fn nested_solids_by_priority_or_by_single_interfaces() {
    let device = TestDevice::open();
    let params = ReferenceParams { max_bounces: Some(24), ..Default::default() };
    let [overlapping, gapless] = [("glass", 1), ("glass-gapless", 2)].map(|(name, seed)| {
        let scene = builtin(name).unwrap();
        let camera = scene.default_camera();
        Stage::new(&device, scene).render(&camera, SIZE, &params, seed, 192)
    });
    let share = measure(&overlapping, &gapless, Metric::ZTest);
    println!("glass and glass-gapless agree in {:.3} % of the pixels", 100.0 * share);
    assert!(share >= 0.9975, "{share}");
}

#[test]
fn samples_in_any_portions_make_the_same_sums() {
    let device = TestDevice::open();
    let scene = builtin("cornell").unwrap();
    let camera = scene.default_camera();
    let mut stage = Stage::new(&device, scene);
    let params = ReferenceParams::default();
    let whole = stage.state(&camera, SIZE, &params, 7, 0..12);
    assert_eq!(whole, stage.state(&camera, SIZE, &params, 7, 0..12), "the same twice");
    assert_ne!(whole, stage.state(&camera, SIZE, &params, 8, 0..12), "another seed");
    // Slices merged: mean and variance of all samples but for rounding.
    let slices: Vec<_> = [0..3, 3..4, 4..12]
        .map(|range| {
            let n = range.end - range.start;
            stage.state(&camera, SIZE, &params, 7, range).estimate(n)
        })
        .into();
    let (merged, single) = (Estimate::merge(&slices).unwrap(), whole.estimate(12));
    assert_eq!(merged.samples, 12);
    for (a, b) in merged.pixels.iter().zip(&single.pixels) {
        assert!(a.mean.abs_diff_eq(b.mean, 1e-6 * b.mean.max_element().max(1e-3)), "{a:?} {b:?}");
        assert!(a.variance.abs_diff_eq(b.variance, 1e-5 * b.variance.max_element() + 1e-9), "{a:?} {b:?}");
        assert!((a.depth - b.depth).abs() <= 1e-5 * b.depth && a.coverage == b.coverage);
    }
}

#[test]
fn error_falls_with_the_number_of_samples() {
    let device = TestDevice::open();
    let camera = Camera::look_at("inside", Vec3::new(0.3, 0.2, 0.0), Vec3::X, 1.2);
    let mut stage = Stage::new(&device, glowing_sphere());
    let mut slope = |sampler| {
        let params = ReferenceParams { sampler, max_bounces: Some(2), spp: 128, ..Default::default() };
        // 1/2 + 1/4 + 1/8 + 1/16 everywhere.
        let mut mse = |k: u32| {
            let estimate = stage.render(&camera, [64, 64], &params, k, 1 << k);
            let square = |p: &EstimatePixel| (f64::from(p.mean.x) - 0.9375).powi(2);
            estimate.pixels.iter().map(square).sum::<f64>() / estimate.pixels.len() as f64
        };
        // Least squares through the logarithms.
        let points: Vec<(f64, f64)> = (0..=7).map(|k| (f64::from(k), mse(k).log2())).collect();
        let n = points.len() as f64;
        let (mx, my) =
            (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>()
            / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
    };
    let (pcg, sobol) = (slope(SamplerKind::Pcg), slope(SamplerKind::Sobol));
    println!("slope of log MSE over log samples: pcg {pcg:.3}, sobol {sobol:.3}");
    assert!((pcg + 1.0).abs() <= 0.05, "{pcg}");
    assert!(sobol < pcg - 0.05, "{sobol} is no faster than {pcg}");
}

/// The stored pairs of mean and variance: `pt reference NAME --size 32x24 --spp 4096 --seed 1000 --no-aov`.
#[test]
fn stored_estimates_are_met() {
    let device = TestDevice::open();
    for (name, spp) in [("cornell", 64), ("glass", 256), ("lamps", 512)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/{name}.exr"));
        let stored = EstimateFile::read(&path).unwrap().estimate;
        let scene = builtin(name).unwrap();
        let camera = scene.default_camera();
        let estimate = Stage::new(&device, scene).render(&camera, stored.size, &Default::default(), 0, spp);
        let share = measure(&estimate, &stored, Metric::ZTest);
        println!("{name}: {:.3} % of the pixels agree with the stored ones", 100.0 * share);
        assert!(share >= 0.9975, "{name}: {share}");
    }
}

/// Where a pixel sees many texels, few samples with filtered textures are nearer to the truth than with the finest ones; near by
/// both are the same.
#[test]
fn ray_cones_filter_textures() {
    let device = TestDevice::open();
    let scene = builtin("textures").unwrap();
    let camera = scene.default_camera();
    let mut stage = Stage::new(&device, scene);
    let params = |ray_cones| ReferenceParams { ray_cones, max_bounces: Some(0), ..Default::default() };
    let truth = stage.render(&camera, SIZE, &params(false), 9, 256);
    let [plain, cones] = [false, true].map(|ray_cones| {
        measure(&stage.render(&camera, SIZE, &params(ray_cones), 1, 1), &truth, Metric::RelMse)
    });
    println!("textures, 1 sample, relMSE: finest level {plain:.3e}, ray cones {cones:.3e}");
    assert!(cones < 0.7 * plain, "{cones} instead of {plain}");
    // Many samples show the bias, and that it is small.
    let bias = measure(&stage.render(&camera, SIZE, &params(true), 1, 256), &truth, Metric::RelMse);
    println!("256 samples with ray cones: relMSE {bias:.3e}");
    assert!(bias < plain / 4.0, "{bias}");
}
