//! The list of shadow rays is complete: every candidate that can give light has a ray, and every ray is traced.

use crate::common::pixels::{Pixel, Rig};
use glam::{Affine3A, Vec3};
use pt_core::split::split_size;
use pt_core::test_support::TestDevice;
use pt_light_sampling::test_support::polygon;
use pt_lights::records::{LightRays, RayCounts};
use pt_lights::{Counted, DirectParams};
use pt_scene::{Environment, EnvironmentImage, Light, Material, Scene};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};
use pt_shaders::records::{AreaSampling, LightSampler};

/// One of each kind of light, none in the way of another, each of which gives light to every point of the floor whatever the sample: a sun
/// overhead, a point, a lamp at one side, and a sky that shines from above (below, so little that no sample goes there).
fn scene() -> Scene {
    let mut scene = Scene::default();
    let lamp = [(0.5, -3.0), (1.5, -3.0), (1.5, 3.0), (0.5, 3.0)].map(|(y, z)| Vec3::new(-8.0, y, z));
    polygon(&mut scene, &lamp, Affine3A::IDENTITY, Material::lamp("lamp", Vec3::splat(3.0)));
    scene.lights.push(Light::directional("sun", Vec3::new(0.1, -1.0, 0.2), Vec3::splat(2.0)));
    scene.lights.push(Light::point("point", Vec3::new(0.3, 2.0, -0.2), Vec3::splat(5.0)));
    let texels = (0..16 * 16).map(|i: u32| Vec3::splat(if i / 16 < 5 { 1.5 } else { 1e-7 })).collect();
    scene.environment = Environment::new(EnvironmentImage { width: 16, height: 16, texels });
    scene
}

/// A box without gaps over the points, below all lights: the instances from the second on.
fn cover(scene: &mut Scene) {
    let board = || Material { double_sided: true, ..Material::lambertian("cover", Vec3::ONE) };
    let corners = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let up = 1.0 * Vec3::Y;
    polygon(scene, &corners.map(|c| c + up), Affine3A::IDENTITY, board());
    for i in 0..4 {
        let (a, b) = (corners[i] - up, corners[(i + 1) % 4] - up);
        polygon(scene, &[a, b, b + 2.0 * up, a + 2.0 * up], Affine3A::IDENTITY, board());
    }
}

/// A metal that reflects nearly straight up.
fn pixel([x, y]: [u32; 2]) -> Option<Pixel> {
    let at = |k: u32| (k % 32) as f32 * 0.1 - 1.6;
    let position = Vec3::new(at(x), 0.0, at(y));
    Some(Pixel { position, metallic: 1.0, roughness: 0.05, base: [0.5; 4], ..Pixel::LAMBERTIAN })
}

fn params(rays: LightRays, samples: u32) -> DirectParams {
    let (sampler, area_sampling) = (LightSampler::Power, AreaSampling::Uniform);
    // The lamp hides the horizon, where the sky is dark; by the cosine a ray could go there.
    DirectParams { rays, sampler, samples, area_sampling, cosine_share: 0.0, ..DirectParams::default() }
}

/// The rays of a frame, and whether any of its texels has light.
fn frame(device: &TestDevice, rig: &mut Rig, index: u32, texels: usize) -> (RayCounts, bool) {
    rig.counted = Some(Counted::new(device, texels).unwrap());
    rig.frame(index, 5, &pixel);
    let lit = |id| rig.texels(id).iter().any(|texel| texel.iter().any(|value| *value != 0.0));
    let lit = lit(COLOR_HF) || lit(COLOR_SPEC);
    (rig.counted.as_ref().unwrap().rays().unwrap(), lit)
}

/// As many rays as there are slots: all places of the list are used. Under a cover none arrives: a ray that the list had lost would not be
/// traced, and its light would arrive. The sizes fill neither the workgroups nor the last row of the launch.
#[test]
fn no_ray_is_lost() {
    let device = TestDevice::open();
    for (rays, slots, size) in
        [(LightRays::PerKind, 5, [11, 7]), (LightRays::PerKind, 5, [70, 9]), (LightRays::Merged, 4, [11, 7])]
    {
        let texels = split_size(size)[0] * size[1];
        let mut scene = scene();
        cover(&mut scene);
        let mut rig = Rig::new(&device, scene, size, &params(rays, 1));
        // More samples than in the frame before: the tables are made again.
        for (index, (samples, arrives)) in
            (0..).zip([(1, true), (1, false), (3, true), (2, true), (3, false)])
        {
            let away = Affine3A::from_translation(if arrives { -50.0 * Vec3::Y } else { Vec3::ZERO });
            rig.uploaded.scene.instances[1..].iter_mut().for_each(|i| i.world_from_object = away);
            rig.params.samples = samples;
            let (counted, lit) = frame(&device, &mut rig, index, texels as usize);
            let case = format!("{}, {size:?}, {samples} samples, open {arrives}", rays.name());
            assert_eq!(counted.traced, slots * texels * samples, "{case}: rays");
            assert_eq!(counted.arrived, if arrives { counted.traced } else { 0 }, "{case}: arrived");
            assert_eq!(lit, arrives, "{case}");
        }
    }
}

/// Each kind of light alone has a ray from every texel, the sky two of them, and without lights there is none.
#[test]
fn each_kind_has_its_rays() {
    let device = TestDevice::open();
    let size = [16, 9];
    let texels = split_size(size)[0] * size[1];
    let mut rig = Rig::new(&device, scene(), size, &params(LightRays::PerKind, 1));
    for (kind, slots) in [1, 1, 1, 2, 0].into_iter().enumerate() {
        let on = |k: usize| k == kind;
        (rig.params.sun, rig.params.positional) = (on(0), on(1));
        (rig.params.emissive, rig.params.environment) = (on(2), on(3));
        let (counted, _) = frame(&device, &mut rig, kind as u32, texels as usize);
        assert_eq!(counted.traced, slots * texels, "kind {kind}");
    }
}
