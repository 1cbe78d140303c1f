//! Gradient pixels: pixels with the last frame's surface and random seed take its light sample again, with this frame's lights.

use crate::common::view::{Surface, View};
use glam::{Affine3A, Vec3};
use pt_core::random::RandomSource;
use pt_core::test_support::TestDevice;
use pt_light_sampling::records::StatisticsTable;
use pt_light_sampling::test_support::{bright_spot, polygon};
use pt_lights::DirectParams;
use pt_lights::records::{EnvironmentRays, LightRays, LightStorage};
use pt_scene::animation::{Deformation, Influence, Skin};
use pt_scene::{AlphaMode, Light, Material, Scene};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{LightSampler, NONE, RisSource};
use std::sync::Arc;

const SIZE: [u32; 2] = [16, 16];
const PIXELS: usize = 256;

/// Points on the floor, from -4 m to 4 m.
fn surfaces() -> Vec<Option<Surface>> {
    let at = |i: u32| (i as f32 + 0.5) * 0.5 - 4.0;
    let surface = |i: u32| Surface {
        position: Vec3::new(at(i % SIZE[0]), 0.0, at(i / SIZE[0])),
        normal: Vec3::Y,
        to_viewer: Vec3::new(0.3, 0.8, 0.1).normalize(),
        material: 0,
    };
    (0..SIZE[0] * SIZE[1]).map(|i| Some(surface(i))).collect()
}

fn square(scene: &mut Scene, centre: Vec3, half: f32, facing_down: bool, material: Material) {
    let z = if facing_down { -half } else { half };
    let corners = [(-half, z), (half, z), (half, -z), (-half, -z)];
    polygon(
        scene,
        &corners.map(|(x, z)| centre + Vec3::new(x, 0.0, z)),
        Affine3A::IDENTITY,
        Material { double_sided: true, ..material },
    );
}

/// A floor under boards that hide parts of the lamps above them from it.
fn floor() -> Scene {
    let mut scene = Scene::default();
    square(&mut scene, Vec3::ZERO, 5.0, false, Material::lambertian("floor", Vec3::splat(0.5)));
    for (x, z) in [(-2.0, -2.0), (2.0, 2.0), (2.5, -2.0), (-2.0, 1.5)] {
        square(&mut scene, Vec3::new(x, 0.7, z), 0.9, false, Material::lambertian("board", Vec3::ONE));
    }
    scene
}

fn lamp(id: u32) -> Light {
    let [x, z] = [(id * 7 % 31) as f32 / 3.9 - 4.0, (id * 11 % 31) as f32 / 3.9 - 4.0];
    let position = Vec3::new(x, 1.0 + (id % 5) as f32 * 0.4, z);
    let intensity = Vec3::splat(0.5 + 0.37 * (id % 9) as f32);
    let light = match id % 3 {
        0 => Light::spot("spot", position, Vec3::new(0.2, -1.0, 0.1), 0.5, 1.2, intensity),
        _ => Light::point("lamp", position, intensity),
    };
    Light { id, radius: if id.is_multiple_of(4) { 0.1 } else { 0.0 }, ..light }
}

/// Every kind of light: 48 emissive triangles, 24 point and spot lights, suns, an environment.
fn hall() -> Scene {
    let mut scene = floor();
    for i in 0..24 {
        let centre =
            Vec3::new((i % 6) as f32 * 1.4 - 3.5, 1.4 + (i % 4) as f32 * 0.3, (i / 6) as f32 * 2.0 - 3.0);
        let radiance = Vec3::new(1.0, 0.8, 0.6) * (1 + i * 5 % 8) as f32;
        square(&mut scene, centre, 0.15, true, Material::lamp("lamp", radiance));
    }
    scene.lights = (1..=24).map(lamp).collect();
    for (id, x) in [(30, 0.5), (31, -0.7)] {
        let sun = Light::directional("sun", Vec3::new(x, -1.0, 0.2), Vec3::splat(0.3 + x.abs()));
        scene.lights.push(Light { id, angular_radius: 0.05, ..sun });
    }
    scene.environment = bright_spot(13, 9);
    scene
}

/// Lights that are all in other places, of other intensities, than a frame before; none is hidden by another.
fn stir(scene: &mut Scene, frame: u32) {
    for light in &mut scene.lights {
        let still = if light.id >= 30 { lamp(1) } else { lamp(light.id) };
        let phase = (frame * 13 + light.id * 7) % 11;
        light.intensity = still.intensity * (0.2 + 0.3 * phase as f32);
        light.position = still.position + Vec3::new(0.2 * phase as f32, 0.0, 0.1 * phase as f32);
    }
}

/// Everything that claims to replay, by name.
fn claims() -> Vec<(String, DirectParams)> {
    let base = DirectParams { replay: true, statistics_interval: 2, ..DirectParams::default() };
    let merged = |sampler| DirectParams { rays: LightRays::Merged, sampler, ..base.clone() };
    let samplers = LightSampler::VALUES.iter().filter(|sampler| sampler.replays());
    let mut all: Vec<_> = samplers.map(|&s| (s.name().to_string(), merged(s))).collect();
    let sparse =
        DirectParams { statistics_table: StatisticsTable::Sparse, ..merged(LightSampler::ClusterStats) };
    let by_power = DirectParams { ris_source: RisSource::Power, ..merged(LightSampler::Ris) };
    all.extend([("sparse".into(), sparse), ("ris by power".into(), by_power), ("per-kind".into(), base)]);
    assert!(all.iter().all(|(_, params)| params.replays()) && all.len() == 9);
    all
}

/// A view of the hall, with room for more lights.
fn view<'d>(device: &'d TestDevice, params: &DirectParams, random: RandomSource) -> View<'d> {
    let mut view = View::with(device, hall(), params.clone(), SIZE, random, 80);
    view.show(&surfaces());
    view
}

fn is_gradient(i: u32) -> bool {
    !(i * 7 + i / 16).is_multiple_of(3)
}

fn gradient_pixels() -> impl Iterator<Item = usize> {
    (0..PIXELS).filter(|&i| is_gradient(i as u32))
}

fn differing<'a>(a: &'a [f64], b: &'a [f64]) -> impl FnMut(&usize) -> bool + 'a {
    |&i| a[i] != b[i]
}

fn set_kinds(view: &mut View<'_>, local: bool, distant: bool) {
    (view.params.positional, view.params.emissive) = (local, local);
    (view.params.sun, view.params.environment) = (distant, distant);
}

/// Samplers share the three sources of random numbers. A kernel takes long to compile: each makes all checks.
fn check_claims(random: RandomSource, part: usize) {
    let device = TestDevice::open();
    for (name, params) in claims().into_iter().skip(part).step_by(3) {
        let mut view = view(&device, &params, random);
        without_change_the_last_frame_is_repeated(&name, &mut view);
        lights_that_double_give_twice_the_value(&name, &mut view);
        if params.rays == LightRays::Merged {
            choices_are_those_of_the_last_frame(&name, &mut view);
            lights_appear_and_vanish(&name, &mut view);
        }
    }
}

#[test]
fn samplers_with_white_noise() {
    check_claims(RandomSource::White, 0);
}

#[test]
fn samplers_with_blue_noise() {
    check_claims(RandomSource::BlueNoise, 1);
}

#[test]
fn samplers_with_sobol() {
    check_claims(RandomSource::Sobol, 2);
}

/// While statistics adapt, gradient pixels have last frame's values to the bit.
fn without_change_the_last_frame_is_repeated(name: &str, view: &mut View<'_>) {
    view.frame();
    for samples in [1, 3] {
        view.params.samples = samples;
        (0..2).for_each(|_| drop(view.frame()));
        let last = view.frame();
        let now = view.frame_with(is_gradient);
        let wrong = gradient_pixels().filter(differing(&now, &last)).count();
        assert_eq!(wrong, 0, "{name}, {samples} samples: gradient pixels that differ");
        let others = (0..PIXELS).filter(|&i| !is_gradient(i as u32));
        assert!(others.filter(differing(&now, &last)).count() > 60, "{name}: the frames are the same anyway");
    }
    view.params.samples = 1;
}

/// The intensity of every third light doubles: a pixel that has chosen it has exactly twice the value, others the same.
fn lights_that_double_give_twice_the_value(name: &str, view: &mut View<'_>) {
    let first = view.uploaded.lights.lists().first_positional();
    for local in [true, false] {
        set_kinds(view, local, !local);
        (view.params.environment, view.params.emissive) =
            (false, local && view.params.rays == LightRays::Merged);
        let before = view.frame();
        view.uploaded.scene.lights.iter_mut().step_by(3).for_each(|light| light.intensity *= 2.0);
        let after = view.frame_with(|_| true);
        let choices = view.choices();
        let mut doubled = 0;
        for (i, ((now, last), choice)) in after.iter().zip(&before).zip(&choices).enumerate() {
            let place = choice[0] as usize;
            let twice = match (view.params.rays, local) {
                (LightRays::Merged, true) => {
                    place != NONE as usize && place >= first && (place - first).is_multiple_of(3)
                }
                _ => now != last,
            };
            assert_eq!(*now, last * if twice { 2.0 } else { 1.0 }, "{name}: pixel {i}");
            doubled += usize::from(twice && *now > 0.0);
        }
        assert!((3..PIXELS).contains(&doubled), "{name}: {doubled} pixels");
        assert!(view.frame() != after, "{name}");
    }
    set_kinds(view, true, true);
}

/// Every light moves and changes its intensity in every frame: the choices stay those of the last frame.
fn choices_are_those_of_the_last_frame(name: &str, view: &mut View<'_>) {
    let mut moved = 0;
    for frame in 0..5 {
        let last = view.choices();
        stir(&mut view.uploaded.scene, frame);
        let repeats = frame == 2 || frame == 4;
        let light = view.frame_with(|_| repeats);
        assert!(light.iter().all(|light| light.is_finite()), "{name}");
        let pairs = || last.iter().zip(view.choices());
        if repeats {
            for (last, now) in pairs() {
                assert_eq!(now[0], last[0], "{name}: light");
                moved += usize::from(now[1] != last[1]);
            }
        } else {
            let same = pairs().filter(|(last, now)| last[0] == now[0]).count();
            assert!(same < PIXELS / 2, "{name}: {same} pixels choose the same anyway");
        }
    }
    assert!(moved > 20, "{name}: only {moved} pixels have chosen a light that moves");
}

/// Lights appear and vanish in every frame. A pixel whose light is still there keeps its value; one whose light has vanished is black.
fn lights_appear_and_vanish(name: &str, view: &mut View<'_>) {
    set_kinds(view, true, false);
    let (mut kept, mut gone) = (0, 0);
    let mut last: Option<(Vec<f64>, Vec<Chosen>)> = None;
    for frame in 0..8 {
        // Between 6 and 29 lights, in a row that turns.
        let count = 6 + frame * 17 % 24;
        let ids = (0..count).map(|i| 1 + (i * 5 + frame * 3) % 29);
        view.uploaded.scene.lights = ids.map(lamp).collect();
        let light = view.frame_with(|i| frame % 2 == 1 && is_gradient(i));
        assert!(light.iter().all(|light| light.is_finite()), "{name}: frame {frame}");
        let chosen = chosen_lights(view);
        if let (Some((values, before)), 1) = (&last, frame % 2) {
            // A place that was free is a choice too: a light that has appeared there counts as a change.
            for i in gradient_pixels().filter(|&i| before[i] != Chosen::Nothing) {
                let lights = &view.uploaded.scene.lights;
                let stays = match before[i] {
                    Chosen::Id(id) => lights.iter().any(|light| light.id == id),
                    _ => true,
                };
                assert_eq!(light[i], if stays { values[i] } else { 0.0 }, "{name}: frame {frame}, pixel {i}");
                assert!(!stays || chosen[i] == before[i], "{name}: another light");
                kept += usize::from(stays && light[i] > 0.0);
                gone += usize::from(!stays && values[i] > 0.0);
            }
        }
        last = Some((light, chosen));
    }
    assert!(kept > 40 && gone > 10, "{name}: {kept} {gone}");
}

#[derive(Clone, Copy, PartialEq)]
enum Chosen {
    Nothing,
    Triangle(u32),
    Id(u32),
}

/// The lights that the pixels have chosen; [`Light::id`] where it is one of the scene.
fn chosen_lights(view: &View<'_>) -> Vec<Chosen> {
    let lists = view.uploaded.lights.lists();
    let chosen = |index: u32| {
        let triangles = lists.first_positional() as u32;
        if index < triangles {
            return Chosen::Triangle(index);
        }
        let record = lists.lights.get(lists.sun_count as usize + (index.wrapping_sub(triangles)) as usize);
        let mut lights = view.uploaded.scene.lights.iter();
        let light = record.and_then(|record| lights.find(|light| light.position == record.position));
        light.map_or(Chosen::Nothing, |light| Chosen::Id(light.id))
    };
    view.choices().iter().map(|&[index, _]| chosen(index)).collect()
}

/// The environment among the lights: it brightens, turns and goes dark, and lamps appear and vanish. The choices are those of the last frame, the
/// light is this frame's.
#[test]
fn environment_among_the_lights_is_repeated() {
    let device = TestDevice::open();
    for sampler in [LightSampler::LightBvh, LightSampler::ClusterStats, LightSampler::Ris] {
        let params = DirectParams {
            replay: true,
            rays: LightRays::Merged,
            environment_rays: EnvironmentRays::List,
            sampler,
            ..DirectParams::default()
        };
        let name = sampler.name();
        let mut view = view(&device, &params, RandomSource::White);
        without_change_the_last_frame_is_repeated(name, &mut view);
        view.params.sun = false;
        let quads = view.uploaded.lights.lists().quad_range();
        let is_quad = |choice: &[u32; 2]| quads.contains(&(choice[0] as usize));

        let before = view.frame();
        view.uploaded.scene.environment.intensity *= 2.0;
        let after = view.frame_with(|_| true);
        let mut doubled = 0;
        for (i, choice) in view.choices().iter().enumerate() {
            let factor = if is_quad(choice) { 2.0 } else { 1.0 };
            assert_eq!(after[i], before[i] * factor, "{name}: pixel {i}");
            doubled += usize::from(factor > 1.0 && after[i] > 0.0);
        }
        assert!((20..PIXELS - 20).contains(&doubled), "{name}: {doubled} pixels");

        view.frame();
        let last = view.choices();
        view.uploaded.scene.environment.rotation += 1.0;
        view.uploaded.scene.lights = (10..=40).map(lamp).collect();
        let turned = view.frame_with(|_| true);
        assert!(turned.iter().all(|light| light.is_finite()), "{name}");
        let lights = |choices: Vec<[u32; 2]>| choices.into_iter().map(|choice| choice[0]).collect::<Vec<_>>();
        assert_eq!(lights(view.choices()), lights(last), "{name}: turned");

        let before = view.frame();
        let last = view.choices();
        view.uploaded.scene.environment.intensity = 0.0;
        let dark = view.frame_with(|_| true);
        let mut gone = 0;
        for (i, choice) in last.iter().enumerate() {
            assert_eq!(dark[i], if is_quad(choice) { 0.0 } else { before[i] }, "{name}: dark, pixel {i}");
            gone += usize::from(is_quad(choice) && before[i] > 0.0);
        }
        assert!(gone > 20, "{name}: {gone} pixels");
        assert_eq!(lights(view.choices()), lights(last), "{name}: dark");
    }
}

/// Where a glossy surface mirrors the sky, the weights of multiple importance sampling are those of the last frame's choice as well: a sky that has
/// become twice as bright gives twice the light, although this frame would choose it more often.
#[test]
fn reflections_have_the_weights_of_the_last_frame() {
    let device = TestDevice::open();
    let params = DirectParams {
        replay: true,
        rays: LightRays::Merged,
        environment_rays: EnvironmentRays::List,
        sampler: LightSampler::Power,
        sun: false,
        ..DirectParams::default()
    };
    let mut scene = hall();
    scene.materials[0].roughness = 0.25;
    let mut view = View::with(&device, scene, params, SIZE, RandomSource::White, 80);
    view.show(&surfaces());
    view.frame();
    let before = view.frame();
    view.uploaded.scene.environment.intensity *= 2.0;
    let after = view.frame_with(|_| true);
    let quads = view.uploaded.lights.lists().quad_range();
    let mut doubled = 0;
    for (i, choice) in view.choices().iter().enumerate().filter(|(_, c)| quads.contains(&(c[0] as usize))) {
        assert_eq!(after[i], 2.0 * before[i], "pixel {i}, light {}", choice[0]);
        doubled += usize::from(after[i] > 0.0);
    }
    assert!(doubled > 20, "{doubled} pixels");
}

/// What covers a ray only in part decides at random whether it does, and stored light is rounded at random: both as in the last frame.
#[test]
fn coverage_and_rounding_are_repeated() {
    let device = TestDevice::open();
    let params = DirectParams { replay: true, storage: LightStorage::Rgbe, ..DirectParams::default() };
    let mut scene = hall();
    for mesh in &mut scene.meshes {
        let material = &mut scene.materials[mesh.triangle_materials[0] as usize];
        if material.name == "board" {
            (material.alpha_mode, material.base_color.w) = (AlphaMode::Blend, 0.5);
            mesh.first_masked = 0;
        }
    }
    let mut view = View::with(&device, scene, params, SIZE, RandomSource::White, 80);
    view.show(&surfaces());
    without_change_the_last_frame_is_repeated("blended boards", &mut view);
}

/// A ball that comes nearer: the replayed estimate has the mean of this frame's estimate, also where the sample was chosen among candidates.
#[test]
fn light_that_moves_is_lit_where_it_is() {
    let device = TestDevice::open();
    let ball =
        |y: f32| Light { radius: 0.3, ..Light::point("ball", Vec3::new(0.2, y, 0.1), Vec3::splat(5.0)) };
    for (name, params) in claims().into_iter().filter(|(name, _)| name == "uniform" || name == "ris") {
        let mut scene = floor();
        scene.instances.truncate(1);
        scene.lights.push(ball(6.0));
        let mut view = View::new(&device, scene, params, SIZE);
        view.show(&surfaces());
        view.frame();
        view.uploaded.scene.lights[0] = ball(1.5);
        let replayed: f64 = view.frame_with(|_| true).iter().sum();
        let now: f64 = view.frame().iter().sum();
        // Points of the ball alone differ: their noise is far less than the change, which is a factor of 5.
        assert!((replayed / now - 1.0).abs() < 0.02, "{name}: {replayed}, {now}");
    }
}

/// Pixels beside gradient pixels are lit as they are without any. Shadow rays of gradient pixels do not count: statistics are afterwards as
/// if no ray had been traced.
#[test]
fn gradient_pixels_change_nothing_else() {
    let device = TestDevice::open();
    let params = claims().into_iter().find(|(name, _)| name == "cluster-stats").unwrap().1;
    let params = DirectParams { statistics_interval: 1, statistics_frames: 1, ..params };
    let mut view = view(&device, &params, RandomSource::White);
    // Two frames, the second of which has gradient pixels or is without local lights, and a third one.
    let mut three = |is_gradient: &dyn Fn(u32) -> bool, local: bool| {
        view.restart();
        stir(&mut view.uploaded.scene, 0);
        view.frame();
        stir(&mut view.uploaded.scene, 1);
        set_kinds(&mut view, local, true);
        let second = view.frame_with(is_gradient);
        set_kinds(&mut view, true, true);
        [second, view.frame()]
    };
    let [plain, counted] = three(&|_| false, true);
    let [partly, _] = three(&is_gradient, true);
    let beside = |&i: &usize| !is_gradient(i as u32);
    assert_eq!((0..PIXELS).filter(beside).filter(differing(&plain, &partly)).count(), 0);
    assert!(gradient_pixels().filter(differing(&plain, &partly)).count() > 60);
    let [_, replayed] = three(&|_| true, true);
    let [_, without] = three(&|_| false, false);
    assert!(replayed == without && replayed != counted);
}

/// Emissive triangles of a mesh that deforms from frame to frame give light from where they are.
#[test]
fn lamp_that_deforms_gives_light_from_where_it_is() {
    let device = TestDevice::open();
    let mut scene = floor();
    scene.instances.truncate(1);
    square(&mut scene, Vec3::new(0.0, 2.0, 0.0), 0.4, true, Material::lamp("lamp", Vec3::splat(9.0)));
    let mesh = scene.meshes.last_mut().unwrap();
    mesh.positions.iter().for_each(|_| mesh.influences.push([Influence { joint: 0, weight: 1.0 }]));
    let skin = Skin { joints: vec![0], inverse_bind: vec![Affine3A::IDENTITY] };
    mesh.deformation = Some(Box::new(Deformation::new(mesh, 0, Some(Arc::new(skin)), &[])));
    let mut view = View::new(&device, scene, DirectParams::default(), SIZE);
    view.show(&surfaces());
    let mut fourth = |joint: &dyn Fn(u32) -> Affine3A| {
        view.reset();
        for frame in 0..3 {
            if let Some(deformation) = &mut view.uploaded.scene.meshes.last_mut().unwrap().deformation {
                deformation.joints[0] = joint(frame);
            }
            view.frame();
        }
        view.frame()
    };
    let (here, there) = (Affine3A::IDENTITY, Affine3A::from_translation(Vec3::new(1.5, 0.0, 1.0)));
    let stays = fourth(&|_| here);
    let moves = fourth(&|frame| if frame < 2 { here } else { there });
    assert!(moves == fourth(&|_| there) && moves != stays);
}
