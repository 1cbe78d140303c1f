//! Shared by the programs and benchmarks of single stages: arguments, device, recorded inputs, timing, the table of times.
//!
//! A program that works from recorded channels alone is one call of [`replay`] inside [`crate::console::program`]; others
//! put [`StageArgs`] and [`measure`] together themselves. A bench is one call of [`bench()`].

mod bench;
mod clock;
mod copy;
mod measure;

pub use bench::bench;
pub use clock::raise_clock;
pub use copy::{CopyBandwidth, copy_bandwidth};
pub use measure::{PassRow, Spread, StageTimes, measure};

use crate::capture::folder::{CaptureFolder, FolderError};
use crate::capture::{self, CaptureError, keys};
use crate::channels::ChannelImages;
use crate::device::{Device, DeviceOptions};
use crate::error::Error;
use crate::frame::Frame;
use crate::inputs::StageInputs;
use crate::plan::StageIo;
use crate::settings::{Knobs, SettingsError, apply_sets};
use pt_image::atomic_file::check_writable;
use pt_image::image_file::{ImageFileError, Layer, LayeredImage, OutputFormat};
use pt_shaders::channels::ChannelId;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Number of warm-up frames: drivers compile in the first one, and caches fill.
pub const WARM_UP: u32 = 4;

/// Errors of a stage program.
#[derive(Debug, thiserror::Error)]
pub enum HarnessError {
    /// A knob.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A file that can't be read or written.
    #[error(transparent)]
    File(#[from] ImageFileError),
    /// The output is not an EXR.
    #[error("{}: only exr can be written here", .0.display())]
    NotExr(PathBuf),
    /// A capture without the channels that the stage reads.
    #[error("{}: {problem}", path.display())]
    Capture {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: CaptureError,
    },
    /// A folder of recorded frames.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The device.
    #[error(transparent)]
    Device(#[from] Error),
    /// The table could not be printed.
    #[error("cannot print: {0}")]
    Print(#[from] std::io::Error),
}

/// Arguments of every stage program.
#[derive(Clone, Debug, clap::Args)]
pub struct StageArgs {
    /// Set a knob of the stage; may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Number of timed frames, after 4 warm-up frames.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

impl StageArgs {
    /// The stage's knobs: defaults, then `--set`.
    ///
    /// # Errors
    /// An unknown key or a value out of range.
    pub fn params<P>(&self) -> Result<P, SettingsError>
    where
        P: Knobs,
    {
        let mut params = P::default();
        apply_sets(&mut params, &self.set)?;
        Ok(params)
    }

    /// Opens the device.
    ///
    /// # Errors
    /// When there is none that matches.
    pub fn open_device(&self) -> Result<Device, Error> {
        Device::open(&DeviceOptions { device: self.device.clone(), validation: false })
    }

    /// Records and times the frames, warm-up first; see [`measure`].
    ///
    /// # Errors
    /// Those of `record`, and a device that fails.
    pub fn measure(
        &self,
        device: &Device,
        size: [u32; 2],
        record: impl FnMut(&mut Frame<'_>) -> Result<(), Error>,
    ) -> Result<StageTimes, Error> {
        measure(device, size, WARM_UP, self.frames, record)
    }
}

/// Arguments of a program that runs a stage on recorded channels.
#[derive(Clone, Debug, clap::Args)]
pub struct ReplayArgs {
    /// Recorded channels: an EXR with a layer for each, as `pt render --aov all` writes, or a folder of `pt capture`.
    #[arg(value_name = "CAPTURE")]
    pub capture: PathBuf,
    /// EXR to write: the output of the stage, one layer per channel.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: Option<PathBuf>,
    /// Arguments that all stage programs share.
    #[command(flatten)]
    pub stage: StageArgs,
}

/// Runs stages on a capture: loads the channels that they read, records frames, prints the table of times, and writes the
/// channels that they write. `stages`: their declarations; `set_up` creates the stages and returns the function that records a frame.
///
/// # Errors
/// An unknown knob, a file that can't be read or written or lacks a channel, a device that can't do it.
pub fn replay<P, R>(
    args: &ReplayArgs,
    stages: &[StageIo],
    out: &mut impl Write,
    set_up: impl FnOnce(&Device, [u32; 2], P) -> Result<R, Error>,
) -> Result<(), HarnessError>
where
    P: Knobs,
    R: FnMut(&mut Frame<'_>, &StageInputs<'_>) -> Result<(), Error>,
{
    let params = args.stage.params()?;
    args.output.as_deref().map_or(Ok(()), check_output)?;
    let recorded = read_capture(&args.capture)?;
    let device = args.stage.open_device()?;
    let images = capture::load(&device, &recorded, stages)
        .map_err(|problem| HarnessError::Capture { path: args.capture.clone(), problem })?;
    let mut record = set_up(&device, images.size(), params)?;
    let times =
        args.stage.measure(&device, images.size(), |frame| record(frame, &StageInputs::new(&images)))?;
    write!(out, "{times}")?;
    match &args.output {
        Some(path) => {
            let writes: Vec<_> = stages.iter().flat_map(|io| io.writes).copied().collect();
            save(path, &device, &images, &writes, recorded.metadata)
        }
        None => Ok(()),
    }
}

/// A recorded frame: an EXR, or the first frame of a folder that `pt capture` wrote.
///
/// # Errors
/// A file or folder that can't be read.
pub fn read_capture(path: &Path) -> Result<LayeredImage, HarnessError> {
    if !path.is_dir() {
        return Ok(LayeredImage::read_exr(path)?);
    }
    let folder = CaptureFolder::open(path)?;
    Ok(folder.frame(folder.range().start)?.into_image())
}

/// Checks before any work that a capture can be written to `path`.
///
/// # Errors
/// An extension other than exr, a folder that is missing or not writable.
pub fn check_output(path: &Path) -> Result<(), HarnessError> {
    match OutputFormat::of(path)? {
        OutputFormat::Exr => Ok(check_writable(path).map_err(ImageFileError::from)?),
        OutputFormat::Png | OutputFormat::Jpeg => Err(HarnessError::NotExr(path.into())),
    }
}

/// Writes channels as the layers of an EXR; the first one with R, G, B is also the main layer, for viewers and
/// `pt compare`. Device and driver are added to the metadata. Images of another extent than the frame's do not fit into the file and are left out.
///
/// # Errors
/// A device that fails, a file that can't be written.
pub fn save(
    path: &Path,
    device: &Device,
    images: &ChannelImages,
    channels: &[ChannelId],
    mut metadata: BTreeMap<String, String>,
) -> Result<(), HarnessError> {
    let [width, height] = images.size();
    let mut file = LayeredImage::new(width, height)?;
    for &id in channels {
        let (layer, size) = capture::read_layer(images, id)?;
        if size == [width, height] {
            file.layers.push(layer);
        }
    }
    let picture = |layer: &Layer| {
        let plane = |name| layer.channels.iter().find(|channel| channel.name == name).cloned();
        Some(vec![plane("R")?, plane("G")?, plane("B")?])
    };
    if let Some(channels) = file.layers.iter().find_map(picture) {
        file.layers.push(Layer { name: String::new(), channels });
    }
    metadata.insert(keys::DEVICE.into(), device.info().name.clone());
    metadata.insert(keys::DRIVER.into(), device.info().driver_line());
    file.metadata = metadata;
    Ok(file.write_exr(path)?)
}
