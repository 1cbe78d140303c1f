//! Where the surfaces of a frame were in the frame before, as far as the files say it.

use anyhow::{Context, Result};
use pt_core::Surfaces;
use pt_image::image_file::{LayeredImage, PictureFile};
use pt_image::metrics::Correspondence;
use std::path::Path;

/// Which files of a sequence say it, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionSource {
    /// Layers `motion` and `view_depth`: surfaces that come into view do not count.
    Surfaces(Side),
    /// The layer `motion` of `pt reference`, which has no distances: surfaces that come into view count, too.
    Vectors(Side),
    /// No file does.
    Still,
}

/// One of the two sequences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The image.
    A,
    /// Its reference.
    B,
}

impl MotionSource {
    /// The best that the files of a frame, image and reference, have; of the reference before that of the image.
    pub fn of(files: &[PictureFile; 2]) -> Self {
        let motions = [Side::B, Side::A].map(|side| Some((side, side.of(files).layers.as_ref()?)));
        for (side, file) in motions.iter().flatten() {
            if Surfaces::of_file(file).is_some() {
                return Self::Surfaces(*side);
            }
        }
        let mut found = motions.iter().flatten();
        let vectors = found.find(|(_, file)| vectors(file).is_some());
        vectors.map_or(Self::Still, |(side, _)| Self::Vectors(*side))
    }

    /// As it is printed.
    pub fn text(self) -> &'static str {
        match self {
            Self::Surfaces(Side::A) => {
                "layers motion and view_depth of a; pixels that come into view do not count"
            }
            Self::Surfaces(Side::B) => {
                "layers motion and view_depth of b; pixels that come into view do not count"
            }
            Self::Vectors(Side::A) => "layer motion of a",
            Self::Vectors(Side::B) => "layer motion of b",
            Self::Still => {
                "none in the files, each pixel is compared with itself, as a still camera needs; pt render --aov motion,view_depth writes it"
            }
        }
    }

    /// The motion of a frame, whose files were read from the paths.
    ///
    /// # Errors
    /// A file that lacks the layers which the first frame had.
    pub fn read(self, paths: [&Path; 2], files: &[PictureFile; 2]) -> Result<Motion> {
        let (side, is_surfaces) = match self {
            Self::Surfaces(side) => (side, true),
            Self::Vectors(side) => (side, false),
            Self::Still => return Ok(Motion::Still),
        };
        let layers = side.of(files).layers.as_ref();
        let found = match is_surfaces {
            true => layers.and_then(Surfaces::of_file).map(Motion::Surfaces),
            false => layers.and_then(vectors).map(Motion::Vectors),
        };
        found.with_context(|| {
            format!("{}: lacks the layers of motion that the first frame has", side.of(&paths).display())
        })
    }
}

impl Side {
    fn of<T>(self, [a, b]: &[T; 2]) -> &T {
        match self {
            Self::A => a,
            Self::B => b,
        }
    }
}

/// The motion of a frame.
pub enum Motion {
    /// With distances.
    Surfaces(Surfaces),
    /// Offsets to the frame before, pixels.
    Vectors(Correspondence),
    /// Nothing moves.
    Still,
}

impl Motion {
    /// Where the pixels of the picture of `size` were in the frame before, whose motion is `before`.
    pub fn since(&self, before: &Self, size: [u32; 2]) -> Correspondence {
        match (self, before) {
            (Self::Surfaces(now), Self::Surfaces(before)) => now.seen_in(before, size),
            (Self::Vectors(offsets), _) => offsets.clone(),
            _ => Correspondence::still(size),
        }
    }
}

/// The layer `motion` in UV as offsets in pixels; where `coverage` says that no surface is seen, nothing is known.
fn vectors(file: &LayeredImage) -> Option<Correspondence> {
    let [x, y] = ["X", "Y"].map(|component| file.channel("motion", component));
    let (x, y) = (x?.to_f32(), y?.to_f32());
    let coverage = file.channel("coverage", "A").map(|samples| samples.to_f32());
    let is_seen = |i: usize| coverage.as_ref().is_none_or(|coverage| coverage[i] > 0.0);
    let offset = |i: usize| is_seen(i).then(|| [x[i] * file.width as f32, y[i] * file.height as f32]);
    Some(Correspondence { offsets: (0..x.len()).map(offset).collect() })
}
