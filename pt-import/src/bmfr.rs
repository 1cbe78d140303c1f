//! Recorded frames of the data set of Koskela et al. 2019, "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction", into captures.
//!
//! The data set has, for each frame, the light of one sample a pixel divided by the albedo, albedo, shading normal and position of the first surface, a reference, and in
//! `camera_matrices.h` the arrays `camera_matrices` (clip from world) and `pixel_offsets` (place of the sample in its pixel). What a capture has beyond that follows from
//! position and camera; seeds, light lists and light by kind are not there.

mod camera;
mod header;

use camera::Camera;
use glam::Vec3;
use pt_core::capture::folder::{CaptureWriter, FolderError, Index};
use pt_core::capture::layer_of;
use pt_core::capture::sidecar::Sidecar;
use pt_core::pack::pack_unit_vector;
use pt_image::atomic_file::FileError;
use pt_image::image_file::{ImageFileError, LayeredImage, encode_exr_parts};
use pt_shaders::channels::{
    BASE_COLOR, BOUNCE_THROUGHPUT, COLOR_HF, COLOR_SPEC, ChannelId, METALLIC_ROUGHNESS, MOTION, NORMAL,
    SHADING_POSITION, THROUGHPUT, TRANSPARENT, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};
use pt_shaders::records::FLAG_PRIMARY;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Why a folder is not imported. One line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum BmfrError {
    /// An image is missing or damaged.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// A file is missing.
    #[error(transparent)]
    File(#[from] FileError),
    /// The capture can't be written.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A file is not what it should be.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

impl BmfrError {
    fn content(path: &Path, problem: impl Into<String>) -> Self {
        Self::Content { path: path.into(), problem: problem.into() }
    }
}

/// What was imported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Imported {
    /// Number of frames.
    pub frames: u32,
    /// Pixels.
    pub size: [u32; 2],
    /// Frames with a reference.
    pub references: u32,
}

/// Distance of pixels that show no surface, metres.
const SKY_DISTANCE: f32 = 1e18;

/// Imports all frames from 0 on into a capture in `output`.
///
/// # Errors
/// See [`BmfrError`]. Frames that were imported before stay.
pub fn import(folder: &Path, output: &Path) -> Result<Imported, BmfrError> {
    let inputs = folder.join("inputs");
    let images = if inputs.is_dir() { inputs } else { folder.into() };
    let first = images.join("color0.exr");
    if !first.exists() {
        return Err(BmfrError::content(&images, "has no color0.exr; give a folder of the BMFR data set"));
    }
    let header = [folder, &images].map(|at| at.join("camera_matrices.h"));
    let header = header.iter().find(|path| path.exists()).ok_or_else(|| {
        BmfrError::content(folder, "has no camera_matrices.h, without which nothing says where surfaces were")
    })?;
    let views = header::read(header)?;
    let mut writer: Option<CaptureWriter> = None;
    let mut done = Imported { frames: 0, size: [0; 2], references: 0 };
    let mut before: Option<Camera> = None;
    while images.join(format!("color{}.exr", done.frames)).exists() {
        let number = done.frames;
        let view = views.get(number as usize).ok_or_else(|| {
            let problem = format!("has matrices of {} frames, and there is a color{number}.exr", views.len());
            BmfrError::content(header, problem)
        })?;
        let frame = Recorded::read(&images, number)?;
        if number > 0 && frame.size != done.size {
            let path = images.join(format!("color{number}.exr"));
            return Err(BmfrError::content(&path, "has another size than color0.exr"));
        }
        let convention = before.as_ref().map(|camera| camera.convention);
        let camera = Camera::fitting(&view.matrix, &frame, convention).map_err(|problem| {
            BmfrError::content(header, format!("the matrix of frame {number} {problem}"))
        })?;
        let reference = reference(&images.join(format!("reference{number}.exr")), frame.size)?;
        let parts = [(String::new(), frame.channels(&camera, before.as_ref().unwrap_or(&camera)))];
        let mut sidecar = sidecar(number, &frame, &camera, before.as_ref().unwrap_or(&camera));
        sidecar.jitter = view.offset.map(|v| v - 0.5);
        let writer = match &mut writer {
            Some(writer) => writer,
            None => writer.insert(CaptureWriter::create(output, index(folder, frame.size))?),
        };
        writer.add_images(&parts, &sidecar, reference.as_deref())?;
        done.references += u32::from(reference.is_some());
        (done.size, done.frames, before) = (frame.size, number + 1, Some(camera));
    }
    Ok(done)
}

fn index(folder: &Path, size: [u32; 2]) -> Index {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Index {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: format!("bmfr {name}"),
        output_size: size,
        accumulate: false,
        frames: Vec::new(),
    }
}

fn sidecar(number: u32, frame: &Recorded, camera: &Camera, before: &Camera) -> Sidecar {
    Sidecar {
        version: env!("CARGO_PKG_VERSION").into(),
        frame: number,
        time: 0.0,
        size: frame.size,
        seed: 0,
        jitter: [0.0; 2],
        time_step: None,
        camera: (&camera.record()).into(),
        camera_previous: (&before.record()).into(),
        // The light is of one kind: bounces are part of it.
        params: serde_json::json!({ "indirect": { "bounces": 0.0 } }),
        device: String::new(),
        driver: String::new(),
        backend: String::new(),
        has_history: number > 0,
        histories: Vec::new(),
        state: BTreeMap::new(),
    }
}

/// The bytes of the reference as a capture has them.
fn reference(path: &Path, size: [u32; 2]) -> Result<Option<Vec<u8>>, BmfrError> {
    if !path.exists() {
        return Ok(None);
    }
    let image = LayeredImage::read_exr(path)?;
    if [image.width, image.height] != size {
        return Err(BmfrError::content(path, "has another size than the light of its frame"));
    }
    let pixels = triples(path, &image)?;
    let mut out = LayeredImage::new(size[0], size[1])?;
    let layer = pt_image::image_file::Layer::from_interleaved("", &["R", "G", "B"], 3, pixels.as_flattened());
    out.layers.push(layer);
    encode_exr_parts(&[(String::new(), out)]).map(Some).map_err(|problem| BmfrError::content(path, problem))
}

/// The first three components of the main layer.
fn triples(path: &Path, image: &LayeredImage) -> Result<Vec<[f32; 3]>, BmfrError> {
    let component = |names: [&str; 2]| {
        let found = names.iter().find_map(|name| image.channel("", name));
        found
            .map(|samples| samples.to_f32())
            .ok_or_else(|| BmfrError::content(path, format!("has no component {} or {}", names[0], names[1])))
    };
    let [r, g, b] = [["R", "X"], ["G", "Y"], ["B", "Z"]].map(component);
    let (r, g, b) = (r?, g?, b?);
    Ok((0..r.len()).map(|i| [r[i], g[i], b[i]]).collect())
}

/// The images of a frame.
struct Recorded {
    size: [u32; 2],
    light: Vec<[f32; 3]>,
    albedo: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    position: Vec<[f32; 3]>,
}

impl Recorded {
    fn read(folder: &Path, number: u32) -> Result<Self, BmfrError> {
        let mut size = None;
        let mut read = |name: &str| {
            let path = folder.join(format!("{name}{number}.exr"));
            let image = LayeredImage::read_exr(&path)?;
            let own = [image.width, image.height];
            if own != *size.get_or_insert(own) {
                return Err(BmfrError::content(&path, "has another size than the light of its frame"));
            }
            triples(&path, &image)
        };
        let light = read("color")?;
        let (albedo, normal, position) = (read("albedo")?, read("shading_normal")?, read("world_position")?);
        Ok(Self { size: size.unwrap_or_default(), light, albedo, normal, position })
    }

    /// Normal and position of the surface that a pixel shows; the data set has a normal of 0 where there is none.
    fn surface(&self, i: usize) -> Option<(Vec3, Vec3)> {
        let (normal, position) = (Vec3::from(self.normal[i]), Vec3::from(self.position[i]));
        let is_there = normal.is_finite() && position.is_finite() && normal.length_squared() > 1e-6;
        is_there.then(|| (normal.normalize(), position))
    }

    /// The channels of the frame contract that follow from the frame.
    fn channels(&self, camera: &Camera, before: &Camera) -> LayeredImage {
        let surfaces: Vec<_> = (0..self.light.len()).map(|i| self.surface(i)).collect();
        let angle = camera.pixel_angle(self.size);
        let words = |of: &dyn Fn(usize) -> Vec<u32>| (0..surfaces.len()).flat_map(of).collect::<Vec<u32>>();
        let floats = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<u32>>();
        let rgb = |c: [f32; 3], a: f32| floats(&[c[0], c[1], c[2], a]);
        let sky = |i: usize| surfaces[i].is_none();
        let distance = |position: Vec3| position.distance(camera.eye);
        let motion = |i: usize| {
            let Some((normal, position)) = surfaces[i] else { return [0.0, 0.0, 0.0, 1.0 / SKY_DISTANCE] };
            let (was, is) = (before.project(position), camera.project(position));
            // A surface that is behind the last frame's camera was in no pixel.
            let uv = match (was, is) {
                (Some(was), Some(is)) => [was[0] - is[0], was[1] - is[1]],
                _ => [10.0, 10.0],
            };
            let d = distance(position);
            let cosine = normal.dot((camera.eye - position).normalize_or_zero()).abs().clamp(0.01, 1.0);
            let range = d * angle * ((1.0 - cosine * cosine).sqrt() / cosine).max(0.1);
            [uv[0], uv[1], position.distance(before.eye) - d, 1.0 / range.max(1e-12)]
        };
        let normal = |i: usize| surfaces[i].map_or(0, |(normal, _)| pack_unit_vector(normal));
        let position = |i: usize| surfaces[i].map(|(_, position)| position);
        let ray = |i: usize| position(i).map_or(Vec3::NEG_Z, |p| (p - camera.eye).normalize_or(Vec3::NEG_Z));
        let depth = |i: usize| position(i).map_or(SKY_DISTANCE, distance);
        let place = |i: usize| {
            let [x, y, z] = position(i).unwrap_or_default().into();
            [x, y, z].map(f32::to_bits).into_iter().chain([u32::from(!sky(i))]).collect()
        };
        // Where there is no surface, the light is what the camera sees.
        let seen = |i: usize| [0, 1, 2].map(|k| self.light[i][k] * self.albedo[i][k]);
        let none = [0.0; 3];
        let layer = |id: ChannelId, of: &dyn Fn(usize) -> Vec<u32>| layer_of(id, &words(of));
        let layers = vec![
            layer(COLOR_HF, &|i| rgb(if sky(i) { none } else { self.light[i] }, 0.0)),
            layer(COLOR_SPEC, &|_| rgb(none, 0.0)),
            layer(BASE_COLOR, &|i| rgb(self.albedo[i], 0.0)),
            layer(METALLIC_ROUGHNESS, &|_| floats(&[0.0, 1.0])),
            layer(NORMAL, &|i| vec![normal(i)]),
            layer(VERTEX_NORMAL, &|i| vec![normal(i)]),
            layer(VIEW_DEPTH, &|i| floats(&[depth(i)])),
            layer(MOTION, &|i| floats(&motion(i))),
            layer(SHADING_POSITION, &place),
            layer(VIEW_DIRECTION, &|i| vec![pack_unit_vector(ray(i)), FLAG_PRIMARY]),
            layer(THROUGHPUT, &|i| rgb([1.0; 3], position(i).map_or(0.0, |p| distance(p).max(1e-4).log2()))),
            layer(BOUNCE_THROUGHPUT, &|_| rgb([1.0; 3], angle)),
            layer(TRANSPARENT, &|i| if sky(i) { rgb(seen(i), 1.0) } else { rgb(none, 0.0) }),
        ];
        LayeredImage { width: self.size[0], height: self.size[1], layers, metadata: BTreeMap::new() }
    }
}
