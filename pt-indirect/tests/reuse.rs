//! Reuse of bounces: the mean light with reuse against a closed form and against that without reuse, over independent runs.
//!
//! A run is a sequence of frames with a seed of its own that starts without history. Frames of a run and pixels of a frame depend on each other through
//! reuse, so errors are standard errors of the means of runs.

use crate::common::{Rig, Texel};
use glam::{Affine3A, DVec3, Vec3};
use pt_core::test_support::TestDevice;
use pt_indirect::IndirectParams;
use pt_indirect::oracle::rectangle_form_factor;
use pt_indirect::records::{BounceReuse, RestirVisibility};
use pt_light_sampling::test_support::polygon;
use pt_scene::{Camera, Light, Material, Scene};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [40, 16];
const RUNS: u32 = 64;
/// Frames of a run where the past is reused.
const FRAMES: u32 = 4;
/// Parts of the floor whose means are compared: those that are about as bright as each other. Mistakes that move light from bright pixels to dark ones keep the
/// mean of the whole.
const BANDS: usize = 6;

/// Half the side of floor and ceiling, and the height of the ceiling; the board between them.
const HALF: f32 = 0.8;
const HEIGHT: f32 = 0.6;
const BOARD: ([f32; 2], [f32; 2], f32) = ([-0.3, -0.75], [0.4, -0.35], 0.2);
/// The sun shines upwards, so low that it passes beside floor and board and lights the whole ceiling.
const SUN: (f32, Vec3) = (0.15, Vec3::new(40.0, 30.0, 20.0));
const EYE: Vec3 = Vec3::new(0.05, 1.6, 5.0);
const TARGET: Vec3 = Vec3::new(0.0, 0.0, 0.05);
/// Vertical field of view, radians.
const FIELD: f32 = 0.1;
/// From one place of the floor to another.
const ASIDE: Vec3 = Vec3::new(0.4, 0.0, 0.0);
const ALBEDO: Vec3 = Vec3::new(0.5, 0.7, 0.3);

fn restir(visibility: RestirVisibility, history: u32) -> IndirectParams {
    IndirectParams {
        reuse: BounceReuse::RestirGi,
        restir_visibility: visibility,
        restir_history: history,
        restir_spatial: 6,
        restir_radius: 16.0,
        ..IndirectParams::default()
    }
}

fn rectangle(scene: &mut Scene, low: [f32; 2], high: [f32; 2], y: f32, faces_up: bool, material: Material) {
    let mut corners = [(low[0], high[1]), (high[0], high[1]), (high[0], low[1]), (low[0], low[1])]
        .map(|(x, z)| Vec3::new(x, y, z));
    if !faces_up {
        corners.reverse();
    }
    polygon(scene, &corners, Affine3A::IDENTITY, material);
}

/// A floor under a ceiling that the sun lights, and a black board between them.
fn planes(floor: Material, ceiling: Material) -> (Scene, Camera) {
    let mut scene = Scene::default();
    rectangle(&mut scene, [-HALF; 2], [HALF; 2], 0.0, true, floor);
    rectangle(&mut scene, [-HALF; 2], [HALF; 2], HEIGHT, false, ceiling);
    let (low, high, height) = BOARD;
    rectangle(&mut scene, low, high, height, false, Material::lambertian("board", Vec3::ZERO));
    scene.lights.push(Light::directional("sun", Vec3::new(SUN.0.cos(), SUN.0.sin(), 0.0), SUN.1));
    let camera = Camera::look_at("floor", EYE, TARGET, FIELD);
    (scene, camera)
}

fn lambertian_planes() -> (Scene, Camera) {
    planes(Material::lambertian("floor", Vec3::splat(0.5)), Material::lambertian("ceiling", ALBEDO))
}

/// Irradiance of the floor by the light of the sun that the ceiling sends back, around the board.
fn exact_irradiance(position: DVec3) -> DVec3 {
    let radiance = ALBEDO.as_dvec3() * SUN.1.as_dvec3() / PI * f64::from(SUN.0).sin();
    let half = f64::from(HALF);
    let foot = [position.x, position.z];
    let ceiling = [-half, half].map(|side| foot.map(|at| side - at));
    // The shadow of the board on the plane of the ceiling, inside of the ceiling.
    let (low, high, height) = BOARD;
    let scale = f64::from(HEIGHT / height);
    let shadow = [low, high].map(|corner| {
        [0, 1].map(|k| ((f64::from(corner[k]) - foot[k]) * scale).clamp(ceiling[0][k], ceiling[1][k]))
    });
    let factor = |[low, high]: [[f64; 2]; 2]| rectangle_form_factor(low, high, HEIGHT.into());
    radiance * PI * (factor(ceiling) - factor(shadow))
}

/// The channels together.
fn exact_light(position: DVec3) -> f64 {
    exact_irradiance(position).element_sum()
}

/// Sum of the channels of the floor's light; `None` elsewhere.
fn floor_light(texel: &Texel) -> Option<f64> {
    texel.position.filter(|p| p.y.abs() < 1e-3)?;
    Some((texel.irradiance + texel.specular).element_sum())
}

/// By what pixels of the floor are put into bands: their place says.
type Label = fn(DVec3) -> f64;

/// Values of `label` that part the bands: these have equal parts of the floor.
fn steps(label: Label) -> [f64; BANDS - 1] {
    const N: usize = 50;
    let half = f64::from(HALF);
    let at = |i: usize| ((i as f64 + 0.5) / N as f64 * 2.0 - 1.0) * half;
    let mut labels: Vec<f64> = (0..N * N).map(|i| label(DVec3::new(at(i % N), 0.0, at(i / N)))).collect();
    labels.sort_by(f64::total_cmp);
    std::array::from_fn(|b| labels[(b + 1) * N * N / BANDS])
}

/// Means of the texels of bands.
fn bands(texels: &[Texel], values: &[Option<f64>], label: Label, steps: &[f64; BANDS - 1]) -> [f64; BANDS] {
    let (mut sums, mut counts) = ([0.0; BANDS], [0.0; BANDS]);
    for (texel, value) in texels.iter().zip(values) {
        let (Some(value), Some(position)) = (value, texel.position) else { continue };
        assert!(value.is_finite(), "{position}: {value}");
        let band = steps.partition_point(|step| *step < label(position));
        sums[band] += value;
        counts[band] += 1.0;
    }
    assert!(counts.iter().all(|count| *count > 10.0), "texels of bands: {counts:?}");
    std::array::from_fn(|b| sums[b] / counts[b])
}

/// Runs of frames: means of their bands.
struct Runs {
    bands: Vec<[f64; BANDS]>,
    /// Mean square of the values of pixels.
    square: f64,
}

impl Runs {
    /// Of the last frames of runs; `value` of a texel, in bands of brightness.
    fn of(rig: &mut Rig, frames: u32, value: impl Fn(&Texel) -> Option<f64>) -> Self {
        Self::of_bands(rig, frames, exact_light, value)
    }

    /// The same in bands of another label.
    fn of_bands(rig: &mut Rig, frames: u32, label: Label, value: impl Fn(&Texel) -> Option<f64>) -> Self {
        let steps = steps(label);
        let (mut square, mut count) = (0.0, 0);
        let run = |seed| {
            rig.images.reset_history();
            let texels = (0..frames).fold(Vec::new(), |_, frame| rig.frame(frame, 1000 + seed));
            let values: Vec<_> = texels.iter().map(&value).collect();
            for value in values.iter().flatten() {
                square += value * value;
                count += 1;
            }
            bands(&texels, &values, label, &steps)
        };
        let bands = (0..RUNS).map(run).collect();
        Self { bands, square: square / f64::from(count) }
    }

    /// The differences of runs with the same seed.
    fn less(&self, other: &Self) -> Self {
        let pairs = self.bands.iter().zip(&other.bands);
        let bands = pairs.map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect();
        Self { bands, square: self.square }
    }

    fn mean(&self) -> [f64; BANDS] {
        let n = self.bands.len() as f64;
        std::array::from_fn(|b| self.bands.iter().map(|run| run[b]).sum::<f64>() / n)
    }

    /// Means over the runs, in standard errors.
    fn deviations(&self, case: &str) -> [f64; BANDS] {
        let n = self.bands.len() as f64;
        let mean = self.mean();
        let squares = |b: usize| self.bands.iter().map(|run| (run[b] - mean[b]).powi(2)).sum::<f64>();
        let error: [f64; BANDS] = std::array::from_fn(|b| (squares(b) / (n - 1.0) / n).sqrt());
        let deviations = std::array::from_fn(|b| mean[b] / error[b].max(1e-12));
        println!(
            "{case}: means {mean:.4?}, standard errors {error:.4?}, deviations {deviations:.1?}, mean square {:.3}",
            self.square
        );
        deviations
    }

    fn assert_zero(&self, case: &str) {
        let deviations = self.deviations(case);
        assert!(deviations.iter().all(|d| d.abs() < 4.0), "{case}: {deviations:.1?} standard errors");
    }
}

/// The light of each pixel less the closed form of where the pixel is in that frame.
fn error_of_closed_form(texel: &Texel) -> Option<f64> {
    Some(floor_light(texel)? - exact_light(texel.position?))
}

/// Of the planes without lobes.
fn errors(device: &TestDevice, params: &IndirectParams, frames: u32) -> Runs {
    let (scene, camera) = lambertian_planes();
    Runs::of(&mut Rig::new(device, scene, camera, SIZE, params), frames, error_of_closed_form)
}

/// The mean is the closed form; the runs without reuse have the same paths, so that the difference from them says it with less noise.
#[test]
fn reuse_has_the_mean_of_the_closed_form() {
    let device = TestDevice::open();
    let none = errors(&device, &IndirectParams::default(), 1);
    none.assert_zero("none");
    let past = restir(RestirVisibility::InWeight, 20);
    let cases = [
        ("neighbours", restir(RestirVisibility::InWeight, 0), 1, 0.75),
        // Of more than half of the points, which are too near.
        (
            "far points of neighbours",
            IndirectParams { restir_distance: 0.14, ..restir(RestirVisibility::InWeight, 0) },
            1,
            1.0,
        ),
        ("neighbours and past", past.clone(), FRAMES, 0.3),
        ("past", IndirectParams { restir_spatial: 0, ..past }, FRAMES, 0.5),
    ];
    for (case, params, frames, noise) in cases {
        let found = errors(&device, &params, frames);
        found.assert_zero(case);
        if frames == 1 {
            found.less(&none).assert_zero(&format!("{case} less none"));
        }
        assert!(found.square < noise * none.square, "{case}: {} of {}", found.square, none.square);
    }
}

/// The past of a pixel is a place of the floor that sees another part of the ceiling.
#[test]
fn the_past_may_be_another_place() {
    let device = TestDevice::open();
    let params = IndirectParams { restir_spatial: 0, ..restir(RestirVisibility::InWeight, 20) };
    let (scene, camera) = lambertian_planes();
    let aside = Camera::look_at("aside", EYE + ASIDE, TARGET + ASIDE, FIELD);
    let mut rig = Rig::new(&device, scene, camera.clone(), SIZE, &params);
    rig.cameras = vec![aside, camera];
    let found = Runs::of(&mut rig, 2, error_of_closed_form);
    found.assert_zero("past elsewhere");
    let without = IndirectParams { restir_history: 0, ..params };
    let (scene, camera) = lambertian_planes();
    let mut rig = Rig::new(&device, scene, camera.clone(), SIZE, &without);
    rig.cameras = vec![camera.clone(), camera];
    let none = Runs::of(&mut rig, 2, error_of_closed_form);
    found.less(&none).assert_zero("past elsewhere less none");
    assert!(found.square < 0.8 * none.square, "{} of {}", found.square, none.square);
}

/// A ceiling that shines: that the first ray meets it is direct light, which counts elsewhere.
#[test]
fn emission_of_a_lamp_is_not_reused() {
    let device = TestDevice::open();
    let shining = Material { emissive: Vec3::splat(2.0), ..Material::lambertian("ceiling", ALBEDO) };
    let (scene, camera) = planes(Material::lambertian("floor", Vec3::splat(0.5)), shining);
    let mut rig = Rig::new(&device, scene, camera, SIZE, &restir(RestirVisibility::InWeight, 0));
    Runs::of(&mut rig, 1, error_of_closed_form).assert_zero("a ceiling that shines");
}

/// A glossy floor under a ceiling that reflects more to one side than to the other: what is reused and what is not add up to the light of the paths.
#[test]
fn parts_of_the_light_add_up() {
    let device = TestDevice::open();
    let material = |name: &str, roughness: f32| Material { roughness, ..Material::diffuse(name, ALBEDO) };
    let runs = |params: &IndirectParams| {
        let (scene, camera) =
            planes(material("floor", 0.5), Material { metallic: 0.5, ..material("ceiling", 0.5) });
        // The sun shines along x.
        Runs::of_bands(&mut Rig::new(&device, scene, camera, SIZE, params), 1, |p| p.x, floor_light)
    };
    let none = runs(&IndirectParams::default());
    let base = restir(RestirVisibility::InWeight, 0);
    runs(&base).less(&none).assert_zero("diffuse light");
    runs(&IndirectParams { restir_roughness: 0.4, ..base }).less(&none).assert_zero("specular light as well");
}

/// How much light the settings lose or gain that are said to be biased.
#[test]
fn biased_settings_are_biased() {
    let device = TestDevice::open();
    let none = errors(&device, &IndirectParams::default(), 1);
    let (scene, camera) = lambertian_planes();
    let mut rig = Rig::new(&device, scene, camera, SIZE, &IndirectParams::default());
    let light = Runs::of(&mut rig, 1, |texel| floor_light(texel).and(texel.position).map(exact_light)).mean();
    for visibility in [RestirVisibility::None, RestirVisibility::Final] {
        let case = visibility.name();
        let bias = errors(&device, &restir(visibility, 0), 1).less(&none);
        let percent: [f64; BANDS] = std::array::from_fn(|b| 100.0 * bias.mean()[b] / light[b]);
        println!("{case}: bias of the bands, dark to bright: {percent:+.1?} %");
        let deviations = bias.deviations(case);
        assert!(deviations.iter().any(|d| d.abs() > 4.0), "{case} is unbiased here");
    }
}

#[test]
fn first_frame_after_a_reset_equals_a_first_frame() {
    let device = TestDevice::open();
    let (scene, camera) = lambertian_planes();
    let mut rig = Rig::new(&device, scene, camera, SIZE, &restir(RestirVisibility::InWeight, 20));
    let light = |rig: &mut Rig, index| rig.frame(index, 1).iter().map(|t| t.irradiance).collect::<Vec<_>>();
    let first = light(&mut rig, 5);
    light(&mut rig, 6);
    assert_ne!(light(&mut rig, 5), first, "the history has no effect");
    rig.images.reset_history();
    assert_eq!(light(&mut rig, 5), first);
}
