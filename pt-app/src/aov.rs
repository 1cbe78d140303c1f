//! Channels of the frame contract as layers of an EXR.

use crate::cli::AovSelection;
use anyhow::{Result, bail};
use pt_checkerboard::mapping::flat_to_split;
use pt_core::channels::field_width;
use pt_core::image_file::{Channel, Layer, Samples};
use pt_core::pack::unpack_unit_vector;
use pt_core::{ChannelImages, Image};
use pt_shaders::channels::{self, ChannelId, ExtentClass};

/// The channels that a selection names.
///
/// # Errors
/// An unknown name, with the closest ones there are.
pub fn select(selection: Option<&AovSelection>, images: &ChannelImages) -> Result<Vec<ChannelId>> {
    let there: Vec<_> = images.ids().filter(|&id| id != channels::DISPLAY).collect();
    match selection {
        None => Ok(Vec::new()),
        Some(AovSelection::All) => Ok(there),
        Some(AovSelection::Named(names)) => names
            .iter()
            .map(|name| match ChannelId::by_name(name).filter(|id| there.contains(id)) {
                Some(id) => Ok(id),
                None => {
                    let names: Vec<_> = there.iter().map(|id| id.channel().name).collect();
                    bail!("--aov {name}: no such channel in this frame; there are {}", names.join(", "))
                }
            })
            .collect(),
    }
}

/// Reads a channel back as a layer in flat scan-line order. Packed directions are unpacked to X, Y, Z.
pub fn layer(images: &ChannelImages, id: ChannelId) -> Result<Layer> {
    let image = images.current(id);
    let size = images.size();
    let channels = match id {
        channels::NORMAL | channels::GEO_NORMAL => directions(&texels(image, id, size)?),
        channels::VIEW_DIRECTION => {
            let words = texels(image, id, size)?;
            let mut channels = directions(&component(&words, 2, 0));
            channels.push(Channel { name: "flags".into(), samples: Samples::U32(component(&words, 2, 1)) });
            channels
        }
        channels::SHADING_POSITION => {
            let words = texels(image, id, size)?;
            let mut channels: Vec<_> = ["X", "Y", "Z"].into_iter().zip(0..).map(|(n, k)| float(n, &words, 4, k)).collect();
            channels.push(Channel { name: "material".into(), samples: Samples::U32(component(&words, 4, 3)) });
            channels
        }
        _ if id.channel().format.is_uint() => {
            let count = id.channel().format.components() as usize;
            let words = texels(image, id, size)?;
            let names = ["x", "y"].into_iter().take(count);
            names
                .zip(0..)
                .map(|(n, k)| Channel { name: n.into(), samples: Samples::U32(component(&words, count, k)) })
                .collect()
        }
        _ => {
            let words = texels(image, id, size)?;
            let count = id.channel().format.components() as usize;
            let names: &[&str] = match count {
                1 => &["Z"],
                2 => &["X", "Y"],
                _ if is_color(id) => &["R", "G", "B", "A"],
                _ => &["X", "Y", "Z", "W"],
            };
            names.iter().zip(0..).map(|(n, k)| float(n, &words, count, k)).collect()
        }
    };
    Ok(Layer { name: id.channel().name.into(), channels })
}

fn is_color(id: ChannelId) -> bool {
    !matches!(id, channels::MOTION | channels::FLAT_MOTION)
}

/// All components of all texels as 32-bit words (floats as their bits), flat scan-line order.
fn texels(image: &Image, id: ChannelId, size: [u32; 2]) -> Result<Vec<u32>> {
    let channel = id.channel();
    let words: Vec<u32> = if channel.format.is_uint() {
        image.read_u32()?
    } else {
        image.read_f32()?.into_iter().map(f32::to_bits).collect()
    };
    if channel.extent == ExtentClass::Flat {
        return Ok(words);
    }
    let components = channel.format.components() as usize;
    let row = image.extent()[0] as usize;
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
    Ok(pixels
        .flat_map(|flat| {
            let [x, y] = flat_to_split(flat, field_width(size[0]));
            let start = (y as usize * row + x as usize) * components;
            words[start..start + components].iter().copied()
        })
        .collect())
}

fn component(words: &[u32], components: usize, k: usize) -> Vec<u32> {
    words.iter().skip(k).step_by(components).copied().collect()
}

fn float(name: &str, words: &[u32], components: usize, k: usize) -> Channel {
    let samples = component(words, components, k).into_iter().map(f32::from_bits).collect();
    Channel { name: name.into(), samples: Samples::F32(samples) }
}

/// X, Y, Z of packed unit vectors; zero where there is no surface.
fn directions(words: &[u32]) -> Vec<Channel> {
    let vectors: Vec<_> =
        words.iter().map(|&w| if w == 0 { [0.0; 3] } else { unpack_unit_vector(w).to_array() }).collect();
    ["X", "Y", "Z"]
        .into_iter()
        .enumerate()
        .map(|(k, name)| Channel { name: name.into(), samples: Samples::F32(vectors.iter().map(|v| v[k]).collect()) })
        .collect()
}
