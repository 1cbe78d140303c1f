//! Frames of a running session on their way into a capture.

use crate::frame::FullFrame;
use crate::params::FrameParams;
use crate::session::Session;
use anyhow::{Context, Result};
use pt_core::capture::folder::{CaptureWriter, Index, history_names, read_histories};
use pt_core::capture::sidecar::{Sidecar, to_hex};
use pt_image::image_file::LayeredImage;
use std::collections::BTreeMap;
use std::path::Path;

/// A capture that is being written.
pub struct FrameCapture {
    writer: CaptureWriter,
    /// What the first frame takes over from those before it: images, and buffers as hexadecimal digits.
    histories: Vec<(String, LayeredImage)>,
    state: BTreeMap<String, String>,
    frames: u32,
}

impl FrameCapture {
    /// An empty capture of frames for pictures of `size` pixels. `accumulate`: whether frames are averaged.
    ///
    /// # Errors
    /// A folder that can't be written, or that holds a capture already.
    pub fn create(folder: &Path, scene: &str, size: [u32; 2], accumulate: bool) -> Result<Self> {
        let index = Index {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: scene.into(),
            output_size: size,
            accumulate,
            frames: Vec::new(),
        };
        let writer = CaptureWriter::create(folder, index)?;
        Ok(Self { writer, histories: Vec::new(), state: BTreeMap::new(), frames: 0 })
    }

    /// Keeps what the next frame, the first one of the capture, will take over from those before it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn begin(&mut self, full: &FullFrame) -> Result<()> {
        if full.images().has_frame() {
            self.histories = read_histories(full.images())?;
            for buffer in full.state() {
                self.state.insert(buffer.name().to_owned(), to_hex(&buffer.read::<u8>()?));
            }
        }
        Ok(())
    }

    /// Adds the last frame of `full`. `has_history`: whether a frame was before it; `time`: scene time, seconds; `reference`: an EXR file with its
    /// ground truth.
    ///
    /// # Errors
    /// A device that fails, a file that can't be written; the frames before it stay.
    pub fn add(
        &mut self,
        session: &Session,
        full: &FullFrame,
        params: &FrameParams,
        has_history: bool,
        time: f64,
        reference: Option<&[u8]>,
    ) -> Result<()> {
        let histories = std::mem::take(&mut self.histories);
        let sidecar = Sidecar {
            has_history,
            histories: history_names(&histories),
            state: std::mem::take(&mut self.state),
            ..sidecar(session, full, params, time)?
        };
        self.writer.add(full.images(), histories, &sidecar, reference)?;
        self.frames += 1;
        Ok(())
    }

    /// Frames so far.
    pub fn frames(&self) -> u32 {
        self.frames
    }
}

/// What is known of the last frame beside its images.
fn sidecar(session: &Session, full: &FullFrame, params: &FrameParams, time: f64) -> Result<Sidecar> {
    let moment = full.moment().context("no frame was recorded")?;
    let record = moment.record;
    Ok(Sidecar {
        version: env!("CARGO_PKG_VERSION").into(),
        frame: record.frame_index,
        time,
        size: record.size.into(),
        seed: record.seed,
        jitter: moment.jitter,
        time_step: moment.time_step,
        camera: (&record.camera).into(),
        camera_previous: (&record.camera_prev).into(),
        params: serde_json::to_value(params)?,
        device: session.device.info().name.clone(),
        driver: session.device.info().driver_line(),
        backend: session.gpu.backend().to_string(),
        has_history: false,
        histories: Vec::new(),
        state: BTreeMap::new(),
    })
}
