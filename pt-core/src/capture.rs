//! Recorded frames: channels of the frame contract as layers of an EXR, both ways.
//!
//! A capture is a [`LayeredImage`] with one layer per channel, called as in the channel table, in flat scan-line order.
//! Writing a layer back gives the texels that it was read from, with three limits: directions are stored unpacked, and come
//! back as the code that decodes to the same direction; what a split image of odd width holds where there is no flat pixel
//! is not recorded, and comes back as zeros; NaN comes back as NaN.
//!
//! | channel | components |
//! |---|---|
//! | `normal`, `vertex_normal` | X, Y, Z, unpacked; 0 = no surface |
//! | `view_direction` | X, Y, Z, unpacked; `flags` (uint) |
//! | `shading_position` | X, Y, Z; `material` (uint) |
//! | other integers | x, y (uint) |
//! | one number | Z |
//! | two numbers | X, Y |
//! | motion | X, Y, Z, W |
//! | other four numbers | R, G, B, A |
//!
//! Metadata: text under the keys of [`keys`]; readers need none of them.

use crate::channels::ChannelImages;
use crate::device::Device;
use crate::error::Error;
use pt_image::image_file::{Channel, Layer, LayeredImage, Samples};
use crate::pack::{pack_unit_vector, unpack_unit_vector};
use crate::split::{to_flat, to_split};
use glam::Vec3;
use pt_shaders::channels::{self, ChannelId, ExtentClass};

/// Metadata of a capture. In the file they are string attributes called `pt.KEY`.
pub mod keys {
    pub use pt_image::image_file::IMAGE_STATE_KEY as IMAGE_STATE;
    /// Name of the scene.
    pub const SCENE: &str = "scene";
    /// The camera, for people to read.
    pub const CAMERA: &str = "camera";
    /// Time of the first frame in the scene's animation, seconds.
    pub const TIME: &str = "time";
    /// Number of frames rendered; the last one is recorded.
    pub const FRAMES: &str = "frames";
    /// `true`: the main layer is the mean of the frames.
    pub const ACCUMULATE: &str = "accumulate";
    /// Seed of the random numbers.
    pub const SEED: &str = "seed";
    /// All knobs, as JSON.
    pub const PARAMS: &str = "params";
    /// Exposure value at ISO 100 that the last frame was shown with.
    pub const EV100: &str = "ev100";
    /// Factor that took scene radiance to exposed values for the last frame, compensation included.
    pub const EXPOSURE: &str = "exposure";
    /// Where in its pixels the last frame was sampled, from the centre, pixels: `x,y`.
    pub const JITTER: &str = "jitter";
    /// Vulkan device.
    pub const DEVICE: &str = "device";
    /// Driver's name and version.
    pub const DRIVER: &str = "driver";
    /// Trace backend that was asked for.
    pub const BACKEND: &str = "backend";
    /// Version of the program that wrote the file.
    pub const VERSION: &str = "version";
}

/// Why recorded channels can't be loaded.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The channel's layer is not there.
    #[error("no layer \"{layer}\"; there are {}", there.join(", "))]
    MissingLayer {
        /// Channel asked for.
        layer: &'static str,
        /// Layers of the file.
        there: Vec<String>,
    },
    /// A layer lacks a component, or has it as another type.
    #[error("layer \"{layer}\" has no {kind} component \"{component}\"; it has {}", there.join(", "))]
    MissingComponent {
        /// The layer.
        layer: &'static str,
        /// The component.
        component: &'static str,
        /// `float` or `uint`.
        kind: &'static str,
        /// Components of the layer.
        there: Vec<String>,
    },
    /// A component has not one sample per pixel.
    #[error("layer \"{layer}\" has {found} samples in \"{component}\", the frame has {expected} pixels")]
    Size {
        /// The layer.
        layer: &'static str,
        /// The component.
        component: &'static str,
        /// Samples that it has.
        found: usize,
        /// Pixels of the frame.
        expected: usize,
    },
    /// The device refused.
    #[error(transparent)]
    Device(#[from] Error),
}

/// What components of a layer say about which word of the texel.
#[derive(Clone, Copy)]
enum Part {
    /// A number.
    Float(&'static str, usize),
    /// An integer; in a float image its bits.
    Uint(&'static str, usize),
    /// A packed unit vector, as X, Y, Z.
    Direction(usize),
}

const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// The components of a channel's layer.
fn parts(id: ChannelId) -> Vec<Part> {
    let format = id.channel().format;
    let names: &[&'static str] = match id {
        channels::NORMAL | channels::VERTEX_NORMAL => return vec![Part::Direction(0)],
        channels::VIEW_DIRECTION => return vec![Part::Direction(0), Part::Uint("flags", 1)],
        channels::SHADING_POSITION => {
            let position = XYZ.into_iter().zip(0..).map(|(name, word)| Part::Float(name, word));
            return position.chain([Part::Uint("material", 3)]).collect();
        }
        channels::MOTION => &["X", "Y", "Z", "W"],
        _ => match (format.is_uint(), format.components()) {
            (true, _) => &["x", "y"],
            (false, 1) => &["Z"],
            (false, 2) => &["X", "Y"],
            (false, _) => &["R", "G", "B", "A"],
        },
    };
    let part = if format.is_uint() { Part::Uint } else { Part::Float };
    names.iter().zip(0..format.components() as usize).map(|(name, word)| part(name, word)).collect()
}

/// Reads a channel of this frame back as a layer; waits for the device.
///
/// # Errors
/// When the device fails.
///
/// # Panics
/// When the channel is not allocated.
pub fn read_layer(images: &ChannelImages, id: ChannelId) -> Result<Layer, Error> {
    let image = images.current(id);
    let width = id.channel().format.components() as usize;
    let mut words: Vec<u32> = if id.channel().format.is_uint() {
        image.read_u32()?
    } else {
        image.read_f32()?.into_iter().map(f32::to_bits).collect()
    };
    if id.channel().extent == ExtentClass::Split {
        let texels: Vec<&[u32]> = words.chunks_exact(width).collect();
        words = to_flat(&texels, images.size()).concat();
    }
    let word = |k: usize| words.iter().skip(k).step_by(width).copied();
    let mut components = Vec::new();
    let mut push = |name: &str, samples| components.push(Channel { name: name.into(), samples });
    for part in parts(id) {
        match part {
            Part::Float(name, k) => push(name, Samples::F32(word(k).map(f32::from_bits).collect())),
            Part::Uint(name, k) => push(name, Samples::U32(word(k).collect())),
            Part::Direction(k) => {
                let unpack = |w| if w == 0 { Vec3::ZERO } else { unpack_unit_vector(w) };
                let directions: Vec<Vec3> = word(k).map(unpack).collect();
                for (axis, name) in XYZ.into_iter().enumerate() {
                    push(name, Samples::F32(directions.iter().map(|d| d[axis]).collect()));
                }
            }
        }
    }
    Ok(Layer { name: id.channel().name.into(), channels: components })
}

/// Fills a channel of this frame from a layer, as [`read_layer`] makes it.
///
/// # Errors
/// A component that is missing, of another type or size, or a device that fails.
///
/// # Panics
/// When the channel is not allocated.
pub fn write_layer(images: &ChannelImages, id: ChannelId, layer: &Layer) -> Result<(), CaptureError> {
    let channel = id.channel();
    let width = channel.format.components() as usize;
    let [columns, rows] = images.size().map(|side| side as usize);
    let source = Source { layer, name: channel.name, pixels: columns * rows };
    let mut words = vec![0u32; source.pixels * width];
    let mut set = |k: usize, values: &mut dyn Iterator<Item = u32>| {
        for (texel, value) in words.chunks_exact_mut(width).zip(values) {
            texel[k] = value;
        }
    };
    for part in parts(id) {
        match part {
            Part::Float(name, k) => set(k, &mut source.floats(name)?.into_iter().map(f32::to_bits)),
            Part::Uint(name, k) => set(k, &mut source.words(name)?.iter().copied()),
            Part::Direction(k) => {
                let [x, y, z] = [source.floats("X")?, source.floats("Y")?, source.floats("Z")?];
                let vectors = x.into_iter().zip(y).zip(z).map(|((x, y), z)| Vec3::new(x, y, z));
                set(k, &mut vectors.map(|v| if v == Vec3::ZERO { 0 } else { pack_unit_vector(v) }));
            }
        }
    }
    if channel.extent == ExtentClass::Split {
        let texels: Vec<&[u32]> = words.chunks_exact(width).collect();
        words = to_split(&texels, images.size(), &[0; 4][..width]).concat();
    }
    let image = images.current(id);
    if channel.format.is_uint() {
        image.write_u32(&words)?;
    } else {
        image.write_f32(&words.into_iter().map(f32::from_bits).collect::<Vec<_>>())?;
    }
    Ok(())
}

/// A layer being written back.
struct Source<'a> {
    layer: &'a Layer,
    name: &'static str,
    pixels: usize,
}

impl<'a> Source<'a> {
    fn floats(&self, component: &'static str) -> Result<Vec<f32>, CaptureError> {
        match self.samples(component)? {
            Some(Samples::U32(_)) | None => Err(self.missing(component, "float")),
            Some(samples) => Ok(samples.to_f32()),
        }
    }

    fn words(&self, component: &'static str) -> Result<&'a [u32], CaptureError> {
        match self.samples(component)? {
            Some(Samples::U32(words)) => Ok(words),
            _ => Err(self.missing(component, "uint")),
        }
    }

    /// The component, one sample per pixel.
    fn samples(&self, component: &'static str) -> Result<Option<&'a Samples>, CaptureError> {
        let samples = self.layer.channels.iter().find(|c| c.name == component).map(|c| &c.samples);
        let (layer, expected) = (self.name, self.pixels);
        match samples.map(Samples::len) {
            Some(found) if found != expected => Err(CaptureError::Size { layer, component, found, expected }),
            _ => Ok(samples),
        }
    }

    fn missing(&self, component: &'static str, kind: &'static str) -> CaptureError {
        let there = self.layer.channels.iter().map(|c| {
            let kind = if matches!(c.samples, Samples::U32(_)) { "uint" } else { "float" };
            format!("{kind} {}", c.name)
        });
        CaptureError::MissingComponent { layer: self.name, component, kind, there: there.collect() }
    }
}

/// Allocates `reads` and `writes` for the frame that `capture` holds and fills `reads` from its layers.
///
/// # Errors
/// A layer or component that is missing, or a device that refuses.
pub fn load(
    device: &Device,
    capture: &LayeredImage,
    reads: &[ChannelId],
    writes: &[ChannelId],
) -> Result<ChannelImages, CaptureError> {
    let size = [capture.width, capture.height];
    let images = ChannelImages::new(device, size, reads.iter().chain(writes).copied())?;
    for &id in reads {
        let name = id.channel().name;
        let layer = capture.layer(name).ok_or_else(|| CaptureError::MissingLayer {
            layer: name,
            there: capture.layers.iter().filter(|l| !l.name.is_empty()).map(|l| l.name.clone()).collect(),
        })?;
        write_layer(&images, id, layer)?;
    }
    Ok(images)
}
