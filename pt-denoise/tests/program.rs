//! The stage program on captures.

use pt_core::capture::read_layer;
use pt_core::harness::save;
use pt_core::test_support::{TestDevice, channel_images, record_folder};
use pt_core::{ChannelImages, Recorder};
use pt_core::{FrameSizes, SplitLight, StageInputs};
use pt_denoise::{Composite, DenoiseParams};
use pt_image::image_file::{Channel, Layer, LayeredImage, Samples};
use pt_shaders::channels::{
    BASE_COLOR, BOUNCE_THROUGHPUT, COLOR, COLOR_HF, COLOR_SPEC, ChannelId, METALLIC_ROUGHNESS, MOTION,
    NORMAL, SHADING_POSITION, THROUGHPUT, TRANSPARENT, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};
use std::path::Path;
use std::process::{Command, Output};

fn pt_denoise(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pt-denoise")).current_dir(folder).args(arguments).output().unwrap()
}

/// Two pixels alike, written out component by component.
fn capture() -> LayeredImage {
    let floats = |name: &str, names: &str, values: &[f32]| Layer {
        name: name.into(),
        channels: (values.iter().zip(names.chars()))
            .map(|(&v, name)| Channel { name: name.into(), samples: Samples::F32(vec![v, v]) })
            .collect(),
    };
    let with = |mut layer: Layer, name: &str, word: u32| {
        layer.channels.push(Channel { name: name.into(), samples: Samples::U32(vec![word, word]) });
        layer
    };
    let mut image = LayeredImage::new(2, 1).unwrap();
    image.layers = vec![
        floats("color_hf", "RGBA", &[2.0, 2.0, 2.0, 0.0]),
        floats("color_spec", "RGBA", &[10.0, 10.0, 10.0, 0.0]),
        floats("base_color", "RGBA", &[1.0, 1.0, 0.0, 0.04]),
        floats("metallic_roughness", "XY", &[0.0, 0.5]),
        with(floats("shading_position", "XYZ", &[0.0; 3]), "material", 1),
        floats("throughput", "RGBA", &[0.5, 0.5, 0.5, 0.0]),
        floats("transparent", "RGBA", &[0.0, 0.0, 3.0, 0.0]),
        with(floats("view_direction", "XYZ", &[0.0, 0.0, -1.0]), "flags", 4),
    ];
    image
}

#[test]
fn composites_a_capture() {
    let folder = tempfile::tempdir().unwrap();
    let run = |image: &LayeredImage, set: &[&str]| -> Output {
        image.write_exr(&folder.path().join("capture.exr")).unwrap();
        let sets = ["variant=off"].iter().chain(set).flat_map(|s| ["--set", *s]);
        pt_denoise(
            folder.path(),
            &["capture.exr", "-o", "out.exr", "--frames", "2"].into_iter().chain(sets).collect::<Vec<_>>(),
        )
    };
    let output = || LayeredImage::read_exr(&folder.path().join("out.exr")).unwrap();
    let done = run(&capture(), &[]);
    assert!(done.status.success(), "{done:?}");
    let table = String::from_utf8(done.stdout).unwrap();
    assert!(table.contains("2x1, 2 frames after 4 to warm up"), "{table}");
    assert!(
        table.contains("median ms") && table.contains("GB/s") && table.contains("\ncomposite "),
        "{table}"
    );
    for (name, want) in [("R", 1.2f32), ("G", 1.2), ("B", 3.2), ("A", 4.0)] {
        let got = output().channel("color", name).unwrap().to_f32();
        // F0 of 0.04 has 16 bits, the light is 10.
        assert!(got.iter().all(|v| (v - want).abs() < 1e-4), "{name}: {got:?}, expected {want}");
    }
    assert_eq!(output().channel("", "R"), output().channel("color", "R"), "the main layer shows the colour");

    assert!(run(&capture(), &["scale_hf=0", "scale_spec=0"]).status.success());
    assert_eq!(output().channel("color", "B").unwrap().to_f32(), [3.0, 3.0]);

    let mut partial = capture();
    partial.layers.retain(|layer| layer.name != "throughput");
    let mut half = capture();
    half.layers[4].channels.retain(|component| component.name != "material");
    for (image, set, expected) in [
        (&partial, "scale_hf=1", "capture.exr: no layer \"throughput\""),
        (&half, "scale_hf=1", "layer \"shading_position\" has no uint component \"material\""),
        (&capture(), "scale_sepc=0", "closest: \"scale_spec\""),
    ] {
        let failed = run(image, &[set]);
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!(failed.status.code(), Some(2), "{message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
    for arguments in
        [&["capture.exr", "-o", "out.png"][..], &["capture.exr", "--frames", "0"], &["none.exr"], &[]]
    {
        let failed = pt_denoise(folder.path(), arguments);
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!((failed.status.code(), message.lines().count()), (Some(2), 1), "{message}");
    }
}

/// What a frame wrote is what the program computes from the frame's capture, bit by bit, also at odd widths.
#[test]
fn replays_a_frame() {
    let device = TestDevice::open();
    let reads = [SplitLight::UNFILTERED.reads, Composite::IO.reads].concat();
    let images =
        ChannelImages::alone(&device, FrameSizes::same([33, 18]), &[SplitLight::UNFILTERED, Composite::IO])
            .unwrap();
    let texels = images.current(COLOR).extent().iter().product::<u32>();
    let fill = |id: ChannelId, scale: f32| {
        let count = texels * id.channel().format.components();
        let values: Vec<f32> = (0..count).map(|i| scale * ((i * 7919) % 6007) as f32 / 6007.0).collect();
        images.current(id).write_f32(&values).unwrap();
    };
    for id in [BASE_COLOR, METALLIC_ROUGHNESS, THROUGHPUT, TRANSPARENT] {
        fill(id, 1.0);
    }
    fill(COLOR_HF, 30.0);
    fill(COLOR_SPEC, 1e4);
    let positions: Vec<u32> = (0..texels).flat_map(|i| [1.5f32.to_bits(), 2, 3, i % 4]).collect();
    images
        .current(SHADING_POSITION)
        .write(&positions.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>())
        .unwrap();
    let directions: Vec<u32> = (0..texels).flat_map(|i| [0x1234_5678, 1 + i % 7]).collect();
    images.current(VIEW_DIRECTION).write_u32(&directions).unwrap();

    let stage = Composite::new(&device).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    stage
        .record(
            &mut frame,
            &StageInputs::new(&images),
            SplitLight::unfiltered(&images),
            &DenoiseParams::default(),
        )
        .unwrap();
    frame.submit().unwrap();

    let folder = tempfile::tempdir().unwrap();
    let metadata = [("seed".to_owned(), "7".to_owned())].into();
    save(&folder.path().join("in.exr"), &device, &images, &reads, metadata).unwrap();
    let done =
        pt_denoise(folder.path(), &["in.exr", "--set", "variant=off", "-o", "out.exr", "--frames", "1"]);
    assert!(done.status.success(), "{done:?}");
    let out = LayeredImage::read_exr(&folder.path().join("out.exr")).unwrap();
    let sorted = |mut layer: Layer| {
        layer.channels.sort_by(|a, b| a.name.cmp(&b.name));
        layer
    };
    let replayed = sorted(out.layer("color").unwrap().clone());
    assert_eq!(replayed, sorted(read_layer(&images, COLOR).unwrap().0));
    assert!(out.channel("color", "R").unwrap().to_f32().iter().any(|&v| v > 1.0), "the frame is not black");
    assert_eq!(out.metadata["seed"], "7");
    assert!(out.metadata.contains_key("driver"));
}

/// Three recorded frames of a wall under noise whose mean is 1 and albedo 0.5.
fn record_wall(folder: &Path, size: [u32; 2]) {
    let device = TestDevice::open();
    let ids = [
        (COLOR_HF, [0.0; 4]),
        (COLOR_SPEC, [0.0; 4]),
        (BASE_COLOR, [0.5, 0.5, 0.5, 0.04]),
        (METALLIC_ROUGHNESS, [0.0, 0.5, 0.0, 0.0]),
        (SHADING_POSITION, [1.0, 2.0, 3.0, f32::from_bits(1)]),
        (VIEW_DEPTH, [3.0, 0.0, 0.0, 0.0]),
        (MOTION, [0.0, 0.0, 0.0, 100.0]),
        (THROUGHPUT, [1.0, 1.0, 1.0, 0.0]),
        (BOUNCE_THROUGHPUT, [1.0, 1.0, 1.0, 0.001]),
        (TRANSPARENT, [0.0; 4]),
        (NORMAL, [0.0; 4]),
        (VERTEX_NORMAL, [0.0; 4]),
        (VIEW_DIRECTION, [0.0; 4]),
    ];
    let images = channel_images(&device, size, ids.map(|(id, _)| id));
    for (id, texel) in ids {
        let format = id.channel().format;
        let texels = images.current(id).extent().iter().product::<u32>();
        let repeated = |words: &[u32]| (0..texels).flat_map(|_| words.to_vec()).collect::<Vec<u32>>();
        if id == NORMAL || id == VERTEX_NORMAL {
            images.current(id).write_u32(&repeated(&[0x8000_8000])).unwrap();
        } else if id == VIEW_DIRECTION {
            images.current(id).write_u32(&repeated(&[0x8000_8000, 1])).unwrap();
        } else {
            let texel = &texel[..format.components() as usize];
            let sample = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32;
            let noisy = |i: u32| if id == COLOR_HF { vec![sample(i); 4] } else { texel.to_vec() };
            let values: Vec<f32> = (0..texels).flat_map(noisy).collect();
            images.current(id).write_f32(&values).unwrap();
        }
    }
    record_folder(folder, &images, 4..7);
    for frame in 4..7 {
        let mut truth = LayeredImage::new(size[0], size[1]).unwrap();
        // Hardly anything to see, but detail to compare with.
        let pixels: Vec<f32> = (0..3 * size[0] * size[1]).map(|i| 0.5 + 1e-3 * (i / 3 % 2) as f32).collect();
        truth.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &pixels));
        truth.write_exr(&folder.join(format!("reference_{frame:06}.exr"))).unwrap();
    }
}

#[test]
fn variants_run_side_by_side_on_a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    record_wall(&folder.path().join("wall"), [32, 18]);
    let line =
        "wall --variant off,accumulate,svgf,atrous,recurrent --reference wall --json out.jsonl --dump out";
    let done = pt_denoise(folder.path(), &line.split(' ').collect::<Vec<_>>());
    assert!(done.status.success(), "{done:?}");
    let table = String::from_utf8(done.stdout).unwrap();
    assert_eq!(table.lines().count(), 6, "{table}");
    let text = std::fs::read_to_string(folder.path().join("out.jsonl")).unwrap();
    let rows: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let variants: Vec<_> = rows.iter().map(|row| row["variant"].as_str().unwrap()).collect();
    assert_eq!(variants, ["off", "accumulate", "svgf", "atrous", "recurrent"].map(|name| [name; 3]).concat());
    for row in &rows {
        let fields: Vec<_> = row.as_object().unwrap().keys().map(String::as_str).collect();
        let mut contract = [
            "variant",
            "frame",
            "relmse",
            "flip",
            "temporal_pixel",
            "temporal_block",
            "detail_ratio",
            "energy_ratio",
            "disoccluded",
            "gpu_ms",
            "passes",
        ];
        contract.sort_unstable();
        let mut sorted = fields.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, contract);
        let energy = row["energy_ratio"].as_f64().unwrap();
        // The recorded hit distances are the light itself: dark pixels are blurred less, which the sum shows.
        let most = if row["variant"] == "recurrent" { 0.2 } else { 0.05 };
        assert!((energy - 1.0).abs() < most, "{row}");
        assert!(row["detail_ratio"].as_f64().unwrap() >= 0.0, "{row}");
        assert!(row["passes"]["composite"].as_f64().unwrap() >= 0.0, "{row}");
    }
    let error = |row: usize| rows[row]["relmse"].as_f64().unwrap();
    // The recorded frames are alike: the filter in space has to do it.
    assert!(error(8) < error(2) / 15.0 && error(11) < error(2) / 15.0, "{text}");
    assert!((error(5) - error(2)).abs() < 1e-6, "the same samples in every frame: {text}");
    for (i, row) in rows.iter().enumerate() {
        for key in ["temporal_pixel", "temporal_block"] {
            // The first frame of a variant has none before it; what stands still does not change.
            let value = row[key].as_f64();
            // Its disks turn from frame to frame.
            let most = if row["variant"] == "recurrent" { 1e-2 } else { 1e-3 };
            assert!(if i % 3 == 0 { value.is_none() } else { value.unwrap() < most }, "{key}: {row}");
        }
    }
    for (i, row) in rows.iter().enumerate() {
        // Everything was seen before.
        let apart = &row["disoccluded"];
        assert_eq!(apart.is_null(), i % 3 == 0, "{row}");
        if i % 3 > 0 {
            assert!(apart["share"] == 0.0 && apart["relmse"].is_null() && apart["flip"].is_null(), "{row}");
            let (others, all) = (apart["relmse_others"].as_f64().unwrap(), row["relmse"].as_f64().unwrap());
            assert!((others - all).abs() < 1e-4 * all.max(1e-6), "{row}");
        }
    }
    for row in &rows {
        let name = format!("{}_{:06}.exr", row["variant"].as_str().unwrap(), row["frame"].as_u64().unwrap());
        let dumped = LayeredImage::read_exr(&folder.path().join("out").join(&name)).unwrap();
        assert_eq!((dumped.width, dumped.height), (32, 18), "{name}");
        let has_history = ["svgf", "accumulate", "recurrent"].iter().any(|name| row["variant"] == *name);
        assert_eq!(dumped.layer("denoise.history_hf").is_some(), has_history, "{name}");
    }

    for (arguments, expected) in [
        ("wall --variant svg", "svgf"),
        ("wall --variant asvgf", "gradient_sample"),
        #[cfg(not(feature = "oidn"))]
        ("wall --variant oidn", "built without Open Image Denoise"),
        ("wall -o out.exr --set variant=oidn", "pt-denoise DIR --variant oidn"),
        ("wall/frame_000004.exr --variant svgf", "need a folder of pt capture"),
        ("wall --variant svgf -o out.exr", "use --dump"),
        ("wall --reference out", "has no reference_000004.exr"),
        ("wall --variant svgf --set atrous.iterations=0", "1 to 7"),
    ] {
        let failed = pt_denoise(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!((failed.status.code(), message.lines().count()), (Some(2), 1), "{arguments}: {message}");
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    // One frame of the folder through a denoiser, as before.
    let done =
        pt_denoise(folder.path(), &["wall", "-o", "one.exr", "--set", "variant=svgf", "--frames", "1"]);
    assert!(done.status.success(), "{done:?}");
    let one = LayeredImage::read_exr(&folder.path().join("one.exr")).unwrap();
    assert_eq!(one.channel("", "R"), one.channel("color", "R"), "the main layer shows the colour");
}
