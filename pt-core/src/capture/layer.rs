//! One image of a frame as a layer of an EXR.

use crate::channels::ChannelImages;
use crate::error::Error;
use crate::image::Image;
use crate::pack::{pack_unit_vector, unpack_unit_vector};
use crate::split::{flat_to_split, to_flat, to_split};
use crate::texels::{decode_f32, decode_u32};
use glam::Vec3;
use pt_image::image_file::{Channel, Layer, LayeredImage, Samples};
use pt_shaders::channels::{ChannelId, ExtentClass, Format, Stored};
use pt_shaders::records::field_width;

fn layers(there: &[String]) -> String {
    let named: Vec<_> = there.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
    match named.as_slice() {
        [] => "it holds a picture alone, pt render --aov all writes the others".into(),
        _ => format!("there are {}", named.join(", ")),
    }
}

/// Why recorded channels can't be loaded.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The channel's layer is not there.
    #[error("no layer \"{layer}\"; {}", layers(there))]
    MissingLayer {
        /// Channel asked for.
        layer: String,
        /// Layers of the file.
        there: Vec<String>,
    },
    /// A layer lacks a component, or has it as another type.
    #[error("layer \"{layer}\" has no {kind} component \"{component}\"; it has {}", there.join(", "))]
    MissingComponent {
        /// The layer.
        layer: String,
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
        layer: String,
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

const XYZ: [&str; 3] = ["X", "Y", "Z"];
/// The packed word of a direction.
const CODE: &str = "code";

/// Size of the layer that an image becomes: split images are stored as flat ones.
fn layer_size(images: &ChannelImages, id: ChannelId) -> [u32; 2] {
    match id.channel().extent {
        ExtentClass::Split => images.size(),
        extent => images.sizes().extent(extent),
    }
}

/// Reads an image of this frame back as a layer, with its size; waits for the device.
///
/// # Errors
/// When the device fails.
///
/// # Panics
/// When the image is not allocated.
pub fn read_layer(images: &ChannelImages, id: ChannelId) -> Result<(Layer, [u32; 2]), Error> {
    let image = images.current(id);
    let width = id.channel().format.components() as usize;
    let mut words = read_words(image)?;
    if id.channel().extent == ExtentClass::Split {
        let texels: Vec<&[u32]> = words.chunks_exact(width).collect();
        words = to_flat(&texels, images.size()).concat();
    }
    Ok((layer_of(id, &words), layer_size(images, id)))
}

/// Reads the texel of an image of this frame that belongs to a pixel of the frame, as a layer of one pixel; waits for the device.
///
/// # Errors
/// When the device fails.
///
/// # Panics
/// When the image is not allocated, or the frame has no such pixel.
pub fn read_pixel(images: &ChannelImages, id: ChannelId, pixel: [u32; 2]) -> Result<Layer, Error> {
    let image = images.current(id);
    let size = images.size();
    let at = match id.channel().extent {
        ExtentClass::Split => flat_to_split(pixel, field_width(size[0])),
        _ => [0, 1].map(|axis| {
            let scaled = u64::from(pixel[axis]) * u64::from(image.extent()[axis]) / u64::from(size[axis]);
            scaled as u32
        }),
    };
    Ok(layer_of(id, &words(image.format(), &image.read_texel(at)?)))
}

/// A layer of an image that no device holds: `words` of its texels in the order of the layer, as many a texel as its format has components; floats as their bits.
pub fn layer_of(id: ChannelId, words: &[u32]) -> Layer {
    let width = id.channel().format.components() as usize;
    let word = |k: usize| words.iter().skip(k).step_by(width).copied();
    let mut components = Vec::new();
    let mut push = |name: &str, samples| components.push(Channel { name: name.into(), samples });
    for part in id.channel().stored {
        match *part {
            Stored::Float(name, k) => push(name, Samples::F32(word(k).map(f32::from_bits).collect())),
            Stored::Uint(name, k) => push(name, Samples::U32(word(k).collect())),
            Stored::Direction(k) => {
                let unpack = |w| if w == 0 { Vec3::ZERO } else { unpack_unit_vector(w) };
                let directions: Vec<Vec3> = word(k).map(unpack).collect();
                for (axis, name) in XYZ.into_iter().enumerate() {
                    push(name, Samples::F32(directions.iter().map(|d| d[axis]).collect()));
                }
                push(CODE, Samples::U32(word(k).collect()));
            }
        }
    }
    Layer { name: id.full_name(), channels: components }
}

/// The texels as one word a component: integers, or the bits of floats.
fn read_words(image: &Image) -> Result<Vec<u32>, Error> {
    Ok(words(image.format(), &image.read()?))
}

fn words(format: Format, texels: &[u8]) -> Vec<u32> {
    decode_u32(format, texels)
        .unwrap_or_else(|| decode_f32(format, texels).into_iter().map(f32::to_bits).collect())
}

/// Fills an image of this frame from a layer, as [`read_layer`] makes it.
///
/// # Errors
/// A component that is missing, of another type or size, or a device that fails.
///
/// # Panics
/// When the image is not allocated.
pub fn write_layer(images: &ChannelImages, id: ChannelId, layer: &Layer) -> Result<(), CaptureError> {
    let channel = id.channel();
    let width = channel.format.components() as usize;
    let [columns, rows] = layer_size(images, id).map(|side| side as usize);
    let source = Source { layer, name: id.full_name(), pixels: columns * rows };
    let mut words = vec![0u32; source.pixels * width];
    let mut set = |k: usize, values: &mut dyn Iterator<Item = u32>| {
        for (texel, value) in words.chunks_exact_mut(width).zip(values) {
            texel[k] = value;
        }
    };
    for part in channel.stored {
        match *part {
            Stored::Float(name, k) => set(k, &mut source.floats(name)?.into_iter().map(f32::to_bits)),
            Stored::Uint(name, k) => set(k, &mut source.words(name)?.iter().copied()),
            Stored::Direction(k) if source.samples(CODE)?.is_some() => {
                set(k, &mut source.words(CODE)?.iter().copied());
            }
            // Made by another program: any code of the direction will do.
            Stored::Direction(k) => {
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

/// Fills an image of this frame from the layer of a capture that has its name.
///
/// # Errors
/// No such layer; otherwise as [`write_layer`].
pub fn load_image(images: &ChannelImages, id: ChannelId, capture: &LayeredImage) -> Result<(), CaptureError> {
    let name = id.full_name();
    match capture.layer(&name) {
        Some(layer) => write_layer(images, id, layer),
        None => {
            let there = capture.layers.iter().filter(|l| !l.name.is_empty()).map(|l| l.name.clone());
            Err(CaptureError::MissingLayer { layer: name, there: there.collect() })
        }
    }
}

/// A layer being written back.
struct Source<'a> {
    layer: &'a Layer,
    name: String,
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
        match samples.map(Samples::len) {
            Some(found) if found != self.pixels => {
                Err(CaptureError::Size { layer: self.name.clone(), component, found, expected: self.pixels })
            }
            _ => Ok(samples),
        }
    }

    fn missing(&self, component: &'static str, kind: &'static str) -> CaptureError {
        let there = self.layer.channels.iter().map(|c| {
            let kind = if matches!(c.samples, Samples::U32(_)) { "uint" } else { "float" };
            format!("{kind} {}", c.name)
        });
        CaptureError::MissingComponent { layer: self.name.clone(), component, kind, there: there.collect() }
    }
}
