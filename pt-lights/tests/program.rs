//! The stage program: rows, pictures and messages.

use std::path::Path;
use std::process::{Command, Output};

fn pt_lights(arguments: &str, folder: &Path) -> Output {
    let arguments: Vec<_> = arguments.split_whitespace().collect();
    Command::new(env!("CARGO_BIN_EXE_pt-lights")).args(arguments).current_dir(folder).output().unwrap()
}

const SHORT: &str =
    "--width 32 --runs 2 --frames 2 --warm-up 2 --reference-spp 16 --backend compute --ray-rate 100";

fn rows(path: &Path) -> Vec<serde_json::Value> {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn samplers_are_ranked() {
    let folder = tempfile::tempdir().unwrap();
    let files = "--json rows.json --heatmaps maps --figure f.svg --markdown table.md --blocks";
    let done = pt_lights(&format!("lamps --samplers {RANKED} {files} {SHORT}"), folder.path());
    assert!(done.status.success(), "{done:?}");
    let rows = rows(&folder.path().join("rows.json"));
    let names: Vec<_> = rows.iter().map(|r| r["sampler"].as_str().unwrap()).collect();
    assert_eq!(names.join(","), RANKED);
    let figure = std::fs::read_to_string(folder.path().join("f.svg")).unwrap();
    let table = std::fs::read_to_string(folder.path().join("table.md")).unwrap();
    let printed = String::from_utf8(done.stdout).unwrap();
    for row in &rows {
        for field in FIELDS {
            assert!(row[field].is_number(), "{field}: {row}");
        }
        let curve = row["curve"].as_array().unwrap();
        assert_eq!((curve[0]["frames"].as_u64(), curve[1]["frames"].as_u64()), (Some(1), Some(2)));
        // The error of the mean of all frames is a point of the curve.
        assert_eq!(curve[1]["relmse"], row["relmse_equal_samples"]);
        let share = row["mrays_per_s"].as_f64().unwrap() / 100.0;
        assert!((row["ray_rate_share"].as_f64().unwrap() / share - 1.0).abs() < 1e-9);
        let [low, high] = [0, 1].map(|i| row["ci"][i].as_f64().unwrap());
        let error = row["relmse_equal_samples"].as_f64().unwrap();
        assert!(low < error && error < high, "{row}");
        let rays = row["rays_per_pixel"].as_f64().unwrap();
        // The sum of both kinds of light; lamps has one.
        assert!(rays > 0.2 && rays <= 1.0, "{row}");
        let sampler = row["sampler"].as_str().unwrap();
        assert!(figure.contains(sampler) && table.contains(sampler), "{sampler}: {table}");
        assert_eq!(printed.matches(sampler).count(), 3, "errors, costs and blocks: {printed}");
        for name in [format!("maps/{sampler}.png"), format!("maps/{sampler}-error.png")] {
            assert!(folder.path().join(&name).is_file(), "{name}");
        }
    }
    // Even two frames tell these two apart.
    let error = |i: usize| rows[i]["relmse_equal_samples"].as_f64().unwrap();
    assert!(error(2) < 0.5 * error(1), "{rows:?}");
    assert_eq!(rows[1]["bytes"], 0);
    assert!(rows[2]["bytes"].as_u64().unwrap() > 0);
}

/// The baseline, and samplers without and with tables.
const RANKED: &str = "per-kind,power,cluster-stats";

const FIELDS: [&str; 22] = [
    "mean_ratio",
    "relmse_one_frame",
    "relmse_one_frame_equal_time",
    "relmse_equal_samples",
    "relmse_equal_time",
    "frames_equal_time",
    "effective_frames",
    "variance",
    "gpu_ms",
    "choose_gpu_ms",
    "build_ms",
    "bytes",
    "rays_per_pixel",
    "arrived",
    "mrays_per_s",
    "ray_rate_share",
    "duplicates",
    "candidates",
    "warm_up",
    "blocks",
    "blocks_within",
    "blocks_largest",
];

/// A comparison with another number of candidates is noted, one with another number of samples is refused.
#[test]
fn unequal_comparisons_are_noted_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let run = |samplers: &str| {
        let done = pt_lights(&format!("cornell --samplers {samplers} {SHORT}"), folder.path());
        (done.status.code(), String::from_utf8(done.stderr).unwrap())
    };
    let (code, message) = run("ris,ris:ris_candidates=2");
    assert_eq!(code, Some(0), "{message}");
    assert!(message.contains("numbers of candidates differ: ris 8, ris:ris_candidates=2 2"), "{message}");
    let (code, message) = run("power,uniform:samples=4");
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("power takes 1 samples a pixel and uniform:samples=4 takes 4"), "{message}");
    let (_, message) = run("power,ris");
    assert!(!message.contains("differ"), "{message}");
}

/// Reuse makes frames alike: the mean of a run is worth fewer frames than it has, where that of independent frames is worth about all.
#[test]
fn correlated_frames_are_worth_less() {
    let folder = tempfile::tempdir().unwrap();
    // Without the neighbours, only the history makes samples alike.
    let samplers = "ris,restir-di:restir_spatial=0,restir-di";
    let longer = SHORT.replace("--frames 2", "--frames 8").replace("--runs 2", "--runs 3");
    let line = format!("lamps --samplers {samplers} --json rows.json {longer}");
    let done = pt_lights(&line, folder.path());
    assert!(done.status.success(), "{done:?}");
    let rows = rows(&folder.path().join("rows.json"));
    let of = |i: usize, field: &str| rows[i][field].as_f64().unwrap();
    assert!(of(0, "effective_frames") > 5.0 && of(0, "effective_frames") < 12.0, "{rows:?}");
    assert!(of(1, "effective_frames") < 0.5 * of(0, "effective_frames"), "{rows:?}");
    assert!(of(1, "relmse_one_frame") < of(0, "relmse_one_frame"), "{rows:?}");
    // Neighbours share samples, although each makes another point of the lamp of them.
    assert!(of(2, "duplicates") > of(0, "duplicates") + 0.05, "{rows:?}");
}

/// Lamps that hang in a scene; the means of blocks are those of the reference, and without the light of triangles they are not.
#[test]
fn blocks_agree_with_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let size = "--width 48 --runs 16 --frames 4 --warm-up 4 --reference-spp 512 --budget 1 --backend compute --ray-rate 100";
    let samplers = "light-bvh,cluster-stats,light-bvh:emissive=false";
    let files = "--json rows.json --markdown table.md";
    let done = pt_lights(
        &format!("cornell --lamps 40 --blocks --samplers {samplers} {files} {size}"),
        folder.path(),
    );
    assert!(done.status.success(), "{done:?}");
    assert!(String::from_utf8(done.stdout).unwrap().starts_with("cornell with 40 lamps, 48x27"));
    let table = std::fs::read_to_string(folder.path().join("table.md")).unwrap();
    assert!(table.contains("blocks within 3 s.e."), "{table}");
    let rows = rows(&folder.path().join("rows.json"));
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["blocks"], 18, "{row}");
        let within = row["blocks_within_3se"].as_f64().unwrap();
        // 0.3 % of the means of independent runs are farther away.
        assert!(if i < 2 { within > 0.9 } else { within < 0.1 }, "{row}");
    }
}

/// Gradient pixels repeat the samples of those samplers that claim it, and only of those.
#[test]
fn replayed_frames_are_those_before() {
    let folder = tempfile::tempdir().unwrap();
    let size = "--width 32 --frames 3 --warm-up 2 --backend compute";
    let line =
        format!("lamps --replay --samplers per-kind,light-bvh,cluster-stats,nee-at --json rows.json {size}");
    let done = pt_lights(&line, folder.path());
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let rows = rows(&folder.path().join("rows.json"));
    for row in &rows {
        let claims = row["sampler"] != "nee-at";
        assert_eq!(
            (row["claims_replay"].as_bool(), row["bit_equal"].as_bool()),
            (Some(claims), Some(claims)),
            "{row}"
        );
        assert!(row["texels_lit"].as_u64().unwrap() > 50, "{row}");
        // Without the replay the light is another one.
        assert!(row["differ_without_replay"].as_f64().unwrap() > 0.1, "{row}");
        assert_eq!(row["texels_differ"].as_u64().unwrap() == 0, claims, "{row}");
    }
}

/// A room with a window: samples of the sky that go through it take noise away.
#[test]
fn portals_pay_in_the_room_with_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let samplers = "power:portal_share=0,power:portal_share=0.5";
    let longer = SHORT.replace("--frames 2", "--frames 8").replace("-spp 16", "-spp 64");
    let done = pt_lights(
        &format!(
            "window --samplers {samplers} --set lights.emissive=false --set lights.cosine_share=0 --json rows.json {longer}"
        ),
        folder.path(),
    );
    assert!(done.status.success(), "{done:?}");
    let rows = rows(&folder.path().join("rows.json"));
    let error = |i: usize| rows[i]["relmse_one_frame"].as_f64().unwrap();
    assert!(error(0) > 3.0 * error(1), "{} {}", error(0), error(1));
}

#[test]
fn changes_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let short = SHORT.replace(" --ray-rate 100", "").replace("--frames 2", "--frames 6");
    let files = "--json rows.json --markdown table.md";
    let line = format!("flicker --change 0.6:0.85 --samplers power,nee-at {files} {short}");
    let done = pt_lights(&line, folder.path());
    assert!(done.status.success(), "{done:?}");
    let table = std::fs::read_to_string(folder.path().join("table.md")).unwrap();
    assert!(table.contains("| frames until settled |") && table.contains("| `nee-at` |"), "{table}");
    let rows = rows(&folder.path().join("rows.json"));
    for row in &rows {
        assert_eq!(row["relmse_frames"].as_array().unwrap().len(), 6, "{row}");
        // The light that has gone on is there in the first frame.
        let [low, high] = [0, 1].map(|i| row["mean_ratio_first_frame_ci"][i].as_f64().unwrap());
        assert!(low < 1.1 && high > 0.9, "{row}");
        assert!(row["relmse_steady"].as_f64().unwrap() > 0.0, "{row}");
    }
    assert_eq!(rows[0]["frames_to_settle"], 0, "a sampler without history: {rows:?}");
}

#[test]
fn costs_of_many_lights_are_timed() {
    let folder = tempfile::tempdir().unwrap();
    let line =
        "--lights-sweep 64,1024 --samplers power,cluster-cdf --width 16 --json rows.json --markdown table.md";
    let done = pt_lights(line, folder.path());
    assert!(done.status.success(), "{done:?}");
    let table = std::fs::read_to_string(folder.path().join("table.md")).unwrap();
    assert!(table.starts_with("| sampler | 64 | 1024 | ratio |") && table.lines().count() == 4, "{table}");
    let rows = rows(&folder.path().join("rows.json"));
    let seen: Vec<_> =
        rows.iter().map(|r| (r["lights"].as_u64().unwrap(), r["sampler"].as_str().unwrap())).collect();
    assert_eq!(seen, [(64, "power"), (64, "cluster-cdf"), (1024, "power"), (1024, "cluster-cdf")]);
    for row in &rows {
        let [all, choice] = ["gpu_ms", "choose_gpu_ms"].map(|field| row[field].as_f64().unwrap());
        // Shadow rays are the larger part on a CPU, and a part of neither is nothing.
        assert!(choice > 0.0 && choice < all, "{row}");
    }
    assert!(String::from_utf8(done.stdout).unwrap().contains("GPU ms with 1024 lights over that with 64"));
}

/// No light, and light without local lights.
#[test]
fn scenes_without_local_lights_run() {
    let folder = tempfile::tempdir().unwrap();
    let done =
        pt_lights(&format!("furnace --samplers uniform,ris,light-bvh,cluster-stats {SHORT}"), folder.path());
    assert!(done.status.success(), "{done:?}");
}

#[test]
fn wrong_arguments_are_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (line, expected) in [
        ("lamps --samplers none", "none"),
        ("nothing-there", "nothing-there"),
        ("lamps --camera 99", "--camera 99: the scene has 2 cameras"),
        ("lamps --budget 0", "--budget: 0 is not a time"),
        ("lamps --ray-rate -1", "--ray-rate"),
        ("lamps --samplers ris:nothing=1", "lights.nothing"),
        ("lamps --samplers ris:ris_candidates=99", "ris_candidates"),
        ("flicker --change 1", "BEFORE:AFTER"),
        ("flicker --change 0:1 --blocks", "--blocks"),
        ("--lights-sweep 0", "0 is not a number of lights"),
        ("lamps --figure no/such/folder/f.svg", "no/such/folder"),
        ("lamps --set lights.nothing=1", "lights.nothing"),
    ] {
        let failed = pt_lights(line, folder.path());
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(failed.status.code(), Some(2), "{line}: {message}");
        assert!(message.contains(expected), "{line}: {message}");
    }
}
