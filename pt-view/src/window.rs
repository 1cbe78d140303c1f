//! The window: events of winit in, pictures and the panel out.

use crate::blit::Blit;
use crate::camera::FreeCamera;
use crate::error::{Error, Result};
use crate::input::{Action, HeldKeys, action};
use crate::layout::{pixel_under, place};
use crate::panel::{Panel, PanelContent};
use crate::panel_renderer::LaidOut;
use crate::presenter::Presenter;
use crate::protocol::{Failure, Frames, Pose, Request, Status, TruthView};
use crate::renderer_thread::RendererThread;
use crate::swapchain_rules::Outcome;
use pt_core::{Device, DeviceOptions};
use std::ffi::CStr;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::PhysicalKey;
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::{Window, WindowId};

/// Between two steps of a camera that flies, and between two looks whether the device is free.
const TICK: Duration = Duration::from_millis(8);

/// The renderer has something to collect.
#[derive(Clone, Copy, Debug)]
struct Woken;

/// A window that is not open yet.
pub struct View {
    events: EventLoop<Woken>,
}

/// What a window shows first.
pub struct Opening {
    /// Title of the window.
    pub title: String,
    /// Size of the pictures, pixels.
    pub size: [u32; 2],
    /// Where the camera is.
    pub pose: Pose,
    /// Longest side of the scene, metres.
    pub scene_size: f32,
    /// Content of the panel.
    pub content: PanelContent,
}

impl View {
    /// Connects to the display.
    ///
    /// # Errors
    /// [`Error::NoWindow`] if there is none.
    pub fn new() -> Result<Self> {
        let no_window = |error: &dyn std::fmt::Display| {
            let text = error.to_string();
            // What winit says after the place in its source.
            Error::NoWindow(text.rsplit(": ").next().unwrap_or(&text).trim_end_matches('.').to_owned())
        };
        let events = EventLoop::<Woken>::with_user_event().build();
        Ok(Self { events: events.map_err(|error| no_window(&error))? })
    }

    /// Opens a device that can show images on the display.
    ///
    /// # Errors
    /// A device that can't, or none.
    pub fn open_device(&self, options: &DeviceOptions) -> Result<Device> {
        let display = self.events.display_handle().map_err(|error| Error::NoWindow(error.to_string()))?;
        let names = ash_window::enumerate_required_extensions(display.as_raw())
            .map_err(|error| Error::NoWindow(error.to_string()))?;
        // SAFETY: ash's names are constants.
        let names: Vec<_> = names.iter().map(|&name| unsafe { CStr::from_ptr(name) }).collect();
        Ok(Device::open_presenting(options, &names)?)
    }

    /// Opens the window and shows frames until it is closed. `start` makes the renderer, on a thread of its own; `commands` gets the command
    /// lines that are handed out.
    ///
    /// # Errors
    /// A display that refuses the window, a device that fails, and what the renderer fails with.
    pub fn run(
        self,
        device: &Device,
        opening: Opening,
        start: impl FnOnce() -> std::result::Result<Box<dyn Frames>, Failure> + Send + 'static,
        commands: &mut dyn FnMut(&str),
    ) -> Result<()> {
        let proxy = self.events.create_proxy();
        // The window may be closed before the last frame is done.
        let wake = move || {
            let _ = proxy.send_event(Woken);
        };
        let renderer =
            RendererThread::new(start, wake).map_err(|error| Error::NoWindow(error.to_string()))?;
        let mut app = App::new(device, opening, renderer, commands);
        self.events.run_app(&mut app).map_err(|error| Error::NoWindow(error.to_string()))?;
        app.failure.take().map_or(Ok(()), Err)
    }
}

/// What exists as long as the window.
struct Opened {
    window: Arc<Window>,
    egui: egui_winit::State,
    presenter: Presenter,
}

struct App<'a> {
    device: Device,
    opening: Opening,
    opened: Option<Opened>,
    context: egui::Context,
    panel: Panel,
    camera: FreeCamera,
    pose_number: u64,
    command_number: u64,
    commands: &'a mut dyn FnMut(&str),
    keys: HeldKeys,
    control: bool,
    drag: Option<MouseButton>,
    cursor: [f64; 2],
    /// The pixel of the picture under it, if its values are shown.
    pixel: Option<[u32; 2]>,
    /// Where the picture is, pixels of the window.
    shown_at: [i32; 4],
    status: Status,
    /// Textures of panels that were left out.
    textures: egui::TexturesDelta,
    is_dirty: bool,
    last_tick: Instant,
    failure: Option<Error>,
    /// Last: it waits for the renderer's last frame.
    renderer: RendererThread,
}

impl<'a> App<'a> {
    fn new(
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
            cursor: [-1.0; 2],
            pixel: None,
            shown_at: [0; 4],
            status: Status { message: "the kernels are being compiled".into(), ..Status::default() },
            textures: egui::TexturesDelta::default(),
            is_dirty: true,
            last_tick: Instant::now(),
            failure: None,
            renderer,
        }
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
        let output = self.context.run(input, |context| {
            // egui may lay out twice.
            requests.extend(panel.ui(context, status));
            left = context.available_rect();
        });
        opened.egui.handle_platform_output(&opened.window, output.platform_output);
        self.renderer.send(requests);
        let scale = output.pixels_per_point;
        let area = [left.min.x, left.min.y, left.max.x, left.max.y].map(|side| (side * scale) as i32);
        let mut blits = Vec::new();
        if let Some(picture) = &self.status.picture {
            self.shown_at = place(picture.extent(), area);
            blits = self.blits();
        }
        let mut textures = std::mem::take(&mut self.textures);
        textures.append(output.textures_delta);
        let triangles = self.context.tessellate(output.shapes, scale);
        let mut panel = LaidOut { triangles, textures, pixels_per_point: scale };
        let Some(opened) = &mut self.opened else { return Ok(()) };
        let outcome = opened.presenter.show(&blits, Some(&mut panel))?;
        self.textures = panel.textures;
        let again = output.viewport_output.values().any(|viewport| viewport.repaint_delay.is_zero());
        self.is_dirty = again || outcome == Outcome::LeftOut;
        Ok(())
    }

    /// The parts of frame and ground truth that are shown.
    fn blits(&self) -> Vec<Blit> {
        let Some(picture) = self.status.picture.clone() else { return Vec::new() };
        let [width, height] = picture.extent().map(|side| side as i32);
        let [left, top, right, bottom] = self.shown_at;
        let whole = |image| Blit { image, from: [0, 0, width, height], to: self.shown_at };
        let Some(truth) = self.status.truth.clone() else { return vec![whole(picture)] };
        match self.panel.truth {
            TruthView::Off => vec![whole(picture)],
            TruthView::Alone | TruthView::Difference => vec![whole(truth)],
            TruthView::Split => {
                let at = (self.panel.split * width as f32).round() as i32;
                let across =
                    left + (f64::from(at) / f64::from(width.max(1)) * f64::from(right - left)) as i32;
                vec![
                    Blit { image: picture, from: [0, 0, at, height], to: [left, top, across, bottom] },
                    Blit { image: truth, from: [at, 0, width, height], to: [across, top, right, bottom] },
                ]
            }
        }
    }

    fn act(&mut self, action: Action) {
        let request = match action {
            Action::Camera(index) => Request::SceneCamera(index),
            Action::PlayOrPause => Request::Play(!self.status.playing),
            Action::Step => Request::Step,
            Action::ResetHistories => Request::ResetHistories,
            Action::NextTruth => self.panel.next_truth(),
            Action::RecordOrWrite => Request::Record(!self.status.recording),
            Action::HandOut => Request::HandOut,
            Action::Save => Request::Save,
            Action::HidePanel => {
                self.panel.is_shown = !self.panel.is_shown;
                return;
            }
            Action::Undo => return self.panel.sheet.undo(),
            Action::Redo => return self.panel.sheet.redo(),
        };
        self.renderer.send([request]);
    }

    fn window_event(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::KeyboardInput { event, .. } => {
                let PhysicalKey::Code(key) = event.physical_key else { return };
                let is_pressed = event.state == ElementState::Pressed;
                self.keys.set(key, is_pressed && !self.control);
                if is_pressed
                    && !event.repeat
                    && let Some(action) = action(key, self.control)
                {
                    self.act(action);
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                self.drag = (*state == ElementState::Pressed).then_some(*button);
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
                if self.keys.held().is_any() || self.drag == Some(MouseButton::Right) {
                    self.camera.hurry(notches);
                } else {
                    self.camera.dolly(notches);
                    self.renderer.send([Request::Camera(self.camera.pose())]);
                }
            }
            _ => {}
        }
    }

    fn cursor_moved(&mut self, at: [f64; 2]) {
        let way = [0, 1].map(|axis| (at[axis] - self.cursor[axis]) as f32);
        self.cursor = at;
        if let Some(button) = self.drag {
            match button {
                MouseButton::Left => self.camera.orbit(way),
                MouseButton::Right => self.camera.look(way),
                MouseButton::Middle => self.camera.pan(way, (self.shown_at[3] - self.shown_at[1]) as f32),
                _ => return,
            }
            self.renderer.send([Request::Camera(self.camera.pose())]);
        }
        let size = self.status.picture.as_ref().map(|picture| picture.extent());
        let size = size.filter(|_| self.panel.shows_pixel());
        let pixel = size.and_then(|size| pixel_under(at, size, self.shown_at));
        if pixel != self.pixel {
            self.pixel = pixel;
            self.renderer.send([Request::Pixel(pixel)]);
        }
    }

    /// Flies on while keys are held.
    fn fly(&mut self) {
        let now = Instant::now();
        let seconds = now.duration_since(self.last_tick).as_secs_f32().min(0.1);
        self.last_tick = now;
        let held = self.keys.held();
        if held.is_any() {
            self.camera.fly(held, seconds);
            self.renderer.send([Request::Camera(self.camera.pose())]);
        }
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
            WindowEvent::Focused(false) => self.keys = HeldKeys::default(),
            // A drag that began in the picture ends wherever it does.
            WindowEvent::MouseInput { state: ElementState::Released, .. } => self.drag = None,
            event if !taken.consumed => {
                self.window_event(event);
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
        if self.failure.is_some() {
            events.exit();
        }
        let busy = self.is_dirty || self.keys.held().is_any();
        let wait = if busy { TICK } else { Duration::from_millis(250) };
        events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait));
    }
}
