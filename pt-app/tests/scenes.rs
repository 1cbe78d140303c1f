//! `pt scenes` and `pt sheet`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use pt_image::image_file::{LinearImage, PixelLayout, write_png};
use serde_json::Value;

fn pt(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pt")).current_dir(folder).args(args).output().unwrap()
}

fn succeeds(folder: &Path, args: &[&str]) -> String {
    let done = pt(folder, args);
    assert!(done.status.success(), "{args:?}: {done:?}");
    String::from_utf8(done.stdout).unwrap()
}

/// Exit code 2 and one line with all of `parts`; what was printed before it.
fn refused(folder: &Path, args: &[&str], parts: &[&str]) -> String {
    let done = pt(folder, args);
    let message = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(2), "{args:?}: {message}");
    assert!(message.starts_with("error: ") && message.lines().count() == 1, "{message}");
    assert!(parts.iter().all(|part| message.contains(part)), "no {parts:?} in {message}");
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn statistics_of_a_built_in_scene() {
    let folder = tempfile::tempdir().unwrap();
    let text = succeeds(folder.path(), &["scenes", "--stats", "glass"]);
    for part in ["glass", "3 solid transmission", "1 absorbing", "emissive table", "camera", "512"] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
    let line = ["scenes", "--stats", "lamps", "--json", "--clusters", "100"];
    let json: Value = serde_json::from_str(&succeeds(folder.path(), &line)).unwrap();
    assert_eq!(json["scene"], "lamps");
    assert_eq!(json["triangles"]["emissive"], 936);
    assert_eq!(json["clusters"]["count"], 100);
    assert_eq!(json["cameras"][1]["path_s"], 15.0);
    assert_eq!(json["lights"][0]["kind"], "emissive");
    assert!(json["lights"][0]["power_w"].as_f64().unwrap() > 1.0);
    let list: Value = serde_json::from_str(&succeeds(folder.path(), &["scenes", "--json"])).unwrap();
    assert!(list.as_array().unwrap().iter().any(|s| s["name"] == "veach" && s["cameras"][0] == "front"));
}

#[test]
fn statistics_tell_extensions_apart() {
    let folder = tempfile::tempdir().unwrap();
    let file = |required: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_materials_ior","EXT_nothing"],
            "extensionsRequired":[{required}],"scenes":[{{"nodes":[]}}]}}"#
        )
    };
    fs::write(folder.path().join("used.gltf"), file("")).unwrap();
    let line = |name: &str| ["scenes", "--stats", name, "--json"].map(str::to_owned);
    let run = |args: &[String; 4]| args.iter().map(String::as_str).collect::<Vec<_>>().join(" ");
    let args = line("used.gltf");
    let text = succeeds(folder.path(), &run(&args).split(' ').collect::<Vec<_>>());
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["extensions"][0]["status"], "supported");
    assert_eq!(json["extensions"][1]["status"], "ignored");
    assert_eq!((&json["bounds"], &json["triangles"]["stored"]), (&Value::Null, &Value::from(0)));
    fs::write(folder.path().join("required.gltf"), file("\"EXT_nothing\"")).unwrap();
    let text = refused(
        folder.path(),
        &["scenes", "--stats", "required.gltf", "--json"],
        &["required.gltf", "EXT_nothing"],
    );
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&json["extensions"][1]["status"], &json["extensions"][1]["required"]),
        (&"refused".into(), &true.into())
    );
    let text = refused(folder.path(), &["scenes", "--stats", "required.gltf"], &["EXT_nothing"]);
    assert!(text.contains("EXT_nothing: refused, required"), "{text}");
    // The same in a binary container, and files that are none.
    let mut glb = b"glTF".to_vec();
    let mut json = file("\"EXT_nothing\"").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    for word in [2, 20 + json.len() as u32, json.len() as u32, 0x4e4f_534a] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(json);
    fs::write(folder.path().join("a.glb"), &glb).unwrap();
    let text = refused(folder.path(), &["scenes", "--stats", "a.glb"], &["EXT_nothing"]);
    assert!(text.contains("KHR_materials_ior: supported"), "{text}");
    for (length, name) in [(0, "empty.glb"), (14, "short.glb"), (40, "cut.glb")] {
        fs::write(folder.path().join(name), &glb[..length]).unwrap();
        assert_eq!(refused(folder.path(), &["scenes", "--stats", name], &[name]), "");
    }
    assert_eq!(refused(folder.path(), &["scenes", "--stats", "cornel"], &["neither a file nor"]), "");
    refused(folder.path(), &["scenes", "--stats", "cornell", "--clusters", "5000"], &["5000", "4096"]);
}

#[test]
fn statistics_take_the_options_of_reading_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // Two triangles' worth of scenes, and a variant of the material.
    let positions = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
    fs::write(at.join("a.bin"), positions).unwrap();
    fs::write(
        at.join("a.gltf"),
        r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_materials_variants"],
        "extensions":{"KHR_materials_variants":{"variants":[{"name":"bright"}]}},
        "scenes":[{"nodes":[0],"name":"one"},{"nodes":[0,1],"name":"two"}],"nodes":[{"mesh":0},{"mesh":0,"translation":[2,0,0]}],
        "materials":[{},{"emissiveFactor":[1,1,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0,
          "extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[0]}]}}}]}],
        "buffers":[{"uri":"a.bin","byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#,
    )
    .unwrap();
    let stats = |more: &[&str]| -> Value {
        let line = [&["scenes", "--stats", "a.gltf", "--json"], more].concat();
        serde_json::from_str(&succeeds(at, &line)).unwrap()
    };
    let plain = stats(&[]);
    assert_eq!((&plain["instances"], &plain["triangles"]["emissive"]), (&1.into(), &0.into()));
    let chosen = stats(&["--gltf-scene", "two", "--variant", "bright"]);
    assert_eq!((&chosen["instances"], &chosen["triangles"]["emissive"]), (&2.into(), &2.into()));
    assert_eq!(chosen["bounds"][1][0], 3.0);
    let stats = ["scenes", "--stats", "a.gltf"];
    let with = |more: &[&'static str]| [&stats[..], more].concat();
    refused(at, &with(&["--env", "sky.hdr"]), &["sky.hdr"]);
    refused(at, &with(&["--variant", "dark"]), &["a.gltf", "dark", "bright"]);
    refused(
        at,
        &with(&["--max-geometry-bytes", "100"]),
        &["a.gltf: meshes[0].primitives[0]: more than 100 bytes", "--max-geometry-bytes"],
    );
    refused(at, &["scenes", "--variant", "bright"], &["--stats"]);
}

#[test]
fn sheets_have_a_tile_for_each_image() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let flat = |name: &str, width: u32, height: u32, color: [u8; 3]| {
        let pixels: Vec<u8> = color.iter().copied().cycle().take((3 * width * height) as usize).collect();
        write_png(&at.join(name), width, height, PixelLayout::Rgb, &pixels).unwrap();
    };
    flat("red.png", 100, 50, [200, 0, 0]);
    flat("green.png", 7, 9, [0, 200, 0]);
    fs::write(at.join("refused.txt"), "error: it cannot be shown\n").unwrap();
    let line =
        ["sheet", "red.png", "green.png", "refused.txt", "-o", "s.png", "--columns", "2", "--tile", "40x30"];
    assert!(succeeds(at, &line).contains("3 tiles"));
    let sheet = LinearImage::read(&at.join("s.png")).unwrap();
    assert_eq!((sheet.width, sheet.height), (2 * 44 + 4, 2 * (30 + 10 + 4) + 4));
    let pixel = |x: u32, y: u32| sheet.pixels[(y * sheet.width + x) as usize].map(|c| c > 0.2);
    // Shrunk to 40 x 20 and centred; as it is and centred.
    assert_eq!(pixel(24, 19), [true, false, false]);
    assert_eq!(pixel(24, 7), [false; 3]);
    assert_eq!(pixel(48 + 20, 19), [false, true, false]);
    assert_eq!(pixel(48 + 20, 27), [false; 3]);
    // Labels, and the text of the third tile.
    let lit = |x: u32, y: u32, w: u32, h: u32| (0..w * h).filter(|i| pixel(x + i % w, y + i / w)[0]).count();
    assert!(
        lit(4, 34, 40, 10) > 15 && lit(4, 48, 40, 30) > 60,
        "{} {}",
        lit(4, 34, 40, 10),
        lit(4, 48, 40, 30)
    );
    let again = fs::read(at.join("s.png")).unwrap();
    succeeds(at, &line);
    assert_eq!(fs::read(at.join("s.png")).unwrap(), again);

    refused(at, &["sheet", "blue.png", "-o", "t.png"], &["blue.png"]);
    refused(at, &["sheet", "red.png", "-o", "t.exr"], &["t.exr", "PNG"]);
    refused(at, &["sheet", "red.png", "-o", "t.png", "--tile", "16384x16384"], &["16392", "out of range"]);
    refused(at, &["sheet", "-o", "t.png"], &["IMAGES"]);
    assert!(!at.join("t.png").exists());
}
