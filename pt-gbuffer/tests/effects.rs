//! The effects against their oracle, which sorts all of them, and against closed forms.

use glam::{Affine3A, DVec2, DVec3, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::split::flat_to_split;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::oracle::effects::{Seen, along, interval};
use pt_gbuffer::{
    Effects as EffectsStage, GbufferParams, Jitter, PrimaryRays, ReflectRefract, images, oracle,
};
use pt_light_sampling::test_support::{Uploaded, polygon};
use pt_scene::gpu::camera_record;
use pt_scene::{Beam, Camera, Drift, Effects, FogVolume, Look, Material, Particle, Scene, Sprite};
use pt_shaders::channels::{THROUGHPUT, TRANSPARENT};
use pt_shaders::records::{CameraRecord, FrameRecord, SKY_DISTANCE};

const SIZE: [u32; 2] = [48, 32];
/// Radiance of the wall at z = 0.
const WALL: Vec3 = Vec3::new(0.5, 0.25, 1.0);
const EYE: Vec3 = Vec3::new(0.0, 0.0, 4.0);

/// A wall of 8 m x 3 m, which shines or is a mirror, above and below it black sky.
fn scene(effects: Effects, mirror: bool) -> Scene {
    let mut scene = Scene { effects, ..Scene::default() };
    let material = match mirror {
        true => Material::metal("mirror", Vec3::ONE, 0.0),
        false => Material { emissive: WALL, ..Material::lambertian("wall", Vec3::ZERO) },
    };
    let corners = [(-4.0, -1.5), (4.0, -1.5), (4.0, 1.5), (-4.0, 1.5)].map(|(x, y)| Vec3::new(x, y, 0.0));
    polygon(&mut scene, &corners, Affine3A::IDENTITY, material);
    scene.validate().unwrap();
    scene
}

fn camera() -> Camera {
    Camera::look_at("front", EYE, Vec3::ZERO, 0.9)
}

/// What a frame shows, in the order of its pixels.
struct Shown {
    transparent: Vec<DVec3>,
    throughput: Vec<DVec3>,
    /// xy = motion, z = luminance, w = opacity.
    motion: Vec<[f32; 4]>,
    milliseconds: f64,
}

fn render(device: &TestDevice, backend: TraceBackend, scene: &Scene, view: &Camera, layers: u32) -> Shown {
    let mut uploaded = Uploaded::new(device, scene.clone(), backend);
    let variant = uploaded.gpu.variant();
    let primary = PrimaryRays::new(device, variant).unwrap();
    let effects = EffectsStage::new(device, variant, layers).unwrap();
    let reflect = ReflectRefract::new(device, variant, false, layers).unwrap();
    let io = [PrimaryRays::IO, EffectsStage::BLEND, reflect.io()];
    let images = ChannelImages::alone(device, FrameSizes::same(SIZE), &io).unwrap();
    let uniforms = Uniforms::new(device, "frame_uniforms").unwrap();
    let params = GbufferParams { jitter: Jitter::None, reflect_refract: 1, ..Default::default() };
    let camera = camera_record(view, SIZE);
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    uploaded.lights.update(&mut frame, &uploaded.scene, &mut uploaded.gpu).unwrap();
    uploaded.gpu.update(&mut frame, &uploaded.scene).unwrap();
    uniforms.upload(&mut frame, &FrameRecord::new(camera, camera, SIZE, 0, 3)).unwrap();
    let inputs = StageInputs { scene: Some(&uploaded.gpu), uniforms: Some(&uniforms), images: &images };
    primary.record(&mut frame, &inputs, &params).unwrap();
    effects.record(&mut frame, &inputs, &params).unwrap();
    reflect.record(&mut frame, &inputs, &params, 0, 0, 0).unwrap();
    frame.submit().unwrap();
    let timings = recorder.finish().unwrap();
    let pass = timings[0].passes.iter().find(|pass| pass.pass == "effects").unwrap();
    let texels = |id| images.current(id).read_f32().unwrap();
    let rgb = |values: Vec<f32>| {
        in_order().map(|i| DVec3::from_array(std::array::from_fn(|c| f64::from(values[4 * i + c])))).collect()
    };
    let motion = texels(images::EFFECTS_MOTION);
    Shown {
        transparent: rgb(texels(TRANSPARENT)),
        throughput: rgb(texels(THROUGHPUT)),
        motion: in_order().map(|i| std::array::from_fn(|c| motion[4 * i + c])).collect(),
        milliseconds: pass.ms,
    }
}

/// Texel of the split frame of each pixel.
fn in_order() -> impl Iterator<Item = usize> {
    let width = field_width(SIZE[0]);
    pixels().map(move |[x, y]| {
        let [sx, sy] = flat_to_split([x, y], width);
        (sy * 2 * width + sx) as usize
    })
}

fn pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]))
}

fn ray(camera: &CameraRecord, [x, y]: [u32; 2]) -> (DVec3, DVec3) {
    let uv = (DVec2::new(x.into(), y.into()) + 0.5) / DVec2::new(SIZE[0].into(), SIZE[1].into());
    oracle::camera_ray(camera, uv)
}

/// Distance of the wall, if the ray meets it.
fn wall(origin: DVec3, direction: DVec3) -> Option<f64> {
    let t = -origin.z / direction.z;
    let at = origin + t * direction;
    (t > 0.0 && at.x.abs() < 4.0 && at.y.abs() < 1.5).then_some(t)
}

fn expected(effects: &Effects, view: &Camera, pixel: [u32; 2]) -> (Seen, DVec3) {
    let (origin, direction) = ray(&camera_record(view, SIZE), pixel);
    let t = wall(origin, direction);
    let seen = along(effects, origin, direction, t.unwrap_or(f64::from(SKY_DISTANCE)));
    (seen, if t.is_some() { WALL.as_dvec3() } else { DVec3::ZERO })
}

fn look(r: f32, g: f32, b: f32, opacity: f32) -> Look {
    Look { radiance: Vec3::new(r, g, b), opacity }
}

fn particle(x: f32, y: f32, z: f32, radius: f32, look: Look) -> Particle {
    Particle { position: Vec3::new(x, y, z), radius, look, drift: Drift::default() }
}

fn beam(ends: [Vec3; 2], radius: f32, look: Look) -> Beam {
    Beam { ends, radius, look, drift: Drift::default() }
}

fn fog(corners: [Vec3; 2], density: f32, gradient: Vec3) -> FogVolume {
    FogVolume { corners, density, gradient, radiance: Vec3::new(0.2, 0.3, 0.4), drift: Drift::default() }
}

/// Some of each kind, before each other, through each other and through the wall.
fn mixture() -> Effects {
    let sprite = |z: f32, tilt: f32, look: Look| Sprite {
        position: Vec3::new(0.3, 0.1, z),
        half_sides: [Vec3::new(0.8, 0.1, tilt), Vec3::new(-0.1, 0.7, 0.2)],
        texture: None,
        look,
        drift: Drift { velocity: Vec3::new(0.1, 0.0, 0.0), ..Drift::default() },
    };
    Effects {
        particles: vec![
            particle(-0.5, 0.2, 1.0, 0.6, look(0.5, 0.2, 0.1, 0.7)),
            particle(-0.2, 0.1, 1.5, 0.5, look(0.0, 0.0, 0.0, 0.9)),
            // Half of it in the wall, and one behind it.
            particle(1.0, -0.3, 0.05, 0.4, look(2.0, 1.0, 1.0, 0.0)),
            particle(0.0, 0.0, -0.5, 0.4, look(9.0, 9.0, 9.0, 1.0)),
            // Round the camera, and behind it.
            particle(0.1, 0.1, 4.0, 0.5, look(0.1, 0.2, 0.1, 0.3)),
            particle(0.0, 0.0, 6.0, 1.0, look(9.0, 9.0, 9.0, 1.0)),
        ],
        beams: vec![
            beam([Vec3::new(-1.5, -0.8, 0.5), Vec3::new(1.5, 0.9, 2.0)], 0.15, look(0.1, 0.5, 2.0, 0.5)),
            // Seen almost end on.
            beam([Vec3::new(0.4, -0.4, 0.5), Vec3::new(0.2, -0.2, 2.5)], 0.2, look(1.0, 0.5, 0.0, 0.8)),
        ],
        sprites: vec![
            sprite(0.8, 0.3, look(0.2, 0.4, 0.2, 0.5)),
            sprite(1.8, -0.5, look(0.3, 0.0, 0.3, 0.4)),
            // Half of it behind the wall.
            sprite(-0.1, 0.6, look(0.1, 0.3, 0.6, 0.6)),
        ],
        fog: vec![
            fog([Vec3::new(-2.0, -1.0, 0.2), Vec3::new(0.3, 0.5, 1.4)], 0.1, Vec3::new(0.2, 0.3, 0.4)),
            fog([Vec3::new(-0.5, -2.0, 2.0), Vec3::new(2.0, 2.0, 5.0)], 0.6, Vec3::new(0.0, -0.1, -0.05)),
        ],
        time: 0.5,
        time_prev: 0.4,
    }
}

/// Pixels at the edge of a sprite or of fog may fall on either side of it.
const EDGES: usize = SIZE[0] as usize * SIZE[1] as usize / 200;

#[test]
fn kernel_and_oracle_agree_while_layers_suffice() {
    let device = TestDevice::open();
    let effects = mixture();
    for backend in TraceBackend::available(&device) {
        let shown = render(&device, backend, &scene(effects.clone(), false), &camera(), 16);
        let (mut wrong, mut covered) = (Vec::new(), 0);
        for (i, pixel) in pixels().enumerate() {
            let (seen, behind) = expected(&effects, &camera(), pixel);
            let error = (shown.transparent[i] - seen.over(behind)).abs().max_element();
            // Throughput is stored in half floats.
            let error = error.max(0.1 * (shown.throughput[i].x - seen.transmittance).abs());
            covered += usize::from(seen.transmittance < 0.9);
            if error > 2e-4 {
                wrong.push((pixel, shown.transparent[i], seen.over(behind)));
            }
        }
        assert!(covered > 500, "{covered}");
        assert!(
            wrong.len() <= EDGES,
            "{backend}: {} pixels, {:?}",
            wrong.len(),
            &wrong[..wrong.len().min(8)]
        );
    }
}

#[test]
fn a_mirror_shows_them() {
    let device = TestDevice::open();
    let effects = mixture();
    let mut first: Option<Vec<DVec3>> = None;
    for backend in TraceBackend::available(&device) {
        let shown = render(&device, backend, &scene(effects.clone(), true), &camera(), 16);
        let mut wrong = 0;
        for (i, pixel) in pixels().enumerate() {
            let (origin, direction) = ray(&camera_record(&camera(), SIZE), pixel);
            let Some(t) = wall(origin, direction) else { continue };
            let onward = direction * DVec3::new(1.0, 1.0, -1.0);
            let reflected = along(&effects, origin + t * direction, onward, f64::from(SKY_DISTANCE));
            let image = along(&effects, origin, direction, t).over(reflected.radiance);
            // Throughput is stored in half floats between the passes.
            wrong += usize::from(
                (shown.transparent[i] - image).abs().max_element() > 1e-3 * (1.0 + image.max_element()),
            );
        }
        assert!(wrong <= 2 * EDGES, "{backend}: {wrong} pixels");
        match &first {
            Some(bits) => assert_eq!(bits, &shown.transparent, "{backend}"),
            None => first = Some(shown.transparent),
        }
    }
}

#[test]
fn fog_has_its_closed_form() {
    let device = TestDevice::open();
    let volume = fog([Vec3::new(-1.0, -1.2, 0.5), Vec3::new(1.5, 1.0, 2.5)], 0.3, Vec3::new(0.4, 0.2, -0.1));
    let effects = Effects { fog: vec![volume], ..Effects::default() };
    // Before the fog, and in it.
    for eye in [EYE, Vec3::new(0.2, 0.1, 1.5)] {
        let view = Camera::look_at("fog", eye, Vec3::new(0.1, 0.0, 0.0), 0.9);
        let shown = render(&device, TraceBackend::Compute, &scene(effects.clone(), false), &view, 4);
        let mut inside = 0;
        for (i, pixel) in pixels().enumerate() {
            let (o, d) = ray(&camera_record(&view, SIZE), pixel);
            let [t1, t2] = interval(&volume, 0.0, o, d);
            let gradient = volume.gradient.as_dvec3();
            let b = f64::from(volume.density) + gradient.dot(o - volume.corners[0].as_dvec3());
            let depth =
                if t1 < t2 { 0.5 * gradient.dot(d) * (t2 * t2 - t1 * t1) + b * (t2 - t1) } else { 0.0 };
            let left = (-depth).exp();
            inside += usize::from(depth > 0.1);
            let behind = if wall(o, d).is_some() { WALL.as_dvec3() } else { DVec3::ZERO };
            let right = (1.0 - left) * volume.radiance.as_dvec3() + left * behind;
            let error = (shown.transparent[i] - right).abs().max_element();
            assert!(error < 2e-5, "{pixel:?}: {} for {right}", shown.transparent[i]);
        }
        assert!(inside > 300, "{inside}");
    }
}

/// Whether a ray meets a capsule: a cylinder's quadratic, and those of two spheres.
fn meets_capsule(o: DVec3, d: DVec3, [a, b]: [DVec3; 2], radius: f64) -> bool {
    let sphere = |c: DVec3| {
        let h = d.dot(c - o);
        h > 0.0 && (c - o).length_squared() - h * h < radius * radius
    };
    let axis = (b - a).normalize();
    let (across, from) = (d - axis * d.dot(axis), (o - a) - axis * (o - a).dot(axis));
    let (qa, qb, qc) = (across.dot(across), across.dot(from), from.dot(from) - radius * radius);
    let root = qb * qb - qa * qc;
    let on_side = root > 0.0 && {
        let along = |t: f64| (o + t * d - a).dot(axis);
        [(-qb - root.sqrt()) / qa, (-qb + root.sqrt()) / qa]
            .iter()
            .any(|&t| t > 0.0 && (0.0..(b - a).length()).contains(&along(t)))
    };
    on_side || sphere(a) || sphere(b)
}

#[test]
fn a_beam_has_the_outline_of_a_capsule() {
    let device = TestDevice::open();
    let ends = [Vec3::new(-1.0, -0.5, 0.8), Vec3::new(0.9, 0.6, 2.2)];
    let effects = Effects { beams: vec![beam(ends, 0.3, look(1e4, 1e4, 1e4, 0.0))], ..Effects::default() };
    let shown = render(&device, TraceBackend::Compute, &scene(effects, false), &camera(), 4);
    let (mut inside, mut wrong) = (0, 0);
    for (i, pixel) in pixels().enumerate() {
        let (o, d) = ray(&camera_record(&camera(), SIZE), pixel);
        let meets = meets_capsule(o, d, ends.map(|end| end.as_dvec3()), 0.3);
        inside += usize::from(meets);
        wrong += usize::from((shown.transparent[i].x > 0.501) != meets);
    }
    assert!(inside > 100, "{inside}");
    // At its rim the beam fades out: there it is too thin to be told from nothing.
    assert!(wrong <= 2, "{wrong} of {inside} pixels");
}

/// Where effects emit as much as they hide, nothing is seen of them, however they are blended.
#[test]
fn energy_is_kept_in_a_furnace() {
    let device = TestDevice::open();
    let mut effects = mixture();
    let grey = |look: &mut Look| look.radiance = look.opacity * WALL;
    effects.particles.iter_mut().for_each(|e| grey(&mut e.look));
    effects.beams.iter_mut().for_each(|e| grey(&mut e.look));
    effects.sprites.iter_mut().for_each(|e| grey(&mut e.look));
    effects.fog.iter_mut().for_each(|e| e.radiance = WALL);
    for layers in [1, 4] {
        let shown = render(&device, TraceBackend::Compute, &scene(effects.clone(), false), &camera(), layers);
        for (i, pixel) in pixels().enumerate() {
            let (o, d) = ray(&camera_record(&camera(), SIZE), pixel);
            if wall(o, d).is_some() {
                let error = (shown.transparent[i] - WALL.as_dvec3()).abs().max_element();
                assert!(error < 1e-5, "{layers} layers, {pixel:?}: {}", shown.transparent[i]);
            }
        }
    }
}

#[test]
fn a_moving_effect_has_its_own_motion() {
    let device = TestDevice::open();
    let velocity = Vec3::new(1.5, -0.5, 0.8);
    let drift = Drift { velocity, ..Drift::default() };
    let moving = Particle { drift, ..particle(-0.2, 0.1, 1.0, 0.7, look(0.0, 0.0, 0.0, 1.0)) };
    // It has started again between the two frames.
    let again = Particle { drift: Drift { period: 0.1, phase: 0.09, ..drift }, ..moving };
    for particle in [moving, again] {
        let effects = Effects { particles: vec![particle], time: 0.02, time_prev: 0.0, ..Effects::default() };
        let shown = render(&device, TraceBackend::Compute, &scene(effects, false), &camera(), 4);
        let record = camera_record(&camera(), SIZE);
        let center = (particle.position + particle.drift.at(0.02)).as_dvec3();
        let mut covered = 0;
        for (i, pixel) in pixels().enumerate() {
            let [x, y, luminance, opacity] = shown.motion[i].map(f64::from);
            assert!(luminance == 0.0 && (0.0..=1.0).contains(&opacity));
            if opacity == 0.0 {
                assert!(x == 0.0 && y == 0.0);
                continue;
            }
            covered += 1;
            let (o, d) = ray(&record, pixel);
            let now = o + (center - o).dot(d) * d;
            let before = now - 0.02 * velocity.as_dvec3();
            let right = oracle::project(&record, before) - oracle::project(&record, now);
            assert!((DVec2::new(x, y) - right.truncate()).length() < 1e-5, "{pixel:?}: {x} {y} for {right}");
        }
        assert!(covered > 40, "{covered}");
    }
}

/// In a plane mirror light and smoke, which are behind the camera, have the motion of their images; so it is that of effects that are where the
/// images are, without the mirror. What covers the mirror keeps its own.
#[test]
fn what_a_mirror_shows_moves_as_its_image() {
    let device = TestDevice::open();
    let velocity = Vec3::new(0.5, 0.2, 0.3);
    let moving = |sign: f32| {
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, sign * z);
        let drift = Drift { velocity: at(velocity.x, velocity.y, velocity.z), ..Drift::default() };
        Effects {
            particles: vec![Particle {
                position: at(-1.8, 0.3, 6.5),
                radius: 1.8,
                look: look(0.5, 0.5, 0.5, 1.0),
                drift,
            }],
            beams: vec![Beam {
                ends: [at(0.8, -1.6, 6.0), at(3.2, 2.0, 7.0)],
                radius: 0.6,
                look: look(2.0, 1.0, 0.5, 0.0),
                drift,
            }],
            time: 0.5,
            time_prev: 0.4,
            ..Effects::default()
        }
    };
    let mut image = Scene { effects: moving(-1.0), ..Scene::default() };
    // Behind the camera.
    let corners = [(-1.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 60.0));
    polygon(&mut image, &corners, Affine3A::IDENTITY, Material::lambertian("triangle", Vec3::ONE));
    let mut covered = moving(1.0);
    covered.particles.push(particle(0.4, 0.0, 1.0, 0.8, look(0.0, 0.0, 0.0, 1.0)));
    for backend in TraceBackend::available(&device) {
        let mirror = render(&device, backend, &scene(moving(1.0), true), &camera(), 4);
        let right = render(&device, backend, &image, &camera(), 4);
        let covered = render(&device, backend, &scene(covered.clone(), true), &camera(), 4);
        let (mut seen, mut kept) = (0, 0);
        for (i, pixel) in pixels().enumerate() {
            let (origin, direction) = ray(&camera_record(&camera(), SIZE), pixel);
            if wall(origin, direction).is_none() {
                continue;
            }
            let ([x, y, z, w], expected) = (mirror.motion[i], right.motion[i]);
            let error = (x - expected[0]).abs().max((y - expected[1]).abs());
            // Rounding decides whether a ray meets the very rim.
            let is_rim = z.max(expected[2]) < 1e-4;
            assert!(error < 2e-5 || is_rim, "{backend}, {pixel:?}: {x} {y} for {expected:?}");
            assert!((z - expected[2]).abs() < 2e-3 && (w - expected[3]).abs() < 2e-3, "{pixel:?}: {z} {w}");
            seen += usize::from(expected[2] > 0.01 && expected[0] != 0.0);
            // The front particle: opacity (1 - d^2 / r^2)^2.
            let d = (DVec3::new(0.4, 0.0, 1.0) - origin).cross(direction).length();
            if (1.0 - (d / 0.8).powi(2)).max(0.0).powi(2) > 0.51 {
                assert_eq!(covered.motion[i][..2], [0.0, 0.0], "{backend}, {pixel:?}");
                kept += usize::from(expected[2] > 0.01);
            }
        }
        println!("{backend}: {seen} pixels see effects in the mirror, {kept} of them are covered");
        assert!(seen > 80 && kept > 10, "{backend}: {seen}, {kept}");
    }
}

/// 1,000 sprites that overlap: the error of each number of layers against all of them sorted.
#[test]
fn more_layers_err_less() {
    let device = TestDevice::open();
    let mut effects = pt_scene::builtin("sprites").unwrap().effects;
    effects.sprites.iter_mut().for_each(|sprite| sprite.texture = None);
    // Before the wall.
    effects.sprites.iter_mut().for_each(|sprite| sprite.position.z += 1.2);
    let right: Vec<DVec3> = pixels()
        .map(|pixel| {
            let (seen, behind) = expected(&effects, &camera(), pixel);
            seen.over(behind)
        })
        .collect();
    let scene = scene(effects, false);
    let errors = [1, 2, 4, 8, 16].map(|layers| {
        let shown = render(&device, TraceBackend::Compute, &scene, &camera(), layers);
        let squares: f64 =
            shown.transparent.iter().zip(&right).map(|(a, b)| (*a - *b).length_squared() / 3.0).sum();
        let mean: f64 = right.iter().map(|c| c.element_sum() / 3.0).sum::<f64>() / right.len() as f64;
        let error = (squares / right.len() as f64).sqrt() / mean;
        println!("{layers:2} layers: relative RMS error {error:.4}, {:.1} ms", shown.milliseconds);
        error
    });
    // The README has the figures. The order in which the tree's leaves come changes what is merged, by a few per cent.
    for (error, most) in errors.iter().zip([0.17, 0.065, 0.013, 0.001, 5e-5]) {
        assert!(*error < most, "{errors:?}");
    }
}

#[test]
fn a_hundred_thousand_particles() {
    let device = TestDevice::open();
    let fraction = |i: u32, ratio: f64| ((f64::from(i) * ratio).fract() * 2.0 - 1.0) as f32;
    let particles = (0..100_000).map(|i| {
        let [x, y, z] = [0.754_877_666, 0.569_840_291, 0.819_172_513].map(|ratio| fraction(i, ratio));
        particle(3.0 * x, 1.5 * y, 1.5 + z, 0.02, look(0.3, 0.2, 0.1, 0.01))
    });
    let effects = Effects { particles: particles.collect(), ..Effects::default() };
    let start = std::time::Instant::now();
    let (records, nodes) = pt_scene::gpu::effect_tree(pt_scene::gpu::effect_records(&effects));
    println!("tree: {:.1} ms, {} nodes", 1e3 * start.elapsed().as_secs_f64(), nodes.len());
    assert_eq!(records.len(), 100_000);
    let shown = render(&device, TraceBackend::Compute, &scene(effects.clone(), false), &camera(), 4);
    for (i, pixel) in pixels().enumerate().step_by(7) {
        let (seen, behind) = expected(&effects, &camera(), pixel);
        let error = (shown.transparent[i] - seen.over(behind)).abs().max_element();
        // All particles look the same, so that their order has little effect.
        assert!(error < 2e-3, "{pixel:?}: {} for {}", shown.transparent[i], seen.over(behind));
    }
}
