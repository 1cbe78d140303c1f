//! Gradient pixels: pixels with the last frame's surface and random seed take its light sample again, with this frame's lights.

mod common;

use common::view::{Surface, View};
use glam::{Affine3A, Vec3};
use pt_core::random::RandomSource;
use pt_core::test_support::TestDevice;
use pt_light_sampling::records::StatisticsTable;
use pt_light_sampling::test_support::{bright_spot, polygon};
use pt_lights::DirectParams;
use pt_lights::records::LightRays;
use pt_scene::animation::{Deformation, Influence, Skin};
use pt_scene::{Light, Material, Scene};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{LightSampler, RisSource};
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
    Light { id, radius: if id % 4 == 0 { 0.1 } else { 0.0 }, ..light }
}

/// Every kind of light: 48 emissive triangles, 24 point and spot lights, suns, an environment.
fn hall() -> Scene {
    let mut scene = floor();
    for i in 0..24 {
        let centre = Vec3::new((i % 6) as f32 * 1.4 - 3.5, 1.4 + (i % 4) as f32 * 0.3, (i / 6) as f32 * 2.0 - 3.0);
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

fn view<'d>(device: &'d TestDevice, scene: Scene, params: &DirectParams, random: RandomSource) -> View<'d> {
    let mut view = View::with(device, scene, params.clone(), SIZE, random, 80);
    view.show(&surfaces());
    view
}

fn is_gradient(i: u32) -> bool {
    (i * 7 + i / 16) % 3 != 0
}

fn gradient_pixels() -> impl Iterator<Item = usize> {
    (0..PIXELS).filter(|&i| is_gradient(i as u32))
}

/// While statistics adapt, gradient pixels have last frame's values to the bit. Every source of random numbers occurs, with one or three
/// samples a pixel; cluster-stats and rays of every kind, which draw from all dimensions, have them all.
#[test]
fn without_change_the_last_frame_is_repeated() {
    let device = TestDevice::open();
    for (i, (name, params)) in claims().into_iter().enumerate() {
        let all = ["cluster-stats", "per-kind"].contains(&name.as_str());
        for j in 0..if all { 3 } else { 1 } {
            let random = [RandomSource::White, RandomSource::BlueNoise, RandomSource::Sobol][(i + j) % 3];
            let params = DirectParams { samples: if (i + j) % 2 == 0 { 3 } else { 1 }, ..params.clone() };
            let mut view = view(&device, hall(), &params, random);
            (0..3).for_each(|_| drop(view.frame()));
            let last = view.frame();
            let now = view.frame_with(is_gradient);
            let differ = |&i: &usize| now[i] != last[i];
            let wrong = gradient_pixels().filter(differ).count();
            assert_eq!(wrong, 0, "{name}, {}: gradient pixels that differ", random.name());
            let others = (0..PIXELS).filter(|&i| !is_gradient(i as u32));
            assert!(others.filter(differ).count() > 60, "{name}: the frames are the same anyway");
        }
    }
}

/// The other pixels are lit as they are without gradient pixels.
#[test]
fn pixels_beside_gradient_pixels_are_not_touched() {
    let device = TestDevice::open();
    let (_, params) = claims().into_iter().find(|(name, _)| name == "cluster-stats").unwrap();
    let [mut plain, mut replayed] = [(); 2].map(|_| view(&device, hall(), &params, RandomSource::White));
    for frame in 0..4 {
        for view in [&mut plain, &mut replayed] {
            stir(&mut view.uploaded.scene, frame);
        }
        let (plain, now) = (plain.frame(), replayed.frame_with(|i| frame == 3 && is_gradient(i)));
        let same = |i: usize| plain[i] == now[i];
        assert!((0..PIXELS).filter(|&i| frame < 3 || !is_gradient(i as u32)).all(same), "frame {frame}");
        assert!(frame < 3 || gradient_pixels().filter(|&i| same(i)).count() < 100);
    }
}

/// Every light moves and changes its intensity in every frame: the choices stay those of the last frame.
#[test]
fn choices_are_those_of_the_last_frame() {
    let device = TestDevice::open();
    for (name, params) in claims().into_iter().filter(|(_, params)| params.rays == LightRays::Merged) {
        let mut view = view(&device, hall(), &params, RandomSource::White);
        let mut moved = 0;
        for frame in 0..5 {
            stir(&mut view.uploaded.scene, frame);
            view.frame();
        }
        for frame in 5..8 {
            let last = view.choices();
            stir(&mut view.uploaded.scene, frame);
            let light = view.frame_with(|_| frame != 6);
            if frame == 6 {
                let same = view.choices().iter().zip(&last).filter(|(a, b)| a[0] == b[0]).count();
                assert!(same < PIXELS / 2, "{name}: {same} pixels choose the same anyway");
                continue;
            }
            // A gradient pixel of the last frame is none now: in frame 5 all are, in frame 6 none, in frame 7 all.
            for (now, last) in view.choices().iter().zip(&last) {
                assert_eq!(now[0], last[0], "{name}: light");
                moved += usize::from(now[1] != last[1]);
            }
            assert!(light.iter().all(|light| light.is_finite()), "{name}");
        }
        assert!(moved > 20, "{name}: only {moved} pixels have chosen a light that moves");
    }
}

/// The intensity of one of several lights doubles: its pixels have exactly twice the value, the others the same.
#[test]
fn light_that_doubles_gives_twice_the_value() {
    let device = TestDevice::open();
    let suns = DirectParams { positional: false, ..DirectParams::default() };
    let suns = ("suns".to_string(), DirectParams { replay: true, ..suns });
    for (name, params) in claims().into_iter().chain([suns]) {
        let mut scene = floor();
        scene.lights = if name == "suns" { hall().lights.split_off(24) } else { (1..=12).map(lamp).collect() };
        let double = scene.lights.len() / 2;
        let mut view = view(&device, scene, &params, RandomSource::White);
        (0..3).for_each(|_| drop(view.frame()));
        let before = view.frame();
        view.uploaded.scene.lights[double].intensity *= 2.0;
        let after = view.frame_with(|_| true);
        let choices = view.choices();
        let mut doubled = 0;
        for i in 0..PIXELS {
            let twice = match params.rays {
                LightRays::Merged => choices[i][0] as usize == double,
                LightRays::PerKind => after[i] != before[i],
            };
            assert_eq!(after[i], before[i] * if twice { 2.0 } else { 1.0 }, "{name}: pixel {i}");
            doubled += usize::from(twice && after[i] > 0.0);
        }
        assert!((3..PIXELS).contains(&doubled), "{name}: {doubled} pixels");
        assert!(view.frame() != after, "{name}");
    }
}

/// A ball that comes nearer: the replayed estimate has the mean of this frame's estimate, also where the sample was chosen among candidates.
#[test]
fn light_that_moves_is_lit_where_it_is() {
    let device = TestDevice::open();
    let ball = |y: f32| Light { radius: 0.3, ..Light::point("ball", Vec3::new(0.2, y, 0.1), Vec3::splat(5.0)) };
    for (name, params) in claims() {
        let mut scene = floor();
        scene.instances.truncate(1);
        scene.lights.push(ball(6.0));
        let mut view = view(&device, scene, &params, RandomSource::White);
        view.frame();
        view.uploaded.scene.lights[0] = ball(1.5);
        let replayed: f64 = view.frame_with(|_| true).iter().sum();
        let now: f64 = view.frame().iter().sum();
        // Points of the ball alone differ: their noise is far less than the change, which is a factor of 5.
        assert!((replayed / now - 1.0).abs() < 0.02, "{name}: {replayed}, {now}");
    }
}

/// Lights appear and vanish in every frame. A pixel whose light is still there keeps its value; one whose light has vanished is black.
#[test]
fn lights_appear_and_vanish() {
    let device = TestDevice::open();
    for (name, params) in claims().into_iter().filter(|(_, params)| params.rays == LightRays::Merged) {
        let mut scene = floor();
        scene.lights = (1..=12).map(lamp).collect();
        let mut view = view(&device, scene, &params, RandomSource::White);
        let (mut kept, mut gone) = (0, 0);
        let mut last: Option<(Vec<f64>, Vec<u32>)> = None;
        for frame in 0..9 {
            // Between 6 and 29 lights, in a row that turns.
            let count = 6 + frame * 17 % 24;
            let ids = (0..count).map(|i| 1 + (i * 5 + frame * 3) % 29);
            view.uploaded.scene.lights = ids.map(lamp).collect();
            let gradient = |i: u32| frame % 2 == 1 && is_gradient(i);
            let light = view.frame_with(gradient);
            assert!(light.iter().all(|light| light.is_finite()), "{name}: frame {frame}");
            let exists = |id: u32| view.uploaded.scene.lights.iter().any(|light| light.id == id);
            let lists = view.uploaded.lights.lists();
            let chosen: Vec<u32> = (view.choices().iter())
                .map(|&[index, _]| match lists.lights.get(index as usize) {
                    Some(record) => view.uploaded.scene.lights.iter().find(|l| l.position == record.position),
                    None => None,
                })
                .map(|light| light.map_or(0, |light| light.id))
                .collect();
            if let (Some((values, ids)), 1) = (&last, frame % 2) {
                // A place that was free is a choice too: a light that has appeared there counts as a change.
                for i in gradient_pixels().filter(|&i| ids[i] != 0) {
                    let stays = exists(ids[i]);
                    assert_eq!(light[i], if stays { values[i] } else { 0.0 }, "{name}: frame {frame}, pixel {i}");
                    assert!(!stays || chosen[i] == ids[i], "{name}: another light");
                    kept += usize::from(stays && light[i] > 0.0);
                    gone += usize::from(!stays && values[i] > 0.0);
                }
            }
            last = Some((light, chosen));
        }
        assert!(kept > 50 && gone > 50, "{name}: {kept} {gone}");
    }
}

/// Shadow rays of gradient pixels do not count: the statistics are as if there had been none in that frame.
#[test]
fn gradient_pixels_are_not_counted_twice() {
    let device = TestDevice::open();
    let params = claims().into_iter().find(|(name, _)| name == "cluster-stats").unwrap().1;
    let params = DirectParams { statistics_interval: 1, statistics_frames: 1, ..params };
    let third = |change: &dyn Fn(&mut View<'_>)| {
        let mut view = view(&device, hall(), &params, RandomSource::White);
        view.frame();
        change(&mut view);
        (view.params.emissive, view.params.positional) = (true, true);
        view.frame()
    };
    let replayed = third(&|view| drop(view.frame_with(|_| true)));
    let without = third(&|view| {
        (view.params.emissive, view.params.positional) = (false, false);
        view.frame();
    });
    let counted = third(&|view| drop(view.frame()));
    assert!(replayed == without && replayed != counted);
}

/// Emissive triangles of a mesh that deforms from frame to frame give light from where they are.
#[test]
fn lamp_that_deforms_gives_light_from_where_it_is() {
    let device = TestDevice::open();
    let lit = |joints: &dyn Fn(u32) -> Affine3A| {
        let mut scene = floor();
        scene.instances.truncate(1);
        square(&mut scene, Vec3::new(0.0, 2.0, 0.0), 0.4, true, Material::lamp("lamp", Vec3::splat(9.0)));
        let mesh = scene.meshes.last_mut().unwrap();
        mesh.positions.iter().for_each(|_| mesh.influences.push([Influence { joint: 0, weight: 1.0 }]));
        let skin = Skin { joints: vec![0], inverse_bind: vec![Affine3A::IDENTITY] };
        mesh.deformation = Some(Box::new(Deformation::new(mesh, 0, Some(Arc::new(skin)), &[])));
        let mut view = view(&device, scene, &DirectParams::default(), RandomSource::White);
        for frame in 0..3 {
            if let Some(deformation) = &mut view.uploaded.scene.meshes.last_mut().unwrap().deformation {
                deformation.joints[0] = joints(frame);
            }
            view.frame();
        }
        view.frame()
    };
    let moved = Affine3A::from_translation(Vec3::new(1.5, 0.0, 1.0));
    let later = lit(&|frame| if frame < 2 { Affine3A::IDENTITY } else { moved });
    assert!(later == lit(&|_| moved) && later != lit(&|_| Affine3A::IDENTITY));
}
