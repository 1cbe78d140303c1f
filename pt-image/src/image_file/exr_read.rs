//! OpenEXR bytes into [`LayeredImage`].

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, ChannelDescription, EnvironmentMap, Text};
use exr::meta::header::Header;
use exr::prelude as ex;
use exr::prelude::{ReadChannels, ReadLayers};
use half::f16;

use super::chromaticities::Chromaticities;
use super::exr_file::ATTRIBUTE_PREFIX;
use super::{Channel, Layer, LayeredImage, Samples, check_room, check_size};

/// Samples that a byte of a file may stand for: more than its compressions reach on a picture.
const PER_BYTE: u64 = 1024;

/// Samples that a display window may have, however few of them the file stores: two channels of 8192x8192 pixels.
const MAX_ZEROS: u64 = 1 << 27;

/// The content of a file, and what its header says about the meaning of the values.
pub(super) struct Decoded {
    pub image: LayeredImage,
    /// The colour space of R, G and B; Rec. 709 without it.
    pub chromaticities: Option<Chromaticities>,
    /// Luminance of R = G = B = 1, cd/m2.
    pub white_luminance: Option<f32>,
    /// Pixels that only one of the two windows has, in words; `None` when the windows agree.
    pub windows: Option<String>,
}

/// The image in the display window: pixels outside of the data window are 0, those outside of the display window are dropped.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, String> {
    // The header alone first: a size out of range is refused before memory is set aside for it.
    let headers = headers(bytes)?;
    let first = headers.first().ok_or("the file has no parts")?;
    let data = first.data_window();
    if let Some(other) = headers.iter().map(Header::data_window).find(|window| *window != data) {
        let [a, b] = [data, other].map(window_text);
        return Err(format!("its parts differ in size or position ({a} and {b})"));
    }
    let display = first.shared_attributes.display_window;
    let size = display.size;
    check_size(size.0 as u64, size.1 as u64).map_err(|error| format!("its display window: {error}"))?;
    check_samples(size, &headers, bytes)?;
    let subsampled = |channel: &&ChannelDescription| channel.sampling != ex::Vec2(1, 1);
    if let Some(channel) = headers.iter().flat_map(|header| &header.channels.list).find(subsampled) {
        return Err(format!("channel {:?} is subsampled, which is not supported", channel.name.to_string()));
    }
    let luminance = |header: &Header| header.own_attributes.white_luminance;
    let bits = |header: &Header| luminance(header).map(f32::to_bits);
    if headers.iter().any(|header| bits(header) != bits(first)) {
        return Err("its parts differ in the attribute whiteLuminance".into());
    }
    let mut decoded = Decoded {
        image: LayeredImage {
            width: size.0 as u32,
            height: size.1 as u32,
            layers: Vec::new(),
            metadata: BTreeMap::new(),
        },
        chromaticities: first.shared_attributes.chromaticities.and_then(chromaticities),
        white_luminance: luminance(first),
        windows: (data != display).then(|| {
            let [data, display] = [data, display].map(window_text);
            format!("of the display window ({display}) only pixels in the data window ({data}) are stored, others are 0")
        }),
    };

    let file = read_parts(bytes)?;
    let image = &mut decoded.image;
    let multi_part = file.layer_data.len() > 1;
    let mut layers = BTreeMap::new();
    read_attributes(&file.attributes.other, &mut image.metadata);
    for part in file.layer_data {
        read_attributes(&part.attributes.other, &mut image.metadata);
        let part_name = part.attributes.layer_name.filter(|_| multi_part).map(|name| lossy(&name));
        collect_channels(part.channel_data, part_name.as_deref(), &mut layers);
    }
    if data != display {
        for channel in layers.values_mut().flatten() {
            channel.samples.place(data, display);
        }
    }
    image.layers = layers.into_iter().map(|(name, channels)| Layer { name, channels }).collect();
    Ok(decoded)
}

/// Every part by itself, in its data window, with its name; that of a single-part file is empty.
pub(super) fn decode_parts(bytes: &[u8]) -> Result<Vec<(String, LayeredImage)>, String> {
    headers(bytes)?;
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

/// Whether a file says that it holds the six faces of a cube (attribute `envmap`); false for what is no OpenEXR file.
pub fn is_cube_map(bytes: &[u8]) -> bool {
    let cube = |header: &Header| header.own_attributes.environment_map == Some(EnvironmentMap::Cube);
    headers(bytes).is_ok_and(|headers| headers.iter().any(cube))
}

/// What is wrong with a file that cannot be read.
fn problem(bytes: &[u8], error: &exr::error::Error) -> String {
    const MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];
    let text = error.to_string();
    match bytes {
        [] => "the file is empty".into(),
        _ if !bytes.starts_with(MAGIC) => "it is no OpenEXR file".into(),
        _ if text.contains("missing bytes") => "the file is cut off".into(),
        _ => text,
    }
}

/// The headers, with sizes in range.
fn headers(bytes: &[u8]) -> Result<Vec<Header>, String> {
    let meta =
        MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| problem(bytes, &error))?;
    for header in &meta.headers {
        let size = header.layer_size;
        check_size(size.0 as u64, size.1 as u64).map_err(|error| error.to_string())?;
    }
    Ok(meta.headers.into_vec())
}

/// Whether the file has room for its samples; a display window that is larger than the data adds zeros, up to a limit.
fn check_samples(display: ex::Vec2<usize>, headers: &[Header], bytes: &[u8]) -> Result<(), String> {
    let channels = headers.iter().map(|header| header.channels.list.len()).sum::<usize>();
    let data = headers.first().map_or(display, |header| header.layer_size);
    check_room([data.0, data.1], channels, bytes.len() as u64, PER_BYTE)?;
    check_room([display.0, display.1], channels, (bytes.len() as u64).max(MAX_ZEROS / PER_BYTE), PER_BYTE)
}

fn window_text(window: ex::IntegerBounds) -> String {
    let (position, size) = (window.position, window.size);
    format!("{}x{} at {},{}", size.0, size.1, position.0, position.1)
}

fn chromaticities(c: exr::meta::attribute::Chromaticities) -> Option<Chromaticities> {
    let [r, g, b, w] = [c.red, c.green, c.blue, c.white].map(|xy| [f64::from(xy.0), f64::from(xy.1)]);
    Chromaticities::from_numbers([r[0], r[1], g[0], g[1], b[0], b[1], w[0], w[1]])
}

impl Samples {
    /// Cuts out of a plane that fills the window `data` what lies in the window `display`, and fills up with zeros.
    fn place(&mut self, data: ex::IntegerBounds, display: ex::IntegerBounds) {
        match self {
            Self::F16(samples) => place(samples, f16::ZERO, data, display),
            Self::F32(samples) => place(samples, 0.0, data, display),
            Self::U32(samples) => place(samples, 0, data, display),
        }
    }
}

fn place<T: Copy>(samples: &mut Vec<T>, zero: T, data: ex::IntegerBounds, display: ex::IntegerBounds) {
    // The part that both windows have along an axis: its start in each of them, and its length.
    let overlap = |data: (i32, usize), display: (i32, usize)| {
        let start = i64::from(data.0).max(display.0.into());
        let end = |(start, length): (i32, usize)| i64::from(start) + length as i64;
        let length = (end(data).min(end(display)) - start).max(0) as usize;
        let offset = |from: i32| (start - i64::from(from)) as usize;
        if length == 0 { (0, 0, 0) } else { (offset(data.0), offset(display.0), length) }
    };
    let (from_x, to_x, columns) =
        overlap((data.position.0, data.size.0), (display.position.0, display.size.0));
    let (from_y, to_y, rows) = overlap((data.position.1, data.size.1), (display.position.1, display.size.1));
    let mut placed = vec![zero; display.size.area()];
    for row in 0..rows {
        let from = &samples[(from_y + row) * data.size.0 + from_x..][..columns];
        placed[(to_y + row) * display.size.0 + to_x..][..columns].copy_from_slice(from);
    }
    *samples = placed;
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
        .map_err(|error| problem(bytes, &error))
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
