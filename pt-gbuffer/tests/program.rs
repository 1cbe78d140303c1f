//! The stage program from a scene to a capture.

use pt_gbuffer::PrimaryRays;
use pt_image::image_file::{LayeredImage, LinearImage, Samples};
use std::collections::BTreeSet;
use std::process::Command;

#[test]
fn writes_the_g_buffer() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt-gbuffer"));
        program.current_dir(folder.path()).args(arguments).output().unwrap()
    };
    let traced =
        ["cornell", "--size", "33x18", "--frames", "2", "--backend", "compute", "--set", "jitter=none"];
    let done = run(&[&traced[..], &["-o", "g.exr", "--sheet", "sheet.png"]].concat());
    assert!(done.status.success(), "{done:?}");
    let table = String::from_utf8(done.stdout).unwrap();
    assert!(table.contains("\nprimary rays ") && table.contains("Mrays/s (primary), compute"), "{table}");

    // Sixteen channels in four columns.
    assert!(table.contains("\nsheet, row 1: rng_seed, visibility, "), "{table}");
    assert!(table.lines().filter(|line| line.starts_with("sheet, row ")).count() == 4, "{table}");
    let sheet = LinearImage::read(&folder.path().join("sheet.png")).unwrap();
    assert_eq!((sheet.width, sheet.height), (4 * 37 + 4, 4 * 22 + 4));
    // The tile of the depth is not of one colour, the gap beside it is.
    let [column, row] = PrimaryRays::IO
        .writes
        .iter()
        .position(|id| id.channel().name == "view_depth")
        .map(|i| [i % 4, i / 4])
        .unwrap();
    let colors = |x: usize, y: usize, w: usize, h: usize| -> BTreeSet<[u32; 3]> {
        let at = |x: usize, y: usize| sheet.pixels[y * sheet.width as usize + x].map(f32::to_bits);
        (y..y + h).flat_map(|y| (x..x + w).map(move |x| at(x, y))).collect()
    };
    assert!(colors(4 + 37 * column, 4 + 22 * row, 33, 18).len() > 20);
    assert_eq!(colors(37 * column, 22 * row, 4, 22).len(), 1);

    let capture = LayeredImage::read_exr(&folder.path().join("g.exr")).unwrap();
    assert_eq!((capture.width, capture.height), (33, 18));
    for id in PrimaryRays::IO.writes {
        assert!(capture.layer(id.channel().name).is_some(), "{}", id.channel().name);
    }
    // The Cornell box fills the middle of the picture, and is some metres away.
    let middle = 9 * 33 + 16;
    let depth = capture.channel("view_depth", "Z").unwrap().to_f32()[middle];
    assert!((0.5..20.0).contains(&depth), "{depth}");
    let Some(Samples::U32(material)) = capture.channel("shading_position", "material") else {
        panic!("material is an integer")
    };
    assert!(material[middle] > 0);
    assert_eq!(capture.channel("", "R"), capture.channel("base_color", "R"));
    assert_eq!(capture.metadata["scene"], "cornell");

    for (arguments, expected) in [
        (&["no-such-scene"][..], "no-such-scene"),
        (&["cornell", "--set", "jiter=none"], "closest: \"jitter\""),
        (&["cornell", "--size", "0x9"], "out of range"),
        (&["cornell", "--set", "godrays.density=-0.1"], "godrays.density"),
        (&["cornell", "--set", "godrays.density=nan"], "godrays.density"),
        (&["cornell", "--set", "godrays.anisotropy=1"], "godrays.anisotropy"),
        (&["cornell", "--set", "godrays.max_distance=inf"], "godrays.max_distance"),
        (&["cornell", "--set", "godrays.steps=0"], "godrays.steps"),
        (&["cornell", "--set", "godrays.density=0.1"], "use pt render"),
        (&["cornell", "--backend", "cuda"], "expected one of auto, compute"),
        (&["cornell", "-o", "a.png"], "only exr"),
        (&["cornell", "--sheet", "a.exr"], "the contact sheet is a png"),
    ] {
        let failed = run(arguments);
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!((failed.status.code(), message.lines().count()), (Some(2), 1), "{message}");
        assert!(message.contains(expected), "{message}");
    }
}
