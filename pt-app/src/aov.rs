//! `--aov`: the images that an EXR holds besides the main one.

use crate::frame::FullFrame;
use crate::params::FrameParams;
use anyhow::{Result, bail, ensure};
use pt_core::ChannelImages;
use pt_core::capture::read_layer;
use pt_core::settings::close_to;
use pt_image::image_file::{Layer, LayeredImage};
use pt_shaders::channels::{ChannelId, ExtentClass};
use std::str::FromStr;

/// The images that an EXR holds besides the main one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AovSelection {
    /// Every channel there is.
    All,
    /// These, in this order.
    Named(Vec<String>),
}

impl FromStr for AovSelection {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let names: Vec<_> = text.split(',').map(|name| name.trim().to_owned()).collect();
        if names.iter().any(String::is_empty) {
            return Err("expected all, or names separated by commas".into());
        }
        Ok(Self::Named(names))
    }
}

/// The images that a selection names: channels of the frame contract by `NAME`, private images of a stage by `STAGE.NAME`. They must
/// have the `size` of the file's main layer.
///
/// # Errors
/// An unknown name, with those that there are; an image of another size.
pub fn select(
    selection: Option<&AovSelection>,
    images: &ChannelImages,
    size: [u32; 2],
) -> Result<Vec<ChannelId>> {
    let layer_size = |id: ChannelId| match id.channel().extent {
        // Split images are stored in scan-line order.
        ExtentClass::Split => images.size(),
        extent => images.sizes().extent(extent),
    };
    let shows = |id: &ChannelId| id.channel().extent != ExtentClass::Output;
    match selection {
        None => Ok(Vec::new()),
        Some(AovSelection::All) => {
            // Images of tiles do not have the size of the frame by themselves.
            let tiles = |id: &ChannelId| matches!(id.channel().extent, ExtentClass::SplitPart(_));
            let all: Vec<_> = images.ids().filter(|id| id.is_contract() && !tiles(id) && shows(id)).collect();
            ensure!(
                all.iter().all(|&id| layer_size(id) == size),
                "--aov: the channels have the size of the frame, not of the picture; render scale 1 is needed"
            );
            Ok(all)
        }
        Some(AovSelection::Named(names)) => {
            names.iter().map(|name| named(name, images, size, layer_size)).collect()
        }
    }
}

/// The names that contain `name`, or the one that is spelt like it.
fn like(name: &str, names: &[String]) -> String {
    let like: Vec<_> = names.iter().filter(|known| known.contains(name)).map(String::as_str).collect();
    match like.is_empty() {
        true => close_to(name, names.iter().map(String::as_str)),
        false => format!("; close to it: {}", like.join(", ")),
    }
}

/// Checks that some frame has images of these names, before there is one.
///
/// # Errors
/// A name that no frame has, with one that is spelt like it.
pub fn check_names(selection: Option<&AovSelection>) -> Result<()> {
    let Some(AovSelection::Named(names)) = selection else { return Ok(()) };
    let private = [
        pt_lights::images::CHANNELS,
        pt_indirect::images::CHANNELS,
        pt_denoise::images::CHANNELS,
        pt_post::images::CHANNELS,
    ];
    let private =
        private.into_iter().flat_map(|table| (0..table.len()).map(move |i| ChannelId::new(table, i)));
    let known: Vec<_> = ChannelId::all().chain(private).map(ChannelId::full_name).collect();
    for name in names {
        ensure!(
            known.contains(name),
            "--aov {name}: no frame has such an image{} (pt passes lists them)",
            like(name, &known)
        );
    }
    Ok(())
}

fn named(
    name: &str,
    images: &ChannelImages,
    size: [u32; 2],
    layer_size: impl Fn(ChannelId) -> [u32; 2],
) -> Result<ChannelId> {
    let Some(id) = images.ids().find(|id| id.full_name() == name) else {
        let names: Vec<_> = images.ids().map(ChannelId::full_name).collect();
        bail!(
            "--aov {name}: no such image in this frame{}; there are {}",
            like(name, &names),
            names.join(", ")
        )
    };
    let [width, height] = layer_size(id);
    ensure!(
        [width, height] == size,
        "--aov {name}: it has {width}x{height} texels, the file has {}x{}; an EXR of pt capture holds images of all sizes",
        size[0],
        size[1]
    );
    Ok(id)
}

/// The layers of a frame's EXR: linear radiance or the picture as the main one, then `aovs`. Waits for the frame.
///
/// # Errors
/// When the device fails.
pub fn layers(full: &FullFrame, params: &FrameParams, aovs: &[ChannelId]) -> Result<LayeredImage> {
    let mut file = if params.post.output == pt_post::Output::Display {
        pt_post::picture_layers(full.images(), params.post.encoding)?
    } else {
        let [width, height] = full.radiance().extent();
        let mut file = LayeredImage::new(width, height)?;
        let mut radiance = full.radiance().read_f32()?;
        let mut names = vec!["R", "G", "B"];
        if let Some(matte) = full.matte() {
            // As is the custom in EXR files, radiance stays premultiplied.
            let matte = matte.read_f32()?;
            radiance.chunks_exact_mut(4).zip(matte.chunks_exact(4)).for_each(|(to, from)| to[3] = from[3]);
            names.push("A");
        }
        file.layers.push(Layer::from_interleaved("", &names, 4, &radiance));
        file
    };
    for &id in aovs {
        file.layers.push(read_layer(full.images(), id)?.0);
    }
    Ok(file)
}
