//! Images of the frame in false colour, and the values of a pixel.

use anyhow::{Context, Result};
use pt_core::ChannelImages;
use pt_core::capture::{read_layer, read_pixel};
use pt_image::image_file::{Layer, Samples, srgb_encode_8bit};
use pt_image::metrics::colour_map;
use pt_shaders::channels::ChannelId;
use pt_view::protocol::Legend;

/// Shares of the values that the ends of the scale leave out on either side, against single bright pixels.
const LEFT_OUT: f64 = 0.01;

/// A picture of 8-bit codes that is not on the device yet.
pub(super) struct Codes {
    pub(super) size: [u32; 2],
    /// Red, green, blue, alpha.
    pub(super) texels: Vec<u8>,
}

/// Names of the images that can be looked at.
pub(super) fn names(images: &ChannelImages) -> Vec<String> {
    images.ids().map(ChannelId::full_name).collect()
}

/// An image of the last frame in false colour: three components as red, green and blue, fewer on the scale.
///
/// # Errors
/// An image that the frame does not have; a device that fails.
pub(super) fn false_color(images: &ChannelImages, name: &str) -> Result<(Codes, Legend)> {
    let id = images.ids().find(|id| id.full_name() == name);
    let id = id.with_context(|| format!("{name}: this frame has no such image"))?;
    let (layer, size) = read_layer(images, id)?;
    let channel = id.channel();
    let meaning = format!("{} ({})", channel.meaning.trim_end_matches('.'), channel.unit);
    let (texels, range, is_color) = texels_of(&layer);
    Ok((Codes { size, texels }, Legend { name: name.into(), meaning, range, is_color }))
}

/// Codes of a layer, the values at the ends of the scale, and whether components are colours.
fn texels_of(layer: &Layer) -> (Vec<u8>, [f32; 2], bool) {
    let words = layer.channels.first().is_some_and(|first| matches!(first.samples, Samples::U32(_)));
    if words {
        return (identifiers(layer), [0.0, 1.0], true);
    }
    let floats = layer.channels.iter().filter(|channel| !matches!(channel.samples, Samples::U32(_)));
    let components: Vec<Vec<f32>> = floats.take(3).map(|channel| channel.samples.to_f32()).collect();
    let range = range(components.iter().flatten().copied());
    let place = |value: f32| (value - range[0]) / (range[1] - range[0]).max(f32::MIN_POSITIVE);
    let count = components.first().map_or(0, Vec::len);
    let color = |i: usize| match components.as_slice() {
        [r, g, b] => [r, g, b].map(|component| srgb_encode_8bit(place(component[i]).clamp(0.0, 1.0))),
        [r, g] => [r[i], g[i], range[0]].map(|value| srgb_encode_8bit(place(value).clamp(0.0, 1.0))),
        [one] => colour_map(place(one[i])),
        _ => [0; 3],
    };
    let texels = (0..count)
        .flat_map(|i| {
            let [r, g, b] = color(i);
            [r, g, b, 255]
        })
        .collect();
    (texels, range, components.len() > 1)
}

/// Numbers of things get colours that differ.
fn identifiers(layer: &Layer) -> Vec<u8> {
    let words: Vec<&Vec<u32>> = (layer.channels.iter())
        .filter_map(|channel| if let Samples::U32(words) = &channel.samples { Some(words) } else { None })
        .collect();
    let color = |i: usize| {
        // Of all components: those of one thing are equal.
        let mixed = words.iter().fold(0, |mixed, words| pt_core::rng::pcg4d([mixed, words[i], 0, 0])[0]);
        let [r, g, b, _] = mixed.to_le_bytes();
        [r, g, b, 255]
    };
    (0..words.first().map_or(0, |words| words.len())).flat_map(color).collect()
}

/// Ends of the scale: from 0 where no value is negative.
fn range(values: impl Iterator<Item = f32>) -> [f32; 2] {
    let mut sorted: Vec<f32> = values.filter(|value| value.is_finite()).collect();
    if sorted.is_empty() {
        return [0.0, 1.0];
    }
    sorted.sort_by(f32::total_cmp);
    let skip = (sorted.len() as f64 * LEFT_OUT) as usize;
    let (least, greatest) = (sorted[skip], sorted[sorted.len() - 1 - skip]);
    let least = if sorted[0] >= 0.0 { 0.0 } else { least };
    if greatest > least { [least, greatest] } else { [least, least + 1.0] }
}

/// Values of all images at a pixel of the frame.
///
/// # Errors
/// When the device fails.
pub(super) fn pixel(images: &ChannelImages, pixel: [u32; 2]) -> Result<Vec<(String, String)>> {
    let values = |id: ChannelId| {
        let layer = read_pixel(images, id, pixel)?;
        let parts = layer.channels.iter().map(|channel| match &channel.samples {
            Samples::U32(words) => words.first().map_or(String::new(), u32::to_string),
            floats => floats.to_f32().first().map_or(String::new(), |value| short(*value)),
        });
        Ok((id.full_name(), parts.collect::<Vec<_>>().join(" ")))
    };
    images.ids().map(values).collect()
}

/// Four digits.
fn short(value: f32) -> String {
    let size = value.abs();
    if value != 0.0 && value.is_finite() && !(1e-3..1e5).contains(&size) {
        format!("{value:.3e}")
    } else {
        format!("{value:.4}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_leaves_single_values_out_and_begins_at_zero() {
        let mut values = vec![1.0; 200];
        values.extend([5.0, 5.0, 5.0, 1000.0, f32::NAN]);
        assert_eq!(range(values.into_iter()), [0.0, 5.0]);
        assert_eq!(range([-2.0, 2.0].into_iter()), [-2.0, 2.0]);
        assert_eq!(range([0.0; 4].into_iter()), [0.0, 1.0], "a constant image");
        assert_eq!(range(std::iter::empty()), [0.0, 1.0]);
    }

    #[test]
    fn one_component_is_on_the_scale_and_three_are_colours() {
        let layer = Layer::from_interleaved("depth", &["Z"], 1, &[0.0, 4.0]);
        let (texels, range, is_color) = texels_of(&layer);
        assert_eq!((range, is_color), ([0.0, 4.0], false));
        assert_eq!(texels[..3], colour_map(0.0));
        assert_eq!(texels[4..7], colour_map(1.0));
        let layer = Layer::from_interleaved("", &["R", "G", "B"], 3, &[1.0, 0.0, 0.5]);
        let (texels, _, is_color) = texels_of(&layer);
        assert_eq!((texels.as_slice(), is_color), ([255, 0, srgb_encode_8bit(0.5), 255].as_slice(), true));
    }

    #[test]
    fn values_are_short() {
        assert_eq!(
            [short(0.0), short(1.5), short(1.25e-6), short(f32::NAN)],
            ["0.0000", "1.5000", "1.250e-6", "NaN"]
        );
    }
}
