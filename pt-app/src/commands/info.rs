//! `pt info` prints devices, drivers, trace backends, and which backend `auto` chooses and why.

use anyhow::Result;
use clap::Args;
use pt_core::device::DeviceInfo;
use pt_core::trace::TraceBackend;
use pt_core::trace::bench::{CLEARLY_FASTER, Choice, choose};
use pt_core::{Device, DeviceOptions};
use pt_scene::gpu::{mesh_geometry, placements};
use serde_json::json;
use std::io::Write;

/// `pt info`
#[derive(Clone, Debug, Args)]
pub struct InfoArgs {
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Only this Vulkan device, by index or part of its name [default: all]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// Scene that `auto` is tried on.
const SCENE: &str = "gallery";

/// Runs the command.
///
/// # Errors
/// No Vulkan at all, or no device that can run the frame.
pub fn run(args: &InfoArgs, out: &mut impl Write) -> Result<bool> {
    let mut devices = Device::list()?;
    if let Some(wanted) = &args.device {
        let chosen = Device::open(&DeviceOptions { device: Some(wanted.clone()), validation: false })?;
        devices.retain(|info| info.index == chosen.info().index);
    }
    let scene = pt_import::open(SCENE, &Default::default())?;
    let mut described = Vec::new();
    for info in devices {
        let choice = match info.unusable {
            Some(_) => None,
            None => {
                let device =
                    Device::open(&DeviceOptions { device: Some(info.index.to_string()), validation: false })?;
                Some(choose(&device, &mesh_geometry(&scene), &placements(&scene))?)
            }
        };
        described.push((info, choice));
    }
    if args.json {
        let list: Vec<_> =
            described.iter().map(|(info, choice)| json!({ "device": info, "auto": choice })).collect();
        let document = json!({ "version": env!("CARGO_PKG_VERSION"), "auto_scene": SCENE, "devices": list });
        writeln!(out, "{}", serde_json::to_string_pretty(&document)?)?;
    } else {
        writeln!(out, "pt {}", env!("CARGO_PKG_VERSION"))?;
        for (info, choice) in &described {
            describe(info, choice.as_ref(), out)?;
        }
    }
    // None that can run the frame: the same message as for a render.
    Device::open(&DeviceOptions::default())?;
    Ok(true)
}

fn describe(info: &DeviceInfo, choice: Option<&Choice>, out: &mut impl Write) -> Result<()> {
    writeln!(out, "\ndevice {}: {} ({})", info.index, info.name, info.kind)?;
    writeln!(out, "  driver    {} {}, Vulkan {}", info.driver, info.driver_version, info.vulkan)?;
    writeln!(out, "  memory    {:.1} GiB", info.memory_bytes as f64 / f64::from(1 << 30))?;
    if let Some(why) = &info.unusable {
        writeln!(out, "  unusable  {why}")?;
    }
    let Some(choice) = choice else { return Ok(()) };
    for backend in TraceBackend::CONCRETE {
        let rate = choice.mrays_per_s.iter().find(|(b, _)| *b == backend).map(|(_, rate)| *rate);
        let missing = choice.missing.iter().find(|(b, _)| *b == backend).map(|(_, why)| why);
        match (rate, missing) {
            (Some(rate), _) => writeln!(out, "  {:<12}{rate:.2} Mrays/s on {SCENE}", backend.name())?,
            (None, Some(why)) => writeln!(out, "  {:<12}not there: {why}", backend.name())?,
            (None, None) if backend == TraceBackend::RtReorder => {
                let sorts =
                    if info.capabilities.rt_reorder_sorts { "" } else { ", and the device does not sort" };
                writeln!(out, "  {:<12}there; auto does not try it{sorts}", backend.name())?;
            }
            (None, None) => writeln!(out, "  {:<12}there, not timed", backend.name())?,
        }
    }
    let why = match choice.backend {
        TraceBackend::Compute if choice.mrays_per_s.is_empty() => {
            "nothing is timed on a CPU or where there is no other".into()
        }
        TraceBackend::Compute => format!("no other is {CLEARLY_FASTER} times as fast"),
        _ => format!("the fastest, and {CLEARLY_FASTER} times as fast as compute"),
    };
    writeln!(out, "  auto        {}: {why}", choice.backend.name())?;
    Ok(())
}
