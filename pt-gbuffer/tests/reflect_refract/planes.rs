//! The lobes of glass in planes of their own: each has its light once, and together they have all of it.

use super::rig::{Frames, IOR, Rig, SIZE, follow, glass, near, parallel_rays, rectangle, sheet};
use glam::{Affine3A, DVec3, Vec2, Vec3};
use pt_core::channels::field_width;
use pt_core::trace::TraceBackend;
use pt_gbuffer::oracle::dielectric;
use pt_gbuffer::{Decomposition, GbufferParams};
use pt_scene::{Camera, Environment, Material, Scene};
use pt_shaders::channels;
use pt_shaders::records::{FLAG_PRIMARY, FLAG_REFLECTION, FLAG_REFRACTION, SKY_DISTANCE};

fn planes(reflect_refract: u32) -> GbufferParams {
    GbufferParams { decomposition: Decomposition::Planes, ..follow(reflect_refract) }
}

/// Glass with all three lobes, that shines besides.
fn shining_milk() -> Material {
    Material {
        transmission: 0.6,
        base_color: Vec3::new(0.9, 0.5, 0.3).extend(1.0),
        emissive: Vec3::new(0.1, 0.2, 0.3),
        ..glass(false)
    }
}

fn render(rig: &Rig, scene: &Scene, camera: &Camera, params: &GbufferParams, count: u32) -> [Frames; 3] {
    [0, 1, 2].map(|plane| rig.render_plane(scene, [camera, camera], params, count, plane))
}

/// Reflection and emission, transmission, and the light that is left for the base, of light from everywhere; exact in every pixel and frame.
fn lobes_of_a_sheet(backend: TraceBackend) {
    let Some(rig) = Rig::new(backend) else { return };
    let camera = parallel_rays(Vec3::Z * 60.0);
    let milk = shining_milk();
    let tint = milk.base_color.truncate().as_dvec3();
    for angle in [0.0, 60.0] {
        let mut scene = sheet(milk.clone(), angle);
        scene.environment = Environment::constant(Vec3::ONE);
        let reflectance = dielectric::fresnel(f64::from(angle).to_radians(), IOR);
        let below = 1.0 - reflectance;
        // The first one that may part is the last one that is followed.
        for passes in [1, 3] {
            let [first, second, third] = render(&rig, &scene, &camera, &planes(passes), 2);
            for i in 0..first.radiance.len() {
                near(first.radiance[i], reflectance + milk.emissive.as_dvec3(), 1e-3);
                near(second.radiance[i], 0.6 * below * tint, 1e-3);
                near(third.radiance[i], DVec3::ZERO, 0.0);
                // The base is lit with the sheet's colour.
                near(third.shaded[i], DVec3::splat(0.4 * below), 1e-3);
            }
            for (frames, flag) in
                [(&first, FLAG_REFLECTION), (&second, FLAG_REFRACTION), (&third, FLAG_REFRACTION)]
            {
                assert!(frames.flags().iter().all(|&f| f == flag), "{passes} passes");
            }
        }
    }
}

#[test]
fn each_plane_has_a_lobe_of_a_sheet() {
    for backend in TraceBackend::CONCRETE {
        lobes_of_a_sheet(backend);
    }
}

/// A mirror that shows the sheet: it is passed in every plane, with its reflectance, and its own emission is in plane 0 alone. What the sheet
/// reflects is the mirror again. Beside the mirror a lamp, and the sky.
#[test]
fn planes_part_at_the_first_glass() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let (light, shine) = (DVec3::new(4.0, 2.0, 1.0), Vec3::new(0.01, 0.03, 0.02));
    let mut scene = Scene { environment: Environment::constant(Vec3::splat(0.5)), ..Scene::default() };
    let base = Vec3::new(0.9, 0.6, 0.3);
    let mirror = Material { emissive: shine, ..Material::metal("mirror", base, 0.0) };
    let place = Affine3A::from_translation(Vec3::X * -2.0) * Affine3A::from_rotation_y(-45_f32.to_radians());
    rectangle(&mut scene, Vec2::new(2.0, 9.0), mirror, place);
    // Its rays leave the mirror along -X.
    let milk = Material { double_sided: true, ..shining_milk() };
    let place =
        Affine3A::from_translation(Vec3::X * -12.0) * Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2);
    rectangle(&mut scene, Vec2::splat(9.0), milk.clone(), place);
    rectangle(
        &mut scene,
        Vec2::new(1.0, 9.0),
        Material::lamp("lamp", light.as_vec3()),
        Affine3A::from_translation(Vec3::X * 2.0),
    );
    let camera = Camera::look_at("parallel", Vec3::Z * 60.0, Vec3::ZERO, 1.0);
    let camera = Camera { projection: pt_scene::Projection::Orthographic { ymag: 3.0 }, ..camera };

    let found = render(&rig, &scene, &camera, &planes(3), 1);
    let metal = dielectric::metal(base.as_dvec3(), 45_f64.to_radians());
    let reflectance = dielectric::fresnel(0.0, IOR);
    let (sky, below) = (DVec3::splat(0.5), 1.0 - reflectance);
    let on_mirror = [
        shine.as_dvec3()
            + metal * (milk.emissive.as_dvec3() + reflectance * (shine.as_dvec3() + metal * sky)),
        metal * 0.6 * below * milk.base_color.truncate().as_dvec3() * sky,
        DVec3::ZERO,
    ];
    let visible = found.each_ref().map(|f| f.images.current(channels::VISIBILITY).read_u32().unwrap());
    let (depths, throughputs) = (
        found.each_ref().map(|f| f.texels(channels::VIEW_DEPTH)),
        found.each_ref().map(|f| f.texels(channels::THROUGHPUT)),
    );
    let mut seen = [0; 3];
    for i in 0..found[0].radiance.len() {
        let flags = found.each_ref().map(|f| f.flags()[i]);
        let what = if found[0].radiance[i].distance(light) < 1e-3 {
            0
        } else if found[0].radiance[i].distance(sky) < 1e-3 {
            1
        } else {
            2
        };
        seen[what] += 1;
        for plane in [1, 2] {
            if what < 2 {
                // Without glass the pixel is in plane 0 alone.
                near(found[plane].radiance[i], DVec3::ZERO, 0.0);
                assert_eq!(visible[plane][2 * i], u32::MAX);
                assert_eq!(flags[plane], FLAG_PRIMARY);
                assert_eq!(depths[plane][i], SKY_DISTANCE);
                assert_eq!(&throughputs[plane][4 * i..4 * i + 3], [0.0; 3]);
            }
        }
        if what < 2 {
            continue;
        }
        (0..3).for_each(|plane| near(found[plane].radiance[i], on_mirror[plane], 2e-3));
        near(found[2].shaded[i], metal * 0.4 * below, 2e-3);
        assert_eq!(flags, [FLAG_REFLECTION, FLAG_REFRACTION, FLAG_REFRACTION]);
    }
    assert!(seen.iter().all(|&n| n > 50), "lamp, sky, mirror: {seen:?} of {SIZE:?}");

    // Where the last pass leads from the mirror to something it is too late to part.
    let [_, second, third] = render(&rig, &scene, &camera, &planes(1), 1);
    for frames in [&second, &third] {
        assert!(frames.radiance.iter().chain(&frames.shaded).all(|&light| light == DVec3::ZERO));
    }
}

/// Rough glass draws a microfacet in every plane, some of which lose a lobe: together the planes have the light of the replacement.
#[test]
fn planes_of_rough_glass_have_its_light() {
    let rig = Rig::new(TraceBackend::Compute).unwrap();
    let camera = parallel_rays(Vec3::Z * 60.0);
    // Without a base a microfacet may leave one lobe alone.
    for (solid, transmission) in [(false, 0.6), (true, 0.6), (false, 1.0), (true, 1.0)] {
        let thickness = f32::from(solid);
        let milk = Material { roughness: 0.7, thickness, transmission, ..shining_milk() };
        let mut scene = sheet(milk, 70.0);
        scene.environment = Environment::constant(Vec3::new(1.0, 0.6, 0.3));
        // Light of each frame, over all pixels; what is shaded counts as if it were lit from everywhere.
        let light = |params: &GbufferParams, plane: u32| {
            let frames = rig.render_plane(&scene, [&camera, &camera], params, 64, plane);
            let light_of = |(&light, &shaded): (&DVec3, &DVec3)| light + shaded;
            let texels: Vec<DVec3> = frames.radiance.iter().zip(&frames.shaded).map(light_of).collect();
            // The replacement reflects in one field and refracts in the other: one of each together is a sample of all light.
            let pair = |row: &[DVec3]| -> Vec<DVec3> {
                let (even, odd) = row.split_at(row.len() / 2);
                even.iter().zip(odd).map(|(&a, &b)| 0.5 * (a + b)).collect()
            };
            let per_pixel: Vec<DVec3> =
                texels.chunks(2 * field_width(SIZE[0]) as usize).flat_map(pair).collect();
            let n = per_pixel.len() as f64;
            let mean = per_pixel.iter().sum::<DVec3>() / n;
            let variance = per_pixel.iter().map(|p| (p - mean) * (p - mean)).sum::<DVec3>() / (n - 1.0);
            (mean, variance / n)
        };
        let (truth, noise) = light(&follow(1), 0);
        let parts = [0, 1, 2].map(|plane| light(&planes(1), plane));
        let sum: DVec3 = parts.iter().map(|part| part.0).sum();
        let error = parts.iter().map(|part| part.1).sum::<DVec3>() + noise;
        println!(
            "solid {solid}, transmission {transmission}: {sum:.4}, replacement {truth:.4} +- {:.4}",
            error.map(f64::sqrt)
        );
        for c in 0..3 {
            assert!((sum[c] - truth[c]).abs() < 4.0 * error[c].sqrt(), "{sum} for {truth}");
            assert!(error[c].sqrt() < 0.01 * truth[c], "too much noise to say anything");
        }
    }
}
