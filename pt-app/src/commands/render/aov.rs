//! Which channels `--aov` names.

use super::args::AovSelection;
use anyhow::{Result, bail};
use pt_core::ChannelImages;
use pt_shaders::channels::{ChannelId, ExtentClass};

/// The channels that a selection names.
///
/// # Errors
/// An unknown name, with the closest ones there are.
pub fn select(selection: Option<&AovSelection>, images: &ChannelImages) -> Result<Vec<ChannelId>> {
    let there: Vec<_> = images.ids().filter(|&id| id.channel().extent != ExtentClass::Output).collect();
    match selection {
        None => Ok(Vec::new()),
        Some(AovSelection::All) => Ok(there),
        Some(AovSelection::Named(names)) => names
            .iter()
            .map(|name| match ChannelId::by_name(name).filter(|id| there.contains(id)) {
                Some(id) => Ok(id),
                None => {
                    let names: Vec<_> = there.iter().map(|id| id.channel().name).collect();
                    bail!("--aov {name}: no such channel in this frame; there are {}", names.join(", "))
                }
            })
            .collect(),
    }
}
