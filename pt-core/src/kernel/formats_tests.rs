use super::super::access::OP_DECORATE;
use super::*;
use pt_shaders::channels::COMPACT;

const FLOAT: u32 = 3;
const IMAGE: u32 = 4;
const POINTER: u32 = 5;
const BASE_COLOR: u32 = 6;
const THROUGHPUT: u32 = 7;
const LATER: u32 = 8;
const LATER_POINTER: u32 = 9;
const DISPLAY: u32 = 10;
const PREVIOUS: u32 = 11;
const TARGET: u32 = 12;
const MAIN: u32 = 20;
const LOADED: u32 = 30;
const BOUND: u32 = 40;

fn name(id: u32, text: &str) -> (u32, Vec<u32>) {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(text.len() / 4 * 4 + 4, 0);
    let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    (OP_NAME, [id].into_iter().chain(words).collect())
}

/// Four images of 16 bits that share a type; then one of 8 bits, whose type is declared after them.
fn module(code: &[(u32, Vec<u32>)]) -> Vec<u32> {
    let image = |id, format| (OP_TYPE_IMAGE, vec![id, FLOAT, 1, 0, 0, 0, 2, format]);
    let parts = [
        (OP_CAPABILITY, vec![1]),
        name(BASE_COLOR, "ch_base_color"),
        name(PREVIOUS, "ch_base_color_prev"),
        name(TARGET, "ch_base_color_target"),
        name(THROUGHPUT, "ch_throughput"),
        (OP_DECORATE, vec![BASE_COLOR, 33, 8]),
        (22, vec![FLOAT, 32]),
        image(IMAGE, 10),
        (OP_TYPE_POINTER, vec![POINTER, 0, IMAGE]),
        (OP_VARIABLE, vec![POINTER, BASE_COLOR, 0]),
        (OP_VARIABLE, vec![POINTER, PREVIOUS, 0]),
        (OP_VARIABLE, vec![POINTER, TARGET, 0]),
        (OP_VARIABLE, vec![POINTER, THROUGHPUT, 0]),
        image(LATER, 4),
        (OP_TYPE_POINTER, vec![LATER_POINTER, 0, LATER]),
        (OP_VARIABLE, vec![LATER_POINTER, DISPLAY, 0]),
    ];
    let words = parts.iter().chain(code).flat_map(|(op, w)| encode(*op, w));
    [0x0723_0203, 0x1_0600, 0, BOUND, 0].into_iter().chain(words).collect()
}

fn load(image: u32, variable: u32) -> (u32, Vec<u32>) {
    (OP_LOAD, vec![image, LOADED, variable])
}

#[test]
fn full_frames_keep_their_kernels() {
    let words = module(&[load(IMAGE, BASE_COLOR)]);
    assert_eq!(with_formats(words.clone(), &[]).unwrap(), words);
}

#[test]
fn a_channel_gets_its_format_alone() {
    let words = module(&[load(IMAGE, BASE_COLOR), load(IMAGE, THROUGHPUT), load(LATER, DISPLAY)]);
    let out = with_formats(words, &[&COMPACT]).unwrap();
    let all: Vec<_> = instructions(&out).map(|(op, w)| (op, w.to_vec())).collect();
    let place = |wanted: (u32, Vec<u32>)| {
        let mut places = (0..all.len()).filter(|&i| all[i] == wanted);
        let first = places.next().unwrap_or_else(|| panic!("{wanted:?} in {all:?}"));
        assert_eq!(places.next(), None, "{wanted:?}");
        first
    };
    // The type of 8 bits is there already: it is declared earlier, and once.
    let image = place((OP_TYPE_IMAGE, vec![LATER, FLOAT, 1, 0, 0, 0, 2, 4]));
    let pointer = place((OP_TYPE_POINTER, vec![LATER_POINTER, 0, LATER]));
    let variable = place((OP_VARIABLE, vec![LATER_POINTER, BASE_COLOR, 0]));
    assert!(image < pointer && pointer < variable);
    place((OP_VARIABLE, vec![LATER_POINTER, PREVIOUS, 0]));
    place((OP_VARIABLE, vec![LATER_POINTER, TARGET, 0]));
    place(load(LATER, BASE_COLOR));
    place((OP_VARIABLE, vec![POINTER, THROUGHPUT, 0]));
    place(load(IMAGE, THROUGHPUT));
    place((OP_VARIABLE, vec![LATER_POINTER, DISPLAY, 0]));
    place((OP_CAPABILITY, vec![CAPABILITY_STORAGE_IMAGE_EXTENDED_FORMATS]));
    assert_eq!(out[3], BOUND);
}

#[test]
fn a_channel_in_a_call_is_refused() {
    let words = module(&[(OP_FUNCTION_CALL, vec![FLOAT, LOADED, MAIN, BASE_COLOR])]);
    let problem = with_formats(words, &[&COMPACT]).unwrap_err();
    assert!(problem.contains("function"), "{problem}");
}
