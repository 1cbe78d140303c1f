//! The panel beside the picture: plain data in, requests out. It knows neither the window nor the renderer.

mod knobs;
mod looking;
mod passes;
mod transport;

use crate::knob_sheet::{Knob, KnobSheet, Profile};
use crate::pass_history::PassHistory;
use crate::protocol::{Request, Status, TruthView};

/// What the panel starts with.
#[derive(Clone, Debug, Default)]
pub struct PanelContent {
    /// The knobs.
    pub knobs: Vec<Knob>,
    /// Their values.
    pub values: Vec<String>,
    /// Named sets of values.
    pub profiles: Vec<Profile>,
    /// Cameras of the scene.
    pub cameras: Vec<String>,
    /// Seconds of scene time that the slider covers.
    pub duration: f64,
}

/// Pages of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Page {
    Knobs,
    Looking,
    Passes,
    Keys,
}

/// The panel.
pub struct Panel {
    /// The knobs.
    pub sheet: KnobSheet,
    /// Whether it is shown.
    pub is_shown: bool,
    /// How the ground truth is shown.
    pub truth: TruthView,
    /// Share of the picture that is left of the ground truth.
    pub split: f32,
    profiles: Vec<Profile>,
    cameras: Vec<String>,
    duration: f64,
    page: Page,
    /// Knobs are listed whose key or sentence holds this.
    filter: String,
    only_changed: bool,
    image: Option<String>,
    history: PassHistory,
}

/// What the keys do.
pub const KEYS: &[(&str, &str)] = &[
    ("W A S D, E, Q", "fly; up, down; Shift: five times as fast"),
    ("left drag", "go round the point that the camera looks at; on the edge of the ground truth: move it"),
    ("right drag", "look about"),
    ("middle drag", "move with the picture"),
    ("wheel", "nearer, farther; while flying: faster, slower"),
    ("1 ... 9", "cameras of the scene"),
    ("Space, .", "scene time runs or stands still; one frame further"),
    ("R", "forget the histories"),
    ("T", "ground truth: off, split, alone, flip, difference"),
    ("F", "the ground truth while it is held"),
    ("K", "record the way of the camera; again: write it"),
    ("C", "copy the command line that reproduces the picture"),
    ("P", "write the picture as PNG and EXR"),
    ("G", "capture the next frames; again: end it"),
    ("Ctrl Z, Ctrl Y", "take a change of a knob back, make it again"),
    ("H", "hide the panel, show it"),
    ("Ctrl Q", "close the window"),
];

impl Panel {
    /// With this content.
    pub fn new(content: PanelContent) -> Self {
        Self {
            sheet: KnobSheet::new(content.knobs, content.values),
            is_shown: true,
            truth: TruthView::Off,
            split: 0.5,
            profiles: content.profiles,
            cameras: content.cameras,
            duration: content.duration,
            page: Page::Knobs,
            filter: String::new(),
            only_changed: false,
            image: None,
            history: PassHistory::default(),
        }
    }

    /// Takes the times of a new frame.
    pub fn frame_done(&mut self, status: &Status) {
        self.history.add(status.frame_ms, &status.passes);
    }

    /// Lists the knobs whose key or sentence holds `text`, all stages open.
    pub fn search(&mut self, text: &str) {
        self.filter = text.into();
    }

    /// Whether the values of a pixel are shown.
    pub fn shows_pixel(&self) -> bool {
        self.is_shown && self.page == Page::Looking
    }

    /// The next way to show the ground truth.
    pub fn next_truth(&mut self) -> Request {
        let index = TruthView::ALL.iter().position(|view| *view == self.truth).unwrap_or_default();
        self.truth = TruthView::ALL[(index + 1) % TruthView::ALL.len()];
        Request::Truth(self.truth)
    }

    /// Lays the panel out at the edges of `ui`; what the user wants.
    pub fn ui(&mut self, ui: &mut egui::Ui, status: &Status) -> Vec<Request> {
        let mut requests = Vec::new();
        if self.is_shown {
            egui::Panel::bottom("transport")
                .show(ui, |ui| transport::ui(ui, status, self.duration, &mut requests));
            egui::Panel::right("panel").default_size(380.0).show(ui, |ui| {
                self.pages(ui);
                ui.separator();
                egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| match self.page {
                    Page::Knobs => self.knobs(ui),
                    Page::Looking => self.looking(ui, status, &mut requests),
                    Page::Passes => passes::ui(ui, &self.history),
                    Page::Keys => keys(ui, &self.cameras, &mut requests),
                });
            });
        }
        let changes = self.sheet.take_changes();
        if !changes.is_empty() {
            requests.push(Request::Knobs(changes));
        }
        requests
    }

    fn pages(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            let pages = [
                (Page::Knobs, "Knobs"),
                (Page::Looking, "Look"),
                (Page::Passes, "Passes"),
                (Page::Keys, "Keys"),
            ];
            for (page, name) in pages {
                ui.selectable_value(&mut self.page, page, name);
            }
        });
    }
}

fn keys(ui: &mut egui::Ui, cameras: &[String], requests: &mut Vec<Request>) {
    egui::Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
        for (key, what) in KEYS {
            ui.strong(*key);
            ui.add(egui::Label::new(*what).wrap());
            ui.end_row();
        }
    });
    if !cameras.is_empty() {
        ui.separator();
        ui.label("Cameras of the scene");
    }
    for (index, camera) in cameras.iter().enumerate() {
        if ui.button(camera).clicked() {
            requests.push(Request::SceneCamera(index));
        }
    }
}
