//! Mirrors and glass against closed forms. Nothing here needs light samples: all light is emission and environment, so that
//! the channel `transparent` is the radiance of the pixel.

mod kinds;
mod media;
mod planes;
mod rig;
mod texture_filter;
mod through;

use glam::{Affine3A, DVec2, DVec3, Vec2, Vec3};
use pt_core::channels::field_width;
use pt_core::split::flat_to_split;
use pt_core::trace::TraceBackend;
use pt_gbuffer::GbufferParams;
use pt_gbuffer::oracle::{self, dielectric};
use pt_scene::gpu::camera_record;
use pt_scene::{Camera, Environment, EnvironmentImage, Material, Scene};
use pt_shaders::channels;
use pt_shaders::records::{CameraRecord, FLAG_REFLECTION, SKY_DISTANCE, SPLIT_FLAGS};
use rig::{Frames, IOR, Rig, SIZE, follow, glass, near, parallel_rays, plate, rectangle, sheet};

/// A mirror that moves, a lamp behind the camera, a camera that moves.
fn mirror(backend: TraceBackend) {
    let Some(rig) = Rig::new(backend) else { return };
    let base = Vec3::new(0.9, 0.6, 0.3);
    let light = DVec3::new(4.0, 2.0, 1.0);
    let mut scene = Scene::default();
    let turn = Affine3A::from_rotation_y(0.2);
    rectangle(&mut scene, Vec2::splat(5.0), Material::metal("mirror", base, 0.0), turn);
    let turn_before =
        Affine3A::from_translation(Vec3::new(0.0, 0.0, -0.03)) * Affine3A::from_rotation_y(0.21);
    scene.instances[0].world_from_object_prev = turn_before;
    let lamp_place = Affine3A::from_translation(Vec3::new(1.0, 0.2, 3.0))
        * Affine3A::from_rotation_y(std::f32::consts::PI);
    rectangle(&mut scene, Vec2::new(1.2, 0.9), Material::lamp("lamp", light.as_vec3()), lamp_place);
    let camera = Camera::look_at("now", Vec3::new(0.3, 0.1, 2.0), Vec3::new(0.2, 0.0, 0.0), 0.9);
    let before = Camera::look_at("before", Vec3::new(0.25, 0.12, 2.1), Vec3::new(0.2, 0.0, 0.0), 0.9);
    let frames = rig.render(&scene, [&camera, &before], &follow(1), 1);

    let (depths, motions, flags) =
        (frames.texels(channels::VIEW_DEPTH), frames.texels(channels::MOTION), frames.flags());
    let records: [CameraRecord; 2] = [camera_record(&camera, SIZE), camera_record(&before, SIZE)];
    let plane = |place: Affine3A| {
        let (point, normal) = (place.translation, place.matrix3 * glam::Vec3A::Z);
        (Vec3::from(point).as_dvec3(), Vec3::from(normal).as_dvec3())
    };
    let image_of = |p: DVec3, (point, normal): (DVec3, DVec3)| p - 2.0 * (p - point).dot(normal) * normal;
    let (now, then) = (plane(turn), plane(turn_before));
    let (mut lit, mut dark) = (0, 0);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let [sx, sy] = flat_to_split([x, y], field_width(SIZE[0]));
            let i = (sy * 2 * field_width(SIZE[0]) + sx) as usize;
            let uv = (DVec2::new(x.into(), y.into()) + 0.5) / DVec2::new(SIZE[0].into(), SIZE[1].into());
            let (eye, d) = oracle::camera_ray(&records[0], uv);
            let hit = eye + d * ((now.0 - eye).dot(now.1) / d.dot(now.1));
            let mirrored = d - 2.0 * d.dot(now.1) * now.1;
            let found = hit + mirrored * ((3.0 - hit.z) / mirrored.z);
            let inside = DVec2::new(1.2 - (found.x - 1.0).abs(), 0.9 - (found.y - 0.2).abs()).min_element();
            if inside.abs() < 5e-3 {
                continue;
            }
            assert_eq!(flags[i], FLAG_REFLECTION);
            if inside < 0.0 {
                dark += 1;
                near(frames.radiance[i], DVec3::ZERO, 0.0);
                assert_eq!(depths[i], -SKY_DISTANCE);
                continue;
            }
            lit += 1;
            near(
                frames.radiance[i],
                light * dielectric::metal(base.as_dvec3(), (-d.dot(now.1)).acos()),
                1e-4,
            );
            let seen = oracle::project(&records[0], image_of(found, now));
            let seen_before = oracle::project(&records[1], image_of(found, then));
            assert!(
                (f64::from(depths[i]) + seen.z).abs() < 1e-3,
                "({x},{y}): depth {} for {}",
                depths[i],
                -seen.z
            );
            let motion = DVec3::from_array(std::array::from_fn(|k| f64::from(motions[4 * i + k])));
            let expected = (seen_before - seen) * DVec3::new(1.0, 1.0, -1.0);
            assert!(motion.distance(expected) < 1e-3, "({x},{y}): motion {motion} for {expected}");
            assert!(expected.truncate().length() > 5e-3, "a motion of zero tests nothing");
        }
    }
    assert!(lit > 50 && dark > 50, "{lit} pixels see the lamp, {dark} do not");
}

#[test]
fn a_mirror_shows_the_lamp_and_its_motion() {
    for backend in TraceBackend::CONCRETE {
        mirror(backend);
    }
}

#[test]
fn a_thin_sheet_reflects_in_one_field_and_lets_through_in_the_other() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    for (angle, tint) in
        [(0.0, Vec3::ONE), (30.0, Vec3::new(0.2, 0.5, 0.9)), (60.0, Vec3::ONE), (80.0, Vec3::ONE)]
    {
        let mut scene = sheet(Material { base_color: tint.extend(1.0), ..glass(false) }, angle);
        scene.environment = Environment::constant(Vec3::ONE);
        let frames = rig.render(&scene, [&camera, &camera], &follow(2), 1);
        let reflectance = dielectric::fresnel(f64::from(angle).to_radians(), IOR);
        let (reflection, transmission) = dielectric::split(reflectance, 1.0, tint.as_dvec3());
        let [even, odd] = Frames::fields(&frames.radiance);
        near(even, reflection, 1e-3);
        near(odd, transmission, 1e-3);
        // The furnace: nothing is lost.
        near(
            0.5 * (even + odd),
            reflectance + (1.0 - reflectance) * tint.as_dvec3(),
            if tint == Vec3::ONE { 1e-6 } else { 1e-3 },
        );
        assert!(frames.flags().iter().all(|&f| f == SPLIT_FLAGS));
    }
}

#[test]
fn fields_change_places_when_asked() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    let mut scene = sheet(glass(false), 70.0);
    scene.environment = Environment::constant(Vec3::ONE);
    let params = GbufferParams { alternate_fields: true, ..follow(2) };
    let frames = rig.render(&scene, [&camera, &camera], &params, 2);
    for pixel in &frames.radiance {
        near(*pixel, DVec3::ONE, 1e-6);
    }
}

/// Light comes from a patch of the sky round -Z only: what goes straight through a plate sees it, what is reflected does not.
fn patch_of_sky() -> Environment {
    let (width, height) = (36, 2);
    let lit = |x: u32| (7..=10).contains(&x);
    let texels = (0..width * height).map(|i| Vec3::splat(f32::from(u8::from(lit(i % width))))).collect();
    Environment::new(EnvironmentImage { width, height, texels })
}

/// Angle of refraction of `angle` degrees.
fn inner_angle(angle: f32) -> f64 {
    (f64::from(angle).to_radians().sin() / IOR).asin()
}

fn plate_series(backend: TraceBackend, frames: u32) {
    let Some(rig) = Rig::new(backend) else { return };
    let camera = parallel_rays(Vec3::Z * 30.0);
    let angle = 75.0;
    let reflectance = dielectric::fresnel(f64::from(angle).to_radians(), IOR);
    let through = 1.0 - reflectance;
    let mut scene = plate(glass(true), 0.2, angle);
    scene.environment = patch_of_sky();
    // Light that was reflected 0, 2, .. times inside; pass 4 is the first that lets the second of these out.
    for (passes, expected) in [
        (2, through * through),
        (3, through * through),
        (4, through * through * (1.0 + reflectance * reflectance)),
    ] {
        let result = rig.render(&scene, [&camera, &camera], &follow(passes), frames);
        let [even, odd] = Frames::fields(&result.radiance);
        near(even, DVec3::ZERO, 0.0);
        let probability = expected / through;
        let samples = f64::from(frames * SIZE[0] * SIZE[1] / 2);
        let sigma = through * (probability * (1.0 - probability) / samples).sqrt();
        near(0.5 * odd, DVec3::splat(expected), 4.0 * sigma);
        assert!(
            4.0 * sigma < 0.5 * through * through * reflectance * reflectance,
            "{sigma}: too noisy to tell the series' terms"
        );
    }
    // In a uniform environment everything that goes in comes out, whatever the number of passes.
    scene.environment = Environment::constant(Vec3::ONE);
    for passes in 1..4 {
        let result = rig.render(&scene, [&camera, &camera], &follow(passes), 2);
        let [even, odd] = Frames::fields(&result.radiance);
        near(0.5 * (even + odd), DVec3::ONE, 2e-3);
    }
}

#[test]
fn a_solid_plate_lets_through_its_series_of_inner_reflections() {
    plate_series(TraceBackend::Compute, 24);
}

#[test]
fn a_solid_plate_on_the_other_backends() {
    plate_series(TraceBackend::RayQuery, 24);
    plate_series(TraceBackend::RtPipeline, 24);
}

#[test]
fn solid_glass_absorbs_by_the_length_of_the_way_inside() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 30.0);
    let (angle, thickness) = (40.0, 0.3);
    let color = DVec3::new(0.9, 0.5, 0.2);
    let material = Material { attenuation_color: color.as_vec3(), attenuation_distance: 0.25, ..glass(true) };
    let mut scene = plate(material, thickness, angle);
    scene.environment = Environment::constant(Vec3::ONE);
    let through = 1.0 - dielectric::fresnel(f64::from(angle).to_radians(), IOR);
    let length = f64::from(thickness) / inner_angle(angle).cos();
    let transmittance = color.powf(length / 0.25);
    // One pass: its ray ignores the far side, but not the glass in front of it.
    let result = rig.render(&scene, [&camera, &camera], &follow(1), 1);
    near(Frames::fields(&result.radiance)[1], 2.0 * through * transmittance, 2e-3);
    // Two passes: what leaves at the far side has passed it once; the rest goes back through the plate.
    let result = rig.render(&scene, [&camera, &camera], &follow(2), 8);
    let expected =
        2.0 * through * (through * transmittance + (1.0 - through) * transmittance * transmittance);
    near(Frames::fields(&result.radiance)[1], expected, 1e-2);
}

#[test]
fn beyond_the_critical_angle_all_light_is_reflected() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    // Inside the plate, 50 degrees onto its far side.
    let mut scene = plate(glass(true), 20.0, 50.0);
    scene.environment = Environment::constant(Vec3::ONE);
    let camera = parallel_rays(Vec3::Z * -6.0);
    let frames = rig.render(&scene, [&camera, &camera], &follow(1), 1);
    assert!(frames.flags().iter().all(|&f| f == FLAG_REFLECTION));
    // In the glass, where the camera is, radiance is n^2 times that outside.
    for pixel in &frames.radiance {
        near(*pixel, DVec3::splat(IOR * IOR), 1e-6);
    }
}

#[test]
fn what_a_glass_does_not_transmit_is_shaded() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    let base = DVec3::new(0.8, 0.4, 0.4);
    let share = 0.3;
    let material = Material { transmission: 0.3, base_color: base.as_vec3().extend(1.0), ..glass(false) };
    let mut scene = sheet(material, 45.0);
    scene.environment = Environment::constant(Vec3::ONE);
    let result = rig.render(&scene, [&camera, &camera], &follow(3), 16);
    let reflectance = dielectric::fresnel(45.0_f64.to_radians(), IOR);
    let (reflection, transmission) = dielectric::split(reflectance, share, base);
    let [even, odd] = Frames::fields(&result.radiance);
    near(even, reflection, 1e-3);
    near(odd, transmission, 0.03);
    let [even, odd] = Frames::fields(&result.shaded);
    near(even, DVec3::ZERO, 0.0);
    near(odd, DVec3::splat(2.0 * (1.0 - reflectance) * (1.0 - share)), 0.05);
    // The shaded base is Lambertian: its highlight is what the other field reflects.
    let specular = result.texels(channels::BASE_COLOR);
    let overlay = result.texels(channels::TRANSPARENT);
    let staying = (0..overlay.len() / 4).filter(|&i| overlay[4 * i + 3] == 0.0);
    assert!(staying.map(|i| specular[4 * i + 3]).all(|s| s == 0.0));
}

/// Share of the light that a rough thin sheet reflects or lets through in one scattering: the integral over the distribution
/// of normals (Walter et al. 2007), which the kernel does not sample.
fn single_scattering(roughness: f64, theta: f64) -> f64 {
    const STEPS: u32 = 300;
    let a2 = roughness.powi(4);
    let (v_x, v_z) = theta.sin_cos();
    let root = |z: f64| (a2 + (1.0 - a2) * z * z).sqrt();
    let mut sum = 0.0;
    for i in 0..STEPS * STEPS {
        let [u, w] = [i / STEPS, i % STEPS].map(|k| (f64::from(k) + 0.5) / f64::from(STEPS));
        let h_z = (1.0 + a2 * u / (1.0 - u)).sqrt().recip();
        let h_x = (1.0 - h_z * h_z).sqrt() * (std::f64::consts::TAU * w).cos();
        let v_h = h_x * v_x + h_z * v_z;
        let l_z = 2.0 * v_h * h_z - v_z;
        if v_h <= 0.0 || l_z <= 0.0 {
            continue;
        }
        let reflectance = dielectric::fresnel(v_h.min(1.0).acos(), IOR);
        let correlated = 2.0 * v_z * l_z / (l_z * root(v_z) + v_z * root(l_z));
        let separable = 2.0 * v_z / (v_z + root(v_z)) * 2.0 * l_z / (l_z + root(l_z));
        sum += (reflectance * correlated + (1.0 - reflectance) * separable) * v_h / (v_z * h_z);
    }
    sum / f64::from(STEPS * STEPS)
}

#[test]
fn rough_glass_loses_what_single_scattering_does() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    for (roughness, angle) in [(0.6, 60.0), (0.5, 30.0)] {
        let mut scene = sheet(Material { roughness, ..glass(false) }, angle);
        scene.environment = Environment::constant(Vec3::ONE);
        let result = rig.render(&scene, [&camera, &camera], &follow(2), 16);
        let [even, odd] = Frames::fields(&result.radiance);
        let expected = single_scattering(roughness.into(), f64::from(angle).to_radians());
        near(0.5 * (even + odd), DVec3::splat(expected), 0.015);
        assert!(expected < 0.97, "{expected}: nothing lost tests nothing");
    }
    // A bent way loses a little more at its second interface.
    let mut scene = plate(Material { roughness: 0.3, ..glass(true) }, 0.2, 30.0);
    scene.environment = Environment::constant(Vec3::ONE);
    let result = rig.render(&scene, [&camera, &camera], &follow(2), 8);
    let [even, odd] = Frames::fields(&result.radiance);
    assert!((0.9..1.0).contains(&(0.5 * (even + odd).x)), "{}", 0.5 * (even + odd));
}

#[test]
fn without_passes_glass_is_a_regular_surface() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    let mut scene = sheet(glass(false), 20.0);
    scene.environment = Environment::constant(Vec3::ONE);
    let frames = rig.render(&scene, [&camera, &camera], &follow(0), 1);
    assert!(frames.flags().iter().all(|&f| f == 1));
    assert!(frames.radiance.iter().all(|&r| r == DVec3::ZERO));
}
