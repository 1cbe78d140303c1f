//! A surface without a window, for tests and benchmarks.

use crate::error::Result;
use crate::panel::Panel;
use crate::panel_renderer::LaidOut;
use crate::presenter::Presenter;
use crate::protocol::Status;
use ash::{ext, khr, vk};
use pt_core::{Device, DeviceOptions};

/// Opens a device that can present to such a surface.
///
/// # Errors
/// A device or a driver that can't.
pub fn open_device(options: &DeviceOptions) -> Result<Device> {
    Ok(Device::open_presenting(options, &[khr::surface::NAME, ext::headless_surface::NAME])?)
}

/// Presents to one of `size` pixels.
///
/// # Errors
/// A device that [`open_device`] has not opened.
pub fn presenter(device: &Device, size: [u32; 2]) -> Result<Presenter> {
    let make = |entry: &ash::Entry, instance: &ash::Instance| {
        let loader = ext::headless_surface::Instance::new(entry, instance);
        // SAFETY: the instance has the extension.
        unsafe { loader.create_headless_surface(&vk::HeadlessSurfaceCreateInfoEXT::default(), None) }
    };
    Presenter::new(device, size, Box::new(make))
}

/// Lays a panel out over a surface of `size` pixels.
pub fn lay_out(context: &egui::Context, size: [u32; 2], panel: &mut Panel, status: &Status) -> LaidOut {
    let size = egui::vec2(size[0] as f32, size[1] as f32);
    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
    let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
    let output = context.run_ui(input, |ui| drop(panel.ui(ui, status)));
    LaidOut {
        triangles: context.tessellate(output.shapes, output.pixels_per_point),
        textures: output.textures_delta,
        pixels_per_point: output.pixels_per_point,
    }
}
