//! Reads from the instructions of a SPIR-V module how it accesses its resources and how its structs are laid out.
//!
//! spirq tells names and types; it does not tell whether a storage image is read, written or both, nor the layout of
//! structs that are reached through device addresses. Opcodes and decorations: SPIR-V specification, section 3.

use std::collections::{HashMap, HashSet};

pub(super) const OP_NAME: u32 = 5;
const OP_MEMBER_NAME: u32 = 6;
const OP_EXECUTION_MODE: u32 = 16;
const OP_TYPE_ARRAY: u32 = 28;
const OP_TYPE_RUNTIME_ARRAY: u32 = 29;
const OP_TYPE_STRUCT: u32 = 30;
const OP_CONSTANT_NULL: u32 = 46;
pub(super) const OP_SPEC_CONSTANT_OP: u32 = 52;
pub(super) const OP_FUNCTION_CALL: u32 = 57;
pub(super) const OP_VARIABLE: u32 = 59;
const OP_IMAGE_TEXEL_POINTER: u32 = 60;
pub(super) const OP_LOAD: u32 = 61;
const OP_STORE: u32 = 62;
const OP_ACCESS_CHAIN: u32 = 65;
const OP_IN_BOUNDS_ACCESS_CHAIN: u32 = 66;
pub(super) const OP_DECORATE: u32 = 71;
const OP_MEMBER_DECORATE: u32 = 72;
const OP_IMAGE_READ: u32 = 98;
const OP_IMAGE_WRITE: u32 = 99;
const OP_ATOMIC_LOAD: u32 = 227;
const OP_ATOMIC_STORE: u32 = 228;
const OP_ATOMIC_FIRST: u32 = 229;
const OP_ATOMIC_LAST: u32 = 242;
pub(super) const OP_SELECTION_MERGE: u32 = 247;
pub(super) const OP_LABEL: u32 = 248;
const EXECUTION_MODE_LOCAL_SIZE: u32 = 17;
const DECORATION_ARRAY_STRIDE: u32 = 6;
const DECORATION_BINDING: u32 = 33;
const DECORATION_DESCRIPTOR_SET: u32 = 34;
const DECORATION_OFFSET: u32 = 35;

/// Accesses to one resource that the instructions show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Access {
    pub(crate) read: bool,
    pub(crate) write: bool,
    /// Passed to a function, whose accesses are not analysed.
    pub(crate) unknown: bool,
}

/// A struct type with explicit layout.
#[derive(Debug, Default, Clone)]
pub(crate) struct StructLayout {
    pub(crate) name: String,
    /// (member name, byte offset).
    pub(crate) members: Vec<(String, u32)>,
    /// Strides of the runtime arrays that have it as element.
    pub(crate) array_strides: Vec<u32>,
}

pub(crate) struct Module {
    /// By (descriptor set, binding).
    pub(crate) accesses: HashMap<(u32, u32), Access>,
    pub(crate) structs: Vec<StructLayout>,
    /// `local_size` of a compute kernel.
    pub(crate) workgroup: Option<[u32; 3]>,
}

/// Words of an instruction.
pub(super) fn encode(op: u32, operands: &[u32]) -> Vec<u32> {
    let mut words = Vec::with_capacity(operands.len() + 1);
    words.push((operands.len() as u32 + 1) << 16 | op);
    words.extend(operands);
    words
}

/// Splits a module into (opcode, operands).
pub(super) fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(5..).unwrap_or_default();
    std::iter::from_fn(move || {
        let (&head, _) = rest.split_first()?;
        let length = (head >> 16) as usize;
        let operands = rest.get(1..length)?;
        rest = &rest[length..];
        Some((head & 0xffff, operands))
    })
}

/// The module without expressions of specialisation constants (`flag ? 1u : 0u`), except for lengths of arrays. spirq computes them all
/// and gives up at those that it does not know, though nobody asks for their values.
pub(crate) fn without_constant_expressions(words: &[u32]) -> Vec<u32> {
    let lengths: HashSet<u32> = instructions(words)
        .filter_map(|(op, w)| match (op, w) {
            (OP_TYPE_ARRAY, [_, _, length]) => Some(*length),
            _ => None,
        })
        .collect();
    let mut out = words.get(..5).unwrap_or_default().to_vec();
    for (op, w) in instructions(words) {
        match (op, w) {
            (OP_SPEC_CONSTANT_OP, [ty, id, ..]) if !lengths.contains(id) => {
                out.extend([3 << 16 | OP_CONSTANT_NULL, *ty, *id]);
            }
            _ => {
                out.push((w.len() as u32 + 1) << 16 | op);
                out.extend(w);
            }
        }
    }
    out
}

pub(super) fn literal_string(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).take_while(|&b| b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

pub(crate) fn examine(words: &[u32]) -> Module {
    let mut names = HashMap::new();
    let mut member_names: HashMap<(u32, u32), String> = HashMap::new();
    let mut offsets: HashMap<(u32, u32), u32> = HashMap::new();
    let mut strides = HashMap::new();
    let mut sets = HashMap::new();
    let mut bindings = HashMap::new();
    let mut workgroup = None;
    let mut struct_sizes = Vec::new();
    let mut arrays: Vec<(u32, u32)> = Vec::new();
    // Every id that is, or was loaded or derived from, a global variable.
    let mut roots: HashMap<u32, u32> = HashMap::new();
    let mut by_variable: HashMap<u32, Access> = HashMap::new();

    for (op, w) in instructions(words) {
        let mut touch = |id: u32, change: fn(&mut Access)| {
            if let Some(&root) = roots.get(&id) {
                change(by_variable.entry(root).or_default());
            }
        };
        match (op, w) {
            (OP_NAME, [id, text @ ..]) => {
                names.insert(*id, literal_string(text));
            }
            (OP_MEMBER_NAME, [id, member, text @ ..]) => {
                member_names.insert((*id, *member), literal_string(text));
            }
            (OP_DECORATE, [id, DECORATION_ARRAY_STRIDE, stride]) => {
                strides.insert(*id, *stride);
            }
            (OP_DECORATE, [id, DECORATION_DESCRIPTOR_SET, set]) => {
                sets.insert(*id, *set);
            }
            (OP_DECORATE, [id, DECORATION_BINDING, binding]) => {
                bindings.insert(*id, *binding);
            }
            (OP_MEMBER_DECORATE, [id, member, DECORATION_OFFSET, offset]) => {
                offsets.insert((*id, *member), *offset);
            }
            (OP_EXECUTION_MODE, [_, EXECUTION_MODE_LOCAL_SIZE, x, y, z]) => workgroup = Some([*x, *y, *z]),
            (OP_TYPE_STRUCT, [id, members @ ..]) => struct_sizes.push((*id, members.len() as u32)),
            (OP_TYPE_RUNTIME_ARRAY, [id, element]) => arrays.push((*id, *element)),
            (OP_VARIABLE, [_, id, ..]) => {
                roots.insert(*id, *id);
            }
            (OP_LOAD, [_, id, pointer, ..]) => {
                touch(*pointer, |a| a.read = true);
                if let Some(&root) = roots.get(pointer) {
                    roots.insert(*id, root);
                }
            }
            (OP_ACCESS_CHAIN | OP_IN_BOUNDS_ACCESS_CHAIN, [_, id, base, ..]) => {
                if let Some(&root) = roots.get(base) {
                    roots.insert(*id, root);
                }
            }
            (OP_STORE | OP_ATOMIC_STORE, [pointer, ..]) => touch(*pointer, |a| a.write = true),
            (OP_ATOMIC_LOAD, [_, _, pointer, ..]) => touch(*pointer, |a| a.read = true),
            (OP_ATOMIC_FIRST..=OP_ATOMIC_LAST, [_, _, pointer, ..]) => {
                touch(*pointer, |a| (a.read, a.write) = (true, true));
            }
            (OP_FUNCTION_CALL, [_, _, _, arguments @ ..]) => {
                for argument in arguments {
                    touch(*argument, |a| a.unknown = true);
                }
            }
            _ => {}
        }
    }

    // Loading an image object is no access to its texels: for images the image instructions decide.
    let image_variables = image_variables(words);
    let accesses = sets
        .iter()
        .filter_map(|(id, set)| {
            let mut access = by_variable.get(id).copied().unwrap_or_default();
            if let Some(image) = image_variables.get(id) {
                access = Access { unknown: access.unknown, ..*image };
            }
            Some(((*set, *bindings.get(id)?), access))
        })
        .collect();
    let structs = struct_sizes
        .into_iter()
        .filter_map(|(id, count)| {
            let members: Vec<_> = (0..count)
                .filter_map(|m| {
                    Some((member_names.get(&(id, m)).cloned().unwrap_or_default(), *offsets.get(&(id, m))?))
                })
                .collect();
            if members.len() as u32 != count || count == 0 {
                return None;
            }
            let array_strides = arrays
                .iter()
                .filter(|(_, element)| *element == id)
                .filter_map(|(array, _)| strides.get(array).copied())
                .collect();
            Some(StructLayout { name: names.get(&id).cloned().unwrap_or_default(), members, array_strides })
        })
        .collect();
    Module { accesses, structs, workgroup }
}

/// Texel accesses by image variable: follows loads of the image object to the image instructions that use it.
fn image_variables(words: &[u32]) -> HashMap<u32, Access> {
    let mut object_of: HashMap<u32, u32> = HashMap::new();
    let mut out: HashMap<u32, Access> = HashMap::new();
    for (op, w) in instructions(words) {
        match (op, w) {
            (OP_LOAD, [_, id, pointer, ..]) => {
                object_of.insert(*id, *pointer);
            }
            (OP_IMAGE_READ, [_, _, image, ..]) => {
                if let Some(variable) = object_of.get(image) {
                    out.entry(*variable).or_default().read = true;
                }
            }
            (OP_IMAGE_WRITE, [image, ..]) => {
                if let Some(variable) = object_of.get(image) {
                    out.entry(*variable).or_default().write = true;
                }
            }
            (OP_IMAGE_TEXEL_POINTER, [_, _, variable, ..]) => {
                *out.entry(*variable).or_default() = Access { read: true, write: true, unknown: false };
            }
            _ => {}
        }
    }
    out
}
