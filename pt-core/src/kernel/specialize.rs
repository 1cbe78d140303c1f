//! Specialisation of a SPIR-V module before the driver sees it: constants get their values, and code that they switch off is removed.
//!
//! A driver does the same, but late: Mesa inlines every function call first, and then removes what no path reaches. Kernels whose
//! constants select one of several light samplers, or leave out what the scene lacks, are compiled several times faster this way.
//! Conditions are folded where they are made of specialisation constants alone. Opcodes: SPIR-V specification, section 3.

use super::access::{OP_DECORATE, OP_FUNCTION_CALL, OP_NAME, OP_SPEC_CONSTANT_OP, OP_VARIABLE, instructions};
use super::control_flow::Function;
use std::collections::{HashMap, HashSet};

const OP_UNDEF: u32 = 1;
const OP_STRING: u32 = 7;
const OP_LINE: u32 = 8;
const OP_EXT_INST_IMPORT: u32 = 11;
const OP_ENTRY_POINT: u32 = 15;
const OP_TYPE_BOOL: u32 = 20;
const OP_TYPE_INT: u32 = 21;
const OP_TYPES: std::ops::RangeInclusive<u32> = 19..=39;
const OP_TYPE_RAY_QUERY: u32 = 4472;
const OP_TYPE_ACCELERATION_STRUCTURE: u32 = 5341;
const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
const OP_CONSTANT: u32 = 43;
const OP_CONSTANT_COMPOSITE: u32 = 44;
const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_SPEC_CONSTANT_COMPOSITE: u32 = 51;
const OP_FUNCTION: u32 = 54;
pub(super) const OP_SELECTION_MERGE: u32 = 247;
pub(super) const OP_LABEL: u32 = 248;
const OP_DECORATE_ID: u32 = 332;
const OP_DECORATE_STRING: u32 = 5632;
const DECORATION_SPEC_ID: u32 = 1;

/// `words` with the values of its specialisation constants fixed: those of `values` by `constant_id`, the others as declared.
pub(super) fn specialize(words: &[u32], values: &HashMap<u32, u32>) -> Vec<u32> {
    let mut constants = Constants::default();
    let mut spec_ids = HashMap::new();
    let mut entries = Vec::new();
    let mut global = Vec::new();
    let mut functions: Vec<Function> = Vec::new();
    for (op, w) in instructions(words) {
        match (op, w) {
            (OP_FUNCTION, _) => functions.push(Function::new(op, w)),
            (OP_DECORATE, [target, DECORATION_SPEC_ID, id]) => {
                spec_ids.insert(*target, *id);
            }
            _ if functions.is_empty() => {
                if let (OP_ENTRY_POINT, [_, id, ..]) = (op, w) {
                    entries.push(*id);
                }
                global.push(constants.declare(op, w, |id| values.get(spec_ids.get(&id)?).copied()));
            }
            _ => functions.last_mut().into_iter().for_each(|function| function.push(op, w)),
        }
    }

    // Functions that the entry points reach through code that is left.
    let mut left: HashMap<u32, Vec<Vec<u32>>> = HashMap::new();
    let mut to_do = entries;
    while let Some(id) = to_do.pop() {
        let Some(function) = functions.iter().find(|f| f.id() == id) else { continue };
        if left.contains_key(&id) {
            continue;
        }
        let code = function.folded(&constants);
        to_do.extend(code.iter().filter(|i| i[0] & 0xffff == OP_FUNCTION_CALL).map(|i| i[3]));
        left.insert(id, code);
    }
    let code: Vec<Vec<u32>> = functions.iter().filter_map(|f| left.remove(&f.id())).flatten().collect();

    // What is left of names and decorations: those of ids that are still defined.
    let defined: HashSet<u32> = global.iter().chain(&code).filter_map(|i| defined_id(i)).collect();
    let mut out = words.get(..5).unwrap_or_default().to_vec();
    for instruction in global.iter().chain(&code) {
        let annotates =
            matches!(instruction[0] & 0xffff, OP_NAME | OP_DECORATE | OP_DECORATE_ID | OP_DECORATE_STRING);
        if !annotates || defined.contains(&instruction[1]) {
            out.extend(instruction);
        }
    }
    out
}

/// Words of an instruction.
pub(super) fn encode(op: u32, operands: &[u32]) -> Vec<u32> {
    let mut words = Vec::with_capacity(operands.len() + 1);
    words.push((operands.len() as u32 + 1) << 16 | op);
    words.extend(operands);
    words
}

/// The id that an instruction defines. Instructions without a result count as defining their second operand: an id that they use,
/// which is defined too.
fn defined_id(words: &[u32]) -> Option<u32> {
    let place = match words[0] & 0xffff {
        OP_NAME | OP_DECORATE | OP_DECORATE_ID | OP_DECORATE_STRING | OP_LINE | OP_SELECTION_MERGE => {
            return None;
        }
        OP_LABEL | OP_STRING | OP_EXT_INST_IMPORT | OP_TYPE_RAY_QUERY | OP_TYPE_ACCELERATION_STRUCTURE => 1,
        op if OP_TYPES.contains(&op) => 1,
        OP_UNDEF | OP_VARIABLE => 2,
        // Headers of the module (capabilities, entry points, execution modes, member decorations).
        op if op < OP_CONSTANT_TRUE || op == OP_DECORATE + 1 => return None,
        _ => 2,
    };
    words.get(place).copied()
}

/// Scalars whose values are known: booleans as 0 and 1, integers of 32 bits.
#[derive(Clone, Default)]
pub(super) struct Constants {
    types: HashSet<u32>,
    boolean: Option<u32>,
    pub(super) values: HashMap<u32, u32>,
}

impl Constants {
    /// Takes in an instruction before the first function; what it becomes.
    fn declare(&mut self, op: u32, w: &[u32], given: impl Fn(u32) -> Option<u32>) -> Vec<u32> {
        match (op, w) {
            (OP_TYPE_BOOL, [ty]) => {
                self.boolean = Some(*ty);
                self.types.insert(*ty);
            }
            (OP_TYPE_INT, [ty, 32, _]) => {
                self.types.insert(*ty);
            }
            (OP_CONSTANT_TRUE, [ty, id]) => return self.truth(*ty, *id, true),
            (OP_CONSTANT_FALSE, [ty, id]) => return self.truth(*ty, *id, false),
            (OP_SPEC_CONSTANT_TRUE | OP_SPEC_CONSTANT_FALSE, [ty, id]) => {
                let value = given(*id).map_or(op == OP_SPEC_CONSTANT_TRUE, |value| value != 0);
                return self.truth(*ty, *id, value);
            }
            (OP_CONSTANT | OP_SPEC_CONSTANT, [ty, id, value]) => {
                let value = given(*id).unwrap_or(*value);
                if self.types.contains(ty) {
                    self.values.insert(*id, value);
                }
                return encode(OP_CONSTANT, &[*ty, *id, value]);
            }
            (OP_SPEC_CONSTANT_COMPOSITE, _) => return encode(OP_CONSTANT_COMPOSITE, w),
            (OP_SPEC_CONSTANT_OP, [ty, id, op, operands @ ..]) => {
                if let Some(value) = self.evaluate(*op, *ty, operands) {
                    if self.boolean == Some(*ty) {
                        return self.truth(*ty, *id, value != 0);
                    }
                    self.values.insert(*id, value);
                    return encode(OP_CONSTANT, &[*ty, *id, value]);
                }
            }
            _ => {}
        }
        encode(op, w)
    }

    fn truth(&mut self, ty: u32, id: u32, value: bool) -> Vec<u32> {
        self.values.insert(id, value.into());
        encode(if value { OP_CONSTANT_TRUE } else { OP_CONSTANT_FALSE }, &[ty, id])
    }

    /// Result of an operation on scalars; `None` where an operand is unknown or the operation is none that constants need.
    pub(super) fn evaluate(&self, op: u32, ty: u32, operands: &[u32]) -> Option<u32> {
        if !self.types.contains(&ty) {
            return None;
        }
        let value = |index: usize| self.values.get(operands.get(index)?).copied();
        let (a, signed) = (value(0)?, |v: u32| v as i32);
        Some(match op {
            168 => 1 - a,                                   // OpLogicalNot
            200 => !a,                                      // OpNot
            169 => value(if a != 0 { 1 } else { 2 })?,      // OpSelect
            128 => a.wrapping_add(value(1)?),               // OpIAdd
            130 => a.wrapping_sub(value(1)?),               // OpISub
            132 => a.wrapping_mul(value(1)?),               // OpIMul
            164 | 170 => (a == value(1)?).into(),           // OpLogicalEqual, OpIEqual
            165 | 171 => (a != value(1)?).into(),           // OpLogicalNotEqual, OpINotEqual
            166 | 197 => a | value(1)?,                     // OpLogicalOr, OpBitwiseOr
            167 | 199 => a & value(1)?,                     // OpLogicalAnd, OpBitwiseAnd
            198 => a ^ value(1)?,                           // OpBitwiseXor
            194 => a.checked_shr(value(1)?)?,               // OpShiftRightLogical
            196 => a.checked_shl(value(1)?)?,               // OpShiftLeftLogical
            172 => (a > value(1)?).into(),                  // OpUGreaterThan
            173 => (signed(a) > signed(value(1)?)).into(),  // OpSGreaterThan
            174 => (a >= value(1)?).into(),                 // OpUGreaterThanEqual
            175 => (signed(a) >= signed(value(1)?)).into(), // OpSGreaterThanEqual
            176 => (a < value(1)?).into(),                  // OpULessThan
            177 => (signed(a) < signed(value(1)?)).into(),  // OpSLessThan
            178 => (a <= value(1)?).into(),                 // OpULessThanEqual
            179 => (signed(a) <= signed(value(1)?)).into(), // OpSLessThanEqual
            _ => return None,
        })
    }
}

#[cfg(test)]
#[path = "specialize_tests.rs"]
mod tests;
