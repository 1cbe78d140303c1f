//! What input does: keys, drags, the wheel.

use super::app::{App, Drag};
use crate::input::{Action, action};
use crate::layout::{is_on_edge, pixel_under, split_under};
use crate::protocol::{Request, TruthView};
use std::time::Instant;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

/// Shows the ground truth while it is held.
const FLIP: KeyCode = KeyCode::KeyF;

impl App<'_> {
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
            Action::Capture => Request::Capture(self.status.capture.is_none()),
            Action::HidePanel => {
                self.panel.is_shown = !self.panel.is_shown;
                return;
            }
            Action::Close => {
                self.is_closed = true;
                return;
            }
            Action::Undo => return self.panel.sheet.undo(),
            Action::Redo => return self.panel.sheet.redo(),
        };
        self.renderer.send([request]);
    }

    pub(super) fn input(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::KeyboardInput { event, .. } => {
                let PhysicalKey::Code(key) = event.physical_key else { return };
                let is_pressed = event.state == ElementState::Pressed;
                self.keys.set(key, is_pressed && !self.control);
                if key == FLIP {
                    self.flip(is_pressed && !self.control);
                }
                if is_pressed
                    && !event.repeat
                    && let Some(action) = action(key, self.control)
                {
                    self.act(action);
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let is_pressed = *state == ElementState::Pressed;
                let takes_edge = *button == MouseButton::Left
                    && self.panel.truth == TruthView::Split
                    && is_on_edge(self.cursor, self.panel.split, self.shown_at);
                let drag = if takes_edge { Drag::Edge } else { Drag::Camera(*button) };
                self.drag = is_pressed.then_some(drag);
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
                if self.keys.held().is_any() || self.drag == Some(Drag::Camera(MouseButton::Right)) {
                    self.camera.hurry(notches);
                } else {
                    self.camera.dolly(notches);
                    self.renderer.send([Request::Camera(self.camera.pose())]);
                }
            }
            _ => {}
        }
    }

    pub(super) fn cursor_moved(&mut self, at: [f64; 2]) {
        let way = [0, 1].map(|axis| (at[axis] - self.cursor[axis]) as f32);
        self.cursor = at;
        if self.drag == Some(Drag::Edge) {
            self.panel.split = split_under(at[0], self.shown_at);
        } else if let Some(Drag::Camera(button)) = self.drag {
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

    /// The frame, or the ground truth while the key is held. Where the truth is not traced or not shown as it is, that begins.
    fn flip(&mut self, is_held: bool) {
        self.is_flipped = is_held;
        if is_held && matches!(self.panel.truth, TruthView::Off | TruthView::Difference) {
            self.panel.truth = TruthView::Flip;
            self.renderer.send([Request::Truth(TruthView::Flip)]);
        }
    }

    /// Flies on while keys are held.
    pub(super) fn fly(&mut self) {
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
