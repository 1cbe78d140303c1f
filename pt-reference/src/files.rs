//! Estimates and checkpoints as EXR files.

use crate::film::{Estimate, EstimatePixel, FilmState};
use crate::identity::Identity;
use crate::records::{FilmPixel, FirstHitPixel};
use glam::{UVec2, Vec2, Vec3};
use pt_image::image_file::{Channel, ImageFileError, Layer, LayeredImage, Samples};
use pt_shaders::records::Background;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Metadata: samples of each pixel.
const SAMPLES: &str = "samples";
/// Metadata: ranges of sample indices that went in, `a..b` separated by commas.
const SPP_RANGES: &str = "spp_ranges";
/// Metadata: samples dropped because they were not finite.
const DROPPED: &str = "dropped";
/// Metadata: what the file is.
const KIND: &str = "kind";
const KIND_ESTIMATE: &str = "estimate";
const KIND_CHECKPOINT: &str = "checkpoint";

/// Why a file of this crate could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceFileError {
    /// Not readable as an image.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// Readable, but not of the expected kind.
    #[error("{path}: {what}", path = path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is missing or wrong.
        what: String,
    },
}

/// An estimate with the samples that it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimateFile {
    /// The image.
    pub estimate: Estimate,
    /// Sample indices that went in, in increasing order.
    pub ranges: Vec<Range<u32>>,
    /// Whether the image has alpha.
    pub background: Background,
    /// The identity of the render.
    pub identity: Identity,
}

/// Sums of an unfinished render.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The sums.
    pub state: FilmState,
    /// Sample indices that went in.
    pub samples: Range<u32>,
    /// What is being rendered.
    pub identity: Identity,
}

impl EstimateFile {
    /// The layers: radiance (unnamed), `variance` of the mean, and what camera rays see first: `albedo`, `normal` (world
    /// space), `depth` (metres), `motion` (UV), `coverage`. With a transparent background the coverage is the alpha of the radiance too,
    /// which is premultiplied: the camera rays that see no surface have brought nothing.
    ///
    /// # Errors
    /// A size that no image may have.
    pub fn to_image(&self) -> Result<LayeredImage, ImageFileError> {
        let Estimate { size, samples, dropped, pixels } = &self.estimate;
        let mut image = LayeredImage::new(size[0], size[1])?;
        let rgb = ["R", "G", "B"];
        let radiance = match self.background {
            Background::Environment => layer("", &rgb, pixels.iter().map(|p| p.mean.to_array())),
            Background::Transparent => {
                let rgba = pixels.iter().map(|p| p.mean.extend(p.coverage).to_array());
                layer("", &["R", "G", "B", "A"], rgba)
            }
        };
        image.layers = vec![
            radiance,
            layer("variance", &rgb, pixels.iter().map(|p| p.variance.to_array())),
            layer("albedo", &rgb, pixels.iter().map(|p| p.albedo.to_array())),
            layer("normal", &["X", "Y", "Z"], pixels.iter().map(|p| p.normal.to_array())),
            layer("depth", &["Z"], pixels.iter().map(|p| [p.depth])),
            layer("motion", &["X", "Y"], pixels.iter().map(|p| p.motion.to_array())),
            layer("coverage", &["A"], pixels.iter().map(|p| [p.coverage])),
        ];
        image.metadata.extend(self.identity.metadata());
        image.metadata.insert(KIND.into(), KIND_ESTIMATE.into());
        image.metadata.insert(SAMPLES.into(), samples.to_string());
        image.metadata.insert(DROPPED.into(), dropped.to_string());
        image.metadata.insert(SPP_RANGES.into(), format_ranges(&self.ranges));
        Ok(image)
    }

    /// Reads what [`EstimateFile::to_image`] made.
    ///
    /// # Errors
    /// A file that is damaged, or no estimate.
    pub fn read(path: &Path) -> Result<Self, ReferenceFileError> {
        let image = LayeredImage::read_exr(path)?;
        let source = Source { image: &image, path };
        source.check_kind(KIND_ESTIMATE, "a file of `pt reference`")?;
        let [mean, variance, albedo] =
            ["", "variance", "albedo"].map(|name| source.planes(name, ["R", "G", "B"]));
        let (mean, variance, albedo) = (mean?, variance?, albedo?);
        let normal = source.planes("normal", ["X", "Y", "Z"])?;
        let [depth] = source.planes("depth", ["Z"])?;
        let motion = source.planes("motion", ["X", "Y"])?;
        let [coverage] = source.planes("coverage", ["A"])?;
        let pixels = (0..depth.len()).map(|i| EstimatePixel {
            mean: vec3(&mean, i),
            variance: vec3(&variance, i),
            albedo: vec3(&albedo, i),
            normal: vec3(&normal, i),
            depth: depth[i],
            motion: Vec2::new(motion[0][i], motion[1][i]),
            coverage: coverage[i],
        });
        Ok(Self {
            estimate: Estimate {
                size: [image.width, image.height],
                samples: source.number(SAMPLES)?,
                dropped: source.number(DROPPED)?,
                pixels: pixels.collect(),
            },
            ranges: source.ranges()?,
            background: match image.channel("", "A") {
                Some(_) => Background::Transparent,
                None => Background::Environment,
            },
            identity: Identity::from_metadata(&image.metadata),
        })
    }
}

impl Checkpoint {
    /// Writes the sums, without loss.
    ///
    /// # Errors
    /// [`ImageFileError`]; an older file under `path` stays as it is unless the new one is complete.
    pub fn write(&self, path: &Path) -> Result<(), ImageFileError> {
        let FilmState { size, film, first_hit, dropped } = &self.state;
        let mut image = LayeredImage::new(size[0], size[1])?;
        let rgb = ["R", "G", "B"];
        image.layers = vec![
            layer("sum", &rgb, film.iter().map(|p| p.sum.to_array())),
            layer("sum_rest", &rgb, film.iter().map(|p| p.sum_rest.to_array())),
            layer("square", &rgb, film.iter().map(|p| p.square.to_array())),
            layer("square_rest", &rgb, film.iter().map(|p| p.square_rest.to_array())),
            counts("rays", film, |p| p.rays),
            counts("shadow_rays", film, |p| p.shadow_rays),
            layer("albedo", &rgb, first_hit.iter().map(|p| p.albedo.to_array())),
            layer("normal", &["X", "Y", "Z"], first_hit.iter().map(|p| p.normal.to_array())),
            layer("depth", &["Z"], first_hit.iter().map(|p| [p.depth])),
            layer("motion", &["X", "Y"], first_hit.iter().map(|p| p.motion.to_array())),
            layer("hits", &["A"], first_hit.iter().map(|p| [p.hits])),
        ];
        image.metadata.extend(self.identity.metadata());
        image.metadata.insert(KIND.into(), KIND_CHECKPOINT.into());
        image.metadata.insert(DROPPED.into(), dropped.to_string());
        image.metadata.insert(SPP_RANGES.into(), format_ranges(std::slice::from_ref(&self.samples)));
        image.write_exr(path)
    }

    /// Reads what [`Checkpoint::write`] wrote.
    ///
    /// # Errors
    /// A file that is damaged, or no checkpoint.
    pub fn read(path: &Path) -> Result<Self, ReferenceFileError> {
        let image = LayeredImage::read_exr(path)?;
        let source = Source { image: &image, path };
        source.check_kind(KIND_CHECKPOINT, "a checkpoint")?;
        let rgb = |name| source.planes(name, ["R", "G", "B"]);
        let (sum, sum_rest, square, square_rest) =
            (rgb("sum")?, rgb("sum_rest")?, rgb("square")?, rgb("square_rest")?);
        let (albedo, normal) = (rgb("albedo")?, source.planes("normal", ["X", "Y", "Z"])?);
        let [depth] = source.planes("depth", ["Z"])?;
        let motion = source.planes("motion", ["X", "Y"])?;
        let [hits] = source.planes("hits", ["A"])?;
        let (rays, shadow_rays) = (source.counts("rays")?, source.counts("shadow_rays")?);
        let pixels = 0..hits.len();
        let film = pixels.clone().map(|i| FilmPixel {
            sum: vec3(&sum, i),
            sum_rest: vec3(&sum_rest, i),
            square: vec3(&square, i),
            square_rest: vec3(&square_rest, i),
            rays: rays[i],
            shadow_rays: shadow_rays[i],
            padding: UVec2::ZERO,
        });
        let first_hit = pixels.map(|i| FirstHitPixel {
            albedo: vec3(&albedo, i),
            normal: vec3(&normal, i),
            depth: depth[i],
            motion: Vec2::new(motion[0][i], motion[1][i]),
            hits: hits[i],
        });
        let ranges = source.ranges()?;
        let [samples] = ranges.as_slice() else {
            return Err(source.wrong("its range of samples is damaged"));
        };
        Ok(Self {
            state: FilmState {
                size: [image.width, image.height],
                film: film.collect(),
                first_hit: first_hit.collect(),
                dropped: source.number(DROPPED)?,
            },
            samples: samples.clone(),
            identity: Identity::from_metadata(&image.metadata),
        })
    }
}

/// Files beside `path` as the tools of Open Image Denoise take them: `NAME_0016spp.hdr.exr` (radiance), `.alb.exr` (albedo) and
/// `.nrm.exr` (world-space normal), each with the channels R, G, B. Radiance is that of the estimate: premultiplied where the background is
/// transparent.
///
/// # Errors
/// A size that no image may have.
pub fn denoiser_inputs(
    path: &Path,
    estimate: &Estimate,
) -> Result<Vec<(PathBuf, LayeredImage)>, ImageFileError> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let suffix = format!("_{:04}spp", estimate.samples);
    let name = stem.strip_suffix(".hdr").unwrap_or(&stem);
    let name = name.strip_suffix(&suffix).unwrap_or(name);
    type Value = fn(&EstimatePixel) -> Vec3;
    let parts: [(&str, Value); 3] = [("hdr", |p| p.mean), ("alb", |p| p.albedo), ("nrm", |p| p.normal)];
    parts
        .into_iter()
        .map(|(part, value)| {
            let mut image = LayeredImage::new(estimate.size[0], estimate.size[1])?;
            let pixels = estimate.pixels.iter().map(|p| value(p).to_array());
            image.layers = vec![layer("", &["R", "G", "B"], pixels)];
            Ok((path.with_file_name(format!("{name}{suffix}.{part}.exr")), image))
        })
        .collect()
}

fn layer<const N: usize>(name: &str, channels: &[&str; N], pixels: impl Iterator<Item = [f32; N]>) -> Layer {
    let values: Vec<f32> = pixels.flatten().collect();
    Layer::from_interleaved(name, channels, N, &values)
}

fn counts(name: &str, film: &[FilmPixel], count: fn(&FilmPixel) -> u32) -> Layer {
    let samples = Samples::U32(film.iter().map(count).collect());
    Layer { name: name.into(), channels: vec![Channel { name: "N".into(), samples }] }
}

fn vec3(planes: &[Vec<f32>; 3], i: usize) -> Vec3 {
    Vec3::new(planes[0][i], planes[1][i], planes[2][i])
}

fn format_ranges(ranges: &[Range<u32>]) -> String {
    let texts: Vec<_> = ranges.iter().map(|range| format!("{}..{}", range.start, range.end)).collect();
    texts.join(",")
}

struct Source<'a> {
    image: &'a LayeredImage,
    path: &'a Path,
}

impl Source<'_> {
    fn wrong(&self, what: impl Into<String>) -> ReferenceFileError {
        ReferenceFileError::Content { path: self.path.into(), what: what.into() }
    }

    fn text(&self, key: &str) -> Result<&str, ReferenceFileError> {
        let value = self.image.metadata.get(key);
        value.map(String::as_str).ok_or_else(|| self.wrong(format!("its header lacks pt.{key}")))
    }

    fn check_kind(&self, expected: &str, name: &str) -> Result<(), ReferenceFileError> {
        match self.image.metadata.get(KIND) {
            Some(kind) if kind == expected => Ok(()),
            _ => Err(self.wrong(format!("is not {name}"))),
        }
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, ReferenceFileError> {
        self.text(key)?.parse().map_err(|_| self.wrong(format!("pt.{key} in its header is no number")))
    }

    fn ranges(&self) -> Result<Vec<Range<u32>>, ReferenceFileError> {
        let parse = |text: &str| {
            let (start, end) = text.split_once("..")?;
            let range = start.parse().ok()?..end.parse().ok()?;
            (range.start <= range.end).then_some(range)
        };
        let ranges: Option<Vec<_>> = self.text(SPP_RANGES)?.split(',').map(parse).collect();
        ranges.ok_or_else(|| self.wrong("its ranges of samples are damaged"))
    }

    fn counts(&self, layer: &str) -> Result<&[u32], ReferenceFileError> {
        match self.image.channel(layer, "N") {
            Some(Samples::U32(values)) => Ok(values),
            _ => Err(self.wrong(format!("lacks the counts of layer {layer:?}"))),
        }
    }

    fn planes<const N: usize>(
        &self,
        layer: &str,
        channels: [&str; N],
    ) -> Result<[Vec<f32>; N], ReferenceFileError> {
        let mut planes = [const { Vec::new() }; N];
        for (plane, channel) in planes.iter_mut().zip(channels) {
            let samples = self.image.channel(layer, channel);
            *plane = samples
                .ok_or_else(|| self.wrong(format!("lacks channel {channel} of layer {layer:?}")))?
                .to_f32();
        }
        Ok(planes)
    }
}
