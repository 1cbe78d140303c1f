//! Radiance pictures: every header variable, orientation and encoding that counts.

use proptest::prelude::*;
use pt_image::image_file::{ImageState, LinearImage};

/// A file with one header variable a line.
fn file(header: &str, resolution: &str, data: &[u8]) -> Vec<u8> {
    [format!("#?RADIANCE\n{header}\n{resolution}\n").as_bytes(), data].concat()
}

fn picture(bytes: &[u8]) -> (LinearImage, Vec<String>) {
    LinearImage::decode(bytes).unwrap_or_else(|e| panic!("{e}"))
}

/// The first pixel of a picture of one pixel.
fn value(header: &str, pixel: [u8; 4]) -> [f32; 3] {
    picture(&file(header, "-Y 1 +X 1", &pixel)).0.pixels[0]
}

fn refusal(bytes: &[u8]) -> String {
    let text = LinearImage::decode(bytes).expect_err("must be refused");
    assert!(!text.contains('\n'), "{text}");
    text
}

fn close(got: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let near = got.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(near, "{got:?} is not {expected:?}");
}

const RGBE: &str = "FORMAT=32-bit_rle_rgbe\n";
const XYZE: &str = "FORMAT=32-bit_rle_xyze\n";

/// Red 0.5, green 1, blue 64 / 256.
const COLOR: [u8; 4] = [64, 128, 32, 129];

#[test]
fn mantissas_share_an_exponent() {
    let (image, notices) = picture(&file(RGBE, "-Y 1 +X 1", &COLOR));
    assert_eq!((image.pixels[0], image.state), ([0.5, 1.0, 0.25], ImageState::SceneReferred));
    assert!(notices.is_empty(), "{notices:?}");
    // Black whatever the mantissas; the smallest and the largest exponent.
    assert_eq!(value(RGBE, [9, 9, 9, 0]), [0.0; 3]);
    // 2^-135, of which 2^-149 is the last bit.
    assert_eq!(value(RGBE, [1, 0, 0, 1]), [f32::from_bits(1 << 14), 0.0, 0.0]);
    assert_eq!(value(RGBE, [255, 0, 0, 255]), [255.0 * 2f32.powi(119), 0.0, 0.0]);
    // Old files name no format.
    assert_eq!(value("", COLOR), [0.5, 1.0, 0.25]);
}

#[test]
fn any_word_follows_the_signature() {
    for word in ["RADIANCE", "RGBE", "AUTOPANO"] {
        let bytes = [format!("#?{word}\n{RGBE}\n-Y 1 +X 1\n").as_bytes(), &COLOR].concat();
        assert_eq!(picture(&bytes).0.pixels[0], [0.5, 1.0, 0.25]);
    }
    // Lines that end as on other systems.
    let bytes = [b"#?RGBE\r\nEXPOSURE=2\r\n\r\n-Y 1 +X 1\n".as_slice(), &COLOR].concat();
    assert_eq!(picture(&bytes).0.pixels[0], [0.25, 0.5, 0.125]);
}

#[test]
fn exposures_multiply_and_are_divided_out() {
    assert_eq!(value(&format!("{RGBE}EXPOSURE=2.0\n"), COLOR), [0.25, 0.5, 0.125]);
    let twice = format!("EXPOSURE=  4.0e0 \n{RGBE}EXPOSURE=0.5\n");
    assert_eq!(value(&twice, COLOR), [0.25, 0.5, 0.125]);
    let (_, notices) = picture(&file(&twice, "-Y 1 +X 1", &COLOR));
    assert!(notices.iter().any(|n| n.contains("EXPOSURE 2")), "{notices:?}");
    // Indented lines are the history of what the picture was made from.
    assert_eq!(value("\tEXPOSURE=8\n", COLOR), [0.5, 1.0, 0.25]);
    let both = "COLORCORR=0.5 2 1\nEXPOSURE=2\nCOLORCORR=1 1 0.5\n";
    assert_eq!(value(both, COLOR), [0.5, 0.25, 0.25]);
    for bad in ["EXPOSURE=0", "EXPOSURE=-1", "EXPOSURE=x", "EXPOSURE=inf", "COLORCORR=1 2", "COLORCORR=1 0 1"]
    {
        let text = refusal(&file(&format!("{bad}\n"), "-Y 1 +X 1", &COLOR));
        assert!(text.contains(bad.split('=').next().unwrap()), "{text}");
    }
    let text = refusal(&file(&"EXPOSURE=1e300\n".repeat(2), "-Y 1 +X 1", &COLOR));
    assert!(text.contains("out of range"), "{text}");
}

#[test]
fn tristimulus_values_become_rgb() {
    // The white of Rec. 709 is D65: X 0.9505, Y 1, Z 1.0890 times 0.5, to 8 bits.
    close(value(XYZE, [121, 128, 139, 128]), [0.5; 3], 0.01);
    // Its red primary: X 0.4124, Y 0.2126, Z 0.0193.
    close(value(XYZE, [211, 109, 10, 127]), [1.0, 0.0, 0.0], 0.01);
    assert!(refusal(&file("FORMAT=16-bit\n", "-Y 1 +X 1", &COLOR)).contains("FORMAT \"16-bit\""));
    assert!(refusal(&file("GAMMA=2.2\n", "-Y 1 +X 1", &COLOR)).contains("GAMMA"));
    assert_eq!(value("GAMMA=1.0\n", COLOR), [0.5, 1.0, 0.25]);
}

#[test]
fn primaries_are_converted_white_to_white() {
    let wide = "PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290\n";
    close(value(wide, [128, 128, 128, 128]), [0.5; 3], 1e-6);
    // BT.2087: the green of Rec. 2020 in Rec. 709.
    close(value(wide, [0, 128, 0, 129]), [-0.5876, 1.1329, -0.1006], 1e-3);
    let own = "PRIMARIES=0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290\n";
    assert_eq!(value(own, COLOR), [0.5, 1.0, 0.25]);
    // Some programs write zeros where they do not know them.
    assert_eq!(value("PRIMARIES=0 0 0 0 0 0 0 0\n", COLOR), [0.5, 1.0, 0.25]);
    for bad in ["PRIMARIES=1 0 1 0 1 0 1 0\n", "PRIMARIES=1 2 3\n"] {
        assert!(refusal(&file(bad, "-Y 1 +X 1", &COLOR)).contains("PRIMARIES"), "{bad}");
    }
}

#[test]
fn all_eight_orientations_show_the_same_picture() {
    // Three columns and two rows; every pixel is another one.
    let at = |row: u8, column: u8| [10 * (row + 1) + column, 0, 0, 136];
    let expected: Vec<f32> = [10u8, 11, 12, 20, 21, 22].map(f32::from).to_vec();
    for (y, x) in [("-Y", "+X"), ("-Y", "-X"), ("+Y", "+X"), ("+Y", "-X")] {
        let rows = if y == "-Y" { [0, 1] } else { [1, 0] };
        let columns = if x == "+X" { [0, 1, 2] } else { [2, 1, 0] };
        let by_rows: Vec<u8> =
            rows.iter().flat_map(|&r| columns.iter().flat_map(move |&c| at(r, c))).collect();
        let by_columns: Vec<u8> =
            columns.iter().flat_map(|&c| rows.iter().flat_map(move |&r| at(r, c))).collect();
        for (resolution, data) in [(format!("{y} 2 {x} 3"), by_rows), (format!("{x} 3 {y} 2"), by_columns)] {
            let (image, _) = picture(&file(RGBE, &resolution, &data));
            assert_eq!((image.width, image.height), (3, 2), "{resolution}");
            let reds: Vec<f32> = image.pixels.iter().map(|p| p[0]).collect();
            assert_eq!(reds, expected, "{resolution}");
        }
    }
    for bad in ["-Y 2 +Y 3", "-X 2 +X 3", "Y 2 X 3", "-Y 2", "-Y 2 +X 3 4", "-Y -2 +X 3", "-Y 2 +X x", ""] {
        assert!(refusal(&file(RGBE, bad, &[1; 64])).contains("resolution"), "{bad}");
    }
}

#[test]
fn runs_of_both_kinds_are_expanded() {
    // Ten pixels, component by component: a run and single bytes.
    let run = |byte: u8| vec![128 + 10, byte];
    let single: Vec<u8> = [vec![4, 1, 2, 3, 4], vec![128 + 6, 9]].concat();
    let data = [vec![2, 2, 0, 10], single, run(0), run(0), run(136)].concat();
    let (image, _) = picture(&file(RGBE, "-Y 1 +X 10", &data));
    let reds: Vec<f32> = image.pixels.iter().map(|p| p[0]).collect();
    assert_eq!(reds, [1.0, 2.0, 3.0, 4.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0]);
    // Pixel by pixel: a pixel, three copies, another one, 2 + 256 copies.
    let old: Vec<[u8; 4]> = vec![[5, 0, 0, 136], [1, 1, 1, 3], [7, 0, 0, 136], [1, 1, 1, 2], [1, 1, 1, 1]];
    let (image, _) = picture(&file(RGBE, "-Y 1 +X 263", &old.concat()));
    let reds: Vec<f32> = image.pixels.iter().map(|p| p[0]).collect();
    assert_eq!((&reds[..5], &reds[5..]), (&[5.0, 5.0, 5.0, 5.0, 7.0][..], &[7.0; 258][..]));
}

#[test]
fn damaged_lines_are_refused_by_number() {
    let line = |data: &[u8]| refusal(&file(RGBE, "-Y 1 +X 10", data));
    let cases: [(&[u8], &str); 7] = [
        (&[], "cut short"),
        (&[2, 2, 0, 11], "it has 11 pixels, the resolution says 10"),
        (&[2, 2, 0, 10, 139, 1], "longer than the line"),
        (&[2, 2, 0, 10, 0], "empty"),
        (&[2, 2, 0, 10, 138], "cut short"),
        (&[1, 1, 1, 5], "no pixel to repeat"),
        (&[9, 9, 9, 9, 1, 1, 1, 200], "longer than the line"),
    ];
    for (data, what) in cases {
        let text = line(data);
        assert!(text.starts_with("scan line 0 of 1: ") && text.contains(what), "{text}");
    }
    let text = refusal(b"#?RADIANCE\nEXPOSURE=1\n");
    assert!(text.contains("header is cut short"), "{text}");
    assert!(refusal(&[b"#?".as_slice(), &[b'x'; 1 << 17]].concat()).contains("header"));
    assert!(refusal(&file(&"A=b\n".repeat(1 << 15), "-Y 1 +X 1", &COLOR)).contains("header"));
}

#[test]
fn sizes_are_checked_before_memory_is_set_aside() {
    for (resolution, what) in [
        ("-Y 16384 +X 16384", "cannot be in"),
        ("-Y 4000000000 +X 4000000000", "out of range"),
        ("-Y 0 +X 4", "out of range"),
        ("+X 16385 -Y 1", "out of range"),
        ("-Y 99999999999 +X 1", "resolution"),
    ] {
        let text = refusal(&file(RGBE, resolution, &[0; 64]));
        assert!(text.contains(what), "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Any bytes behind any header are an error or a picture of the size that the header says.
    #[test]
    fn any_data_are_no_panic(
        data in proptest::collection::vec(prop_oneof![Just(1u8), Just(2), Just(0), Just(136), any::<u8>()], 0..400),
        width in 1usize..40,
        height in 1usize..6,
        by_columns in any::<bool>(),
    ) {
        let resolution =
            if by_columns { format!("+X {width} -Y {height}") } else { format!("-Y {height} +X {width}") };
        match LinearImage::decode(&file(RGBE, &resolution, &data)) {
            Ok((image, _)) => prop_assert_eq!(image.pixels.len(), width * height),
            Err(text) => prop_assert!(!text.contains('\n')),
        }
    }
}
