//! Split frame <-> flat frame: the host twin of `checkerboard.glsl`.
//!
//! The even field (flat x and y of equal parity) is the left half of a split image, the odd field the right half; each is
//! `field_width = ceil(W/2)` wide. For odd W the last column of one field, which alternates from row to row, has no flat
//! pixel.

use pt_shaders::records::field_width;

/// Flat pixel of a split pixel. For odd W, x comes out as W where there is no flat pixel.
pub const fn split_to_flat(split: [u32; 2], field_width: u32) -> [u32; 2] {
    let [x, y] = split;
    let odd_field = x >= field_width;
    let column = if odd_field { x - field_width } else { x };
    [2 * column + ((y & 1) ^ odd_field as u32), y]
}

/// Split pixel of a flat pixel.
pub const fn flat_to_split(flat: [u32; 2], field_width: u32) -> [u32; 2] {
    let [x, y] = flat;
    let odd_field = (x ^ y) & 1 == 1;
    [(x >> 1) + if odd_field { field_width } else { 0 }, y]
}

/// Extent of the split image of a flat frame.
pub const fn split_size(flat_size: [u32; 2]) -> [u32; 2] {
    [2 * field_width(flat_size[0]), flat_size[1]]
}

/// Sorts the pixels of a flat frame (scan-line order) into its two fields; split pixels without a flat pixel get `fill`.
///
/// # Panics
/// When `flat` has not `flat_size[0] * flat_size[1]` pixels.
pub fn to_split<T: Copy>(flat: &[T], flat_size: [u32; 2], fill: T) -> Vec<T> {
    let [width, height] = flat_size;
    assert_eq!(flat.len(), width as usize * height as usize, "pixels of a {width}x{height} frame");
    let [split_width, _] = split_size(flat_size);
    (0..height)
        .flat_map(|y| (0..split_width).map(move |x| split_to_flat([x, y], split_width / 2)))
        .map(|[x, y]| if x < width { flat[y as usize * width as usize + x as usize] } else { fill })
        .collect()
}

/// Interleaves the two fields of a split image: the inverse of [`to_split`].
///
/// # Panics
/// When `split` has not as many pixels as [`split_size`] says.
pub fn to_flat<T: Copy>(split: &[T], flat_size: [u32; 2]) -> Vec<T> {
    let [width, height] = flat_size;
    let [split_width, _] = split_size(flat_size);
    assert_eq!(
        split.len(),
        split_width as usize * height as usize,
        "split pixels of a {width}x{height} frame"
    );
    (0..height)
        .flat_map(|y| (0..width).map(move |x| flat_to_split([x, y], split_width / 2)))
        .map(|[x, y]| split[y as usize * split_width as usize + x as usize])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check_bijection(size: [u32; 2]) {
        let [width, height] = size;
        let half = field_width(width);
        let mut hit = vec![false; (2 * half * height) as usize];
        for y in 0..height {
            for x in 0..width {
                let split = flat_to_split([x, y], half);
                assert!(split[0] < 2 * half, "{size:?}: flat ({x}, {y}) leaves the split image");
                assert_eq!(split_to_flat(split, half), [x, y], "{size:?}");
                assert_eq!(split[0] < half, x % 2 == y % 2, "{size:?}: field of ({x}, {y})");
                let seen = &mut hit[(split[1] * 2 * half + split[0]) as usize];
                assert!(!*seen, "{size:?}: {split:?} twice");
                *seen = true;
            }
        }
        for (index, _) in hit.iter().enumerate().filter(|(_, seen)| !**seen) {
            let split = [index as u32 % (2 * half), index as u32 / (2 * half)];
            assert_eq!(split_to_flat(split, half), [width, split[1]], "{size:?}: only column W is left over");
            assert!(width % 2 == 1);
        }
    }

    /// Field by field, written out.
    #[test]
    fn a_small_frame_is_sorted() {
        let flat: Vec<u32> = (0..6).collect();
        assert_eq!(to_split(&flat, [3, 2], 9), [0, 2, 1, 9, 4, 9, 3, 5]);
    }

    #[test]
    fn bijection_at_small_sizes() {
        for width in 1..=9 {
            for height in 1..=5 {
                check_bijection([width, height]);
            }
        }
    }

    proptest! {
        #[test]
        fn bijection_at_any_size(width in 1u32..300, height in 1u32..40) {
            check_bijection([width, height]);
        }

        #[test]
        fn fields_come_together_again(width in 1u32..60, height in 1u32..20) {
            let flat: Vec<u32> = (0..width * height).collect();
            prop_assert_eq!(to_flat(&to_split(&flat, [width, height], u32::MAX), [width, height]), flat);
        }
    }
}
