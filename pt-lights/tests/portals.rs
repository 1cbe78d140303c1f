//! Samples of the environment that go through windows, and those that are drawn by the cosine.

use crate::common::pixels::{Pixel, Rig};
use crate::common::room::{indoors, room};
use glam::Vec3;
use pt_core::test_support::TestDevice;
use pt_lights::DirectParams;
use pt_scene::{Portal, Scene};

const SIZE: [u32; 2] = [16, 16];
const FRAMES: u32 = 96;

fn sky_alone() -> DirectParams {
    DirectParams { positional: false, emissive: false, ..DirectParams::default() }
}

/// The left half is glossy metal.
fn glossy(at: [u32; 2]) -> Option<Pixel> {
    let gloss = |p: Pixel| Pixel { roughness: 0.25, metallic: 1.0, base: [0.5; 4], ..p };
    indoors(at).map(|p| if at[0] < SIZE[0] / 2 { gloss(p) } else { p })
}

/// Of the glossy half and of the rough half: mean light, variance of a pixel with one sample, and error of the mean.
fn measured(rig: &mut Rig) -> [[f64; 3]; 2] {
    let mut sums = vec![[0.0; 2]; 256];
    for frame in 0..FRAMES {
        rig.frame(frame, 11, &glossy);
        sums.iter_mut().zip(rig.light()).for_each(|(s, v)| *s = [s[0] + v, s[1] + v * v]);
    }
    let n = f64::from(FRAMES);
    [true, false].map(|smooth| {
        let pixels = || (0..256).filter(|i| (i % 16 < 8) == smooth).map(|i| sums[i]);
        let mean = pixels().map(|s| s[0] / n).sum::<f64>() / 128.0;
        let variance = pixels().map(|s| (s[1] - s[0] * s[0] / n) / (n - 1.0)).sum::<f64>() / 128.0;
        [mean, f64::from(rig.params.samples) * variance, (variance / 128.0 / n).sqrt()]
    })
}

/// Half of the samples drawn by the cosine, and nearly all of them: the mean is that without, also where a reflected ray shares the light with them,
/// and less is left to chance where the surface sees a part of the sky alone.
#[test]
fn samples_by_the_cosine_keep_the_mean() {
    let device = TestDevice::open();
    let with = |cosine_share: f32, samples: u32| {
        let params = DirectParams { cosine_share, samples, ..sky_alone() };
        measured(&mut Rig::new(&device, room(), SIZE, &params))
    };
    let plain = with(0.0, 8);
    for share in [0.5, 0.95] {
        for (kind, (found, plain)) in ["glossy", "rough"].iter().zip(with(share, 8).into_iter().zip(plain)) {
            let both = found[2].hypot(plain[2]);
            let case = format!("share {share}, {kind}: {:.4} of {:.4} +- {both:.4}", found[0], plain[0]);
            println!("{case}; variance {:.4} of {:.4}", found[1], plain[1]);
            assert!((found[0] - plain[0]).abs() < 4.0 * both, "{case}");
            assert!(both < 0.08 * plain[0], "{case}: too noisy to tell");
            assert!(*kind == "glossy" || found[1] < plain[1], "{case}: {} of {}", found[1], plain[1]);
        }
    }
}

/// The window of the room as a portal, with one that leads nowhere; and portals that do not know the window. The mean is that without portals, on
/// rough and on glossy surfaces, whatever they are; the noise is less where they fit.
#[test]
fn portals_take_noise_away_and_keep_the_mean() {
    let device = TestDevice::open();
    let portal = |corner: Vec3, edges| Portal { corner, edges };
    let window = portal(Vec3::new(2.0, 1.0, -0.6), [1.2 * Vec3::Y, 1.2 * Vec3::Z]);
    // In the middle of a wall; and half of the window with a part of the wall beside it, crossed by every direction twice.
    let blind = portal(Vec3::new(-0.5, 1.0, -2.0), [Vec3::X, Vec3::Y]);
    let half = portal(Vec3::new(2.0, 1.5, -1.0), [Vec3::Y, Vec3::Z]);
    let inner = portal(Vec3::new(1.9, 1.5, -1.0), [Vec3::Y, Vec3::Z]);
    let rig = |portals: &[Portal]| {
        let scene = Scene { portals: portals.to_vec(), ..room() };
        let params = DirectParams { cosine_share: 0.0, ..sky_alone() };
        Rig::new(&device, scene, SIZE, &params)
    };
    let measure = |rig: &mut Rig, portal_share: f32, samples: u32| {
        (rig.params.portal_share, rig.params.samples) = (portal_share, samples);
        measured(rig)
    };
    let plain = measure(&mut rig(&[]), 0.5, 16);
    for (name, portals, cases) in [
        ("window", &[window][..], &[(0.5, 8.0), (0.9, 8.0)][..]),
        ("window and a blind one", &[window, blind][..], &[(0.5, 1.5)][..]),
        ("beside the window", &[half, inner][..], &[(0.5, 0.2)][..]),
    ] {
        let mut rig = rig(portals);
        for &(share, least_gain) in cases {
            let found = measure(&mut rig, share, 1);
            for (i, kind) in ["glossy", "rough"].into_iter().enumerate() {
                let ([mean, variance, error], [expected, of_plain, spread]) = (found[i], plain[i]);
                let both = error.hypot(spread);
                let case =
                    format!("{name}, share {share}, {kind}: mean {mean:.4} of {expected:.4} +- {both:.4}");
                println!("{case}; variance {variance:.4} of {of_plain:.4}");
                assert!((mean - expected).abs() < 4.0 * both, "{case}");
                assert!(
                    kind == "glossy" || of_plain > least_gain * variance,
                    "{case}: {variance} of {of_plain}"
                );
                // Without a portal that fits a frame has too few samples to tell more.
                let precision = if least_gain > 1.0 { 0.05 } else { 0.15 };
                assert!(both < precision * expected, "{case}: too noisy to tell");
            }
        }
    }
}
