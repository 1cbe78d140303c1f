//! Specialisation of a SPIR-V module before the driver sees it: constants get their values, and code that they switch off is removed.
//!
//! A driver does the same, but late: Mesa inlines every function call first, and then removes what no path reaches. Kernels whose
//! constants select one of several light samplers, or leave out what the scene lacks, are compiled several times faster this way.
//! Conditions are folded where they are made of specialisation constants alone. Opcodes: SPIR-V specification, section 3.

use super::access::{
    OP_DECORATE, OP_FUNCTION_CALL, OP_LABEL, OP_NAME, OP_SELECTION_MERGE, OP_VARIABLE, instructions,
};
use super::control_flow::Function;
use super::fold::{Constants, OP_CONSTANT_TRUE};
use std::collections::{HashMap, HashSet};

const OP_UNDEF: u32 = 1;
const OP_STRING: u32 = 7;
const OP_LINE: u32 = 8;
const OP_EXT_INST_IMPORT: u32 = 11;
const OP_ENTRY_POINT: u32 = 15;
const OP_TYPES: std::ops::RangeInclusive<u32> = 19..=39;
const OP_TYPE_RAY_QUERY: u32 = 4472;
const OP_TYPE_ACCELERATION_STRUCTURE: u32 = 5341;
const OP_FUNCTION: u32 = 54;
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

#[cfg(test)]
#[path = "specialize_tests.rs"]
mod tests;
