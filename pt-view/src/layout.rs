//! Where the picture is in the window.

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
}
