use super::*;
use crate::test_support::bright_spot;
use crate::{LightLists, environment, test_support};
use pt_scene::{EnvironmentImage, Light};

fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Environment {
    let texels = (0..width * height).map(|i| Vec3::splat(texel(i % width, i / width))).collect();
    Environment::new(EnvironmentImage { width, height, texels })
}

/// A sun of a few texels in a gradient, and a black lower half.
fn sky(width: u32, height: u32) -> Environment {
    image(width, height, |x, y| {
        let sun = (x, y) == (width / 3, height / 4);
        if y > height / 2 { 0.0 } else { 1.0 + 0.1 * y as f32 + if sun { 5e4 } else { 0.0 } }
    })
}

fn environments() -> Vec<(&'static str, Environment)> {
    vec![
        ("bright spots", bright_spot(13, 9)),
        ("sky", sky(256, 128)),
        ("narrow sky", sky(300, 7)),
        ("constant", Environment::constant(Vec3::ONE)),
        ("fine constant", image(200, 100, |_, _| 3.0)),
        ("one texel", image(150, 75, |x, y| if (x, y) == (0, 70) { 5e4 } else { 0.0 })),
        ("huge", image(150, 75, |_, _| f32::MAX)),
    ]
}

fn is_close(a: f64, b: f64, tolerance: f64) -> bool {
    (a / b - 1.0).abs() < tolerance
}

/// The quads are a partition of the cells that are not black, the tree finds every cell in its quad, and their powers are that of the picture.
#[test]
fn quads_are_a_partition() {
    for (name, environment) in environments() {
        let quads = EnvironmentQuads::new(&environment);
        let map = Map::new(&environment);
        assert!((1..=EnvironmentQuads::MOST).contains(&quads.quads().len()), "{name}");
        let mut owner = vec![None; map.weights.len()];
        for (i, quad) in quads.quads().iter().enumerate() {
            for (y, x) in (0..quad.size.y).flat_map(|y| (0..quad.size.x).map(move |x| (y, x))) {
                let cell = (quad.corner.y + y) * quads.grid[0] + quad.corner.x + x;
                assert_eq!(owner[cell as usize].replace(i), None, "{name}: two quads have a cell");
            }
        }
        for (cell, owner) in (0..).zip(&owner) {
            let at = [cell % quads.grid[0], cell / quads.grid[0]];
            assert_eq!(quads.find(at), *owner, "{name}: {at:?}");
            assert!(owner.is_some() || map.weights[cell as usize] == 0.0, "{name}: {at:?} is left out");
        }
        let lit: f64 = (0..quads.quads().len()).map(|quad| quads.solid_angle(quad)).sum();
        let cells = (0..).zip(&owner).filter(|(_, owner)| owner.is_none());
        let black: f64 = cells.map(|(cell, _): (u32, _)| quads.cell_solid_angle(cell / quads.grid[0])).sum();
        assert!(is_close(lit + black, 4.0 * PI, 1e-9), "{name}: {lit} + {black}");
        if name.contains("constant") {
            assert!(is_close(lit, 4.0 * PI, 1e-9), "{name}: {lit}");
        }
        let power: f64 = quads.quads().iter().map(|quad| f64::from(quad.irradiance)).sum();
        // The weights of whole texels, by a filter of their own.
        let expected: f64 = environment::weights(&environment).iter().sum();
        let bound =
            if name == "huge" || name == "narrow sky" || name == "bright spots" { 0.02 } else { 1e-3 };
        if name != "huge" {
            assert!(is_close(power, expected, bound), "{name}: {power} of {expected}");
        }
        assert_eq!(quads, EnvironmentQuads::new(&environment), "{name}");
    }
}

/// One colour gives quads of about the same solid angle; one bright texel those that its lookups reach, no larger than a texel.
#[test]
fn quads_follow_the_power() {
    for environment in [Environment::constant(Vec3::ONE), image(512, 256, |_, _| 2.0)] {
        let quads = EnvironmentQuads::new(&environment);
        assert_eq!(quads.quads().len(), EnvironmentQuads::MOST);
        for quad in 0..quads.quads().len() {
            let share = quads.solid_angle(quad) / (4.0 * PI) * EnvironmentQuads::MOST as f64;
            assert!((0.85..1.15).contains(&share), "{share}");
        }
    }
    let one = image(256, 128, |x, y| if (x, y) == (0, 30) { 5e4 } else { 0.0 });
    let quads = EnvironmentQuads::new(&one);
    // The texel and its eight neighbours, on both sides of the seam.
    assert_eq!(quads.quads().len(), 9);
    assert!(quads.quads().iter().all(|quad| quad.size == UVec2::ONE));
    let brightest = quads.find([0, 30]).unwrap();
    let share = f64::from(quads.quads()[brightest].irradiance)
        / quads.quads().iter().map(|quad| f64::from(quad.irradiance)).sum::<f64>();
    assert!(is_close(share, 36.0 / 64.0, 1e-2), "{share}");
    assert_eq!(quads.find([128, 64]), None);
    // A sun in a sky: quads around it are small.
    let quads = EnvironmentQuads::new(&sky(256, 128));
    let sizes = quads.quads().iter().map(|quad| quad.size.x * quad.size.y);
    assert_eq!(sizes.clone().min(), Some(1));
    assert!(sizes.max() > Some(100));
}

/// What is no light, or no number, has no quad and makes nothing else dark.
#[test]
fn bad_pictures_have_no_quads() {
    let bad = [
        image(64, 32, |_, _| 0.0),
        image(1, 1, |_, _| 0.0),
        image(64, 32, |x, _| if x == 3 { f32::NAN } else { 1.0 }),
        image(64, 32, |x, _| if x == 3 { -2.0 } else { 1.0 }),
        image(64, 32, |x, _| if x == 3 { f32::INFINITY } else { 1.0 }),
    ];
    for environment in bad {
        let mut scene = test_support::all_kinds();
        let alone = LightLists::new(&scene);
        scene.environment = environment;
        let mut lists = LightLists::new(&scene);
        assert!(lists.list_environment(&scene, true));
        assert_eq!((lists.quad_count(), &lists.local), (0, &alone.local));
        assert_eq!(lists.local_alias, alone.local_alias);
    }
}

/// A brute-force cone: every point of the borders of cells is within.
#[test]
fn cones_hold_their_directions() {
    for (name, environment) in environments() {
        let environment = Environment { rotation: 0.9, ..environment };
        let quads = EnvironmentQuads::new(&environment);
        for (i, quad) in quads.quads().iter().enumerate() {
            let light = quads.light(i, &environment, 1.0);
            let (mut least, steps) = (1.0f32, 24);
            for (u, v) in (0..=steps).flat_map(|u| (0..=steps).map(move |v| (u, v))) {
                let cell =
                    quad.corner.as_vec2() + quad.size.as_vec2() * UVec2::new(u, v).as_vec2() / steps as f32;
                let uv = cell / UVec2::from_array(quads.grid).as_vec2();
                least = least.min(light.axis.dot(environment.direction(uv)));
            }
            assert!(least >= light.cos_spread, "{name}: {least} outside of {}", light.cos_spread);
            // And it is no larger than it has to be.
            let half = |cos: f32| f64::from(cos.clamp(-1.0, 1.0)).acos();
            assert!(half(light.cos_spread) < half(least) + 5e-3, "{name}: {least} {}", light.cos_spread);
        }
    }
}

/// Intensity and rotation are those of the frame; the triangles come before the quads, the positional lights after them.
#[test]
fn intensity_and_rotation_reach_the_list() {
    let mut scene = test_support::all_kinds();
    let alone = LightLists::new(&scene);
    let mut lists = alone.clone();
    assert!(lists.list_environment(&scene, true) && !lists.list_environment(&scene, true));
    let range = lists.quad_range();
    assert!(range.start > 0 && lists.first_positional() < lists.local.len());
    let others = [&lists.local[..range.start], &lists.local[range.end..]].concat();
    assert_eq!(others, alone.local);
    assert_eq!(lists.may_change.len(), lists.local.len());
    assert!(lists.quad_count() > 8);
    let before = lists.local.clone();
    scene.environment.intensity *= 3.0;
    lists.update_lights(&scene);
    let change = lists.update_local(&scene);
    assert!(change.moved && change.power);
    for (now, before) in lists.local[range.clone()].iter().zip(&before[range.clone()]) {
        assert!(is_close((now.irradiance / before.irradiance).into(), 3.0, 1e-5));
        assert!(is_close((now.power / before.power).into(), 3.0, 1e-5));
    }
    assert_eq!(lists.environment_intensity, scene.environment.intensity);
    scene.environment.rotation += 1.0;
    lists.update_lights(&scene);
    assert!(lists.update_local(&scene).moved);
    assert_ne!(lists.local[range.start].axis, before[range.start].axis);
    scene.environment.intensity = 0.0;
    lists.update_lights(&scene);
    lists.update_local(&scene);
    assert!(lists.local[range.clone()].iter().all(|light| light.power == 0.0));
    scene.environment.intensity = 1.0;
    lists.update_lights(&scene);
    assert!(lists.update_local(&scene).power && lists.local[range.start].power > 0.0);
    // Quads keep their indices when lights appear.
    scene.lights.push(Light { id: 99, ..Light::point("late", Vec3::Y, Vec3::ONE) });
    lists.update_lights(&scene);
    lists.update_local(&scene);
    assert_eq!((lists.quad_range(), lists.local.len()), (range.clone(), alone.local.len() + range.len() + 1));
    assert!(lists.local[range].iter().all(LightBounds::is_distant));
    scene.lights.pop();
    lists.update_lights(&scene);
    lists.update_local(&scene);
    assert!(lists.list_environment(&scene, false));
    assert_eq!(lists.local[..alone.local.len()], alone.local);
    assert_eq!(lists.may_change.len(), lists.local.len());
}
