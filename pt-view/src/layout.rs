//! Where the picture is in the window, and which parts of it are the frame and the ground truth.

use crate::protocol::TruthView;

/// Distance from the edge between frame and ground truth at which a drag takes it, pixels of the window.
const REACH: f64 = 6.0;

/// Places a picture of `size` pixels in `area` (left, top, right, bottom, pixels of the window): centred, and as large as fits; enlarged by whole
/// factors alone, so that each pixel is a square.
pub fn place(size: [u32; 2], area: [i32; 4]) -> [i32; 4] {
    let room = [0, 1].map(|axis| f64::from((area[axis + 2] - area[axis]).max(0)));
    let fit = [0, 1].map(|axis| room[axis] / f64::from(size[axis].max(1)));
    let scale = fit[0].min(fit[1]);
    let scale = if scale >= 1.0 { scale.floor() } else { scale };
    let [width, height] = size.map(|side| (f64::from(side) * scale) as i32);
    let left = area[0] + (room[0] as i32 - width) / 2;
    let top = area[1] + (room[1] as i32 - height) / 2;
    [left, top, left + width, top + height]
}

/// The pixel of a picture of `size` pixels, shown at `place`, under `at` (pixels of the window).
pub fn pixel_under(at: [f64; 2], size: [u32; 2], place: [i32; 4]) -> Option<[u32; 2]> {
    let pixel = [0, 1].map(|axis| {
        let (start, end) = (f64::from(place[axis]), f64::from(place[axis + 2]));
        let share = (at[axis] - start) / (end - start);
        (0.0..1.0).contains(&share).then_some((share * f64::from(size[axis])) as u32)
    });
    Some([pixel[0]?, pixel[1]?])
}

/// What a part of the picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The frame.
    Frame,
    /// The ground truth.
    Truth,
}

/// A part of the picture. Rectangles are left, top, right, bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// What it shows.
    pub layer: Layer,
    /// Its pixels of the picture.
    pub from: [i32; 4],
    /// Its pixels of the window.
    pub to: [i32; 4],
}

/// The parts of a picture of `size` pixels at `place`. `is_flipped`: the key is held that shows the ground truth; `split`: the share of the picture that
/// is left of it.
pub fn parts(view: TruthView, is_flipped: bool, split: f32, size: [u32; 2], place: [i32; 4]) -> Vec<Part> {
    let [width, height] = size.map(|side| side as i32);
    let [left, top, right, bottom] = place;
    let whole = |layer| vec![Part { layer, from: [0, 0, width, height], to: place }];
    match view {
        TruthView::Off => whole(Layer::Frame),
        TruthView::Alone | TruthView::Difference => whole(Layer::Truth),
        TruthView::Split | TruthView::Flip if is_flipped => whole(Layer::Truth),
        TruthView::Flip => whole(Layer::Frame),
        TruthView::Split => {
            let at = (split.clamp(0.0, 1.0) * width as f32).round() as i32;
            let across = left + (f64::from(at) / f64::from(width.max(1)) * f64::from(right - left)) as i32;
            let frame =
                Part { layer: Layer::Frame, from: [0, 0, at, height], to: [left, top, across, bottom] };
            let from = [at, 0, width, height];
            vec![frame, Part { layer: Layer::Truth, from, to: [across, top, right, bottom] }]
        }
    }
}

/// Whether a drag at `at` (pixels of the window) takes the edge of a picture at `place`.
pub fn is_on_edge(at: [f64; 2], split: f32, place: [i32; 4]) -> bool {
    let [left, top, right, bottom] = place.map(f64::from);
    let edge = left + f64::from(split) * (right - left);
    (at[0] - edge).abs() <= REACH && (top..bottom).contains(&at[1])
}

/// The share of a picture at `place` that is left of `x`, pixels of the window.
pub fn split_under(x: f64, place: [i32; 4]) -> f32 {
    let [left, _, right, _] = place.map(f64::from);
    ((x - left) / (right - left).max(1.0)).clamp(0.0, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_centred_and_enlarged_by_whole_factors() {
        assert_eq!(place([10, 10], [0, 0, 35, 50]), [2, 10, 32, 40]);
        assert_eq!(place([100, 50], [10, 0, 60, 100]), [10, 37, 60, 62], "made smaller");
        let none = place([10, 10], [5, 5, 5, 5]);
        assert_eq!([none[2] - none[0], none[3] - none[1]], [0, 0]);
    }

    #[test]
    fn the_pixel_under_the_cursor() {
        let shown = place([10, 10], [0, 0, 35, 50]);
        assert_eq!(pixel_under([2.0, 10.0], [10, 10], shown), Some([0, 0]));
        assert_eq!(pixel_under([31.9, 39.9], [10, 10], shown), Some([9, 9]));
        assert_eq!(pixel_under([5.0, 13.0], [10, 10], shown), Some([1, 1]));
        assert_eq!(pixel_under([32.0, 20.0], [10, 10], shown), None);
        assert_eq!(pixel_under([1.0, 20.0], [10, 10], shown), None);
        assert_eq!(pixel_under([1.0, 1.0], [10, 10], [0; 4]), None, "no picture");
    }

    #[test]
    fn the_edge_follows_a_drag() {
        let shown = [10, 20, 110, 70];
        assert!(is_on_edge([60.0, 30.0], 0.5, shown) && is_on_edge([66.0, 30.0], 0.5, shown));
        assert!(!is_on_edge([67.0, 30.0], 0.5, shown) && !is_on_edge([60.0, 71.0], 0.5, shown));
        assert_eq!([0.0, 35.0, 110.0, 300.0].map(|x| split_under(x, shown)), [0.0, 0.25, 1.0, 1.0]);
        assert_eq!(split_under(3.0, [0; 4]), 1.0, "no picture");
        let split = parts(TruthView::Split, false, split_under(35.0, shown), [40, 20], shown);
        assert_eq!((split[0].layer, split[0].to), (Layer::Frame, [10, 20, 35, 70]));
        assert_eq!((split[1].layer, split[1].from), (Layer::Truth, [10, 0, 40, 20]));
        assert_eq!(split[1].to, [35, 20, 110, 70]);
    }

    #[test]
    fn a_held_key_shows_the_truth() {
        let shown = |view, is_flipped| {
            let parts = parts(view, is_flipped, 0.5, [10, 10], [0, 0, 10, 10]);
            parts.iter().map(|part| part.layer).collect::<Vec<_>>()
        };
        assert_eq!(shown(TruthView::Flip, false), [Layer::Frame]);
        assert_eq!(shown(TruthView::Flip, true), [Layer::Truth]);
        assert_eq!(shown(TruthView::Split, false), [Layer::Frame, Layer::Truth]);
        assert_eq!(shown(TruthView::Split, true), [Layer::Truth]);
        assert_eq!(shown(TruthView::Off, true), [Layer::Frame], "no truth yet");
    }
}
