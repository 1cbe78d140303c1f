//! Tables of directional albedos, which kernels that evaluate lobes look up (bsdf/albedo.glsl). The example albedo_tables of
//! pt-reference computes them.

const TEXT: &str = include_str!("bsdf_tables.txt");

/// Name of the file, for the program that writes it.
pub const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/bsdf_tables.txt");

/// The values of a table, row by row: `ggx`, `grazing`, `charlie` or `mean`; empty for other names. The head of the file describes them.
pub fn table(name: &str) -> Vec<f64> {
    let body = TEXT.split("= ").find_map(|part| part.strip_prefix(name)?.strip_prefix('\n'));
    body.unwrap_or("").split_whitespace().map_while(|word| word.parse().ok()).collect()
}

/// The content of the buffer "bsdf_tables".
pub fn packed() -> Vec<f32> {
    ["ggx", "grazing", "charlie", "mean"].into_iter().flat_map(table).map(|value| value as f32).collect()
}
