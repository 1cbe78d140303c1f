//! The stage program on a capture.

use pt_core::image_file::{Channel, Layer, LayeredImage, Samples};
use std::process::{Command, Output};

fn capture() -> LayeredImage {
    let floats = |name: &str, values: &[f32]| Layer {
        name: name.into(),
        channels: (values.iter().zip(["X", "Y", "Z", "W"]))
            .map(|(&v, name)| Channel { name: name.into(), samples: Samples::F32(vec![v, v]) })
            .collect(),
    };
    let words = |name: &str, x: u32, y: u32| Layer {
        name: name.into(),
        channels: ([("X", x), ("Y", y)])
            .map(|(name, v)| Channel { name: name.into(), samples: Samples::U32(vec![v, v]) })
            .into(),
    };
    let mut image = LayeredImage::new(2, 1).unwrap();
    image.layers = vec![
        floats("color_hf", &[2.0, 2.0, 2.0, 0.0]),
        floats("color_spec", &[10.0, 10.0, 10.0, 0.0]),
        floats("base_color", &[1.0, 1.0, 0.0, 1.0]),
        floats("metallic_roughness", &[0.0, 0.5]),
        floats("shading_position", &[0.0, 0.0, 0.0, f32::from_bits(1)]),
        floats("throughput", &[0.5, 0.5, 0.5, 0.0]),
        floats("transparent", &[0.0, 0.0, 3.0, 0.0]),
        words("view_direction", u32::MAX, 4),
    ];
    image
}

#[test]
fn composites_a_capture() {
    let folder = tempfile::tempdir().unwrap();
    let run = |image: &LayeredImage, set: &[&str]| -> Output {
        image.write_exr(&folder.path().join("capture.exr")).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt-denoise"));
        program.current_dir(folder.path()).args(["capture.exr", "-o", "out.exr"]);
        program.args(set.iter().flat_map(|s| ["--set", *s])).output().unwrap()
    };
    let done = run(&capture(), &[]);
    assert!(done.status.success(), "{done:?}");
    let out = LayeredImage::read_exr(&folder.path().join("out.exr")).unwrap();
    for (name, want) in [("R", 1.2f32), ("G", 1.2), ("B", 3.2), ("A", 4.0)] {
        let got = out.channel("", name).unwrap().to_f32();
        assert!(got.iter().all(|v| (v - want).abs() < 1e-5), "{name}: {got:?}, expected {want}");
    }

    // The words by themselves, as AOV files have them.
    let mut aov = capture();
    for (layer, from, to, value) in
        [("shading_position", "W", "material", 0), ("view_direction", "Y", "flags", 2)]
    {
        let layer = aov.layers.iter_mut().find(|l| l.name == layer).unwrap();
        layer.channels.retain(|c| c.name != from);
        layer.channels.push(Channel { name: to.into(), samples: Samples::U32(vec![value; 2]) });
    }
    assert!(run(&aov, &[]).status.success());
    let out = LayeredImage::read_exr(&folder.path().join("out.exr")).unwrap();
    let pixel = ["R", "G", "B", "A"].map(|name| out.channel("", name).unwrap().to_f32()[1]);
    assert_eq!(pixel, [0.0, 0.0, 3.0, 2.0], "no surface: the transparent layer alone");

    let mut partial = capture();
    partial.layers.retain(|layer| layer.name != "throughput");
    let missing = String::from_utf8(run(&partial, &[]).stderr).unwrap();
    assert!(missing.contains("capture.exr: no layer \"throughput\""), "{missing}");
    let unknown = String::from_utf8(run(&capture(), &["scale_sepc=0"]).stderr).unwrap();
    assert!(unknown.contains("closest: \"scale_spec\""), "{unknown}");
}
