//! Joins the shards of a study.

use crate::error::StudyError;
use crate::folder::{Finished, Folder, check_same, read_finished, read_study};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Writes the results of all `shards` into a folder of its own at `output`; returns the number of cells. What an earlier attempt has left there is
/// completed. Shards of one selection of cells must be all there;
/// of parts with different filters, which do not know of each other, the study has the cells that it is given.
///
/// # Errors
/// Shards of different studies, versions or devices; cells that are missing, or that differ between two shards; an output that is one of the shards, or
/// has other results; files that cannot be read or written.
pub fn merge(shards: &[PathBuf], output: &Path) -> Result<usize, StudyError> {
    let mut study = None;
    let mut cells: BTreeMap<String, Finished> = BTreeMap::new();
    let mut images = Vec::new();
    let mut one_selection = true;
    for shard in shards {
        let record = read_study(shard)?;
        let first = study.get_or_insert_with(|| record.clone());
        check_same(shard, &record, first)?;
        one_selection &= record.cells == first.cells;
        for finished in read_finished(shard)? {
            let cell = &finished.cell;
            if let Some(name) = cell.images.values().find(|name| !is_within(name)) {
                return Err(StudyError::folder(
                    shard,
                    format!("names the image {name}, which is outside of the folder"),
                ));
            }
            images.extend(cell.images.values().map(|name| (shard.join(name), name.clone())));
            match cells.entry(cell.cell.clone()) {
                Entry::Occupied(other) if other.get().cell != *cell => {
                    return Err(StudyError::folder(
                        shard,
                        format!("cell {} differs from that of another shard", cell.cell),
                    ));
                }
                Entry::Occupied(_) => {}
                Entry::Vacant(place) => {
                    place.insert(finished);
                }
            }
        }
    }
    let Some(mut study) = study else { return Err(StudyError::Selection("no shards are given".into())) };
    if !one_selection || cells.len() > study.cells {
        study.cells = cells.len();
        study.command = without(&study.command, "--filter");
    }
    if cells.len() != study.cells {
        return Err(StudyError::folder(
            output,
            format!(
                "the shards have {} of {} cells; give all of them, each finished",
                cells.len(),
                study.cells
            ),
        ));
    }
    // Names begin with the number of the cell.
    let finished: Vec<Finished> = cells.into_values().collect();
    study.command = without(&study.command, "--shard");
    let is_output =
        |shard: &PathBuf| matches!((shard.canonicalize(), output.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if let Some(shard) = shards.iter().find(|shard| is_output(shard)) {
        return Err(StudyError::folder(shard, "is a shard and the output; give another folder with -o"));
    }
    let folder = Folder::open(output, &study, true)?;
    for (from, name) in images {
        let to = output.join(&name);
        let parent = to.parent().unwrap_or(output);
        fs::create_dir_all(parent)
            .map_err(|cause| StudyError::folder(parent, format!("cannot be made ({cause})")))?;
        pt_image::atomic_file::write_atomic(&to, &pt_image::atomic_file::read(&from)?)?;
    }
    finished.iter().try_for_each(|cell| folder.keep(cell))?;
    folder.finish(&finished)?;
    Ok(finished.len())
}

/// Whether a path stays in the folder that it is relative to.
fn is_within(name: &str) -> bool {
    Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}

/// The command without an option and its values.
fn without(command: &str, option: &str) -> String {
    let mut words = command.split(' ');
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        if word == option {
            words.next();
        } else {
            kept.push(word);
        }
    }
    kept.join(" ")
}
