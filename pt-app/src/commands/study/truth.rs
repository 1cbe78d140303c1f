//! The ground truth of a study's frames: path traced once and kept by content, or recorded in a capture.

use super::plan::Plan;
use super::views;
use crate::args::CameraArgs;
use crate::ground_truth::{PathTraced, TruthOf, path_trace};
use crate::session::Session;
use anyhow::{Context, Result, bail, ensure};
use pt_core::Device;
use pt_core::capture::folder::CaptureFolder;
use pt_core::capture::sidecar::CapturedCamera;
use pt_image::image_file::{ImageState, Layer, LayeredImage, LinearImage};
use pt_reference::ReferenceParams;
use pt_scene::Scene;
use pt_shaders::records::FrameRecord;
use pt_study::cell::Cell;
use pt_study::file::Against;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Layer of a reference: the mean of the first half of its samples.
const HALF: &str = "half";

/// The ground truth of a frame, with the name of its picture.
#[derive(Clone)]
pub struct Truth {
    /// Linear radiance, or linear display values.
    pub image: Rc<LinearImage>,
    /// The same from the first half of its samples, if it is known: see [`PathTraced::half`].
    pub half: Option<Rc<LinearImage>>,
    /// Name by content, fit for a file.
    pub key: String,
}

impl Truth {
    /// Of a picture as shown, which other knobs show otherwise.
    pub fn of_picture(image: LinearImage, half: Option<LinearImage>) -> Self {
        let mut hasher = blake3::Hasher::new();
        for value in image.pixels.as_flattened() {
            hasher.update(&value.to_le_bytes());
        }
        let key = hasher.finalize().to_hex()[..24].to_owned();
        Self { image: Rc::new(image), half: half.map(Rc::new), key }
    }
}

/// Where ground truth comes from.
pub enum Truths {
    /// It is path traced, and kept in a folder.
    Traced(Traced),
    /// It was recorded.
    Captured(CaptureFolder, PathBuf),
}

/// Path traced ground truth.
pub struct Traced {
    device: Device,
    folder: PathBuf,
    params: ReferenceParams,
    /// Those of the view that is worked on.
    kept: HashMap<String, Truth>,
}

impl Truths {
    /// The ground truth that the plan asks for; `cache`: folder for references.
    ///
    /// # Errors
    /// A capture that cannot be read, or lacks frames.
    pub fn new(plan: &Plan, device: &Device, cache: &Path) -> Result<Self> {
        let study = &plan.study;
        match &study.against {
            Against::Reference { .. } => {
                std::fs::create_dir_all(cache)
                    .with_context(|| format!("{}: cannot be made", cache.display()))?;
                Ok(Self::Traced(Traced {
                    device: device.clone(),
                    folder: cache.into(),
                    params: plan.reference.clone(),
                    kept: HashMap::new(),
                }))
            }
            Against::Capture(path) => Ok(Self::Captured(views::recorded(study, path)?, path.clone())),
        }
    }

    /// The ground truth of frame `index`, which the session renders
    ///
    /// # Errors
    /// A reference of another scene, size or camera; files that can't be read or written; a device that can't do it.
    pub fn of_frame(&mut self, cell: &Cell, scene: &Scene, view: View<'_>) -> Result<Truth> {
        match self {
            Self::Traced(traced) => traced.of_frame(cell, scene, view),
            Self::Captured(folder, path) => captured(folder, path, view),
        }
    }
}

/// What a frame shows.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The session that renders it.
    pub session: &'a Session,
    /// What chose its camera.
    pub camera: &'a CameraArgs,
    /// Number of the frame.
    pub index: u32,
    /// Scene time, seconds.
    pub time: f64,
    /// Its camera and the size of the picture.
    pub record: FrameRecord,
}

impl Traced {
    fn of_frame(&mut self, cell: &Cell, scene: &Scene, view: View<'_>) -> Result<Truth> {
        let session = view.session;
        // A view that does not move is the same at each time.
        let info = session.device.info();
        let words = serde_json::json!({
            "version": env!("CARGO_PKG_VERSION"),
            "device": [&info.name, &info.driver_line()],
            "scene": scene.fingerprint(),
            "camera": CapturedCamera::from(&view.record.camera),
            "time": scene.is_animated().then_some(view.time),
            "size": cell.size,
            "params": self.params,
            "layers": [HALF],
        });
        let key = blake3::hash(words.to_string().as_bytes()).to_hex()[..24].to_owned();
        if let Some(truth) = self.kept.get(&key) {
            return Ok(truth.clone());
        }
        let path = self.folder.join(format!("{key}.exr"));
        if !path.exists() {
            let truth = TruthOf { scene, camera: view.camera, time: view.time, record: view.record };
            let PathTraced { file, half } =
                path_trace(&self.device, session.gpu.backend(), &truth, &self.params)?;
            let mut image = file.to_image()?;
            let layer = |half: LinearImage| {
                Layer::from_interleaved(HALF, &["R", "G", "B"], 3, half.pixels.as_flattened())
            };
            image.layers.extend(half.map(layer));
            image.write_exr(&path)?;
        }
        // As the file has it, also the first time.
        let file = LayeredImage::read_exr(&path)?;
        ensure!(
            [file.width, file.height] == cell.size,
            "{}: has not the size of the frame; remove it",
            path.display()
        );
        let radiance = layer_of(&file, "").with_context(|| {
            format!("{}: is no reference of a study; remove it, or give another --cache", path.display())
        })?;
        let half = layer_of(&file, HALF).map(Rc::new);
        let truth = Truth { image: Rc::new(radiance), half, key: key.clone() };
        // Memory for the views of one cell.
        if self.kept.len() > 256 {
            self.kept.clear();
        }
        self.kept.insert(key, truth.clone());
        Ok(truth)
    }
}

/// Red, green and blue of a layer; `None` where it is not there.
fn layer_of(file: &LayeredImage, name: &str) -> Option<LinearImage> {
    let plane = |channel| file.channel(name, channel).map(|samples| samples.to_f32());
    let (red, green, blue) = (plane("R")?, plane("G")?, plane("B")?);
    let pixels = red.into_iter().zip(green).zip(blue).map(|((r, g), b)| [r, g, b]).collect();
    Some(LinearImage { width: file.width, height: file.height, pixels, state: ImageState::SceneReferred })
}

/// The reference that a capture has of the frame.
fn captured(folder: &CaptureFolder, path: &Path, view: View<'_>) -> Result<Truth> {
    let name = path.display();
    let place = (view.index - folder.range().start) as usize;
    let entry = &folder.index.frames[place];
    let recorded = folder.sidecar(view.index)?;
    if recorded.camera != CapturedCamera::from(&view.record.camera) {
        bail!(
            "{name}: frame {} was recorded with another camera or at another time; give a capture of the same view",
            view.index
        );
    }
    let reference = entry.reference.as_ref().context("the reference was there before")?;
    let image = LinearImage::read(&path.join(&reference.name))?;
    Ok(Truth {
        image: Rc::new(image),
        half: None,
        key: reference.blake3[..24.min(reference.blake3.len())].into(),
    })
}
