//! Scalar constants of a SPIR-V module, and operations on them that are known before the driver sees it.
//! Opcodes: SPIR-V specification, section 3.

use super::access::{OP_SPEC_CONSTANT_OP, encode};
use std::collections::{HashMap, HashSet};

pub(super) const OP_TYPE_BOOL: u32 = 20;
pub(super) const OP_TYPE_INT: u32 = 21;
pub(super) const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
pub(super) const OP_CONSTANT: u32 = 43;
const OP_CONSTANT_COMPOSITE: u32 = 44;
pub(super) const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
pub(super) const OP_SPEC_CONSTANT: u32 = 50;
const OP_SPEC_CONSTANT_COMPOSITE: u32 = 51;

/// Scalars whose values are known: booleans as 0 and 1, integers of 32 bits.
#[derive(Clone, Default)]
pub(super) struct Constants {
    types: HashSet<u32>,
    boolean: Option<u32>,
    pub(super) values: HashMap<u32, u32>,
}

impl Constants {
    /// Takes in an instruction before the first function; what it becomes.
    pub(super) fn declare(&mut self, op: u32, w: &[u32], given: impl Fn(u32) -> Option<u32>) -> Vec<u32> {
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
