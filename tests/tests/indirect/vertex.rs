//! One bounce, ray by ray, against the oracle: the channels say where each ray went.

use crate::common::{self, furnace, params};
use glam::{Affine3A, DVec3, Quat, Vec3};
use pt_core::pack::unpack_unit_vector;
use pt_core::trace::{NativeScene, TraceBackend};
use pt_indirect::oracle::{ShLight, vertex_radiance};
use pt_scene::gpu::{mesh_geometry, placements};
use pt_scene::{Light, Material};
use pt_shaders::channels::{COLOR_LF_COCG, COLOR_LF_SH, NORMAL, SHADING_POSITION};
use pt_shaders::records::{NONE, Ray, SKY_DISTANCE};
use pt_tests::Frames;

/// A box with a block in it and a point light: the only random number of a bounce is its direction, which the spherical harmonics of a single sample
/// keep.
#[test]
fn a_bounce_is_that_of_the_oracle() {
    let (mut scene, camera) = furnace(Vec3::ZERO, Vec3::new(0.6, 0.5, 0.3));
    let place = Affine3A::from_scale_rotation_translation(
        Vec3::new(0.3, 0.5, 0.3),
        Quat::from_rotation_y(0.5),
        Vec3::new(-0.2, -0.5, -0.3),
    );
    common::cube(&mut scene, place, false, Material::lambertian("block", Vec3::new(0.2, 0.8, 0.4)));
    let light = (Vec3::new(0.5, 0.6, 0.3), Vec3::new(2.0, 1.5, 1.0));
    scene.lights.push(Light::point("point", light.0, light.1));
    scene.validate().unwrap();
    let native = NativeScene::new(&mesh_geometry(&scene), &placements(&scene), Default::default()).unwrap();
    let ray = |origin: DVec3, direction: DVec3, t_max: f32| Ray {
        origin: origin.as_vec3(),
        t_min: 1e-4,
        direction: direction.as_vec3(),
        t_max,
    };
    let arrives = |from: DVec3, to: DVec3| {
        let way = to - from;
        !native.occluded(&ray(from, way.normalize(), way.length() as f32 - 1e-4), u32::MAX, None)
    };

    let mut frames =
        Frames::with_params(scene.clone(), &camera, TraceBackend::Compute, [32, 24], 9, false, params(&[]));
    frames.render(0.0);
    let (sh, cocg) = (frames.floats(COLOR_LF_SH), frames.floats(COLOR_LF_COCG));
    let (positions, normals) = (frames.floats(SHADING_POSITION), frames.integers(NORMAL));
    frames.finish();

    let (mut compared, mut differ) = (0, 0);
    for (i, luma) in sh.chunks_exact(4).enumerate() {
        let luma: [f64; 4] = std::array::from_fn(|k| f64::from(luma[k]));
        if luma[3] == 0.0 {
            continue;
        }
        let found = ShLight {
            luma1: DVec3::new(luma[0], luma[1], luma[2]),
            luma0: luma[3],
            chroma: [cocg[2 * i], cocg[2 * i + 1]].map(f64::from),
        };
        let found = found.irradiance(unpack_unit_vector(normals[i]).as_dvec3());
        let direction = DVec3::new(luma[0], luma[1], luma[2]).normalize();
        let position = DVec3::from_array(std::array::from_fn(|k| f64::from(positions[4 * i + k])));
        let hit = native.closest(&ray(position, direction, SKY_DISTANCE), u32::MAX, None);
        assert_ne!(hit.instance, NONE, "the box is closed");
        let mesh = &scene.meshes[scene.instances[hit.instance as usize].mesh as usize];
        let [a, b, c] = mesh.triangle(hit.triangle as usize);
        let normal = (b - a).cross(c - a).normalize().as_dvec3();
        let normal = if normal.dot(direction) < 0.0 { normal } else { -normal };
        let albedo = scene.materials[mesh.triangle_materials[hit.triangle as usize] as usize].base_color;
        let light = (light.0.as_dvec3(), light.1.as_dvec3());
        let met = position + direction * f64::from(hit.t);
        let radiance = vertex_radiance(met, normal, albedo.truncate().as_dvec3(), light, arrives);
        // A cosine-weighted ray stands for an irradiance of pi times its radiance.
        let expected = std::f64::consts::PI * radiance;
        compared += 1;
        differ += u32::from((found - expected).abs().max_element() > 1e-2 * expected.max_element() + 1e-6);
    }
    println!("{differ} of {compared} bounces differ");
    // A ray may pass an edge on the other side, because the direction of the first ray is stored in 32 bits.
    assert!(compared > 300 && differ * 500 <= compared, "{differ} of {compared} bounces differ");
}
