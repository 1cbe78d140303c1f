use super::super::access::{OP_SPEC_CONSTANT_OP, encode};
use super::super::fold::{OP_CONSTANT, OP_SPEC_CONSTANT, OP_SPEC_CONSTANT_TRUE, OP_TYPE_BOOL, OP_TYPE_INT};
use super::*;

const VOID: u32 = 1;
const FUNCTION_TYPE: u32 = 2;
const BOOL: u32 = 3;
const UINT: u32 = 4;
const MAIN: u32 = 10;
const HELPER: u32 = 11;
const FLAG: u32 = 20;
const FEATURES: u32 = 21;
const MASKED: u32 = 22;
const ZERO: u32 = 23;
const TWO: u32 = 24;
const HAS: u32 = 25;
const UNKNOWN: u32 = 30;

/// `layout(constant_id = 5) const bool FLAG = true; layout(constant_id = 6) const uint FEATURES = 1u;`
/// `const bool HAS = (FEATURES & 2u) != 0u;`, then `main` with the given blocks and a function `HELPER`.
fn module(blocks: &[(u32, &[u32])]) -> Vec<u32> {
    let global: &[(u32, &[u32])] = &[
        (OP_ENTRY_POINT, &[5, MAIN, 0]),
        (OP_NAME, &[HELPER, 0]),
        (OP_NAME, &[MAIN, 0]),
        (OP_DECORATE, &[FLAG, DECORATION_SPEC_ID, 5]),
        (OP_DECORATE, &[FEATURES, DECORATION_SPEC_ID, 6]),
        (19, &[VOID]),
        (33, &[FUNCTION_TYPE, VOID]),
        (OP_TYPE_BOOL, &[BOOL]),
        (OP_TYPE_INT, &[UINT, 32, 0]),
        (OP_SPEC_CONSTANT_TRUE, &[BOOL, FLAG]),
        (OP_SPEC_CONSTANT, &[UINT, FEATURES, 1]),
        (OP_CONSTANT, &[UINT, ZERO, 0]),
        (OP_CONSTANT, &[UINT, TWO, 2]),
        (OP_SPEC_CONSTANT_OP, &[UINT, MASKED, 199, FEATURES, TWO]),
        (OP_SPEC_CONSTANT_OP, &[BOOL, HAS, 171, MASKED, ZERO]),
        (OP_UNDEF, &[BOOL, UNKNOWN]),
        (OP_FUNCTION, &[VOID, MAIN, 0, FUNCTION_TYPE]),
    ];
    let helper: &[(u32, &[u32])] =
        &[(OP_FUNCTION, &[VOID, HELPER, 0, FUNCTION_TYPE]), (OP_LABEL, &[90]), (253, &[]), (56, &[])];
    let end: &[(u32, &[u32])] = &[(56, &[])];
    let parts = global.iter().chain(blocks).chain(end).chain(helper);
    [0x0723_0203, 0x1_0600, 0, 100, 0].into_iter().chain(parts.flat_map(|(op, w)| encode(*op, w))).collect()
}

/// Instructions of `main` after specialisation, and whether `HELPER` is left, with its name.
fn specialized(blocks: &[(u32, &[u32])], values: &[(u32, u32)]) -> (Vec<(u32, Vec<u32>)>, bool) {
    let words = specialize(&module(blocks), &values.iter().copied().collect());
    let all: Vec<(u32, Vec<u32>)> = instructions(&words).map(|(op, w)| (op, w.to_vec())).collect();
    assert!(!all.iter().any(|(op, w)| *op == OP_DECORATE && w[1] == DECORATION_SPEC_ID));
    let named = all.contains(&(OP_NAME, vec![HELPER, 0]));
    let defined = all.iter().any(|(op, w)| *op == OP_FUNCTION && w[1] == HELPER);
    assert_eq!(named, defined);
    let start = all.iter().position(|(op, w)| *op == OP_FUNCTION && w[1] == MAIN).unwrap();
    let end = start + all[start..].iter().position(|(op, _)| *op == 56).unwrap();
    (all[start + 1..end].to_vec(), defined)
}

const SELECTION: &[(u32, &[u32])] = &[
    (OP_LABEL, &[50]),
    (OP_SELECTION_MERGE, &[52, 0]),
    (250, &[HAS, 51, 52]),
    (OP_LABEL, &[51]),
    (OP_FUNCTION_CALL, &[VOID, 60, HELPER]),
    (249, &[52]),
    (OP_LABEL, &[52]),
    (253, &[]),
];

#[test]
fn what_a_condition_switches_off_is_removed() {
    let (main, helper) = specialized(SELECTION, &[]);
    let expected = [(OP_LABEL, vec![50]), (249, vec![52]), (OP_LABEL, vec![52]), (253, vec![])];
    assert_eq!((main.as_slice(), helper), (expected.as_slice(), false));
    // With bit 2 of the features, the branch is taken.
    let (main, helper) = specialized(SELECTION, &[(6, 3)]);
    assert!(main.contains(&(OP_FUNCTION_CALL, vec![VOID, 60, HELPER])) && helper);
    assert!(main.contains(&(249, vec![51])) && !main.iter().any(|(op, _)| *op == OP_SELECTION_MERGE));
}

#[test]
fn conditions_of_two_parts_are_folded() {
    // `if (HAS && unknown) HELPER();`
    let blocks: &[(u32, &[u32])] = &[
        (OP_LABEL, &[50]),
        (OP_SELECTION_MERGE, &[52, 0]),
        (250, &[HAS, 51, 52]),
        (OP_LABEL, &[51]),
        (249, &[52]),
        (OP_LABEL, &[52]),
        (245, &[BOOL, 61, HAS, 50, UNKNOWN, 51]),
        (OP_SELECTION_MERGE, &[54, 0]),
        (250, &[61, 53, 54]),
        (OP_LABEL, &[53]),
        (OP_FUNCTION_CALL, &[VOID, 60, HELPER]),
        (249, &[54]),
        (OP_LABEL, &[54]),
        (253, &[]),
    ];
    let (main, helper) = specialized(blocks, &[]);
    assert!(!helper && main.contains(&(245, vec![BOOL, 61, HAS, 50])));
    let (main, helper) = specialized(blocks, &[(6, 2)]);
    assert!(helper && main.contains(&(245, vec![BOOL, 61, UNKNOWN, 51])));
    assert!(main.contains(&(250, vec![61, 53, 54])));
}

#[test]
fn a_switch_keeps_its_merge_block_and_one_case() {
    let blocks: &[(u32, &[u32])] = &[
        (OP_LABEL, &[50]),
        (OP_SELECTION_MERGE, &[53, 0]),
        (251, &[FEATURES, 51, 7, 52]),
        (OP_LABEL, &[51]),
        (OP_FUNCTION_CALL, &[VOID, 60, HELPER]),
        (249, &[53]),
        (OP_LABEL, &[52]),
        (253, &[]),
        (OP_LABEL, &[53]),
        (253, &[]),
    ];
    let (main, helper) = specialized(blocks, &[(6, 7)]);
    let expected = [
        (OP_LABEL, vec![50]),
        (OP_SELECTION_MERGE, vec![53, 0]),
        (251, vec![FEATURES, 52]),
        (OP_LABEL, vec![52]),
        (253, vec![]),
        (OP_LABEL, vec![53]),
        (255, vec![]),
    ];
    assert_eq!((main.as_slice(), helper), (expected.as_slice(), false));
    assert!(specialized(blocks, &[]).1);
}

#[test]
fn a_loop_that_ends_at_once_stays_a_loop() {
    let blocks: &[(u32, &[u32])] = &[
        (OP_LABEL, &[50]),
        (249, &[51]),
        (OP_LABEL, &[51]),
        (246, &[54, 53, 0]),
        (249, &[52]),
        (OP_LABEL, &[52]),
        (250, &[FLAG, 55, 54]),
        (OP_LABEL, &[55]),
        (OP_FUNCTION_CALL, &[VOID, 60, HELPER]),
        (249, &[53]),
        (OP_LABEL, &[53]),
        (249, &[51]),
        (OP_LABEL, &[54]),
        (253, &[]),
    ];
    let (main, helper) = specialized(blocks, &[(5, 0)]);
    assert!(!helper && main.contains(&(246, vec![54, 53, 0])));
    let place = main.iter().position(|i| *i == (OP_LABEL, vec![53])).unwrap();
    assert_eq!(main[place + 1], (249, vec![51]));
    assert!(specialized(blocks, &[]).1);
}

#[test]
fn operations_on_constants_have_their_results() {
    let mut constants = Constants::default();
    constants.declare(OP_TYPE_INT, &[UINT, 32, 0], |_| None);
    let (minus_one, three) = (70, 71);
    constants.declare(OP_CONSTANT, &[UINT, minus_one, u32::MAX], |_| None);
    constants.declare(OP_CONSTANT, &[UINT, three, 3], |_| None);
    let result = |op| constants.evaluate(op, UINT, &[minus_one, three]);
    for (op, expected) in [(128, 2), (130, u32::MAX - 3), (132, 3u32.wrapping_neg()), (194, u32::MAX >> 3)] {
        assert_eq!(result(op), Some(expected), "{op}");
    }
    for (op, expected) in [(172, 1), (173, 0), (176, 0), (177, 1), (174, 1), (175, 0), (178, 0), (179, 1)] {
        assert_eq!(result(op), Some(expected), "{op}");
    }
    assert_eq!([result(164), result(166), result(198)], [Some(0), Some(u32::MAX), Some(u32::MAX - 3)]);
    // An unknown operation, an unknown operand, a shift by more than the width.
    assert_eq!(result(134), None);
    assert_eq!(constants.evaluate(128, UINT, &[three, 99]), None);
    assert_eq!(constants.evaluate(194, UINT, &[three, minus_one]), None);
}
