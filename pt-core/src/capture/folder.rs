//! Folders of recorded frames: an index, and for each frame an EXR, a sidecar in JSON and perhaps a reference image.
//!
//! The index names every file with its hash. It is rewritten after each frame, so that an interrupted capture keeps all complete
//! frames.

use super::layer::{CaptureError, read_layer, write_layer};
use super::sidecar::Sidecar;
use crate::channels::ChannelImages;
use crate::error::Error;
use pt_image::atomic_file::{FileError, read, write_atomic};
use pt_image::image_file::{LayeredImage, decode_exr_parts, encode_exr_parts};
use pt_shaders::channels::ChannelId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of the index.
pub const INDEX: &str = "index.json";
/// Prefix of the layers that hold the histories of the first frame.
const HISTORY: &str = "history.";

/// Why a folder can't be written or read. One line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// The content of a file does not match the index or the format.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A file's layer is missing or does not fit.
    #[error("{}: {problem}", path.display())]
    Layer {
        /// The file.
        path: PathBuf,
        /// What is wrong with the layer.
        problem: CaptureError,
    },
    /// The device refused.
    #[error(transparent)]
    Device(#[from] Error),
}

/// A file with the hash of its content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileEntry {
    /// Name in the folder.
    pub name: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

/// The files of a frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameEntry {
    /// Frames since the start of the run.
    pub frame: u32,
    /// Images, see [`super`].
    pub images: FileEntry,
    /// See [`Sidecar`].
    pub sidecar: FileEntry,
    /// Ground truth of the same view, linear radiance.
    pub reference: Option<FileEntry>,
}

/// The index of a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Index {
    /// Version of the program that recorded it.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Size of the picture in pixels.
    pub output_size: [u32; 2],
    /// Whether frames are averaged.
    pub accumulate: bool,
    /// The frames, in order and without a hole.
    pub frames: Vec<FrameEntry>,
}

/// A folder that frames are recorded into.
pub struct CaptureWriter {
    folder: PathBuf,
    index: Index,
}

impl CaptureWriter {
    /// An empty capture in `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// A folder that can't be made or written, or that holds a capture already.
    pub fn create(folder: &Path, index: Index) -> Result<Self, FolderError> {
        let content = |problem: String| FolderError::Content { path: folder.into(), problem };
        std::fs::create_dir_all(folder).map_err(|e| content(format!("cannot make the folder: {e}")))?;
        if folder.join(INDEX).exists() {
            return Err(content("holds a capture already; choose another folder or remove it".into()));
        }
        pt_image::atomic_file::check_writable(&folder.join(INDEX))?;
        Ok(Self { folder: folder.into(), index })
    }

    /// Records a frame: the current content of all channels of the frame contract, and `histories`, which [`read_histories`]
    /// returned before the frame.
    ///
    /// # Errors
    /// A device that fails, a file that can't be written; then the frames before it stay.
    pub fn add(
        &mut self,
        images: &ChannelImages,
        histories: Vec<(String, LayeredImage)>,
        sidecar: &Sidecar,
        reference: Option<&[u8]>,
    ) -> Result<(), FolderError> {
        let mut parts = Parts::default();
        for id in images.ids().filter(|id| id.is_contract()) {
            parts.add(images, id, "")?;
        }
        for (_, image) in histories {
            parts.merge(image);
        }
        self.add_images(&parts.into_list(), sidecar, reference)
    }

    /// Records a frame whose images no device holds: layers as [`super::layer_of`] makes them, one part for each image size.
    ///
    /// # Errors
    /// A file that can't be written; then the frames before it stay.
    pub fn add_images(
        &mut self,
        parts: &[(String, LayeredImage)],
        sidecar: &Sidecar,
        reference: Option<&[u8]>,
    ) -> Result<(), FolderError> {
        let number = sidecar.frame;
        let exr = format!("frame_{number:06}.exr");
        let bytes = encode_exr_parts(parts).map_err(|problem| self.content(&exr, problem))?;
        let sidecar_text =
            serde_json::to_string_pretty(sidecar).map_err(|e| self.content(&exr, e.to_string()))?;
        let entry = FrameEntry {
            frame: number,
            images: self.write(exr, &bytes)?,
            sidecar: self.write(format!("frame_{number:06}.json"), sidecar_text.as_bytes())?,
            reference: reference
                .map(|bytes| self.write(format!("reference_{number:06}.exr"), bytes))
                .transpose()?,
        };
        self.index.frames.push(entry);
        let index =
            serde_json::to_string_pretty(&self.index).map_err(|e| self.content(INDEX, e.to_string()))?;
        Ok(write_atomic(&self.folder.join(INDEX), index.as_bytes())?)
    }

    fn write(&self, name: String, bytes: &[u8]) -> Result<FileEntry, FolderError> {
        write_atomic(&self.folder.join(&name), bytes)?;
        Ok(FileEntry { name, blake3: blake3::hash(bytes).to_hex().to_string() })
    }

    fn content(&self, name: &str, problem: String) -> FolderError {
        FolderError::Content { path: self.folder.join(name), problem }
    }
}

/// Layers by the size of their images; parts are named by it.
#[derive(Default)]
struct Parts(BTreeMap<(u32, u32), LayeredImage>);

impl Parts {
    fn add(&mut self, images: &ChannelImages, id: ChannelId, prefix: &str) -> Result<(), Error> {
        let (mut layer, [width, height]) = read_layer(images, id)?;
        layer.name.insert_str(0, prefix);
        self.part(width, height).layers.push(layer);
        Ok(())
    }

    fn merge(&mut self, image: LayeredImage) {
        self.part(image.width, image.height).layers.extend(image.layers);
    }

    fn part(&mut self, width: u32, height: u32) -> &mut LayeredImage {
        self.0.entry((width, height)).or_insert_with(|| LayeredImage {
            width,
            height,
            layers: Vec::new(),
            metadata: BTreeMap::new(),
        })
    }

    /// Larger images first.
    fn into_list(self) -> Vec<(String, LayeredImage)> {
        let named = |((width, height), image)| (format!("{width}x{height}"), image);
        self.0.into_iter().rev().map(named).collect()
    }
}

/// The histories that the next frame will read, as layers of a capture; empty before the first frame.
///
/// # Errors
/// When the device fails.
pub fn read_histories(images: &ChannelImages) -> Result<Vec<(String, LayeredImage)>, Error> {
    let mut parts = Parts::default();
    if images.has_frame() {
        for id in images.histories() {
            parts.add(images, id, HISTORY)?;
        }
    }
    Ok(parts.into_list())
}

/// Names of the layers in what [`read_histories`] returned.
pub fn history_names(histories: &[(String, LayeredImage)]) -> Vec<String> {
    let layers = histories.iter().flat_map(|(_, image)| &image.layers);
    layers.filter_map(|layer| Some(layer.name.strip_prefix(HISTORY)?.to_owned())).collect()
}

/// A recorded sequence.
pub struct CaptureFolder {
    folder: PathBuf,
    /// The index.
    pub index: Index,
}

/// The images of a recorded frame, read and checked.
pub struct RecordedFrame {
    path: PathBuf,
    parts: Vec<(String, LayeredImage)>,
    /// Its cameras, seed, knobs and device.
    pub sidecar: Sidecar,
}

impl CaptureFolder {
    /// Reads the index of a folder that this version of the program recorded.
    ///
    /// # Errors
    /// No index, one of another version, a hole in the sequence.
    pub fn open(folder: &Path) -> Result<Self, FolderError> {
        let path = folder.join(INDEX);
        let content = |problem: String| FolderError::Content { path: path.clone(), problem };
        if !path.exists() {
            let parent = folder.parent().filter(|parent| parent.join(INDEX).is_file());
            let problem = match parent {
                _ if !folder.exists() => "no such folder; give one that pt capture wrote".into(),
                Some(parent) if folder.is_file() && parent.as_os_str().is_empty() => {
                    "is a file of a capture; give its folder, which is .".into()
                }
                Some(parent) if folder.is_file() => {
                    format!("is a file of a capture; give its folder, {}", parent.display())
                }
                _ if folder.is_file() => "is a file; give a folder that pt capture wrote".into(),
                _ => format!("is no capture, it has no {INDEX}; give a folder that pt capture wrote"),
            };
            return Err(FolderError::Content { path: folder.into(), problem });
        }
        let bytes = read(&path)?;
        // The version first: another one may have other fields.
        let not_read = |error: serde_json::Error| {
            content(match bytes.is_empty() {
                true => "the file is empty".into(),
                false if error.is_eof() => "is cut off; record it again".into(),
                false if error.is_syntax() => "is no JSON; record it again".into(),
                false => "is no index of a capture; give a folder that pt capture wrote".into(),
            })
        };
        let version: Version = serde_json::from_slice(&bytes).map_err(not_read)?;
        let ours = env!("CARGO_PKG_VERSION");
        if version.version != ours {
            return Err(content(format!(
                "was recorded by version {}, this is {ours}; record it again",
                version.version
            )));
        }
        let index: Index = serde_json::from_slice(&bytes).map_err(not_read)?;
        if index.frames.is_empty() {
            return Err(content("has no frames".into()));
        }
        for pair in index.frames.windows(2) {
            if pair[1].frame != pair[0].frame + 1 {
                let (a, b) = (pair[0].frame, pair[1].frame);
                return Err(content(format!("has a hole: frame {b} follows frame {a}")));
            }
        }
        Ok(Self { folder: folder.into(), index })
    }

    /// First frame and the one behind the last.
    pub fn range(&self) -> std::ops::Range<u32> {
        let first = self.index.frames[0].frame;
        first..first + self.index.frames.len() as u32
    }

    /// Reads a frame's sidecar alone.
    ///
    /// # Errors
    /// As [`CaptureFolder::frame`].
    ///
    /// # Panics
    /// As [`CaptureFolder::frame`].
    pub fn sidecar(&self, number: u32) -> Result<Sidecar, FolderError> {
        let entry = &self.index.frames[(number - self.range().start) as usize];
        let bytes = self.read(&entry.sidecar)?;
        let path = self.folder.join(&entry.sidecar.name);
        serde_json::from_slice(&bytes)
            .map_err(|error| FolderError::Content { path, problem: error.to_string() })
    }

    /// Reads a frame's images and sidecar.
    ///
    /// # Errors
    /// A file that is missing, truncated or not the one that the index names.
    ///
    /// # Panics
    /// When the frame is not in [`CaptureFolder::range`].
    pub fn frame(&self, number: u32) -> Result<RecordedFrame, FolderError> {
        let entry = &self.index.frames[(number - self.range().start) as usize];
        let sidecar = self.sidecar(number)?;
        let content =
            |name: &str, problem: String| FolderError::Content { path: self.folder.join(name), problem };
        let bytes = self.read(&entry.images)?;
        let parts = decode_exr_parts(&bytes).map_err(|problem| content(&entry.images.name, problem))?;
        Ok(RecordedFrame { path: self.folder.join(&entry.images.name), parts, sidecar })
    }

    fn read(&self, entry: &FileEntry) -> Result<Vec<u8>, FolderError> {
        let path = self.folder.join(&entry.name);
        let bytes = read(&path)?;
        let found = blake3::hash(&bytes).to_hex().to_string();
        if found != entry.blake3 {
            let problem =
                format!("is not the file that {INDEX} names: its hash is {found}, not {}", entry.blake3);
            return Err(FolderError::Content { path, problem });
        }
        Ok(bytes)
    }
}

/// The part of an index that every version has.
#[derive(Deserialize)]
struct Version {
    version: String,
}

impl RecordedFrame {
    /// The frame's images of frame size, for what takes a single image.
    pub fn into_image(mut self) -> LayeredImage {
        let [width, height] = self.sidecar.size;
        let place = self.parts.iter().position(|(_, image)| [image.width, image.height] == [width, height]);
        self.parts.swap_remove(place.unwrap_or(0)).1
    }

    /// Whether the frame was recorded with that image.
    pub fn has_layer(&self, id: ChannelId) -> bool {
        self.parts.iter().any(|(_, image)| image.layer(&id.full_name()).is_some())
    }

    /// Fills images from their layers.
    ///
    /// # Errors
    /// A layer that is missing or does not fit.
    pub fn load(&self, images: &ChannelImages, ids: &[ChannelId]) -> Result<(), FolderError> {
        ids.iter().try_for_each(|&id| self.load_one(images, id, ""))
    }

    /// Restores the histories that the recorded frame started with. If the capture lacks some of them, it restores nothing and
    /// returns their names; the next frame then starts without history.
    ///
    /// # Errors
    /// A layer that is missing or does not fit.
    pub fn load_histories(&self, images: &mut ChannelImages) -> Result<Vec<String>, FolderError> {
        if !self.sidecar.has_history {
            return Ok(Vec::new());
        }
        let ids: Vec<_> = images.histories().collect();
        let names = ids.iter().map(|id| id.full_name());
        let missing: Vec<_> = names.filter(|name| !self.sidecar.histories.contains(name)).collect();
        if missing.is_empty() {
            ids.into_iter().try_for_each(|id| self.load_one(images, id, HISTORY))?;
            images.resume_history();
        }
        Ok(missing)
    }

    fn load_one(&self, images: &ChannelImages, id: ChannelId, prefix: &str) -> Result<(), FolderError> {
        let name = format!("{prefix}{}", id.full_name());
        let layer = |problem| FolderError::Layer { path: self.path.clone(), problem };
        match self.parts.iter().find_map(|(_, image)| image.layer(&name)) {
            Some(found) => write_layer(images, id, found).map_err(layer),
            None => {
                let layers = self.parts.iter().flat_map(|(_, image)| &image.layers);
                let there = layers.map(|layer| layer.name.clone()).collect();
                Err(layer(CaptureError::MissingLayer { layer: name, there }))
            }
        }
    }
}
