//! One bounce, ray by ray, against the oracle: the channels say where each ray went.

use crate::common::{self, furnace, params};
use glam::{Affine3A, DVec3, Quat, Vec3};
use pt_core::pack::unpack_unit_vector;
use pt_core::trace::{NativeScene, TraceBackend};
use pt_indirect::oracle::{ShLight, vertex_radiance};
use pt_scene::gpu::{mesh_geometry, placements};
use pt_scene::{Camera, Light, Material, Scene};
use pt_shaders::channels::{COLOR_LF_COCG, COLOR_LF_SH, NORMAL, SHADING_POSITION};
use pt_shaders::records::{NONE, Ray, SKY_DISTANCE};
use pt_tests::Frames;

const LIGHT: (Vec3, Vec3) = (Vec3::new(0.5, 0.6, 0.3), Vec3::new(2.0, 1.5, 1.0));

/// A box with a block in it and a point light.
fn lit_box() -> (Scene, Camera) {
    let (mut scene, camera) = furnace(Vec3::ZERO, Vec3::new(0.6, 0.5, 0.3));
    let place = Affine3A::from_scale_rotation_translation(
        Vec3::new(0.3, 0.5, 0.3),
        Quat::from_rotation_y(0.5),
        Vec3::new(-0.2, -0.5, -0.3),
    );
    common::cube(&mut scene, place, false, Material::lambertian("block", Vec3::new(0.2, 0.8, 0.4)));
    scene.lights.push(Light::point("point", LIGHT.0, LIGHT.1));
    scene.validate().unwrap();
    (scene, camera)
}

/// Irradiance that the bounce ray of a texel brings, and the direction of the ray; `None`: it brings nothing.
fn bounce(sh: &[f32], cocg: &[f32], normals: &[u32], i: usize) -> Option<(DVec3, DVec3)> {
    let luma: [f64; 4] = std::array::from_fn(|k| f64::from(sh[4 * i + k]));
    let luma1 = DVec3::new(luma[0], luma[1], luma[2]);
    let chroma = [cocg[2 * i], cocg[2 * i + 1]].map(f64::from);
    let light = ShLight { luma1, luma0: luma[3], chroma };
    (luma[3] != 0.0).then(|| (light.irradiance(unpack_unit_vector(normals[i]).as_dvec3()), luma1.normalize()))
}

/// Knob `firefly`: one bounce off a Lambertian surface is limited by the knob times the square root of the first ray's cosine. The light of a second
/// bounce, which is what it adds to the first, is limited by no more than that.
#[test]
fn fireflies_are_limited_by_what_their_paths_scattered() {
    let (scene, camera) = lit_box();
    let render = |bounces: &str, firefly: f64| {
        let sets = [format!("indirect.bounces={bounces}"), format!("indirect.firefly={firefly}")];
        let params = params(&sets.each_ref().map(String::as_str));
        let mut frames =
            Frames::with_params(scene.clone(), &camera, TraceBackend::Compute, [32, 24], 9, false, params);
        frames.render(0.0);
        let (sh, cocg, normals) =
            (frames.floats(COLOR_LF_SH), frames.floats(COLOR_LF_COCG), frames.integers(NORMAL));
        frames.finish();
        let light = |i: usize| {
            let (irradiance, direction) = bounce(&sh, &cocg, &normals, i)?;
            let cosine = unpack_unit_vector(normals[i]).as_dvec3().dot(direction);
            Some((irradiance / std::f64::consts::PI, cosine))
        };
        (0..normals.len()).map(light).collect::<Vec<_>>()
    };
    let mean = |radiance: DVec3| radiance.element_sum() / 3.0;
    let limit = 0.05;
    let [one, two] = ["1", "2"].map(|bounces| [0.0, limit].map(|firefly| render(bounces, firefly)));
    let (mut limited, mut free, mut second) = (0, 0, 0);
    for i in 0..one[0].len() {
        let Some((all, cosine)) = one[0][i] else { continue };
        let most = limit * cosine.max(0.0).sqrt();
        let factor = (most / mean(all)).min(1.0);
        *if factor < 1.0 { &mut limited } else { &mut free } += 1;
        let (found, _) = one[1][i].unwrap();
        // 13 bits of narrowness, 32 bits of direction.
        assert!(
            (found - factor * all).length() < 0.01 * all.length(),
            "{i}: {found} of {all}, factor {factor}"
        );
        let [more, more_limited] = [0, 1].map(|k| mean(two[k][i].unwrap().0 - one[k][i].unwrap().0));
        assert!(more_limited <= 1.01 * most + 1e-5, "{i}: second bounce {more_limited}, at most {most}");
        second += u32::from(more > most);
    }
    println!("{limited} limited, {free} not, {second} second bounces were above the limit");
    assert!(limited > 50 && free > 50 && second > 20, "{limited}, {free}, {second}");
}

/// The only random number of a bounce is its direction, which the spherical harmonics of a single sample keep.
#[test]
fn a_bounce_is_that_of_the_oracle() {
    let (scene, camera) = lit_box();
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
    for i in 0..normals.len() {
        let Some((found, direction)) = bounce(&sh, &cocg, &normals, i) else { continue };
        let position = DVec3::from_array(std::array::from_fn(|k| f64::from(positions[4 * i + k])));
        let hit = native.closest(&ray(position, direction, SKY_DISTANCE), u32::MAX, None);
        assert_ne!(hit.instance, NONE, "the box is closed");
        let mesh = &scene.meshes[scene.instances[hit.instance as usize].mesh as usize];
        let [a, b, c] = mesh.triangle(hit.triangle as usize);
        let normal = (b - a).cross(c - a).normalize().as_dvec3();
        let normal = if normal.dot(direction) < 0.0 { normal } else { -normal };
        let albedo = scene.materials[mesh.triangle_materials[hit.triangle as usize] as usize].base_color;
        let light = (LIGHT.0.as_dvec3(), LIGHT.1.as_dvec3());
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
