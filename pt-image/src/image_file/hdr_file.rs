//! Radiance pictures (`.hdr`, `.pic`) into linear RGB, after the format's description by its author: Ward, "Real Pixels",
//! Graphics Gems II (1991), and the file formats appendix of the Radiance reference manual.

use glam::{DMat3, DVec3};

use super::chromaticities::{Chromaticities, rec_709_from_xyz};
use super::{check_room, check_size};

/// Longest header that is read, bytes.
const MAX_HEADER: usize = 1 << 16;

/// Pixels that a byte of a file may stand for: runs of 127 equal components make 16, of 255 equal pixels 64.
const PIXELS_PER_BYTE: u64 = 64;

/// Scan lines of other lengths are never stored component by component.
const COMPONENT_RUNS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// A decoded picture.
pub(super) struct Picture {
    pub width: u32,
    pub height: u32,
    /// Radiance, Rec. 709, rows from the top.
    pub pixels: Vec<[f32; 3]>,
    /// What of the header changed the values, one sentence each.
    pub notices: Vec<String>,
}

/// Whether the bytes begin like a Radiance file; the word after it names the program or the format.
pub(super) fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let mut input = Input { bytes };
    let header = Header::read(&mut input)?;
    let layout = Layout::parse(&input.line()?)?;
    let (width, height) = (layout.width, layout.height);
    check_size(width as u64, height as u64).map_err(|error| error.to_string())?;
    check_room([width, height], 1, bytes.len() as u64, PIXELS_PER_BYTE)?;

    let to_radiance = header.to_radiance()?;
    let mut pixels = vec![[0.0; 3]; width * height];
    let mut line = vec![[0; 4]; layout.line_length()];
    for i in 0..layout.line_count() {
        input.scan_line(&mut line).map_err(|what| {
            let lines = layout.line_count();
            format!("scan line {i} of {lines}: {what}")
        })?;
        for (j, &stored) in line.iter().enumerate() {
            pixels[layout.index(i, j)] = (to_radiance * value(stored)).as_vec3().to_array();
        }
    }
    Ok(Picture { width: width as u32, height: height as u32, pixels, notices: header.notices() })
}

/// Three mantissas that share an exponent; an exponent of 0 is black.
fn value([a, b, c, exponent]: [u8; 4]) -> DVec3 {
    if exponent == 0 {
        return DVec3::ZERO;
    }
    DVec3::new(a.into(), b.into(), c.into()) * 2f64.powi(i32::from(exponent) - 136)
}

struct Header {
    is_xyz: bool,
    /// Product of all EXPOSURE lines: pixel value = radiance x exposure.
    exposure: f64,
    /// Product of all COLORCORR lines.
    correction: DVec3,
    primaries: Option<Chromaticities>,
}

impl Header {
    /// Everything up to the empty line. Variables of commands that made parts of the picture are indented and do not count.
    fn read(input: &mut Input<'_>) -> Result<Self, String> {
        let mut header = Self { is_xyz: false, exposure: 1.0, correction: DVec3::ONE, primaries: None };
        let start = input.bytes.len();
        loop {
            let line = input.line()?;
            if line.is_empty() {
                return Ok(header);
            }
            if start - input.bytes.len() > MAX_HEADER {
                return Err(format!("its header has more than {MAX_HEADER} bytes"));
            }
            if let Some((name, text)) = line.split_once('=') {
                header.variable(name, text.trim())?;
            }
        }
    }

    fn variable(&mut self, name: &str, text: &str) -> Result<(), String> {
        match name {
            "FORMAT" => match text {
                "32-bit_rle_rgbe" => self.is_xyz = false,
                "32-bit_rle_xyze" => self.is_xyz = true,
                _ => {
                    return Err(format!(
                        "FORMAT {text:?} is not supported; 32-bit_rle_rgbe and 32-bit_rle_xyze are"
                    ));
                }
            },
            "EXPOSURE" => {
                let [factor] = positive(name, text)?;
                self.exposure *= factor;
            }
            "COLORCORR" => self.correction *= DVec3::from_array(positive(name, text)?),
            "PRIMARIES" => {
                let numbers = numbers(text).ok_or_else(|| {
                    format!(
                        "PRIMARIES {text:?} should be eight numbers: x and y of red, green, blue and white"
                    )
                })?;
                self.primaries = Chromaticities::from_numbers(numbers);
            }
            "GAMMA" if numbers(text) != Some([1.0]) => {
                return Err(format!("GAMMA {text:?} is not supported; values must be linear"));
            }
            _ => {}
        }
        Ok(())
    }

    /// From stored values to radiance in Rec. 709.
    fn to_radiance(&self) -> Result<DMat3, String> {
        let scale = (self.exposure * self.correction).recip();
        if !(scale.is_finite() && scale.min_element() > 0.0) {
            return Err("the product of its EXPOSURE and COLORCORR lines is out of range".into());
        }
        let to_rec_709 = match self.primaries {
            // Tristimulus values need no primaries.
            _ if self.is_xyz => Some(rec_709_from_xyz()),
            Some(primaries) => primaries.to_rec_709().map_err(|what| format!("PRIMARIES: {what}"))?,
            None => None,
        };
        Ok(to_rec_709.unwrap_or(DMat3::IDENTITY) * DMat3::from_diagonal(scale))
    }

    fn notices(&self) -> Vec<String> {
        let mut notices = Vec::new();
        if self.exposure != 1.0 {
            notices.push(format!("values are divided by the EXPOSURE {} in its header", self.exposure));
        }
        if self.correction != DVec3::ONE {
            let [r, g, b] = self.correction.to_array();
            notices.push(format!("values are divided by the COLORCORR {r} {g} {b} in its header"));
        }
        if self.is_xyz {
            notices.push("converted from CIE XYZ to Rec. 709 primaries".into());
        } else if self.primaries.is_some_and(|p| p.to_rec_709() != Ok(None)) {
            notices.push("converted from the PRIMARIES in its header to those of Rec. 709".into());
        }
        notices
    }
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    numbers.ok()?.try_into().ok().filter(|numbers: &[f64; N]| numbers.iter().all(|x| x.is_finite()))
}

fn positive<const N: usize>(name: &str, text: &str) -> Result<[f64; N], String> {
    let found = numbers(text).filter(|numbers: &[f64; N]| numbers.iter().all(|&x| x > 0.0));
    found.ok_or_else(|| {
        let numbers = if N == 1 { "a number above 0".into() } else { format!("{N} numbers above 0") };
        format!("{name} {text:?} should be {numbers}")
    })
}

/// Where the scan lines lie in the picture: the resolution string.
struct Layout {
    width: usize,
    height: usize,
    /// Scan lines are columns.
    by_columns: bool,
    /// The bottom row comes first.
    from_bottom: bool,
    /// The right column comes first.
    from_right: bool,
}

impl Layout {
    /// `-Y HEIGHT +X WIDTH` in its eight forms: Y points up, and a minus says that the coordinate falls.
    fn parse(line: &str) -> Result<Self, String> {
        let invalid = || format!("its resolution {line:?} is not of the form -Y HEIGHT +X WIDTH");
        let words: Vec<_> = line.split_whitespace().collect();
        let &[first, lines, second, length] = words.as_slice() else { return Err(invalid()) };
        let by_columns = first.ends_with('X');
        let (y, x) = if by_columns { (second, first) } else { (first, second) };
        let (rows, columns) = if by_columns { (length, lines) } else { (lines, length) };
        if !(matches!(y, "-Y" | "+Y") && matches!(x, "-X" | "+X")) {
            return Err(invalid());
        }
        let count = |text: &str| text.parse::<u32>().map(|n| n as usize).map_err(|_| invalid());
        let (width, height) = (count(columns)?, count(rows)?);
        Ok(Self { width, height, by_columns, from_bottom: y == "+Y", from_right: x == "-X" })
    }

    fn line_count(&self) -> usize {
        if self.by_columns { self.width } else { self.height }
    }

    fn line_length(&self) -> usize {
        if self.by_columns { self.height } else { self.width }
    }

    /// Index in the picture of pixel `at` of scan line `line`.
    fn index(&self, line: usize, at: usize) -> usize {
        let (row, column) = if self.by_columns { (at, line) } else { (line, at) };
        let row = if self.from_bottom { self.height - 1 - row } else { row };
        let column = if self.from_right { self.width - 1 - column } else { column };
        row * self.width + column
    }
}

/// The bytes that have not been read yet.
struct Input<'a> {
    bytes: &'a [u8],
}

impl Input<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (taken, rest) = self.bytes.split_first_chunk().ok_or("the file is cut short")?;
        self.bytes = rest;
        Ok(*taken)
    }

    /// A line of the header without its end.
    fn line(&mut self) -> Result<String, String> {
        let end = self.bytes.iter().take(MAX_HEADER).position(|&byte| byte == b'\n');
        let end = end.ok_or("its header is cut short")?;
        let line = String::from_utf8_lossy(&self.bytes[..end]).trim_end().to_owned();
        self.bytes = &self.bytes[end + 1..];
        Ok(line)
    }

    fn scan_line(&mut self, out: &mut [[u8; 4]]) -> Result<(), String> {
        match *self.bytes {
            [2, 2, high, low, ..] if high < 128 && COMPONENT_RUNS.contains(&out.len()) => {
                let length = usize::from(u16::from_be_bytes([high, low]));
                if length != out.len() {
                    return Err(format!("it has {length} pixels, the resolution says {}", out.len()));
                }
                self.take::<4>()?;
                (0..4).try_for_each(|component| self.component(out, component))
            }
            _ => self.pixels(out),
        }
    }

    /// One component of all pixels of a scan line, in runs.
    fn component(&mut self, out: &mut [[u8; 4]], component: usize) -> Result<(), String> {
        let mut at = 0;
        while at < out.len() {
            let [code] = self.take()?;
            let (count, repeats) = if code > 128 { (code - 128, true) } else { (code, false) };
            let run = out.get_mut(at..at + usize::from(count)).filter(|run| !run.is_empty());
            let run = run.ok_or("a run of a component is empty or longer than the line")?;
            at += run.len();
            if repeats {
                let [byte] = self.take()?;
                run.iter_mut().for_each(|pixel| pixel[component] = byte);
            } else {
                for pixel in run {
                    [pixel[component]] = self.take()?;
                }
            }
        }
        Ok(())
    }

    /// Pixels one by one. In files of the first version mantissas of 1, 1, 1 repeat the pixel before them: the exponent counts,
    /// and counts that follow each other are digits of base 256, the lowest first.
    fn pixels(&mut self, out: &mut [[u8; 4]]) -> Result<(), String> {
        let mut at = 0;
        let mut shift = 0;
        while at < out.len() {
            let pixel = self.take()?;
            if let [1, 1, 1, count] = pixel {
                let before =
                    at.checked_sub(1).ok_or("it begins with a run, and there is no pixel to repeat")?;
                let count = if shift < 32 { usize::from(count) << shift } else { usize::MAX };
                let end = at.checked_add(count).filter(|&end| end <= out.len());
                let end = end.ok_or("a run of pixels is longer than the line")?;
                let repeated = out[before];
                out[at..end].fill(repeated);
                (at, shift) = (end, shift + 8);
            } else {
                out[at] = pixel;
                (at, shift) = (at + 1, 0);
            }
        }
        Ok(())
    }
}
