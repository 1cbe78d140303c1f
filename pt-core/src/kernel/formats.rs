//! Formats of the images in a kernel. GLSL declares the formats of the tables; where a knob gives some images others (`OtherFormats`),
//! these are put into the SPIR-V here. Opcodes and formats: SPIR-V specification, section 3.

use super::access::{self, OP_FUNCTION_CALL, OP_LOAD, OP_NAME, OP_VARIABLE, encode, instructions};
use pt_shaders::channels::{Format, OtherFormats};
use std::collections::{HashMap, HashSet};

const OP_CAPABILITY: u32 = 17;
const OP_TYPE_IMAGE: u32 = 25;
const OP_TYPE_POINTER: u32 = 32;
const CAPABILITY_STORAGE_IMAGE_EXTENDED_FORMATS: u32 = 49;
/// Place of the format among the operands of `OpTypeImage`.
const FORMAT: usize = 7;

/// Image Format of SPIR-V.
const fn spirv_number(format: Format) -> u32 {
    match format {
        Format::Rgba32F => 1,
        Format::Rgba16F | Format::Half(_) => 2,
        Format::R32F => 3,
        Format::Rgba8Unorm | Format::Rgba8Root => 4,
        Format::Rg32F => 6,
        Format::Rgba16Unorm => 10,
        Format::Rg16Unorm => 12,
        Format::Rg8Unorm => 13,
        Format::Rgba32Uint => 30,
        Format::R32Uint => 33,
        Format::Rg32Uint => 35,
        Format::R16Uint => 38,
    }
}

/// Ends of the names of a storage image: this frame's, last frame's, and a target that stands for it in the kernel's own descriptor set.
const ENDS: [&str; 3] = ["", "_prev", "_target"];

/// The module with the formats that its images have where some have others than their tables say.
///
/// # Errors
/// An image with another format that is passed to a function: what the function does with it would have to be changed too.
pub(super) fn with_formats(words: Vec<u32>, others: &[&OtherFormats]) -> Result<Vec<u32>, String> {
    let mut wanted = HashMap::new();
    for (id, format) in others.iter().flat_map(|others| others.images) {
        wanted.extend(ENDS.map(|end| (id.glsl_name() + end, spirv_number(*format))));
    }
    let mut formats = HashMap::new();
    for (op, w) in instructions(&words) {
        if let (OP_NAME, [id, text @ ..]) = (op, w)
            && let Some(format) = wanted.get(&access::literal_string(text))
        {
            formats.insert(*id, *format);
        }
    }
    if formats.is_empty() { Ok(words) } else { Rewrite::new(&words, formats).rewrite(&words) }
}

/// Types that are not aggregates may be declared once only: those that are there are found by their operands.
struct Rewrite {
    /// Format by variable.
    formats: HashMap<u32, u32>,
    /// Operands without the result by id, and the reverse: images and pointers.
    operands: HashMap<u32, (u32, Vec<u32>)>,
    ids: HashMap<(u32, Vec<u32>), u32>,
    declared: HashSet<u32>,
    next_id: u32,
    out: Vec<u32>,
}

impl Rewrite {
    fn new(words: &[u32], formats: HashMap<u32, u32>) -> Self {
        let (operands, ids, declared) = Default::default();
        let next_id = words.get(3).copied().unwrap_or_default();
        let out = words.get(..5).unwrap_or_default().to_vec();
        let mut new = Self { formats, operands, ids, declared, next_id, out };
        for (op, w) in instructions(words) {
            if let (OP_TYPE_IMAGE | OP_TYPE_POINTER, [id, rest @ ..]) = (op, w) {
                new.operands.insert(*id, (op, rest.to_vec()));
                new.ids.insert((op, rest.to_vec()), *id);
            }
        }
        new
    }

    fn rewrite(mut self, words: &[u32]) -> Result<Vec<u32>, String> {
        let extended =
            |(op, w): (u32, &[u32])| op == OP_CAPABILITY && w == [CAPABILITY_STORAGE_IMAGE_EXTENDED_FORMATS];
        if !instructions(words).any(extended) {
            self.out.extend(encode(OP_CAPABILITY, &[CAPABILITY_STORAGE_IMAGE_EXTENDED_FORMATS]));
        }
        // Type of the image in a variable.
        let mut images = HashMap::new();
        for (op, w) in instructions(words) {
            match (op, w) {
                (OP_TYPE_IMAGE | OP_TYPE_POINTER, [id, ..]) if !self.declared.insert(*id) => {}
                (OP_VARIABLE, [pointer, id, storage, ..]) if self.formats.contains_key(id) => {
                    let (image, pointer) = self.types(*pointer, self.formats[id]);
                    images.insert(*id, image);
                    self.out.extend(encode(op, &[pointer, *id, *storage]));
                }
                (OP_LOAD, [_, id, variable, rest @ ..]) if images.contains_key(variable) => {
                    self.out.extend(encode(op, &[&[images[variable], *id, *variable], rest].concat()));
                }
                (OP_FUNCTION_CALL, [_, _, _, arguments @ ..])
                    if arguments.iter().any(|id| images.contains_key(id)) =>
                {
                    return Err(
                        "an image that has not the format of its table is passed to a function".into()
                    );
                }
                _ => self.out.extend(encode(op, w)),
            }
        }
        self.out[3] = self.next_id;
        Ok(self.out)
    }

    /// The types of an image with another format than that behind `pointer`, and of a pointer to it.
    fn types(&mut self, pointer: u32, format: u32) -> (u32, u32) {
        let (_, pointer) = self.operands[&pointer].clone();
        let (_, mut image) = self.operands[&pointer[1]].clone();
        image[FORMAT - 1] = format;
        let image = self.declare(OP_TYPE_IMAGE, image);
        (image, self.declare(OP_TYPE_POINTER, vec![pointer[0], image]))
    }

    /// The id of a type, which is declared here unless it is already.
    fn declare(&mut self, op: u32, operands: Vec<u32>) -> u32 {
        let id = *self.ids.entry((op, operands.clone())).or_insert_with(|| {
            self.next_id += 1;
            self.next_id - 1
        });
        if self.declared.insert(id) {
            self.operands.insert(id, (op, operands.clone()));
            self.out.extend(encode(op, &[&[id], &operands[..]].concat()));
        }
        id
    }
}

#[cfg(test)]
#[path = "formats_tests.rs"]
mod tests;
