//! What a variant costs: the GPU time of its frames.

use crate::record::CellRecord;
use crate::summary::{pair_of, strata};

/// GPU time of the frames of some cells of one variant, in the unit of `time_of`: of each view (scene, camera, size, backend) the least time of its
/// seeds, and of these the mean over the views. The work of a frame hardly depends on the seed, and whatever else a device does makes a measured
/// time longer, never shorter. `time_of` takes the name of a cell; `None`: no cell has a time.
pub fn gpu_time<'a>(
    cells: impl IntoIterator<Item = &'a CellRecord>,
    time_of: impl Fn(&str) -> Option<f64>,
) -> Option<f64> {
    let timed = cells.into_iter().filter_map(|cell| Some((pair_of(cell), time_of(&cell.cell)?)));
    let views = strata(timed);
    let least = views.iter().map(|times| times.iter().copied().fold(f64::INFINITY, f64::min));
    (!views.is_empty()).then(|| least.sum::<f64>() / views.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn a_disturbed_seed_is_no_cost() {
        let cell = |name: &str, scene: &str| CellRecord {
            cell: name.into(),
            variant: "v".into(),
            scene: scene.into(),
            camera: String::new(),
            size: [64, 36],
            backend: "compute".into(),
            seed: 0,
            metrics: BTreeMap::new(),
            frames: BTreeMap::new(),
            first_frame: 0,
            ledger: None,
            images: BTreeMap::new(),
            command: String::new(),
        };
        let cells = [cell("a", "lamps"), cell("b", "lamps"), cell("c", "cornell"), cell("d", "cornell")];
        let time = |name: &str| match name {
            "a" => Some(4.0),
            "b" => Some(1.0),
            "c" => Some(2.0),
            _ => None,
        };
        assert_eq!(gpu_time(&cells, time), Some(1.5));
        assert_eq!(gpu_time(&cells[3..], time), None);
    }
}
