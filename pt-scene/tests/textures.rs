//! Mip chains.

use pt_scene::{MipLevel, Texture, TextureUsage, linear_from_srgb, srgb_from_linear};

fn noise(width: u32, height: u32, srgb: bool) -> Texture {
    let texels = (0..width * height * 4).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let usage = if srgb { TextureUsage::Color } else { TextureUsage::Data };
    Texture::rgba8("noise", [width, height], usage, texels)
}

fn linear_means(level: &MipLevel, srgb: bool) -> [f64; 4] {
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
            let mips = noise(width, height, srgb).mips();
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
    let texture = Texture::rgba8("checks", [2, 2], TextureUsage::Color, texels);
    // Half the light is 188 in sRGB, not 128.
    assert_eq!(texture.mips()[1].texels, [188, 188, 188, 255]);
}

#[test]
fn srgb_inverts() {
    for i in 0..=255u8 {
        let x = f32::from(i) / 255.0;
        assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-5);
    }
}
