//! `pt scenes`: the built-in scenes.

use anyhow::Result;
use pt_scene::BUILTIN;
use std::io::Write;

/// Runs the command.
///
/// # Errors
/// Standard output that can't be written.
pub fn run(out: &mut impl Write) -> Result<bool> {
    let width = BUILTIN.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    for (name, description) in BUILTIN {
        writeln!(out, "{name:width$}  {description}")?;
        let cameras = pt_scene::builtin(name).map(|scene| scene.cameras).unwrap_or_default();
        let names: Vec<_> = cameras.iter().map(|c| c.name.as_str()).collect();
        writeln!(out, "{:width$}  cameras: {}", "", names.join(", "))?;
    }
    Ok(true)
}
