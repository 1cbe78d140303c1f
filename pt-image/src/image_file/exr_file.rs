//! [`LayeredImage`] to and from OpenEXR bytes.

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, LineOrder, Text};
use exr::prelude as ex;
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};

use super::{Channel, Layer, LayeredImage, Samples, check_size};

/// Front of the names of our header attributes.
const ATTRIBUTE_PREFIX: &str = "pt.";

/// Longest channel and attribute name, bytes (OpenEXR long names).
const MAX_NAME: usize = 255;

type ExrLayer = ex::Layer<ex::AnyChannels<ex::FlatSamples>>;

pub(super) fn encode(image: &LayeredImage) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    ex::Image::from_layer(exr_layer(image)?)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| error.to_string())?;
    sort_header_attributes(bytes.into_inner()).ok_or_else(|| "the EXR writer made no valid header".into())
}

/// Parts of different sizes, each with its name; the first says how large the file is for viewers.
pub(super) fn encode_parts(parts: &[(String, LayeredImage)]) -> Result<Vec<u8>, String> {
    let mut layers = Vec::new();
    for (name, image) in parts {
        let mut layer = exr_layer(image)?;
        layer.attributes.layer_name = Some(text(name));
        layers.push(layer);
    }
    let first = layers.first().ok_or("the image has no parts")?.size;
    let attributes = ex::ImageAttributes::new(ex::IntegerBounds::from_dimensions(first));
    let mut bytes = Cursor::new(Vec::new());
    ex::Image::from_layers(attributes, layers)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| error.to_string())?;
    sort_header_attributes(bytes.into_inner()).ok_or_else(|| "the EXR writer made no valid header".into())
}

fn exr_layer(image: &LayeredImage) -> Result<ExrLayer, String> {
    check_size(image.width.into(), image.height.into()).map_err(|error| error.to_string())?;
    let channels = named_channels(image)?;
    let list = channels.into_iter().map(|(name, samples)| {
        let samples = match samples {
            Samples::F16(samples) => ex::FlatSamples::F16(samples.clone()),
            Samples::F32(samples) => ex::FlatSamples::F32(samples.clone()),
            Samples::U32(samples) => ex::FlatSamples::U32(samples.clone()),
        };
        ex::AnyChannel::new(text(&name), samples)
    });
    let encoding = ex::Encoding {
        compression: ex::Compression::ZIP16,
        blocks: ex::Blocks::ScanLines,
        // Blocks are compressed on several threads; this makes the writer put them in order.
        line_order: LineOrder::Increasing,
    };
    let size = ex::Vec2(image.width as usize, image.height as usize);
    let mut attributes = ex::LayerAttributes::default();
    for (key, value) in &image.metadata {
        let name = format!("{ATTRIBUTE_PREFIX}{key}");
        check_name("metadata key", &name)?;
        attributes.other.insert(text(&name), AttributeValue::Text(text(value)));
    }
    Ok(ex::Layer::new(size, attributes, encoding, ex::AnyChannels::sort(list.collect())))
}

/// All channels under their full names, sorted.
fn named_channels(image: &LayeredImage) -> Result<BTreeMap<String, &Samples>, String> {
    let expected = image.width as usize * image.height as usize;
    let mut named = BTreeMap::new();
    for layer in &image.layers {
        for Channel { name, samples } in &layer.channels {
            let full = if layer.name.is_empty() { name.clone() } else { format!("{}.{name}", layer.name) };
            check_name("channel", &full)?;
            if name.is_empty() || name.contains('.') {
                return Err(format!(
                    "channel {full:?}: the name within the layer must not be empty or hold a dot"
                ));
            }
            if samples.len() != expected {
                let (width, height, found) = (image.width, image.height, samples.len());
                return Err(format!(
                    "channel {full:?} has {found} samples, {width}x{height} pixels need {expected}"
                ));
            }
            if named.insert(full.clone(), samples).is_some() {
                return Err(format!("channel {full:?} is there twice"));
            }
        }
    }
    if named.is_empty() { Err("the image has no channels".into()) } else { Ok(named) }
}

fn check_name(what: &str, name: &str) -> Result<(), String> {
    if name.len() > MAX_NAME || name.contains('\0') {
        return Err(format!("{what} {name:?} must have at most {MAX_NAME} bytes and no zero byte"));
    }
    Ok(())
}

/// EXR text is bytes; UTF-8 passes through unchanged.
fn text(content: &str) -> Text {
    Text::from_slice_unchecked(content.as_bytes())
}

/// Sorts the attributes of every part by name, as the OpenEXR library itself writes them.
///
/// The exr crate keeps custom attributes in a hash map and writes them in its random order. Sorting moves no byte
/// behind the headers, so the offset tables stay valid. `None` when the bytes are no EXR header.
fn sort_header_attributes(mut file: Vec<u8>) -> Option<Vec<u8>> {
    /// Magic number and version field.
    const START: usize = 8;
    /// Bit of the version field: several parts follow, and an empty one behind the last.
    const MULTI_PART: u8 = 0x10;
    let multi_part = file.get(5)? & MULTI_PART != 0;
    let mut at = START;
    loop {
        let start = at;
        let string_end = |from: usize| Some(from + file.get(from..)?.iter().position(|&byte| byte == 0)?);
        let mut attributes: BTreeMap<&[u8], &[u8]> = BTreeMap::new();
        while *file.get(at)? != 0 {
            let name_end = string_end(at)?;
            let type_end = string_end(name_end + 1)?;
            let size = file.get(type_end + 1..type_end + 5)?.try_into().ok()?;
            let end = type_end + 5 + usize::try_from(i32::from_le_bytes(size)).ok()?;
            attributes.insert(&file[at..name_end], file.get(at..end)?);
            at = end;
        }
        let sorted = attributes.into_values().collect::<Vec<_>>().concat();
        if sorted.len() != at - start {
            return None;
        }
        file[start..at].copy_from_slice(&sorted);
        at += 1;
        if !multi_part || *file.get(at)? == 0 {
            return Some(file);
        }
    }
}

pub(super) fn decode(bytes: &[u8]) -> Result<LayeredImage, String> {
    // The header alone first: a size out of range is refused before memory is set aside for it.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
    let size = meta.headers.first().ok_or("the file has no parts")?.layer_size;
    check_size(size.0 as u64, size.1 as u64).map_err(|error| error.to_string())?;
    if let Some(other) = meta.headers.iter().find(|header| header.layer_size != size) {
        let other = other.layer_size;
        return Err(format!("its parts differ in size ({}x{} and {}x{})", size.0, size.1, other.0, other.1));
    }
    let subsampled = |channel: &&exr::meta::attribute::ChannelDescription| channel.sampling != ex::Vec2(1, 1);
    if let Some(channel) = meta.headers.iter().flat_map(|header| &header.channels.list).find(subsampled) {
        return Err(format!("channel {:?} is subsampled, which is not supported", channel.name.to_string()));
    }

    let file = read_parts(bytes)?;
    let mut image = LayeredImage {
        width: size.0 as u32,
        height: size.1 as u32,
        layers: Vec::new(),
        metadata: BTreeMap::new(),
    };
    let multi_part = file.layer_data.len() > 1;
    let mut layers = BTreeMap::new();
    read_attributes(&file.attributes.other, &mut image.metadata);
    for part in file.layer_data {
        read_attributes(&part.attributes.other, &mut image.metadata);
        let part_name = part.attributes.layer_name.filter(|_| multi_part).map(|name| lossy(&name));
        collect_channels(part.channel_data, part_name.as_deref(), &mut layers);
    }
    image.layers = layers.into_iter().map(|(name, channels)| Layer { name, channels }).collect();
    Ok(image)
}

/// Every part by itself, with its name; that of a single-part file is empty.
pub(super) fn decode_parts(bytes: &[u8]) -> Result<Vec<(String, LayeredImage)>, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
    for header in &meta.headers {
        let size = header.layer_size;
        check_size(size.0 as u64, size.1 as u64).map_err(|error| error.to_string())?;
    }
    let mut parts = Vec::new();
    for part in read_parts(bytes)?.layer_data {
        let (width, height) = (part.size.0 as u32, part.size.1 as u32);
        let mut image = LayeredImage { width, height, layers: Vec::new(), metadata: BTreeMap::new() };
        read_attributes(&part.attributes.other, &mut image.metadata);
        let mut layers = BTreeMap::new();
        collect_channels(part.channel_data, None, &mut layers);
        image.layers = layers.into_iter().map(|(name, channels)| Layer { name, channels }).collect();
        parts.push((part.attributes.layer_name.map_or(String::new(), |name| lossy(&name)), image));
    }
    Ok(parts)
}

/// The text attributes of all parts; `None` without a valid header.
pub(super) fn decode_metadata(bytes: &[u8]) -> Option<BTreeMap<String, String>> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).ok()?;
    let mut metadata = BTreeMap::new();
    for header in &meta.headers {
        read_attributes(&header.shared_attributes.other, &mut metadata);
        read_attributes(&header.own_attributes.other, &mut metadata);
    }
    Some(metadata)
}

fn read_parts(bytes: &[u8]) -> Result<ex::FlatImage, String> {
    ex::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())
}

/// Adds a part's channels to the layers that their names say, behind the name of the part if there is one.
fn collect_channels(
    channels: ex::AnyChannels<ex::FlatSamples>,
    part: Option<&str>,
    layers: &mut BTreeMap<String, Vec<Channel>>,
) {
    for channel in channels.list {
        let mut full = lossy(&channel.name);
        if let Some(part) = part.filter(|part| !full.starts_with(&format!("{part}."))) {
            full = format!("{part}.{full}");
        }
        let (layer, name) = full.rsplit_once('.').unwrap_or(("", &full));
        let samples = match channel.sample_data {
            ex::FlatSamples::F16(samples) => Samples::F16(samples),
            ex::FlatSamples::F32(samples) => Samples::F32(samples),
            ex::FlatSamples::U32(samples) => Samples::U32(samples),
        };
        layers.entry(layer.into()).or_default().push(Channel { name: name.into(), samples });
    }
}

fn lossy(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn read_attributes<'a>(
    attributes: impl IntoIterator<Item = (&'a Text, &'a AttributeValue)>,
    metadata: &mut BTreeMap<String, String>,
) {
    for (name, value) in attributes {
        if let (Some(key), AttributeValue::Text(value)) = (lossy(name).strip_prefix(ATTRIBUTE_PREFIX), value)
        {
            metadata.insert(key.into(), lossy(value));
        }
    }
}
