//! Mip chains.

use pt_scene::{MipLevel, Texels, Texture, TextureUsage, linear_from_srgb, srgb_from_linear};

fn noise(width: u32, height: u32, srgb: bool) -> Texture {
    let texels = (0..width * height * 4).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let usage = if srgb { TextureUsage::Color } else { TextureUsage::Data };
    Texture::rgba8("noise", [width, height], usage, texels)
}

fn linear_means(level: &MipLevel<'_>, srgb: bool) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for texel in level.texels.chunks_exact(4) {
        for c in 0..4 {
            let x = f32::from(texel[c]) / 255.0;
            sums[c] += f64::from(if srgb && c < 3 { linear_from_srgb(x) } else { x });
        }
    }
    sums.map(|s| s / f64::from(level.width * level.height))
}

#[test]
fn every_level_has_the_mean_of_the_texture() {
    for (width, height) in [(64, 64), (37, 11), (1, 19), (100, 3)] {
        for srgb in [false, true] {
            let texture = noise(width, height, srgb);
            let mips = texture.mips();
            let expected = linear_means(&mips[0], srgb);
            let last = mips.last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            for level in &mips {
                let means = linear_means(level, srgb);
                for c in 0..4 {
                    assert!(
                        (means[c] - expected[c]).abs() < 4e-3,
                        "{width}x{height} srgb {srgb}: {means:?}, {expected:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn colour_is_averaged_in_linear_light() {
    let texels = [[0u8, 0, 0, 255], [255, 255, 255, 255]].repeat(2).concat();
    // Half the light is 188 in sRGB, not 128.
    for usage in [TextureUsage::Color, TextureUsage::Cutout] {
        assert!(usage.is_srgb());
        let texture = Texture::rgba8("checks", [2, 2], usage, texels.clone());
        assert_eq!(*texture.mips()[1].texels, [188, 188, 188, 255], "{usage:?}");
    }
}

#[test]
fn coverage_weights_colour() {
    // Opaque red beside transparent green: what shows is red, half of it.
    let texels = [[255u8, 0, 0, 255], [0, 255, 0, 0]].repeat(2).concat();
    let mip = |usage| Texture::rgba8("leaf", [2, 2], usage, texels.clone()).mips()[1].texels.to_vec();
    let [r, g, _, a] = mip(TextureUsage::Cutout)[..] else { panic!("one texel") };
    assert!(r >= 254 && g <= 12 && a == 128, "{r} {g} {a}");
    // Where alpha means nothing, colour does not depend on it.
    assert_eq!(mip(TextureUsage::Color), [188, 188, 0, 128]);
    // Wholly transparent texels keep their colour.
    let clear = Texture::rgba8("clear", [2, 2], TextureUsage::Cutout, [[0u8, 255, 0, 0]; 4].concat());
    assert_eq!(*clear.mips()[1].texels, [0, 255, 0, 0]);
}

#[test]
fn normals_are_averaged_as_vectors() {
    // Two slopes against each other: upwards, of unit length again.
    let texels = [[218u8, 128, 218, 255], [38, 128, 218, 255]].repeat(2).concat();
    let texture = Texture::rgba8("ridge", [2, 2], TextureUsage::Normal, texels);
    let mips = texture.mips();
    let [x, y, z, a] = mips[1].texels[..] else { panic!("one texel") };
    assert!(x.abs_diff(128) <= 1 && y.abs_diff(128) <= 1 && z == 255 && a == 255, "{x} {y} {z} {a}");
    for level in noise_normals().mips() {
        for t in level.texels.chunks_exact(4) {
            let [x, y, z] = [0, 1, 2].map(|c| f32::from(t[c]) / 127.5 - 1.0);
            assert!((x * x + y * y + z * z - 1.0).abs() < 0.03, "({x}, {y}, {z})");
        }
    }
}

/// Unit vectors about +Z.
fn noise_normals() -> Texture {
    let noise = noise(19, 7, false);
    let Texels::Rgba8(texels) = &noise.texels else { unreachable!() };
    let unit = texels.chunks_exact(4).flat_map(|t| {
        let v = [f32::from(t[0]) / 255.0 - 0.5, f32::from(t[1]) / 255.0 - 0.5, 0.7];
        let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
        let [x, y, z] = v.map(|x| ((x / length * 0.5 + 0.5) * 255.0).round() as u8);
        [x, y, z, 255]
    });
    Texture::rgba8("normals", [19, 7], TextureUsage::Normal, unit.collect())
}

#[test]
fn srgb_inverts() {
    for i in 0..=255u8 {
        let x = f32::from(i) / 255.0;
        assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-5);
    }
}
