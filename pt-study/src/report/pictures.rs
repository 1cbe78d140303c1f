//! The pictures of the page, within its limit of size.

use super::figure::{Source, View};
use super::number::significant;
use super::table::{Datum, Table};
use crate::record::CellRecord;
use base64::Engine;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the picture viewer shows. The script of the page reads `views` and `images`.
#[derive(Default, Serialize)]
pub struct Pictures {
    pub views: Vec<PictureView>,
    /// Contents, as data URIs. A file that several cells name is here once.
    pub images: Vec<String>,
    /// Index of the variant that is shown first.
    pub first: usize,
    /// Sentences about what is not shown.
    pub notes: Vec<String>,
    pub table: Table,
}

/// Pictures that can be compared: the same view and seed.
#[derive(Serialize)]
pub struct PictureView {
    pub name: String,
    pub pictures: Vec<Picture>,
}

/// A picture to choose.
#[derive(Serialize)]
pub struct Picture {
    pub name: String,
    /// Index of the tone-mapped picture.
    pub picture: usize,
    /// Index of the error in false colours.
    pub error: Option<usize>,
    /// Metrics as text.
    pub values: Vec<String>,
}

/// A file of the folder that a view shows.
enum Role {
    Reference,
    Picture,
    Error,
}

/// Collects files until the limit is reached.
struct Collector<'a> {
    folder: &'a Path,
    images: Vec<String>,
    by_path: BTreeMap<String, Option<usize>>,
    room: usize,
    full: bool,
    left_out: usize,
    left_out_views: Vec<String>,
    unreadable: Vec<String>,
}

impl Collector<'_> {
    fn add(&mut self, path: &str, view: &str) -> Option<usize> {
        if let Some(known) = self.by_path.get(path) {
            return *known;
        }
        let index = self.embed(path, view);
        self.by_path.insert(path.into(), index);
        index
    }

    fn embed(&mut self, path: &str, view: &str) -> Option<usize> {
        // A folder of somebody else must not make the report show other files of this machine.
        let inside = |file: &PathBuf| self.folder.canonicalize().is_ok_and(|folder| file.starts_with(folder));
        let file = self.folder.join(path).canonicalize().ok().filter(inside);
        let bytes = file.and_then(|file| std::fs::read(file).ok());
        let Some(bytes) = bytes.filter(|bytes| bytes.starts_with(b"\x89PNG\r\n\x1a\n")) else {
            self.unreadable.push(path.into());
            return None;
        };
        const HEAD: &str = "data:image/png;base64,";
        // With the quotation marks and the comma of the list.
        let size = HEAD.len() + bytes.len().div_ceil(3) * 4 + 3;
        // After the first file that has no room all others are left out too: small ones that still fit would make an arbitrary choice.
        self.full |= size > self.room;
        if self.full {
            self.left_out += 1;
            if !self.left_out_views.iter().any(|name| name == view) {
                self.left_out_views.push(view.into());
            }
            return None;
        }
        self.room -= size;
        self.images.push(HEAD.to_owned() + &base64::engine::general_purpose::STANDARD.encode(&bytes));
        Some(self.images.len() - 1)
    }
}

/// All pictures of the folder for which there is room, in bytes of the page.
pub fn pictures(source: &Source<'_>, folder: &Path, room: usize) -> Pictures {
    let mut collector = Collector {
        folder,
        images: vec![],
        by_path: BTreeMap::new(),
        room,
        full: false,
        left_out: 0,
        left_out_views: vec![],
        unreadable: vec![],
    };
    let study = &source.results.study;
    let metrics = || study.metrics.iter().map(|metric| &metric.name);
    let head =
        ["View", "Picture"].map(str::to_owned).into_iter().chain(metrics().map(|name| format!("#{name}")));
    let mut table = Table::new(head.collect::<Vec<_>>().iter().map(String::as_str));
    let groups = groups(source);
    let mut views = Vec::new();
    for (name, cells) in &groups {
        let mut indices: BTreeMap<(usize, &str), usize> = BTreeMap::new();
        for role in [Role::Reference, Role::Picture, Role::Error] {
            for (number, cell) in cells.iter().enumerate() {
                let key = match role {
                    Role::Reference => "reference",
                    Role::Picture => "picture",
                    Role::Error => "error",
                };
                let index = cell.images.get(key).and_then(|path| collector.add(path, name));
                indices.extend(index.map(|index| ((number, key), index)));
            }
        }
        let mut shown = Vec::new();
        let reference = (0..cells.len()).find_map(|number| indices.get(&(number, "reference")));
        if let Some(&picture) = reference {
            shown.push(Picture { name: "reference".into(), picture, error: None, values: vec![] });
        }
        for (number, cell) in cells.iter().enumerate() {
            let Some(&picture) = indices.get(&(number, "picture")) else { continue };
            let value = |metric: &String| cell.metrics.get(metric).copied().flatten();
            let values =
                metrics().map(|m| format!("{m} {}", value(m).map_or("–".into(), |v| significant(v, 3))));
            let error = indices.get(&(number, "error")).copied();
            shown.push(Picture { name: cell.variant.clone(), picture, error, values: values.collect() });
            let series = source.series.iter().find(|series| series.name == cell.variant);
            let head = [Datum::text(name), series.map_or_else(|| Datum::text(&cell.variant), Datum::series)];
            table.rows.push(head.into_iter().chain(metrics().map(|m| Datum::value(value(m)))).collect());
        }
        if !shown.is_empty() {
            views.push(PictureView { name: name.clone(), pictures: shown });
        }
    }
    let first = views.first().and_then(|view| view.pictures.iter().position(|p| p.name == study.baseline));
    let notes = notes(&collector);
    Pictures { views, images: collector.images, first: first.unwrap_or(0), notes, table }
}

fn notes(collector: &Collector<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    if collector.left_out > 0 {
        notes.push(format!(
            "To keep this file below {} MB, {} of {} pictures are left out, from: {}. They are in the folder images/.",
            super::LIMIT / 1_000_000,
            collector.left_out,
            collector.left_out + collector.images.len(),
            collector.left_out_views.join("; ")
        ));
    }
    if !collector.unreadable.is_empty() {
        let count = collector.unreadable.len();
        let some = collector.unreadable.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
        let more = if count > 8 { ", ..." } else { "" };
        notes.push(format!(
            "Not shown, because they are no PNG files inside the result folder ({count}): {some}{more}."
        ));
    }
    notes
}

/// Cells with pictures by view and seed. The first seed of every view comes before the second of any.
fn groups<'a>(source: &Source<'a>) -> Vec<(String, Vec<&'a CellRecord>)> {
    let mut groups: Vec<(View, u64, Vec<&CellRecord>)> = Vec::new();
    for cell in source.results.cells.iter().filter(|cell| !cell.images.is_empty()) {
        let view = View::of(cell);
        match groups.iter_mut().find(|(other, seed, _)| *other == view && *seed == cell.seed) {
            Some((.., cells)) => cells.push(cell),
            None => groups.push((view, cell.seed, vec![cell])),
        }
    }
    let turn = |index: usize| groups[..index].iter().filter(|(view, ..)| *view == groups[index].0).count();
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_key(|&index| turn(index));
    let seeds = groups.iter().any(|(_, seed, _)| *seed != groups[0].1);
    let named = |index: usize| {
        let (view, seed, cells) = &groups[index];
        let seed = if seeds { format!(", seed {seed}") } else { String::new() };
        (view.name(&source.views) + &seed, cells.clone())
    };
    order.into_iter().map(named).collect()
}
