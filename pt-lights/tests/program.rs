//! The stage program: rows, pictures and messages.

use std::path::Path;
use std::process::{Command, Output};

fn pt_lights(arguments: &str, folder: &Path) -> Output {
    let arguments: Vec<_> = arguments.split_whitespace().collect();
    Command::new(env!("CARGO_BIN_EXE_pt-lights")).args(arguments).current_dir(folder).output().unwrap()
}

const SHORT: &str = "--width 32 --runs 2 --frames 2 --reference-spp 16 --backend compute";

#[test]
fn samplers_are_ranked() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!("lamps --samplers power,cluster-stats --json rows.json --heatmaps maps {SHORT}");
    let done = pt_lights(&line, folder.path());
    assert!(done.status.success(), "{done:?}");
    let rows: Vec<serde_json::Value> =
        serde_json::from_slice(&std::fs::read(folder.path().join("rows.json")).unwrap()).unwrap();
    assert_eq!(
        rows.iter().map(|r| r["sampler"].as_str().unwrap()).collect::<Vec<_>>(),
        ["power", "cluster-stats"]
    );
    for row in &rows {
        for field in
            ["mean_ratio", "relmse_equal_samples", "relmse_equal_time", "gpu_ms", "bytes", "rays_per_pixel"]
        {
            assert!(row[field].is_number(), "{field}: {row}");
        }
        let [low, high] = [0, 1].map(|i| row["ci"][i].as_f64().unwrap());
        let error = row["relmse_equal_samples"].as_f64().unwrap();
        assert!(low < error && error < high, "{row}");
        let rays = row["rays_per_pixel"].as_f64().unwrap();
        assert!(rays > 0.2 && rays <= 1.0, "{row}");
        let sampler = row["sampler"].as_str().unwrap();
        for name in [format!("maps/{sampler}.png"), format!("maps/{sampler}-error.png")] {
            assert!(folder.path().join(&name).is_file(), "{name}");
        }
    }
    // Even two frames tell these two apart.
    let error = |i: usize| rows[i]["relmse_equal_samples"].as_f64().unwrap();
    assert!(error(1) < 0.5 * error(0), "{rows:?}");
    assert_eq!(rows[0]["bytes"], 0);
    assert!(rows[1]["bytes"].as_u64().unwrap() > 0);
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
        ("lamps --set lights.nothing=1", "lights.nothing"),
    ] {
        let failed = pt_lights(line, folder.path());
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(failed.status.code(), Some(2), "{line}: {message}");
        assert!(message.contains(expected), "{line}: {message}");
    }
}
