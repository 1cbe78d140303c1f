//! The images that the chain runs on: files, and frames of capture folders.

use anyhow::{Context, Result, ensure};
use pt_core::ChannelImages;
use pt_core::capture::folder::{CaptureFolder, RecordedFrame};
use pt_core::capture::keys;
use pt_image::image_file::{ImageState, LayeredImage, LinearImage, Samples};
use pt_shaders::channels::{FLAT_COLOR, FLAT_MOTION};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Where an image comes from.
pub enum Source {
    /// An image file.
    File(PathBuf),
    /// A frame of a folder, by its number, and its file.
    Frame(Rc<CaptureFolder>, u32, PathBuf),
}

impl Source {
    /// The images of the arguments: a folder stands for all of its frames.
    pub fn list(inputs: &[PathBuf]) -> Result<Vec<Self>> {
        let mut sources = Vec::new();
        for path in inputs {
            if path.is_dir() {
                let folder = Rc::new(CaptureFolder::open(path)?);
                for (number, entry) in folder.range().zip(&folder.index.frames) {
                    sources.push(Self::Frame(folder.clone(), number, path.join(&entry.images.name)));
                }
            } else {
                sources.push(Self::File(path.clone()));
            }
        }
        Ok(sources)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path) | Self::Frame(_, _, path) => path,
        }
    }

    /// Reads the image.
    pub fn read(&self) -> Result<Input> {
        match self {
            Self::File(path) => read_file(path),
            Self::Frame(folder, number, _) => Ok(Input::Frame(Box::new(folder.frame(*number)?))),
        }
    }
}

/// An image with what belongs to it.
pub enum Input {
    /// Of a file.
    Image {
        size: [u32; 2],
        color: Vec<[f32; 4]>,
        /// Zero if the file has no motion.
        motion: Vec<[f32; 2]>,
        jitter: [f32; 2],
    },
    /// A frame of a folder.
    Frame(Box<RecordedFrame>),
}

impl Input {
    /// Size of the frame in pixels.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Image { size, .. } => *size,
            Self::Frame(frame) => frame.sidecar.size,
        }
    }

    /// Where in its pixels it was sampled, from the centre, pixels.
    pub fn jitter(&self) -> [f32; 2] {
        match self {
            Self::Image { jitter, .. } => *jitter,
            Self::Frame(frame) => frame.sidecar.jitter,
        }
    }

    /// Seconds since the image before, if recorded.
    pub fn time_step(&self) -> Option<f32> {
        match self {
            Self::Image { .. } => None,
            Self::Frame(frame) => frame.sidecar.time_step,
        }
    }

    /// Fills the images that the chain reads.
    pub fn load(&self, images: &ChannelImages) -> Result<()> {
        match self {
            Self::Image { color, motion, .. } => {
                images.current(FLAT_COLOR).write_f32(color.as_flattened())?;
                images.current(FLAT_MOTION).write_f32(motion.as_flattened())?;
            }
            Self::Frame(frame) => frame.load(images, &[FLAT_COLOR, FLAT_MOTION])?,
        }
        Ok(())
    }
}

fn read_file(path: &Path) -> Result<Input> {
    let image = LinearImage::read(path)?;
    ensure!(
        image.state == ImageState::SceneReferred,
        "{}: already tone-mapped, scene radiance (exr, hdr) is needed",
        path.display()
    );
    let size = [image.width, image.height];
    let color = image.pixels.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect();
    let (mut motion, mut jitter) = (vec![[0.0; 2]; image.pixels.len()], [0.0; 2]);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        let capture = LayeredImage::read_exr(path)?;
        let layer = FLAT_MOTION.channel().name;
        let component = |name| capture.channel(layer, name).map(Samples::to_f32);
        if let (Some(x), Some(y)) = (component("X"), component("Y")) {
            motion = x.into_iter().zip(y).map(|(x, y)| [x, y]).collect();
        }
        if let Some(text) = capture.metadata.get(keys::JITTER) {
            let parsed = text.split_once(',').and_then(|(x, y)| Some([x.parse().ok()?, y.parse().ok()?]));
            jitter = parsed.with_context(|| format!("{}: jitter {text:?} is no pair", path.display()))?;
        }
    }
    Ok(Input::Image { size, color, motion, jitter })
}
