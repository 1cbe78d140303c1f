//! The variants and cells of a study.

use crate::error::StudyError;
use crate::file::{AxisValue, Design, Pairing, Setting, Study};
use pt_core::settings::close_to;
use std::collections::BTreeMap;
use std::str::FromStr;

/// Studies with as many cells run only if it is confirmed.
pub const MANY_CELLS: u64 = 1_000_000;

/// A combination of the values of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its values on the axes, as one name.
    pub name: String,
    /// Its value on each axis.
    pub axes: BTreeMap<String, String>,
    /// What it sets: the common settings, then those of the axes.
    pub set: Vec<Setting>,
}

/// One run: a variant on a scene with a camera, a size, a backend and a seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Unique in the study, fit for a file name, and sorted as the cells are.
    pub name: String,
    /// Index into the variants.
    pub variant: usize,
    /// Scene, as given.
    pub scene: String,
    /// Camera, as given.
    pub camera: String,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// Trace backend.
    pub backend: String,
    /// Seed of the study, by which cells pair.
    pub seed: u64,
    /// Seed of the random numbers.
    pub random_seed: u64,
}

impl Study {
    /// Number of variants; not listed, as they may be many.
    fn variant_count(&self) -> u64 {
        let sizes = self.axes.iter().map(|axis| axis.values.len() as u64);
        match self.design {
            Design::All => sizes.fold(1, u64::saturating_mul),
            Design::OneAtATime => 1 + sizes.map(|size| size.saturating_sub(1)).sum::<u64>(),
        }
    }

    /// Number of cells.
    pub fn cell_count(&self) -> u64 {
        let lists =
            [self.scenes.len(), self.cameras.len(), self.sizes.len(), self.backends.len(), self.seeds.len()];
        lists.into_iter().map(|size| size as u64).fold(self.variant_count(), u64::saturating_mul)
    }

    /// The variants, in the order of the file: the last axis changes fastest. Empty if there are more than [`MANY_CELLS`].
    pub fn variants(&self) -> Vec<Variant> {
        if self.variant_count() > MANY_CELLS {
            return Vec::new();
        }
        match self.design {
            Design::All => {
                let mut combinations: Vec<Vec<&AxisValue>> = vec![Vec::new()];
                for axis in &self.axes {
                    combinations = combinations
                        .iter()
                        .flat_map(|start| {
                            axis.values.iter().map(move |value| [&start[..], &[value]].concat())
                        })
                        .collect();
                }
                let name = |values: &[&AxisValue]| match values {
                    [] => "default".to_owned(),
                    _ => self.name_of(values, 0..values.len()),
                };
                combinations.iter().map(|values| self.variant(name(values), values)).collect()
            }
            Design::OneAtATime => {
                let first: Vec<&AxisValue> = self.axes.iter().map(|axis| &axis.values[0]).collect();
                let mut variants = vec![self.variant("baseline".into(), &first)];
                for (i, axis) in self.axes.iter().enumerate() {
                    for value in &axis.values[1..] {
                        let mut values = first.clone();
                        values[i] = value;
                        variants.push(self.variant(self.name_of(&values, i..i + 1), &values));
                    }
                }
                variants
            }
        }
    }

    /// The name of values on some axes. That of a named variant stands alone, as does the value of an only axis that is no number or switch.
    fn name_of(&self, values: &[&AxisValue], axes: std::ops::Range<usize>) -> String {
        let plain = |name: &str| name.parse::<f64>().is_err() && name.parse::<bool>().is_err();
        let names = axes.map(|i| {
            let (axis, value) = (&self.axes[i], &values[i].name);
            if axis.name == "variant" || (self.axes.len() == 1 && plain(value)) {
                value.clone()
            } else {
                format!("{}={value}", axis.name)
            }
        });
        names.collect::<Vec<_>>().join(", ")
    }

    fn variant(&self, name: String, values: &[&AxisValue]) -> Variant {
        let axes = self.axes.iter().zip(values).map(|(axis, value)| (axis.name.clone(), value.name.clone()));
        let set = self.set.iter().filter(|setting| !setting.key.starts_with("reference."));
        let of_axes = values.iter().flat_map(|value| &value.set);
        Variant { name, axes: axes.collect(), set: set.chain(of_axes).cloned().collect() }
    }

    /// Name of the baseline.
    pub fn baseline_name(&self, variants: &[Variant]) -> String {
        let first = variants.first().map(|variant| variant.name.clone());
        self.baseline.clone().or(first).unwrap_or_default()
    }

    /// All cells: scene by scene, then camera, size, backend, variant and seed.
    pub fn cells(&self, variants: &[Variant]) -> Vec<Cell> {
        let mut cells = Vec::new();
        for scene in &self.scenes {
            for camera in &self.cameras {
                for &size in &self.sizes {
                    for backend in &self.backends {
                        for (index, variant) in variants.iter().enumerate() {
                            for &seed in &self.seeds {
                                let number = cells.len();
                                cells.push(Cell {
                                    name: cell_name(number, scene, &variant.name, seed),
                                    variant: index,
                                    scene: scene.clone(),
                                    camera: camera.clone(),
                                    size,
                                    backend: backend.clone(),
                                    seed,
                                    random_seed: match self.pairing {
                                        Pairing::Seed => seed,
                                        Pairing::Independent => decorrelated(&variant.name, seed),
                                    },
                                });
                            }
                        }
                    }
                }
            }
        }
        cells
    }
}

/// The number keeps names apart and in order.
fn cell_name(number: usize, scene: &str, variant: &str, seed: u64) -> String {
    let scene = scene.rsplit(['/', '\\']).next().unwrap_or_default();
    let fit = |text: &str| -> String {
        let keep = |c: char| if c.is_ascii_alphanumeric() || "._-=".contains(c) { c } else { '_' };
        text.chars().map(keep).take(48).collect()
    };
    format!("{number:07}-{}-{}-seed{seed}", fit(scene), fit(variant))
}

/// A seed of its own for each variant: FNV-1a over the name, then the finalizer of SplitMix64 (Steele et al. 2014), so that no two variants share random
/// numbers.
fn decorrelated(variant: &str, seed: u64) -> u64 {
    let hash = variant.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let mut z = hash ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// `KEY=VALUE`: the cells of one value. Values of one key add up, keys restrict each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filter {
    /// `scene`, `camera`, `size`, `backend`, `seed`, `variant`, or an axis.
    pub key: String,
    /// Its value.
    pub value: String,
}

impl FromStr for Filter {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                Ok(Self { key: key.trim().into(), value: value.trim().into() })
            }
            _ => Err("expected KEY=VALUE, for example scene=cornell".into()),
        }
    }
}

/// `i/n`: the i-th of n parts, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number, from 1.
    pub index: u32,
    /// Number of shards.
    pub count: u32,
}

impl FromStr for Shard {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parts =
            text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match parts {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("expected I/N, the I-th of N shards, from 1, for example 1/4".into()),
        }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// The cells of the shard: a run of neighbours, which share references and scenes.
    pub fn of<T>(self, cells: &[T]) -> &[T] {
        let at = |i: u32| (cells.len() as u64 * u64::from(i) / u64::from(self.count)) as usize;
        &cells[at(self.index - 1)..at(self.index)]
    }
}

/// The cells that all filters keep.
///
/// # Errors
/// An unknown key; no cell left.
pub fn filtered(cells: Vec<Cell>, variants: &[Variant], filters: &[Filter]) -> Result<Vec<Cell>, StudyError> {
    const KEYS: [&str; 6] = ["scene", "camera", "size", "backend", "seed", "variant"];
    let axes: Vec<&str> = variants.iter().take(1).flat_map(|v| v.axes.keys()).map(String::as_str).collect();
    let known: Vec<&str> =
        KEYS.into_iter().chain(axes.into_iter().filter(|axis| !KEYS.contains(axis))).collect();
    if let Some(filter) = filters.iter().find(|filter| !known.contains(&filter.key.as_str())) {
        let closest = close_to(&filter.key, known.iter().copied());
        return Err(StudyError::Selection(format!(
            "--filter {}={}: unknown key{closest} (there are {})",
            filter.key,
            filter.value,
            known.join(", ")
        )));
    }
    let value = |cell: &Cell, key: &str| match key {
        "scene" => cell.scene.clone(),
        "camera" => cell.camera.clone(),
        "size" => format!("{}x{}", cell.size[0], cell.size[1]),
        "backend" => cell.backend.clone(),
        "seed" => cell.seed.to_string(),
        "variant" => variants[cell.variant].name.clone(),
        axis => variants[cell.variant].axes.get(axis).cloned().unwrap_or_default(),
    };
    let keeps = |cell: &Cell| {
        filters.iter().all(|filter| {
            let of_key = filters.iter().filter(|other| other.key == filter.key);
            let found = value(cell, &filter.key);
            of_key.into_iter().any(|other| other.value == found)
        })
    };
    let kept: Vec<Cell> = cells.into_iter().filter(keeps).collect();
    if kept.is_empty() {
        let texts: Vec<_> = filters.iter().map(|f| format!("{}={}", f.key, f.value)).collect();
        return Err(StudyError::Selection(format!(
            "no cell has {}; pt study --dry-run lists the cells",
            texts.join(" and ")
        )));
    }
    Ok(kept)
}
