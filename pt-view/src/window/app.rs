//! What exists while the event loop runs: it draws the panel over pictures that the renderer has left.

use super::{Opening, Woken};
use crate::blit::Blit;
use crate::camera::FreeCamera;
use crate::durations::{Durations, Summary};
use crate::error::{Error, Result};
use crate::input::HeldKeys;
use crate::layout::{Layer, Part, is_on_edge, parts, place};
use crate::panel::Panel;
use crate::panel_renderer::LaidOut;
use crate::presenter::Presenter;
use crate::protocol::{Status, TruthView};
use crate::renderer_thread::RendererThread;
use crate::swapchain_rules::Outcome;
use pt_core::Device;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::{Window, WindowId};

/// Between two steps of a camera that flies, and between two looks whether the device is free.
const TICK: Duration = Duration::from_millis(8);

/// What the pointer drags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drag {
    /// The camera, by a button.
    Camera(MouseButton),
    /// The edge between frame and ground truth.
    Edge,
}

/// What exists as long as the window.
pub(super) struct Opened {
    window: Arc<Window>,
    egui: egui_winit::State,
    presenter: Presenter,
}

pub(super) struct App<'a> {
    pub(super) device: Device,
    pub(super) opening: Opening,
    pub(super) opened: Option<Opened>,
    pub(super) context: egui::Context,
    pub(super) panel: Panel,
    pub(super) camera: FreeCamera,
    pub(super) pose_number: u64,
    pub(super) command_number: u64,
    pub(super) commands: &'a mut dyn FnMut(&str),
    pub(super) keys: HeldKeys,
    pub(super) control: bool,
    pub(super) drag: Option<Drag>,
    /// The key is held that shows the ground truth.
    pub(super) is_flipped: bool,
    pub(super) cursor: [f64; 2],
    /// The pixel of the picture under it, if its values are shown.
    pub(super) pixel: Option<[u32; 2]>,
    /// Where the picture is, pixels of the window.
    pub(super) shown_at: [i32; 4],
    pub(super) status: Status,
    /// Textures of panels that were left out.
    pub(super) textures: egui::TexturesDelta,
    pub(super) is_dirty: bool,
    pub(super) last_tick: Instant,
    /// How long the thread was busy, from each wake to the next rest: input that comes meanwhile waits.
    pub(super) busy: Durations,
    pub(super) woke: Instant,
    pub(super) first_frame: Option<Instant>,
    pub(super) is_closed: bool,
    pub(super) failure: Option<Error>,
    /// Last: it waits for the renderer's last frame.
    pub(super) renderer: RendererThread,
}

impl<'a> App<'a> {
    pub(super) fn new(
        device: &Device,
        mut opening: Opening,
        renderer: RendererThread,
        commands: &'a mut dyn FnMut(&str),
    ) -> Self {
        let panel = Panel::new(std::mem::take(&mut opening.content));
        Self {
            device: device.clone(),
            camera: FreeCamera::new(opening.pose, opening.scene_size),
            opening,
            opened: None,
            context: egui::Context::default(),
            panel,
            pose_number: 0,
            command_number: 0,
            commands,
            keys: HeldKeys::default(),
            control: false,
            drag: None,
            is_flipped: false,
            cursor: [-1.0; 2],
            pixel: None,
            shown_at: [0; 4],
            status: Status { message: "the kernels are being compiled".into(), ..Status::default() },
            textures: egui::TexturesDelta::default(),
            is_dirty: true,
            last_tick: Instant::now(),
            busy: Durations::default(),
            woke: Instant::now(),
            first_frame: None,
            is_closed: false,
            failure: None,
            renderer,
        }
    }

    /// What ended it, or what it did.
    pub(super) fn end(mut self) -> Result<Summary> {
        // egui takes textures that nobody uploads for a mistake; these are of panels that nobody will see.
        self.textures.clear();
        let seconds = self.first_frame.map_or(0.0, |first| first.elapsed().as_secs_f64());
        let summary = Summary { frames: self.renderer.frames(), seconds, input: self.busy };
        self.failure.map_or(Ok(summary), Err)
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let no_window = |error: &dyn std::fmt::Display| Error::NoWindow(error.to_string());
        // Room for the panel and the bar.
        let size = [self.opening.size[0] + 400, self.opening.size[1] + 60].map(|side| side.clamp(320, 2400));
        let attributes = Window::default_attributes()
            .with_title(self.opening.title.clone())
            .with_inner_size(PhysicalSize::new(size[0], size[1]));
        let window = Arc::new(events.create_window(attributes).map_err(|error| no_window(&error))?);
        let shared = window.clone();
        let make_surface = move |entry: &ash::Entry, instance: &ash::Instance| {
            let lost = |_| ash::vk::Result::ERROR_SURFACE_LOST_KHR;
            let display = shared.display_handle().map_err(lost)?.as_raw();
            let window = shared.window_handle().map_err(lost)?.as_raw();
            // SAFETY: the handles are those of the window, which the closure keeps alive.
            unsafe { ash_window::create_surface(entry, instance, display, window, None) }
        };
        let size: [u32; 2] = window.inner_size().into();
        let presenter = Presenter::new(&self.device, size, Box::new(make_surface))?;
        let most = self.device.info().capabilities.max_image_side as usize;
        let scale = Some(window.scale_factor() as f32);
        let root = egui::ViewportId::ROOT;
        let egui = egui_winit::State::new(self.context.clone(), root, &window, scale, None, Some(most));
        self.opened = Some(Opened { window, egui, presenter });
        Ok(())
    }

    /// Takes what the renderer has left.
    fn collect(&mut self) {
        match self.renderer.collect() {
            Some(Ok(status)) => {
                self.panel.frame_done(&status);
                if let Some((number, pose)) = status.pose
                    && number != self.pose_number
                {
                    self.pose_number = number;
                    self.camera.put(pose);
                }
                if let Some((number, command)) = &status.command
                    && *number != self.command_number
                {
                    self.command_number = *number;
                    self.context.copy_text(command.clone());
                    (self.commands)(command);
                }
                self.status = status;
                self.first_frame.get_or_insert_with(Instant::now);
                self.is_dirty = true;
            }
            Some(Err(failure)) => self.failure = Some(Error::Renderer(failure)),
            None => {}
        }
    }

    /// Lays the panel out and shows it over the picture, if the device is free.
    fn draw(&mut self) -> Result<()> {
        let Some(opened) = &mut self.opened else { return Ok(()) };
        if !self.is_dirty || !opened.presenter.is_free()? {
            return Ok(());
        }
        let input = opened.egui.take_egui_input(&opened.window);
        // What the panel leaves of the window.
        let mut left = egui::Rect::NOTHING;
        let mut requests = Vec::new();
        let (panel, status) = (&mut self.panel, &self.status);
        let drags_edge = self.drag == Some(Drag::Edge)
            || self.drag.is_none()
                && panel.truth == TruthView::Split
                && is_on_edge(self.cursor, panel.split, self.shown_at);
        let output = self.context.run_ui(input, |ui| {
            if drags_edge {
                ui.set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
            }
            // egui may lay out twice.
            requests.extend(panel.ui(ui, status));
            left = ui.available_rect_before_wrap();
        });
        opened.egui.handle_platform_output(&opened.window, output.platform_output);
        self.renderer.send(requests);
        let scale = output.pixels_per_point;
        let area = [left.min.x, left.min.y, left.max.x, left.max.y].map(|side| (side * scale) as i32);
        let mut blits = Vec::new();
        if let Some(picture) = &self.status.picture {
            self.shown_at = place(picture.extent(), area);
            let truth = self.status.truth.as_ref();
            let view = truth.map_or(TruthView::Off, |_| self.panel.truth);
            let blit = |part: Part| {
                let image = if part.layer == Layer::Truth { truth.unwrap_or(picture) } else { picture };
                Blit { image: image.clone(), from: part.from, to: part.to }
            };
            let parts = parts(view, self.is_flipped, self.panel.split, picture.extent(), self.shown_at);
            blits = parts.into_iter().map(blit).collect();
        }
        let mut textures = std::mem::take(&mut self.textures);
        textures.append(output.textures_delta);
        let triangles = self.context.tessellate(output.shapes, scale);
        let mut panel = LaidOut { triangles, textures, pixels_per_point: scale };
        let Some(opened) = &mut self.opened else { return Ok(()) };
        let outcome = opened.presenter.show(&blits, Some(&mut panel));
        self.textures = panel.textures;
        let outcome = outcome?;
        let again = output.viewport_output.values().any(|viewport| viewport.repaint_delay.is_zero());
        self.is_dirty = again || outcome == Outcome::LeftOut;
        Ok(())
    }
}

impl ApplicationHandler<Woken> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.opened.is_none()
            && let Err(error) = self.open(events)
        {
            self.failure = Some(error);
            events.exit();
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, _: StartCause) {
        self.woke = Instant::now();
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: Woken) {
        self.collect();
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else { return };
        let taken = opened.egui.on_window_event(&opened.window, &event);
        self.is_dirty |= taken.repaint;
        match &event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                opened.presenter.resized((*size).into());
                self.is_dirty = true;
            }
            WindowEvent::RedrawRequested => self.is_dirty = true,
            WindowEvent::ModifiersChanged(modifiers) => {
                self.control = modifiers.state().control_key();
                self.keys.shift = modifiers.state().shift_key();
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.cursor_moved([position.x, position.y]);
            }
            WindowEvent::Focused(false) => {
                (self.keys, self.is_flipped) = (HeldKeys::default(), false);
            }
            event if !taken.consumed || is_release(event) => {
                self.input(event);
                self.is_dirty = true;
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        self.collect();
        self.fly();
        if let Err(error) = self.draw() {
            self.failure.get_or_insert(error);
        }
        if self.failure.is_none() && !self.renderer.is_running() {
            self.failure = Some(Error::Renderer("its thread ended".into()));
        }
        if self.failure.is_some() || self.is_closed {
            events.exit();
        }
        let busy = self.is_dirty || self.keys.held().is_any();
        let wait = if busy { TICK } else { Duration::from_millis(250) };
        events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait));
        if self.opened.is_some() {
            self.busy.add(self.woke.elapsed());
        }
    }
}

/// What began in the picture ends wherever it does: a key or a button.
fn is_release(event: &WindowEvent) -> bool {
    match event {
        WindowEvent::MouseInput { state, .. } => *state == ElementState::Released,
        WindowEvent::KeyboardInput { event, .. } => event.state == ElementState::Released,
        _ => false,
    }
}
