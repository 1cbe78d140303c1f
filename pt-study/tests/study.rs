//! Study files, cells, and result folders, without a device.

use pt_core::knobs;
use pt_core::settings::Knobs;
use pt_study::StudyError;
use pt_study::cell::{Filter, Shard, filtered};
use pt_study::file::Study;
use pt_study::folder::{Finished, Folder};
use pt_study::merge::merge;
use pt_study::record::{CellRecord, FORMAT, StudyRecord, TimingRecord};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

knobs! {
    /// Knobs to study.
    pub struct Blur {
        /// Width.
        pub sigma: f32 = 1.0, in 0.0..=9.0;
        /// Whether it is on.
        pub enabled: bool = true;
    }
}

knobs! {
    /// A stage.
    pub struct Stages {
        /// The blur.
        pub blur: Blur;
    }
}

fn parse(text: &str) -> Result<Study, StudyError> {
    Study::parse(Path::new("a/s.toml"), text.into(), &Stages::knobs(), &["lights", "denoise"])
}

const HEAD: &str = "scenes = [\"cornell\"]\nmetrics = [\"relmse\"]\n";

fn refused(rest: &str) -> String {
    parse(&format!("{HEAD}{rest}")).unwrap_err().to_string()
}

#[test]
fn errors_have_a_place_and_the_closest_key() {
    let error = parse("scens = [\"cornell\"]\n").unwrap_err().to_string();
    assert!(error.starts_with("a/s.toml:1:1: unknown key \"scens\", closest: \"scenes\""), "{error}");
    let error = refused("[[axis]]\n  key = \"blur.sigmo\"\n  values = [1]\n");
    assert!(
        error.starts_with("a/s.toml:4:9: unknown knob \"blur.sigmo\", closest: \"blur.sigma\""),
        "{error}"
    );
    let error = refused("set = { blur.sigma = 10 }\n");
    assert!(error.starts_with("a/s.toml:3:22: blur.sigma = 10: expected 0 to 9"), "{error}");
    let error = refused("frames = 4\nmeasure = 5\n");
    assert!(error.contains(":4:11: measure: expected how many of the last frames, 1 to 4"), "{error}");
    let error = refused("sizes = [\"0x1\"]\n");
    assert!(error.contains(":3:10: size \"0x1\""), "{error}");
    let error = parse("scenes = [\n\"a\"\nmetrics").unwrap_err().to_string();
    assert!(error.starts_with("a/s.toml:3:"), "{error}");
    assert!(!error.contains('\n'), "{error}");
    // Nothing is proposed that is not spelt like what was written.
    for rest in [
        "wavelength = 3\n",
        "set = { wavelength = 3 }\n",
        "baseline = \"wavelength\"\n[[variant]]\nname = \"off\"\n",
    ] {
        let error = refused(rest);
        assert!(error.contains("\"wavelength\"") && !error.contains("closest"), "{error}");
    }
    let error = parse("scenes = [\"a\"]\nmetrics = [\"wavelength\"]\n").unwrap_err().to_string();
    assert!(error.starts_with("a/s.toml:2:12: unknown metric \"wavelength\" (there are relmse, "), "{error}");
    for (text, part) in [
        ("metrics = [\"relmse\"]\n", "has no scenes"),
        ("scenes = [\"a\"]\nmetrics = [\"relms\"]\n", "closest: \"relmse\""),
        ("scenes = []\nmetrics = [\"relmse\"]\n", "no cells"),
        ("scenes = [\"a\", \"a\"]\nmetrics = [\"relmse\"]\n", "a is twice in scenes"),
        ("scenes = [1]\nmetrics = [\"relmse\"]\n", "expected a string, got a value of type integer"),
    ] {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn contradictions_are_refused() {
    let axis = |key: &str| format!("[[axis]]\nkey = \"{key}\"\nvalues = [true, false]\n");
    let twice = format!("{0}{0}", axis("blur.enabled"));
    assert!(refused(&twice).contains("blur.enabled is set by two axes"));
    let in_set = format!("set = {{ blur.enabled = true }}\n{}", axis("blur.enabled"));
    assert!(refused(&in_set).contains("blur.enabled is an axis and in set"));
    let named =
        format!("[[variant]]\nname = \"a\"\nset = {{ blur.enabled = true }}\n{}", axis("blur.enabled"));
    assert!(refused(&named).contains("blur.enabled is set by two axes"));
    assert!(
        refused("[[variant]]\nname = \"a\"\n[[variant]]\nname = \"a\"\n")
            .contains("a is twice on the axis variant")
    );
    assert!(refused("[[axis]]\nkey = \"blur.enabled\"\nvalues = []\n").contains("no cells"));
    assert!(refused("baseline = \"of\"\n[[variant]]\nname = \"off\"\n").contains("closest: \"off\""));
    assert!(refused("[ledger]\nstages = [\"taa\"]\n").contains("expected one of lights, denoise"));
}

#[test]
fn variants_are_combinations_or_one_at_a_time() {
    let axes = "[[axis]]\nkey = \"blur.sigma\"\nvalues = [1, 2, 3]\n[[axis]]\nname = \"placebo\"\nvalues = [\"a\", \"b\"]\n";
    let names = |study: &Study| study.variants().into_iter().map(|v| v.name).collect::<Vec<_>>();
    let all = parse(&format!("{HEAD}{axes}")).unwrap();
    assert_eq!(all.variants().len(), 6);
    assert_eq!(names(&all)[1], "blur.sigma=1, placebo=b");
    let one = parse(&format!("design = \"one-at-a-time\"\n{HEAD}{axes}")).unwrap();
    assert_eq!(names(&one), ["baseline", "blur.sigma=2", "blur.sigma=3", "placebo=b"]);
    assert_eq!(one.cell_count(), 4 * 5);
    assert_eq!(one.variants()[1].set.iter().map(|s| s.assignment()).collect::<Vec<_>>(), ["blur.sigma=2"]);
    assert_eq!(one.variants()[3].set[0].value, "1", "the placebo has the values of the baseline");
    // Each list of 5000 values: far more cells than memory has bytes, counted without listing them.
    let many: String = (0..4)
        .map(|axis| {
            format!(
                "[[axis]]\nname = \"{axis}\"\nvalues = [{}]\n",
                (0..5000).map(|i| i.to_string()).collect::<Vec<_>>().join(",")
            )
        })
        .collect();
    assert_eq!(parse(&format!("{HEAD}{many}")).unwrap().cell_count(), 5 * 5000u64.pow(4));
}

#[test]
fn cells_have_names_for_files_and_seeds_of_their_own() {
    let text = "scenes = [\"cornell\", \"x/ä b.gltf\"]\nmetrics = [\"relmse\"]\nseeds = [3, 4]\n[[axis]]\nname = \"placebo\"\nvalues = [\"a\", \"b\"]\n";
    let study = parse(text).unwrap();
    let variants = study.variants();
    let cells = study.cells(&variants);
    assert_eq!(cells.len(), 8);
    assert!(cells.is_sorted_by(|a, b| a.name < b.name));
    assert!(
        cells.iter().all(|cell| cell.name.chars().all(|c| c.is_ascii_alphanumeric() || "._-=".contains(c)))
    );
    // Variants share no random numbers, and pairs of scenes do not matter.
    let seeds: BTreeSet<u64> = cells[..4].iter().map(|cell| cell.random_seed).collect();
    assert_eq!(seeds.len(), 4);
    let common = parse(&format!("pairing = \"seed\"\n{text}")).unwrap();
    assert!(common.cells(&variants).iter().all(|cell| cell.random_seed == cell.seed));

    let filter = |text: &str| -> Filter { text.parse().unwrap() };
    let kept = filtered(cells.clone(), &variants, &[filter("placebo=b"), filter("seed=3"), filter("seed=4")])
        .unwrap();
    assert_eq!(kept.len(), 4);
    let error = filtered(cells.clone(), &variants, &[filter("wavelength=b")]).unwrap_err().to_string();
    assert!(error.contains("unknown key (there are scene, "), "{error}");
    let error = filtered(cells.clone(), &variants, &[filter("placbo=b")]).unwrap_err().to_string();
    assert!(error.contains("closest: \"placebo\""), "{error}");
    assert!(
        filtered(cells.clone(), &variants, &[filter("seed=9")])
            .unwrap_err()
            .to_string()
            .contains("no cell has seed=9")
    );

    // Shards are a partition, also where there are more of them than cells.
    for count in [1, 3, 8, 11] {
        let parts: Vec<_> =
            (1..=count).flat_map(|index| Shard { index, count }.of(&cells).to_vec()).collect();
        assert_eq!(parts, cells, "{count}");
    }
    assert!(
        "0/4".parse::<Shard>().is_err() && "5/4".parse::<Shard>().is_err() && "1/0".parse::<Shard>().is_err()
    );
}

fn record(cells: usize) -> StudyRecord {
    StudyRecord {
        format: FORMAT,
        name: "s".into(),
        question: "q".into(),
        file: "text".into(),
        command: "pt study s.toml --shard 1/4 -o DIR".into(),
        version: "1".into(),
        revision: String::new(),
        device: "d".into(),
        driver: "d".into(),
        metrics: Vec::new(),
        axes: Vec::new(),
        baseline: "a".into(),
        variants: Vec::new(),
        cells,
    }
}

fn cell(number: usize, wall_s: f64) -> Finished {
    let name = format!("{number:07}");
    let cell = CellRecord {
        cell: name.clone(),
        variant: "a".into(),
        scene: "s".into(),
        camera: String::new(),
        size: [1, 1],
        backend: "auto".into(),
        seed: number as u64,
        metrics: BTreeMap::from([
            ("relmse".into(), Some(1.0 / (number as f64 + 0.1))),
            ("flip".into(), None),
        ]),
        frames: BTreeMap::new(),
        first_frame: 0,
        ledger: None,
        images: BTreeMap::new(),
        command: "c".into(),
    };
    let timing = TimingRecord { cell: name, gpu_ms: wall_s, gpu_ms_p95: 0.0, passes: Vec::new(), wall_s };
    Finished::new(cell, timing).unwrap()
}

/// What a program does with a folder: the cells of `numbers` that are not there, up to `budget` of them.
fn run(
    path: &Path,
    record: &StudyRecord,
    numbers: &[usize],
    budget: usize,
    resume: bool,
) -> Result<(), StudyError> {
    let folder = Folder::open(path, record, resume)?;
    let mut left = budget;
    let mut all = Vec::new();
    for &number in numbers {
        let name = format!("{number:07}");
        let found = match folder.finished(&name)? {
            Some(found) => found,
            None if left == 0 => return Ok(()),
            None => {
                left -= 1;
                // Times differ from run to run.
                let made = cell(number, left as f64);
                folder.keep(&made)?;
                made
            }
        };
        all.push(found);
    }
    folder.finish(&all)
}

fn results(path: &Path) -> Vec<u8> {
    fs::read(path.join("results.jsonl")).unwrap()
}

#[test]
fn a_study_that_stops_goes_on_and_shards_join() {
    let at = tempfile::tempdir().unwrap();
    let numbers: Vec<usize> = (0..13).collect();
    let whole = at.path().join("whole");
    run(&whole, &record(13), &numbers, 99, false).unwrap();
    let stopped = at.path().join("stopped");
    run(&stopped, &record(13), &numbers, 5, false).unwrap();
    assert!(!stopped.join("results.jsonl").exists());
    // A kill while a cell is written leaves a temporary file.
    fs::write(stopped.join("cells/.0000007.jsonl.x.tmp"), "{\"cell\":").unwrap();
    run(&stopped, &record(13), &numbers, 5, true).unwrap();
    run(&stopped, &record(13), &numbers, 5, true).unwrap();
    assert!(results(&stopped) == results(&whole), "the same bytes");

    let shards: Vec<_> = (1..=4).map(|i| at.path().join(format!("shard{i}"))).collect();
    for (i, shard) in shards.iter().enumerate() {
        run(shard, &record(13), Shard { index: i as u32 + 1, count: 4 }.of(&numbers), 99, false).unwrap();
    }
    let merged = at.path().join("merged");
    let error = merge(&shards[..3], &merged).unwrap_err().to_string();
    assert!(error.contains("the shards have 9 of 13 cells"), "{error}");
    assert!(!merged.exists(), "nothing is written by halves");
    // In any order, and one of them twice.
    let order = [&shards[2], &shards[0], &shards[3], &shards[1], &shards[0]].map(Clone::clone);
    assert_eq!(merge(&order, &merged).unwrap(), 13);
    assert!(results(&merged) == results(&whole), "the same bytes");
    assert!(!fs::read_to_string(merged.join("study.json")).unwrap().contains("--shard"));
}

/// Parts that were selected with `--filter` do not know how many cells the others have.
#[test]
fn parts_of_different_filters_join() {
    let at = tempfile::tempdir().unwrap();
    let numbers: Vec<usize> = (0..13).collect();
    let whole = at.path().join("whole");
    run(&whole, &record(13), &numbers, 99, false).unwrap();
    for (name, cuts) in [("unequal", &[0, 5, 13][..]), ("equal", &[0, 6, 12, 13])] {
        let parts: Vec<_> = cuts
            .windows(2)
            .map(|cut| {
                let part = at.path().join(format!("{name}{}", cut[0]));
                run(&part, &record(cut[1] - cut[0]), &numbers[cut[0]..cut[1]], 99, false).unwrap();
                part
            })
            .collect();
        let merged = at.path().join(name);
        assert_eq!(merge(&parts, &merged).unwrap(), 13);
        assert!(results(&merged) == results(&whole), "the same bytes");
    }
}

/// Variable that makes [`worker`] run a study into the folder that it names.
const WORKER: &str = "PT_STUDY_WORKER";

/// A program that runs a study of 40 cells, a few milliseconds each; nothing in an ordinary run of the tests.
#[test]
fn worker() {
    let Some(path) = std::env::var_os(WORKER) else { return };
    let numbers: Vec<usize> = (0..40).collect();
    for budget in 1..=40 {
        std::thread::sleep(std::time::Duration::from_millis(2));
        run(Path::new(&path), &record(40), &numbers, usize::from(budget < 40), true).unwrap();
    }
    run(Path::new(&path), &record(40), &numbers, 40, true).unwrap();
}

#[test]
fn ten_kills_at_random_moments_change_nothing() {
    let at = tempfile::tempdir().unwrap();
    let start = |path: &Path| {
        let mut command = std::process::Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "study::worker"]).env(WORKER, path).stdout(std::process::Stdio::null());
        command.spawn().unwrap()
    };
    let whole = at.path().join("whole");
    assert!(start(&whole).wait().unwrap().success());
    let killed = at.path().join("killed");
    let mut random = fastrand::Rng::with_seed(std::process::id().into());
    for _ in 0..10 {
        let mut child = start(&killed);
        std::thread::sleep(std::time::Duration::from_micros(random.u64(1_000..60_000)));
        // SIGKILL.
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(start(&killed).wait().unwrap().success());
    assert!(results(&killed) == results(&whole), "the same bytes");
}

#[test]
fn folders_of_others_are_left_alone() {
    let at = tempfile::tempdir().unwrap();
    let path = at.path().join("study");
    run(&path, &record(3), &[0, 1, 2], 1, false).unwrap();
    let refused =
        |record: &StudyRecord, resume| run(&path, record, &[0, 1, 2], 9, resume).unwrap_err().to_string();
    assert!(refused(&record(3), false).contains("--resume goes on"));
    assert!(refused(&StudyRecord { file: "other".into(), ..record(3) }, true).contains("another study"));
    assert!(
        refused(&StudyRecord { version: "2".into(), ..record(3) }, true)
            .contains("another version of pt: \"1\" there, \"2\" here")
    );
    assert!(refused(&StudyRecord { device: "e".into(), ..record(3) }, true).contains("another device"));
    assert!(refused(&record(4), true).contains("3 cells there, 4 here"));
    // A study that failed before its first cell leaves a folder that any study may take.
    let fresh = at.path().join("fresh");
    drop(Folder::open(&fresh, &record(3), false).unwrap());
    drop(Folder::open(&fresh, &record(4), false).unwrap());
    assert_eq!(pt_study::folder::read_study(&fresh).unwrap(), record(4));
    // Two studies into one folder.
    let open = Folder::open(&path, &record(3), true).unwrap();
    assert!(refused(&record(3), true).contains("another process writes into it"));
    drop(open);
    // What a killed process leaves does not lock.
    run(&path, &record(3), &[0, 1, 2], 9, true).unwrap();
    let text = fs::read_to_string(path.join("study.json")).unwrap();
    fs::write(path.join("study.json"), text.replace("\"format\": 1", "\"format\": 9")).unwrap();
    assert!(refused(&record(3), true).contains("has format 9, this program reads 1"));
    fs::write(path.join("study.json"), "{").unwrap();
    assert!(refused(&record(3), true).contains("study.json: is damaged"));
    let foreign = at.path().join("photos");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("a.png"), "").unwrap();
    assert!(
        run(&foreign, &record(3), &[0], 1, false)
            .unwrap_err()
            .to_string()
            .contains("is no result folder, it has a.png")
    );
    assert!(run(&path.join("study.json"), &record(3), &[0], 1, false).is_err(), "a file is no folder");
    assert!(merge(&[foreign], &at.path().join("m")).unwrap_err().to_string().contains("no result folder"));
}
