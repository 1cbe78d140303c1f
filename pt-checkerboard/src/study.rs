//! Compares schemes that show a surface which both reflects and refracts, at equal numbers of rays.
//!
//! A pixel should show `share * reflection + (1 - share) * refraction`. Given both images, each scheme is played through with
//! a number of rays for each pixel; what it shows then can be measured against that sum.

use crate::oracle::interleave;
use pt_core::channels::field_width;
use pt_core::rng::random4;
use pt_core::split::{split_size, split_to_flat};
use pt_shaders::records::SPLIT_FLAGS;

/// A scheme that shows a split surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// One field reflects, the other refracts; each pixel is blended with its neighbours of the other field. One ray a pixel
    /// and frame. The default.
    Blend,
    /// The fields change their path from frame to frame, and frames are averaged. One ray a pixel and frame.
    Swap,
    /// No checkerboard: both paths at once, two rays. Of a single ray a pixel every second pixel is traced, the others are
    /// interpolated.
    Both,
    /// Each ray takes one path at random, with the probability of its share.
    Random,
}

impl Scheme {
    /// All schemes.
    pub const ALL: [Self; 4] = [Self::Blend, Self::Swap, Self::Both, Self::Random];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blend => "blend (default)",
            Self::Swap => "swap per frame",
            Self::Both => "both paths",
            Self::Random => "random path",
        }
    }
}

/// A split surface: the radiance along its reflected and its refracted path.
#[derive(Clone, Copy, Debug)]
pub struct SplitSurface<'a> {
    /// Pixels of the frame.
    pub size: [u32; 2],
    /// Radiance along the reflected path, one a pixel.
    pub reflection: &'a [[f32; 3]],
    /// Radiance along the refracted path.
    pub refraction: &'a [[f32; 3]],
    /// Share of the reflection, 0 to 1.
    pub share: f32,
}

impl SplitSurface<'_> {
    /// What should be seen.
    pub fn truth(&self) -> Vec<[f32; 3]> {
        let [reflected, refracted] = [self.share, 1.0 - self.share];
        let pair = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|i| reflected * a[i] + refracted * b[i]);
        self.reflection.iter().zip(self.refraction).map(pair).collect()
    }

    /// What `scheme` shows after `rays` rays for each pixel (1 or more), averaged over frames. `frame` is the first frame's
    /// number: the next ones draw other random numbers.
    pub fn shown(&self, scheme: Scheme, rays: u32, frame: u32) -> Vec<[f32; 3]> {
        match scheme {
            Scheme::Blend => self.blended(),
            Scheme::Swap => self.mean(rays, |pixel, ray| {
                let [x, y] = self.place(pixel);
                self.path((x + y + frame + ray).is_multiple_of(2), 0.5, pixel)
            }),
            Scheme::Both if rays > 1 => self.truth(),
            Scheme::Both => self.interpolated(),
            Scheme::Random => self.mean(rays, |pixel, ray| {
                let [number, ..] = random4(self.place(pixel), frame + ray, 0, 0);
                self.path(number < self.share, self.share, pixel)
            }),
        }
    }

    fn place(&self, pixel: usize) -> [u32; 2] {
        [pixel as u32 % self.size[0], pixel as u32 / self.size[0]]
    }

    /// Light of one path, divided by the probability to take it.
    fn path(&self, reflects: bool, probability: f32, pixel: usize) -> [f32; 3] {
        if reflects {
            self.reflection[pixel].map(|v| v * self.share / probability)
        } else {
            self.refraction[pixel].map(|v| v * (1.0 - self.share) / (1.0 - probability))
        }
    }

    fn mean(&self, rays: u32, ray: impl Fn(usize, u32) -> [f32; 3]) -> Vec<[f32; 3]> {
        let pixel = |pixel| {
            let sum = (0..rays).fold([0.0f64; 3], |sum, i| {
                let c = ray(pixel, i);
                [0, 1, 2].map(|k| sum[k] + f64::from(c[k]))
            });
            sum.map(|v| (v / f64::from(rays)) as f32)
        };
        (0..self.reflection.len()).map(pixel).collect()
    }

    /// More rays show the same: the paths are those of the pixels' centres.
    fn blended(&self) -> Vec<[f32; 3]> {
        let [width, height] = split_size(self.size);
        let half = field_width(self.size[0]);
        let split: Vec<[f32; 4]> = (0..width * height)
            .map(|i| {
                let [x, y] = split_to_flat([i % width, i / width], half);
                if x >= self.size[0] {
                    return [0.0; 4];
                }
                let [r, g, b] = self.path(i % width < half, 0.5, (y * self.size[0] + x) as usize);
                [r, g, b, SPLIT_FLAGS as f32]
            })
            .collect();
        let motion = vec![[0.0; 4]; split.len()];
        let (flat, _) = interleave(&split, &motion, self.size, true);
        flat.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
    }

    fn interpolated(&self) -> Vec<[f32; 3]> {
        let truth = self.truth();
        let [width, height] = self.size.map(i64::from);
        let pixel = |i: usize| {
            let [x, y] = self.place(i).map(i64::from);
            if (x + y) & 1 == 0 {
                return truth[i];
            }
            let around: Vec<[f32; 3]> = [(-1, 0), (1, 0), (0, -1), (0, 1)]
                .into_iter()
                .map(|(dx, dy)| (x + dx, y + dy))
                .filter(|&(x, y)| (0..width).contains(&x) && (0..height).contains(&y))
                .map(|(x, y)| truth[(y * width + x) as usize])
                .collect();
            [0, 1, 2].map(|k| around.iter().map(|c| c[k]).sum::<f32>() / around.len().max(1) as f32)
        };
        (0..truth.len()).map(pixel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface<'a>(reflection: &'a [[f32; 3]], refraction: &'a [[f32; 3]], share: f32) -> SplitSurface<'a> {
        SplitSurface { size: [17, 8], reflection, refraction, share }
    }

    /// Constant light on both paths: every scheme shows the sum, at once or in the mean.
    #[test]
    fn constant_light_is_shown_as_it_is() {
        let (reflection, refraction) = (vec![[4.0; 3]; 136], vec![[1.0; 3]; 136]);
        let surface = surface(&reflection, &refraction, 0.25);
        assert!(surface.truth().iter().all(|c| *c == [1.75; 3]));
        for (scheme, rays) in [(Scheme::Blend, 1), (Scheme::Swap, 2), (Scheme::Both, 1), (Scheme::Both, 2)] {
            let shown = surface.shown(scheme, rays, 0);
            assert!(shown.iter().flatten().all(|v| (v - 1.75).abs() < 1e-6), "{scheme:?}");
        }
        let random = surface.shown(Scheme::Random, 4096, 0);
        let mean = random.iter().map(|c| f64::from(c[0])).sum::<f64>() / 136.0;
        // 557056 choices between 1 and 4: a standard error of 1.7e-3.
        assert!((mean - 1.75).abs() < 7e-3, "{mean}");
        let one = surface.shown(Scheme::Random, 1, 0);
        assert!(one.iter().all(|c| c[0] == 1.0 || c[0] == 4.0), "one path at full weight");
    }

    /// A checker of the two paths is what one swapped frame shows, and the next one its complement.
    #[test]
    fn swapped_frames_complement_each_other() {
        let reflection: Vec<[f32; 3]> = (0..136).map(|i| [i as f32; 3]).collect();
        let refraction: Vec<[f32; 3]> = (0..136).map(|i| [200.0 - i as f32; 3]).collect();
        let surface = surface(&reflection, &refraction, 0.3);
        let (first, second) = (surface.shown(Scheme::Swap, 1, 0), surface.shown(Scheme::Swap, 1, 1));
        let truth = surface.truth();
        for i in 0..136 {
            assert!(((first[i][0] + second[i][0]) / 2.0 - truth[i][0]).abs() < 1e-4);
        }
        assert_eq!(surface.shown(Scheme::Swap, 8, 0), surface.shown(Scheme::Swap, 2, 0));
    }
}
