//! A result folder that no renderer made: a handful of variants, scenes and seeds with small pictures.

use pt_study::record::{
    AxisRecord, CellRecord, FORMAT, LedgerRecord, MetricRecord, PassTime, StudyRecord, TimingRecord,
    VariantRecord,
};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Variants: name, error in relation to the baseline, GPU time in milliseconds. Names may be anything.
pub const VARIANTS: [(&str, f64, f64); 6] = [
    ("asvgf", 1.0, 3.1),
    ("svgf", 1.35, 2.6),
    ("placebo", 1.0, 3.1),
    ("<b>bold</b> & \"quoted\"", 0.72, 4.4),
    ("accumulate", 1.9, 0.9),
    ("off", 9.0, 0.2),
];
const SCENES: [&str; 2] = ["cornell", "gallery"];
const SEEDS: u64 = 5;
const FRAMES: u32 = 24;
const SIZE: [u32; 2] = [96, 54];
const STAGES: [&str; 5] = ["lights", "indirect", "denoise", "interleave", "taa"];

/// Noise between -1 and 1 from a hash (SplitMix64).
fn noise(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

pub fn study() -> StudyRecord {
    let metric = |name: &str, formula: &str, perfect: f64| MetricRecord {
        name: name.into(),
        formula: formula.into(),
        perfect,
    };
    let variant = |(name, ..): (&str, f64, f64)| VariantRecord {
        name: name.into(),
        axes: BTreeMap::from([("denoise.variant".into(), name.into())]),
        set: vec![format!("denoise.variant={name}"), "denoise.alpha=0.1".into()],
    };
    StudyRecord {
        format: FORMAT,
        name: "denoiser".into(),
        question: "Which denoiser brings one sample a pixel nearest to the reference, and at which cost?".into(),
        file: "name = \"denoiser\"\nscenes = [\"cornell\", \"gallery\"]\nseeds = [1, 2, 3, 4, 5]\n\n[[axis]]\nkey = \"denoise.variant\"\n".into(),
        command: "pt study studies/denoiser.toml -o out/denoiser".into(),
        version: "0.1.0".into(),
        revision: "0123456789abcdef0123456789abcdef01234567-dirty".into(),
        device: "llvmpipe (LLVM 19.1.7, 256 bits)".into(),
        driver: "Mesa 25.0.7".into(),
        metrics: vec![
            metric("relmse", "mean of (a - b)^2 / (b^2 + 0.01) over pixels and channels", 0.0),
            metric("flip", "FLIP of Andersson et al. 2020 on display values, mean over pixels", 0.0),
            metric("energy_ratio", "mean luminance divided by that of the reference", 1.0),
        ],
        axes: vec![AxisRecord { name: "denoise.variant".into(), values: VARIANTS.map(|v| v.0.into()).into() }],
        baseline: "asvgf".into(),
        variants: VARIANTS.map(variant).into(),
        cells: VARIANTS.len() * SCENES.len() * SEEDS as usize,
    }
}

/// Cells and their times.
pub fn cells() -> (Vec<CellRecord>, Vec<TimingRecord>) {
    let (mut cells, mut timings) = (vec![], vec![]);
    for (s, scene) in SCENES.iter().enumerate() {
        for (v, (name, factor, ms)) in VARIANTS.iter().enumerate() {
            for seed in 1..=SEEDS {
                let key = (s as u64) << 32 | (v as u64) << 16 | seed;
                let cell = format!("{scene}-v{v}-s{seed}");
                let scale = factor * if s == 0 { 0.011 } else { 0.06 };
                let error = |frame: u32, metric: u64| {
                    let converged = 1.0 + 6.0 / f64::from(frame + 1);
                    converged * (1.0 + 0.12 * noise(key ^ metric << 40 ^ u64::from(frame) << 48))
                };
                let frames: BTreeMap<String, Vec<Option<f64>>> = BTreeMap::from([
                    ("relmse".into(), (0..FRAMES).map(|f| Some(scale * error(f, 1))).collect()),
                    (
                        "flip".into(),
                        (0..FRAMES).map(|f| Some(0.9 * scale.sqrt() * error(f, 2).sqrt())).collect(),
                    ),
                    // The variant without a denoiser has frames whose ratio is not finite.
                    (
                        "energy_ratio".into(),
                        (0..FRAMES)
                            .map(|f| {
                                (*name != "off" || f > 4)
                                    .then(|| 1.0 + 0.02 * noise(key ^ u64::from(f) << 20))
                            })
                            .collect(),
                    ),
                ]);
                let mean = |values: &Vec<Option<f64>>| {
                    let values: Vec<f64> = values.iter().flatten().copied().collect();
                    Some(values.iter().sum::<f64>() / values.len() as f64)
                };
                let metrics = frames.iter().map(|(name, values)| (name.clone(), mean(values))).collect();
                let picture = |kind: &str| (kind.to_owned(), format!("images/{cell}-{kind}.png"));
                let mut images = BTreeMap::new();
                if seed == 1 {
                    images.extend([picture("picture"), picture("error")]);
                    images.insert("reference".into(), format!("images/{scene}-reference.png"));
                }
                cells.push(CellRecord {
                    cell: cell.clone(),
                    variant: (*name).into(),
                    scene: (*scene).into(),
                    camera: String::new(),
                    size: SIZE,
                    backend: "compute".into(),
                    seed,
                    metrics,
                    frames,
                    first_frame: 8,
                    ledger: Some(ledger(scale, key)),
                    images,
                    command: format!("pt render {scene} --size 96x54 --seed {seed} --set 'denoise.variant={name}' -o {cell}.exr"),
                });
                let time = |share: f64, pass: u64| share * ms * (1.0 + 0.04 * noise(key ^ pass << 52));
                let pass = |(pass, share): (usize, f64)| PassTime {
                    pass: STAGES[pass].into(),
                    median_ms: time(share, pass as u64),
                    p95_ms: 1.1 * time(share, pass as u64),
                };
                timings.push(TimingRecord {
                    cell,
                    gpu_ms: time(1.0, 9),
                    gpu_ms_p95: 1.1 * time(1.0, 9),
                    passes: [0.3, 0.3, 0.25, 0.1, 0.05].into_iter().enumerate().map(pass).collect(),
                    wall_s: 1.5,
                });
            }
        }
    }
    (cells, timings)
}

fn ledger(total: f64, key: u64) -> LedgerRecord {
    let of = |total: f64, key: u64, frames: Vec<LedgerRecord>| {
        let share = [0.2, 0.25, 0.45, -0.06, 0.04];
        let parts: Vec<(String, f64)> = STAGES
            .iter()
            .zip(share)
            .enumerate()
            .map(|(n, (stage, share))| {
                ((*stage).to_owned(), total * share * (1.0 + 0.1 * noise(key ^ (n as u64) << 44)))
            })
            .collect();
        let interaction = total - parts.iter().map(|part| part.1).sum::<f64>();
        LedgerRecord {
            metric: "relmse".into(),
            total,
            parts,
            interaction,
            reference_noise: Some(0.03),
            frames,
        }
    };
    let frame = |f: u32| of(total * (1.0 + 6.0 / f64::from(f + 1)), key ^ u64::from(f) << 36, vec![]);
    let frames: Vec<_> = (0..FRAMES).map(frame).collect();
    let mean = frames.iter().map(|f| f.total).sum::<f64>() / f64::from(FRAMES);
    of(mean, key, frames)
}

fn write_png(path: &Path, pixel: impl Fn(u32, u32) -> [u8; 3]) {
    let data: Vec<u8> =
        (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).flat_map(|(x, y)| pixel(x, y)).collect();
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
}

/// A room with a ball, and noise that grows with the error.
fn shade(x: u32, y: u32, scene: usize, noise_seed: u64, error: f64) -> [u8; 3] {
    let (u, v) = (f64::from(x) / f64::from(SIZE[0]), f64::from(y) / f64::from(SIZE[1]));
    let ball = (1.0 - ((u - 0.55) * 6.0).powi(2) - ((v - 0.6) * 3.4).powi(2)).max(0.0).sqrt();
    let mut wall = [0.75 - 0.5 * u, 0.35 + 0.2 * v, 0.2 + 0.5 * u];
    wall.rotate_left(scene);
    let at = u64::from(y * SIZE[0] + x) + (scene as u64) * 77_777;
    let noise = 1.0 + error * noise(noise_seed << 24 ^ at);
    wall.map(|wall| ((0.8 * wall + 0.7 * ball * (1.2 - v)) * noise * 255.0).clamp(0.0, 255.0) as u8)
}

/// Writes the records of a folder.
pub fn write_records(folder: &Path, study: &StudyRecord, cells: &[CellRecord], timings: &[TimingRecord]) {
    fs::write(folder.join("study.json"), serde_json::to_vec_pretty(study).unwrap()).unwrap();
    let lines = |lines: Vec<String>| lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    let cells = cells.iter().map(|cell| serde_json::to_string(cell).unwrap()).collect();
    let timings = timings.iter().map(|timing| serde_json::to_string(timing).unwrap()).collect();
    fs::write(folder.join("results.jsonl"), lines(cells)).unwrap();
    fs::write(folder.join("timings.jsonl"), lines(timings)).unwrap();
}

/// Writes the whole folder.
pub fn write(folder: &Path) {
    let (cells, timings) = cells();
    write_records(folder, &study(), &cells, &timings);
    fs::create_dir(folder.join("images")).unwrap();
    for (s, scene) in SCENES.iter().enumerate() {
        write_png(&folder.join(format!("images/{scene}-reference.png")), |x, y| shade(x, y, s, 0, 0.0));
        for (v, (_, error, _)) in VARIANTS.iter().enumerate() {
            let error = 0.05 * error;
            let seed = v as u64 + 1;
            let path = |kind: &str| folder.join(format!("images/{scene}-v{v}-s1-{kind}.png"));
            write_png(&path("picture"), |x, y| shade(x, y, s, seed, error));
            write_png(&path("error"), |x, y| {
                let t = (error * noise(seed << 24 ^ u64::from(y * SIZE[0] + x)).abs() * 2.0).min(1.0);
                [(t * 255.0) as u8, (t * t * 220.0) as u8, ((0.3 + 0.4 * t) * 255.0) as u8]
            });
        }
    }
}
