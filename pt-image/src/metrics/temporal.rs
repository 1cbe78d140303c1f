//! Errors of the change from frame to frame. A sequence flickers when its change differs from the change of its reference, whatever each frame's own
//! error is: a constant error does not count, and a light that goes on does not either.

use super::{MetricError, RELMSE_EPSILON, check_pair};
use crate::image_file::LinearImage;

/// Side of the blocks of [`TemporalError::block`], pixels.
pub const TEMPORAL_BLOCK: usize = 16;

/// Two frames of a sequence, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct FramePair<'a> {
    /// The frame.
    pub now: &'a LinearImage,
    /// The frame before it.
    pub before: &'a LinearImage,
}

/// Where the surface of each pixel was in the frame before.
#[derive(Clone, Debug, PartialEq)]
pub struct Correspondence {
    /// For each pixel, rows from the top: where it was minus where it is, pixels; `None` where the frame before did not show it, or where it was
    /// outside of the image.
    pub offsets: Vec<Option<[f32; 2]>>,
}

impl Correspondence {
    /// Nothing moves in an image of `size`, pixels.
    pub fn still(size: [u32; 2]) -> Self {
        Self { offsets: vec![Some([0.0; 2]); size[0] as usize * size[1] as usize] }
    }
}

/// Errors of the change between two frames; 0: as in the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct TemporalError {
    /// Mean over pixels and channels of d^2 / (b^2 + epsilon): grain that moves. Here and below a is the sequence, b its reference, x' where pixel x
    /// was before, d = (a(x) - a_before(x')) - (b(x) - b_before(x')), bilinear at x', and epsilon [`RELMSE_EPSILON`].
    pub pixel: f64,
    /// Mean over blocks of 16 x 16 pixels and channels of mean(d)^2 / (mean(b)^2 + epsilon): light that breathes. Blocks with less than half of
    /// their pixels are left out.
    pub block: f64,
    /// Share of the pixels that count: those that have been seen before.
    pub counted: f64,
}

/// Compares the change of `a` with the change of its reference `b`.
///
/// # Errors
/// [`MetricError::Size`] unless all images and the correspondence have one size, [`MetricError::NonFinite`].
pub fn temporal_error(
    a: FramePair<'_>,
    b: FramePair<'_>,
    motion: &Correspondence,
) -> Result<TemporalError, MetricError> {
    check_pair(a.now, b.now)?;
    check_pair(a.before, b.before)?;
    check_pair(a.now, a.before)?;
    let (width, height) = (a.now.width as usize, a.now.height as usize);
    assert_eq!(motion.offsets.len(), width * height, "motion of an image of another size");
    let across = width.div_ceil(TEMPORAL_BLOCK);
    let mut blocks = vec![Block::default(); across * height.div_ceil(TEMPORAL_BLOCK)];
    let (mut sum, mut counted) = (0.0, 0_usize);
    for (index, offset) in motion.offsets.iter().enumerate() {
        let (x, y) = (index % width, index / width);
        let block = &mut blocks[y / TEMPORAL_BLOCK * across + x / TEMPORAL_BLOCK];
        block.pixels += 1;
        let before = offset.and_then(|[dx, dy]| {
            let at = [x as f64 + f64::from(dx), y as f64 + f64::from(dy)];
            Some([bilinear(a.before, at)?, bilinear(b.before, at)?])
        });
        let Some([a_before, b_before]) = before else { continue };
        counted += 1;
        block.counted += 1;
        for channel in 0..3 {
            let (a_now, b_now) =
                (f64::from(a.now.pixels[index][channel]), f64::from(b.now.pixels[index][channel]));
            let d = (a_now - a_before[channel]) - (b_now - b_before[channel]);
            sum += d * d / (b_now * b_now + RELMSE_EPSILON);
            block.difference[channel] += d;
            block.reference[channel] += b_now;
        }
    }
    let terms: Vec<f64> =
        blocks.iter().filter(|b| b.counted > 0 && 2 * b.counted >= b.pixels).map(Block::error).collect();
    Ok(TemporalError {
        pixel: sum / (3 * counted.max(1)) as f64,
        block: terms.iter().sum::<f64>() / terms.len().max(1) as f64,
        counted: counted as f64 / (width * height).max(1) as f64,
    })
}

/// Sums over a block.
#[derive(Clone, Copy, Default)]
struct Block {
    pixels: usize,
    counted: usize,
    difference: [f64; 3],
    reference: [f64; 3],
}

impl Block {
    fn error(&self) -> f64 {
        let n = self.counted as f64;
        let term = |channel: usize| {
            let (d, b) = (self.difference[channel] / n, self.reference[channel] / n);
            d * d / (b * b + RELMSE_EPSILON)
        };
        (0..3).map(term).sum::<f64>() / 3.0
    }
}

/// At `at` pixels from the middle of the first pixel; `None` outside of the pixels' middles.
fn bilinear(image: &LinearImage, at: [f64; 2]) -> Option<[f64; 3]> {
    let last = [image.width - 1, image.height - 1].map(f64::from);
    if !(0..2).all(|axis| (0.0..=last[axis]).contains(&at[axis])) {
        return None;
    }
    let cell = [0, 1].map(|axis| at[axis].floor().min((last[axis] - 1.0).max(0.0)));
    let part = [0, 1].map(|axis| at[axis] - cell[axis]);
    let [x, y] = cell.map(|c| c as usize);
    let width = image.width as usize;
    let mut sum = [0.0; 3];
    for (dy, weight_y) in [(0, 1.0 - part[1]), (1, part[1])] {
        for (dx, weight_x) in [(0, 1.0 - part[0]), (1, part[0])] {
            let weight = weight_x * weight_y;
            if weight > 0.0 {
                let pixel = image.pixels[(y + dy) * width + x + dx];
                (0..3).for_each(|channel| sum[channel] += weight * f64::from(pixel[channel]));
            }
        }
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::ImageState;

    const SIZE: [u32; 2] = [40, 24];

    fn image(value: impl Fn(f64, f64) -> f64) -> LinearImage {
        let pixels = (0..SIZE[0] * SIZE[1])
            .map(|i| [value(f64::from(i % SIZE[0]), f64::from(i / SIZE[0])) as f32; 3])
            .collect();
        LinearImage { width: SIZE[0], height: SIZE[1], pixels, state: ImageState::SceneReferred }
    }

    /// Numbers in -1..1 that repeat only after a long time.
    fn hash(x: f64, y: f64, frame: f64) -> f64 {
        2.0 * ((x * 12.9898 + y * 78.233 + frame * 37.719).sin() * 43758.5453).fract().abs() - 1.0
    }

    fn moved(pixels: f32) -> Correspondence {
        Correspondence { offsets: vec![Some([-pixels, 0.0]); (SIZE[0] * SIZE[1]) as usize] }
    }

    #[test]
    fn a_constant_error_and_a_change_of_the_reference_do_not_count() {
        let [now, before] = [2.0, 1.0].map(|light| image(|x, _| light * (1.0 + x)));
        let [now_off, before_off] = [2.0, 1.0].map(|light| image(|x, _| light * (1.0 + x) + 0.5));
        let still = Correspondence::still(SIZE);
        let (a, b) =
            (FramePair { now: &now_off, before: &before_off }, FramePair { now: &now, before: &before });
        let error = temporal_error(a, b, &still).unwrap();
        assert!(error.pixel < 1e-12 && error.block < 1e-12 && error.counted == 1.0, "{error:?}");
    }

    #[test]
    fn grain_is_seen_by_pixels_and_breathing_by_blocks() {
        let one = image(|_, _| 1.0);
        let still = Correspondence::still(SIZE);
        let b = FramePair { now: &one, before: &one };
        let [first, second] = [0.0, 1.0].map(|frame| image(|x, y| 1.0 + 0.1 * hash(x, y, frame)));
        let grain = temporal_error(FramePair { now: &first, before: &second }, b, &still).unwrap();
        // Differences of two uniform numbers: variance 2 / 3 of their range; means of 256 of them.
        let expected = 0.01 * 2.0 / 3.0 / 1.01;
        assert!((grain.pixel / expected - 1.0).abs() < 0.1, "{grain:?} {expected}");
        assert!(grain.block < 0.02 * grain.pixel, "{grain:?}");
        let brighter = image(|_, _| 1.1);
        let breath = temporal_error(FramePair { now: &brighter, before: &one }, b, &still).unwrap();
        assert!((breath.pixel - 0.01 / 1.01).abs() < 1e-6, "{breath:?}");
        assert!((breath.block - breath.pixel).abs() < 1e-9, "{breath:?}");
    }

    /// A pattern that moves by 2.5 pixels: its change is that of the reference only along the motion.
    #[test]
    fn motion_is_compensated() {
        let pattern = |x: f64| 1.0 + 0.02 * x;
        let [now, before] = [2.5, 0.0].map(|shift| image(|x, _| pattern(x - shift)));
        let [clean_now, clean_before] = [image(|_, _| 1.0), image(|_, _| 1.0)];
        let a = FramePair { now: &now, before: &before };
        let b = FramePair { now: &clean_now, before: &clean_before };
        let along = temporal_error(a, b, &moved(2.5)).unwrap();
        assert!(along.pixel < 1e-10, "{along:?}");
        // Three columns come from outside.
        assert!((along.counted - 37.0 / 40.0).abs() < 1e-9, "{along:?}");
        let still = temporal_error(a, b, &Correspondence::still(SIZE)).unwrap();
        assert!(still.pixel > 1e-3, "{still:?}");
    }

    #[test]
    fn what_was_not_seen_before_does_not_count() {
        let one = image(|_, _| 1.0);
        let spoiled = image(|x, _| if x < 20.0 { 5.0 } else { 1.0 });
        let mut motion = Correspondence::still(SIZE);
        for (i, offset) in motion.offsets.iter_mut().enumerate() {
            if i % 40 < 20 {
                *offset = None;
            }
        }
        let (a, b) = (FramePair { now: &spoiled, before: &one }, FramePair { now: &one, before: &one });
        let error = temporal_error(a, b, &motion).unwrap();
        assert_eq!((error.pixel, error.block, error.counted), (0.0, 0.0, 0.5));
    }
}
