//! The page of the passes: a graph of the frames' times, and a table of the passes.

use crate::pass_history::PassHistory;

/// GPU time of the graph's upper edge above the median.
const HEADROOM: f64 = 1.6;

pub(super) fn ui(ui: &mut egui::Ui, history: &PassHistory) {
    let median = history.median_ms();
    ui.label(format!("frame: {median:.2} ms (median of the last frames)"));
    graph(ui, history, median);
    egui::Grid::new("passes").num_columns(4).striped(true).show(ui, |ui| {
        for title in ["pass", "median ms", "Mrays", "MB"] {
            ui.strong(title);
        }
        ui.end_row();
        for row in history.rows() {
            ui.label(&row.last.name);
            ui.monospace(format!("{:.3}", row.median_ms));
            let millions =
                |count: u64| if count == 0 { String::new() } else { format!("{:.2}", count as f64 * 1e-6) };
            ui.monospace(millions(row.last.rays));
            ui.monospace(millions(row.last.bytes));
            ui.end_row();
        }
    });
}

fn graph(ui: &mut egui::Ui, history: &PassHistory, median: f64) {
    let size = egui::vec2(ui.available_width().min(340.0), 80.0);
    let (area, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(area, 2.0, ui.visuals().extreme_bg_color);
    let most = (median * HEADROOM).max(1e-6);
    let times: Vec<_> = history.frame_times().collect();
    let at = |index: usize, ms: f64| {
        let x = area.left() + area.width() * index as f32 / (times.len().max(2) - 1) as f32;
        egui::pos2(x, area.bottom() - area.height() * (ms / most).min(1.0) as f32)
    };
    let line = times.iter().enumerate().map(|(index, &ms)| at(index, ms)).collect();
    painter.add(egui::Shape::line(line, egui::Stroke::new(1.5, egui::Color32::LIGHT_BLUE)));
    let y = at(0, median).y;
    painter.hline(area.x_range(), y, egui::Stroke::new(1.0, egui::Color32::GRAY));
}
