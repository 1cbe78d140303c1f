//! OpenEXR files of other programs as linear pictures: windows, colour spaces, names of layers.

use std::io::Cursor;

use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use pt_image::image_file::{LayeredImage, LinearImage};

/// A file of one part in the making. The value of a channel at a pixel of the data window is its own plus the pixel's index / 8.
struct File {
    data: IntegerBounds,
    display: IntegerBounds,
    channels: Vec<(&'static str, f32)>,
    chromaticities: Option<Chromaticities>,
    white_luminance: Option<f32>,
}

/// One pixel of some channels.
fn pixel(channels: &[(&'static str, f32)]) -> File {
    let window = IntegerBounds::new((0, 0), (1, 1));
    File {
        data: window,
        display: window,
        channels: channels.to_vec(),
        chromaticities: None,
        white_luminance: None,
    }
}

fn rgb([r, g, b]: [f32; 3]) -> File {
    pixel(&[("R", r), ("G", g), ("B", b)])
}

impl File {
    fn bytes(&self) -> Vec<u8> {
        let list = self.channels.iter().map(|&(name, value)| {
            let samples = (0..self.data.size.area()).map(|i| value + i as f32 / 8.0).collect();
            AnyChannel::new(name, FlatSamples::F32(samples))
        });
        let mut attributes = LayerAttributes::named("part");
        attributes.layer_position = self.data.position;
        attributes.white_luminance = self.white_luminance;
        let channels = AnyChannels::sort(list.collect());
        let mut image =
            Image::from_layer(Layer::new(self.data.size, attributes, Encoding::UNCOMPRESSED, channels));
        image.attributes.display_window = self.display;
        image.attributes.chromaticities = self.chromaticities;
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn picture(&self) -> (LinearImage, Vec<String>) {
        LinearImage::decode(&self.bytes()).unwrap_or_else(|e| panic!("{e}"))
    }

    fn refusal(&self) -> String {
        LinearImage::decode(&self.bytes()).expect_err("must be refused")
    }
}

fn close(got: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let near = got.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(near, "{got:?} is not {expected:?}");
}

#[test]
fn the_picture_is_the_display_window() {
    let window = |position: (i32, i32), size: (usize, usize)| IntegerBounds::new(position, size);
    let display = window((2, -1), (3, 2));
    let at = |data: IntegerBounds| {
        let (image, notices) = File { data, display, ..rgb([1.0, 1.0, 1.0]) }.picture();
        assert_eq!((image.width, image.height), (3, 2));
        assert!(notices.iter().any(|n| n.contains("display window (3x2 at 2,-1)")), "{notices:?}");
        image.pixels.iter().map(|p| p[1]).collect::<Vec<_>>()
    };
    // A part of it, in the lower right corner.
    assert_eq!(at(window((3, 0), (2, 1))), [0.0, 0.0, 0.0, 0.0, 1.0, 1.125]);
    // More than it on all sides: rows of 5.
    assert_eq!(at(window((1, -2), (5, 4))), [1.75, 1.875, 2.0, 2.375, 2.5, 2.625]);
    // Across the left border, and far from it.
    assert_eq!(at(window((0, -1), (3, 1))), [1.25, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(at(window((-100, 7), (4, 4))), [0.0; 6]);
    // Windows that agree say nothing, wherever they lie.
    let (image, notices) = File { data: display, display, ..rgb([1.0; 3]) }.picture();
    assert_eq!((image.pixels[5], notices.len()), ([1.625; 3], 0));
}

#[test]
fn layers_are_cut_to_the_display_window_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crop.exr");
    let display = IntegerBounds::new((0, 0), (4, 1));
    let data = IntegerBounds::new((1, 0), (2, 1));
    let file = File { data, display, ..pixel(&[("depth.Z", 3.0)]) };
    std::fs::write(&path, file.bytes()).unwrap();
    let image = LayeredImage::read_exr(&path).unwrap();
    assert_eq!((image.width, image.height), (4, 1));
    assert_eq!(image.channel("depth", "Z").unwrap().to_f32(), [0.0, 3.0, 3.125, 0.0]);
}

#[test]
fn a_small_file_cannot_ask_for_a_huge_picture() {
    let display = IntegerBounds::new((0, 0), (16_384, 16_384));
    let text = File { display, ..rgb([1.0; 3]) }.refusal();
    assert!(text.contains("16384x16384 pixels cannot be in"), "{text}");
    let display = IntegerBounds::new((0, 0), (70_000, 1));
    let text = File { display, ..rgb([1.0; 3]) }.refusal();
    assert!(text.contains("display window") && text.contains("70000x1 is out of range"), "{text}");
}

#[test]
fn other_primaries_become_those_of_rec_709() {
    let ap1 = Chromaticities {
        red: Vec2(0.713, 0.293),
        green: Vec2(0.165, 0.83),
        blue: Vec2(0.128, 0.044),
        white: Vec2(0.32168, 0.33767),
    };
    let convert = |color| File { chromaticities: Some(ap1), ..rgb(color) }.picture();
    let (image, notices) = convert([0.6, 0.3, 0.2]);
    close(image.pixels[0], [0.82, 0.26, 0.18], 0.005);
    assert!(notices.iter().any(|n| n.contains("chromaticities")), "{notices:?}");
    close(convert([0.5; 3]).0.pixels[0], [0.5; 3], 1e-5);
    // An infinite value, of a light that was too bright for the file, stays one.
    assert_eq!(convert([f32::INFINITY; 3]).0.pixels[0], [f32::INFINITY; 3]);
    // Those of Rec. 709 itself leave every bit alone.
    let rec_709 = Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    };
    let (image, notices) = File { chromaticities: Some(rec_709), ..rgb([0.1, 0.2, 0.3]) }.picture();
    assert_eq!((image.pixels[0], notices.len()), ([0.1, 0.2, 0.3], 0));
    let none = Chromaticities { red: Vec2(0.0, 0.0), green: Vec2(0.0, 0.0), ..rec_709 };
    let text = File { chromaticities: Some(none), ..rgb([1.0; 3]) }.refusal();
    assert!(text.contains("chromaticities") && text.contains("do not define a colour space"), "{text}");
}

#[test]
fn white_luminance_scales_to_candelas() {
    let with = |luminance| File { white_luminance: Some(luminance), ..rgb([0.5, 0.25, 1.0]) };
    let (image, notices) = with(80.0).picture();
    assert_eq!(image.pixels[0], [40.0, 20.0, 80.0]);
    assert!(notices.iter().any(|n| n.contains("whiteLuminance 80")), "{notices:?}");
    assert_eq!(with(1.0).picture().0.pixels[0], [0.5, 0.25, 1.0]);
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let text = with(bad).refusal();
        assert!(text.contains(&format!("whiteLuminance {bad} is not above 0")), "{text}");
    }
}

#[test]
fn the_finished_picture_is_found_among_layers() {
    const COMBINED: [(&str, f32); 4] = [
        ("ViewLayer.Combined.R", 1.0),
        ("ViewLayer.Combined.G", 2.0),
        ("ViewLayer.Combined.B", 3.0),
        ("ViewLayer.Combined.A", 4.0),
    ];
    const DIFFUSE: [(&str, f32); 3] =
        [("ViewLayer.DiffCol.R", 5.0), ("ViewLayer.DiffCol.G", 6.0), ("ViewLayer.DiffCol.B", 7.0)];
    const COMPOSITE: [(&str, f32); 3] =
        [("Composite.Combined.R", 7.0), ("Composite.Combined.G", 8.0), ("Composite.Combined.B", 9.0)];
    const OTHER: [(&str, f32); 3] =
        [("Second.Combined.R", 0.0), ("Second.Combined.G", 0.0), ("Second.Combined.B", 0.0)];
    let picture = |parts: &[&[(&'static str, f32)]]| pixel(&parts.concat()).picture().0.pixels[0];
    assert_eq!(picture(&[&COMBINED]), [1.0, 2.0, 3.0]);
    assert_eq!(picture(&[&COMBINED, &DIFFUSE]), [1.0, 2.0, 3.0]);
    assert_eq!(picture(&[&COMBINED, &DIFFUSE, &COMPOSITE]), [7.0, 8.0, 9.0]);
    assert_eq!(picture(&[&DIFFUSE]), [5.0, 6.0, 7.0]);
    assert_eq!(picture(&[&COMBINED, &[("R", 0.5), ("G", 0.5), ("B", 0.5)]]), [0.5; 3]);
    let text = pixel(&[COMBINED.as_slice(), &OTHER].concat()).refusal();
    assert!(
        text.contains("more than one layer") && text.contains("Second.Combined, ViewLayer.Combined"),
        "{text}"
    );
}

#[test]
fn luminance_alone_is_grey() {
    assert_eq!(pixel(&[("Y", 0.75)]).picture().0.pixels[0], [0.75; 3]);
    assert_eq!(pixel(&[("Y", 0.75), ("A", 1.0)]).picture().0.pixels[0], [0.75; 3]);
    assert_eq!(pixel(&[("View.Combined.Y", 0.75), ("Z", 9.0)]).picture().0.pixels[0], [0.75; 3]);
    let text = pixel(&[("Y", 0.5), ("RY", 0.0), ("BY", 0.0)]).refusal();
    assert!(text.contains("luminance and chroma (channels Y, RY, BY)"), "{text}");
    // Neither directions nor a depth are a picture.
    let text = pixel(&[("normal.X", 0.0), ("normal.Y", 1.0), ("normal.Z", 0.0), ("Z", 9.0)]).refusal();
    assert!(text.contains("no layer has channels R, G, B or Y (channels: Z, normal.X"), "{text}");
}
