//! The page of the images, of the pixel under the cursor, and of the ground truth.

use super::Panel;
use crate::protocol::{Legend, Request, Status, TruthView};
use pt_image::metrics::colour_map;

impl Panel {
    pub(super) fn looking(&mut self, ui: &mut egui::Ui, status: &Status, requests: &mut Vec<Request>) {
        self.images(ui, status, requests);
        if let Some(legend) = &status.legend {
            show_legend(ui, legend);
        }
        ui.separator();
        self.ground_truth(ui, status, requests);
        ui.separator();
        ui.strong("Pixel under the cursor");
        if status.pixel.is_empty() {
            ui.weak("the cursor is outside of the picture");
        }
        egui::Grid::new("pixel").num_columns(2).striped(true).show(ui, |ui| {
            for (name, values) in &status.pixel {
                ui.label(name);
                ui.monospace(values);
                ui.end_row();
            }
        });
    }

    fn images(&mut self, ui: &mut egui::Ui, status: &Status, requests: &mut Vec<Request>) {
        let before = self.image.clone();
        egui::ComboBox::from_label("image")
            .selected_text(self.image.as_deref().unwrap_or("picture"))
            .height(400.0)
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut self.image, None, "picture");
                for name in &status.images {
                    ui.selectable_value(&mut self.image, Some(name.clone()), name);
                }
            });
        if self.image != before {
            requests.push(Request::Look(self.image.clone()));
        }
    }

    fn ground_truth(&mut self, ui: &mut egui::Ui, status: &Status, requests: &mut Vec<Request>) {
        ui.strong("Ground truth");
        ui.horizontal(|ui| {
            for view in TruthView::ALL {
                if ui.selectable_label(self.truth == view, view.name()).clicked() {
                    self.truth = view;
                    requests.push(Request::Truth(view));
                }
            }
        });
        if self.truth == TruthView::Split {
            ui.add(egui::Slider::new(&mut self.split, 0.0..=1.0).text("frame | truth").show_value(false));
        }
        if self.truth == TruthView::Flip {
            ui.weak("F shows the truth while it is held");
        }
        if self.truth == TruthView::Off {
            return;
        }
        let state = status.truth_state;
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
        egui::Grid::new("truth").num_columns(2).show(ui, |ui| {
            for (name, value) in [
                ("samples a pixel", state.samples.to_string()),
                ("relative standard error", number(state.relative_error)),
                ("FLIP of the frame", number(state.flip)),
                ("relMSE of the frame", number(state.rel_mse)),
            ] {
                ui.label(name);
                ui.monospace(value);
                ui.end_row();
            }
        });
    }
}

fn show_legend(ui: &mut egui::Ui, legend: &Legend) {
    ui.label(format!("{}: {}", legend.name, legend.meaning));
    let [least, greatest] = legend.range;
    if !legend.is_color {
        let (area, _) =
            ui.allocate_exact_size(egui::vec2(ui.available_width().min(340.0), 14.0), egui::Sense::hover());
        let steps = 64;
        for step in 0..steps {
            let [r, g, b] = colour_map(step as f32 / (steps - 1) as f32);
            let width = area.width() / steps as f32;
            let left = area.left() + step as f32 * width;
            let bar = egui::Rect::from_min_size(
                egui::pos2(left, area.top()),
                egui::vec2(width + 1.0, area.height()),
            );
            ui.painter().rect_filled(bar, 0.0, egui::Color32::from_rgb(r, g, b));
        }
    }
    ui.monospace(format!("{least:.4} to {greatest:.4}"));
}
