//! The `pt` program.
fn main() {}
