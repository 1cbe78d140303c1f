//! The bar below the picture: scene time, and what the last frame was.

use crate::protocol::{Request, Status};

pub(super) fn ui(ui: &mut egui::Ui, status: &Status, duration: f64, requests: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        if ui.button(if status.playing { "Pause" } else { "Play" }).clicked() {
            requests.push(Request::Play(!status.playing));
        }
        if ui.button("Step").clicked() {
            requests.push(Request::Step);
        }
        let mut time = status.time;
        let slider = egui::Slider::new(&mut time, 0.0..=duration.max(1.0)).suffix(" s").fixed_decimals(2);
        if ui.add(slider).changed() {
            requests.push(Request::Seek(time));
        }
        if ui.button("Reset").on_hover_text("forget the histories").clicked() {
            requests.push(Request::ResetHistories);
        }
        if ui.button("Copy command").on_hover_text("the command line that reproduces the picture").clicked() {
            requests.push(Request::HandOut);
        }
        if ui.button("Save").on_hover_text("the picture as PNG and EXR").clicked() {
            requests.push(Request::Save);
        }
        let record = if status.recording { "Write path" } else { "Record path" };
        if ui.button(record).clicked() {
            requests.push(Request::Record(!status.recording));
        }
        let capture = if status.capture.is_some() { "End capture" } else { "Capture" };
        if ui.button(capture).on_hover_text("the next frames, for pt replay").clicked() {
            requests.push(Request::Capture(status.capture.is_none()));
        }
    });
    ui.horizontal(|ui| {
        ui.monospace(format!("frame {:>5}  {:>8.2} ms", status.frames, status.frame_ms));
        if let Some([done, all]) = status.capture {
            let share = done as f32 / all.max(1) as f32;
            let text = format!("captured {done} of {all}");
            ui.add(egui::ProgressBar::new(share).desired_width(160.0).text(text));
        }
        ui.add(egui::Label::new(&status.message).truncate());
    });
}
