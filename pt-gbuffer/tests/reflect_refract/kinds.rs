//! Kinds of materials that have a behaviour of their own in the G-buffer: the motion of a chrome model, the view of a camera, waves, screens.

use super::rig::{Rig, SIZE, follow, near, parallel_rays, rectangle, sheet};
use glam::{Affine3A, DVec2, DVec3, Vec2, Vec3};
use pt_core::channels::field_width;
use pt_core::pack::unpack_unit_vector;
use pt_core::split::split_to_flat;
use pt_core::trace::TraceBackend;
use pt_gbuffer::oracle::{self, dielectric};
use pt_scene::gpu::camera_record;
use pt_scene::{Camera, Environment, Material, MaterialKind, Scene, Shows, Waves};
use pt_shaders::channels;
use pt_shaders::records::FLAG_REFLECTION;

fn of(kind: MaterialKind) -> Material {
    Material::diffuse(kind.name(), Vec3::splat(0.6)).with_kind(kind)
}

/// A mirror that moves under a sky.
#[test]
fn a_chrome_model_has_its_own_motion_and_chrome_that_of_the_mirror_image() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 5.0);
    let motions = |kind, passes| {
        let mut scene = sheet(of(kind), 20.0);
        scene.environment = Environment::constant(Vec3::ONE);
        let wall =
            Affine3A::from_translation(Vec3::Z * 9.0) * Affine3A::from_rotation_y(std::f32::consts::PI);
        rectangle(&mut scene, Vec2::splat(50.0), Material::lamp("wall", Vec3::ONE), wall);
        scene.instances[0].world_from_object_prev =
            Affine3A::from_translation(Vec3::new(0.05, 0.02, 0.0)) * scene.instances[0].world_from_object;
        let frames = rig.render(&scene, [&camera, &camera], &follow(passes), 1);
        let texels = frames.texels(channels::MOTION);
        texels.chunks(4).map(|m| DVec2::new(m[0].into(), m[1].into())).collect::<Vec<_>>()
    };
    let surface = motions(MaterialKind::Chrome, 0);
    assert!(surface.iter().all(|motion| motion.length() > 0.01), "a motion of zero tests nothing");
    let own = motions(MaterialKind::ChromeModel, 1);
    assert!(own == surface, "{} for {}", own[0], surface[0]);
    let image = motions(MaterialKind::Chrome, 1);
    assert!(image.iter().zip(&surface).all(|(a, b)| a.distance(*b) > 0.005));
}

/// A wall that fills the picture and shows the view of a camera elsewhere, which sees a lamp in one corner.
#[test]
fn a_surface_shows_what_another_camera_sees() {
    let mut scene = Scene::default();
    let half = Vec2::new(0.5 * SIZE[0] as f32 / SIZE[1] as f32, 0.5);
    rectangle(&mut scene, half, of(MaterialKind::Camera), Affine3A::IDENTITY);
    scene.meshes[0].uv0 = vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];
    let light = DVec3::new(1.0, 2.0, 3.0);
    // 4 m in front of the other camera, from the middle of its picture to the right and up.
    let (at, side) = (Vec3::new(100.0, 0.0, 0.0), Vec2::new(1.5, 0.8));
    let place = Affine3A::from_translation(at + Vec3::new(side.x, side.y, -4.0));
    rectangle(&mut scene, side, Material::lamp("lamp", light.as_vec3()), place);
    let other = Camera::look_at("other", at, at - Vec3::Z, 0.9);
    let record = camera_record(&other, [16, 9]);
    scene.cameras = vec![Camera::look_at("unused", Vec3::Y, Vec3::ZERO, 1.0), other];
    scene.materials[0].shows = Shows::Camera(1);
    scene.validate().unwrap();
    let width = field_width(SIZE[0]);
    for backend in TraceBackend::CONCRETE {
        let Some(rig) = Rig::new(backend) else { continue };
        let camera = parallel_rays(Vec3::Z);
        let frames = rig.render(&scene, [&camera, &camera], &follow(1), 1);
        let (mut lit, mut dark) = (0, 0);
        for (i, radiance) in (0..).zip(&frames.radiance) {
            let flat = split_to_flat([i % (2 * width), i / (2 * width)], width);
            let uv = (DVec2::from(flat.map(f64::from)) + 0.5) / DVec2::from(SIZE.map(f64::from));
            let (_, direction) = oracle::camera_ray(&record, uv);
            let hit = direction * (4.0 / -direction.z);
            let inside = (side.as_dvec2() - (hit.truncate() - side.as_dvec2()).abs()).min_element();
            if inside.abs() > 1e-3 {
                near(*radiance, if inside > 0.0 { light } else { DVec3::ZERO }, 1e-4);
                *(if inside > 0.0 { &mut lit } else { &mut dark }) += 1;
            }
        }
        assert!(lit > 50 && dark > 50, "{backend}: {lit} pixels see the lamp, {dark} do not");
        // The back of the wall shows nothing.
        let behind = Camera::look_at("behind", -Vec3::Z, Vec3::ZERO, 1.0);
        let frames = rig.render(&scene, [&behind, &behind], &follow(1), 1);
        assert!(frames.radiance.iter().all(|radiance| *radiance == DVec3::ZERO), "{backend}");
    }
}

/// Normals of the G-buffer against the host's waves, on surfaces that lie, stand and lean.
#[test]
fn waves_bend_the_normals_of_water_and_run() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let waves = Waves { slope: 0.3, length: 0.4 };
    let normals = |angle: f32, waves: Waves, time: f64| {
        let mut scene = Scene::default();
        let place = Affine3A::from_rotation_x(angle.to_radians());
        rectangle(
            &mut scene,
            Vec2::splat(50.0),
            Material { waves: Some(waves), ..of(MaterialKind::Water) },
            place,
        );
        scene.set_time(time, time);
        let eye = place.transform_vector3(Vec3::new(0.0, 0.3, 2.0));
        let camera = Camera::look_at("above", eye, Vec3::ZERO, 0.6);
        let frames = rig.render(&scene, [&camera, &camera], &follow(0), 1);
        let positions = frames.texels(channels::SHADING_POSITION);
        let packed = frames.images.current(channels::NORMAL).read_u32().unwrap();
        let normal = place.transform_vector3(Vec3::Z).as_dvec3();
        let pairs = positions.chunks(4).zip(packed).map(move |(p, packed)| {
            let position = DVec3::from_array(std::array::from_fn(|k| f64::from(p[k])));
            (unpack_unit_vector(packed).as_dvec3(), waves.bend(normal, position, time), normal)
        });
        pairs.collect::<Vec<_>>()
    };
    for angle in [-90.0, 0.0, -40.0] {
        for time in [0.0, 7.3] {
            let mut tilt = 0.0f64;
            for (normal, expected, flat) in normals(angle, waves, time) {
                assert!(normal.distance(expected) < 2e-3, "{angle} {time}: {normal} for {expected}");
                tilt = tilt.max(expected.distance(flat));
            }
            assert!(tilt > 0.1, "{angle}: flat water tests nothing");
        }
        // At another time they are elsewhere.
        let [now, later] = [0.0, 0.1].map(|time| normals(angle, waves, time));
        assert!(now.iter().zip(&later).any(|(a, b)| a.0.distance(b.0) > 0.05), "{angle}");
    }
    for (normal, _, flat) in normals(-90.0, Waves { slope: 0.0, ..waves }, 1.0) {
        assert!(normal.distance(flat) < 1e-4, "{normal}");
    }
}

/// Its clear coat mirrors, over the light that it emits.
#[test]
fn a_screen_mirrors_as_glass_does_and_emits() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    for angle in [0.0f32, 50.0, 70.0] {
        let mut scene = sheet(of(MaterialKind::Screen), angle);
        scene.environment = Environment::constant(Vec3::new(1.0, 2.0, 3.0));
        let frames = rig.render(&scene, [&camera, &camera], &follow(1), 1);
        let reflectance = dielectric::fresnel(f64::from(angle).to_radians(), 1.5);
        assert!(frames.flags().iter().all(|&flags| flags == FLAG_REFLECTION));
        for radiance in &frames.radiance {
            near(*radiance, 0.6 + reflectance * DVec3::new(1.0, 2.0, 3.0), 3e-3);
        }
    }
}
