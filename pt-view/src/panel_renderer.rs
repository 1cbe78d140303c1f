//! Draws what egui lays out. The one file that knows egui-ash-renderer.

use crate::error::{Error, Result};
use ash::vk;
use egui_ash_renderer::allocator::DefaultAllocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer};
use pt_core::Device;

/// A panel that egui has laid out.
pub struct LaidOut {
    /// Triangles with their clip rectangles.
    pub triangles: Vec<egui::ClippedPrimitive>,
    /// Textures that change, and those that are no longer needed.
    pub textures: egui::TexturesDelta,
    /// Pixels of a point.
    pub pixels_per_point: f32,
}

/// Draws panels over pictures.
pub(crate) struct PanelRenderer {
    device: Device,
    renderer: Renderer<DefaultAllocator>,
    pool: vk::CommandPool,
    /// Textures that the panel that is drawn now still reads.
    unneeded: Vec<egui::TextureId>,
}

impl PanelRenderer {
    /// For attachments of `format`. `pool`: for the upload of textures.
    pub(crate) fn new(device: &Device, pool: vk::CommandPool, format: vk::Format) -> Result<Self> {
        let vulkan = device.vulkan();
        let rendering = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let renderer = Renderer::with_default_allocator(
            vulkan.instance,
            vulkan.physical,
            vulkan.device.clone(),
            rendering,
            Options::default(),
        )
        .map_err(failed)?;
        Ok(Self { device: device.clone(), renderer, pool, unneeded: Vec::new() })
    }

    /// Uploads textures, before the panel is drawn. No earlier panel is being drawn.
    pub(crate) fn prepare(&mut self, panel: &mut LaidOut) -> Result<()> {
        let Self { device, renderer, pool, unneeded } = self;
        for texture in unneeded.drain(..) {
            renderer.free_texture(texture).map_err(failed)?;
        }
        unneeded.extend(panel.textures.free.drain());
        if panel.textures.set.is_empty() {
            return Ok(());
        }
        // The queue is kept from first to last, so that all together wait for what it has now, which is one frame.
        let mut textures = panel.textures.set.drain();
        let upload = |queue| {
            textures.try_for_each(|(texture, deltas)| {
                deltas.iter().try_for_each(|delta| renderer.set_texture(queue, *pool, texture, delta))
            })
        };
        device.with_queue(upload).map_err(failed)
    }

    /// Records the panel, within a rendering to an attachment of `extent`.
    pub(crate) fn draw(
        &mut self,
        commands: vk::CommandBuffer,
        extent: vk::Extent2D,
        panel: &LaidOut,
    ) -> Result<()> {
        self.renderer.cmd_draw(commands, extent, panel.pixels_per_point, &panel.triangles).map_err(failed)
    }
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Panel(error.to_string())
}
