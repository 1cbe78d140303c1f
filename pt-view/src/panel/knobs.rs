//! The page of the knobs, grouped by stage.

use super::Panel;
use crate::knob_sheet::{Knob, KnobKind, KnobSheet, NONE};

/// Of knobs that differ from their defaults.
const CHANGED: egui::Color32 = egui::Color32::from_rgb(255, 176, 64);

impl Panel {
    pub(super) fn knobs(&mut self, ui: &mut egui::Ui) {
        self.header(ui);
        let stages: Vec<String> = self.sheet.stages().into_iter().map(str::to_owned).collect();
        let filter = self.filter.to_lowercase();
        for stage in stages {
            let is_listed = |i: &usize| {
                let knob = &self.sheet.knobs()[*i];
                let text =
                    || knob.key.to_lowercase().contains(&filter) || knob.doc.to_lowercase().contains(&filter);
                knob.stage() == stage && text() && (!self.only_changed || self.sheet.is_changed(*i))
            };
            let listed: Vec<_> = (0..self.sheet.knobs().len()).filter(is_listed).collect();
            if listed.is_empty() {
                continue;
            }
            let title = match self.sheet.changed_in(&stage) {
                0 => egui::RichText::new(&stage),
                changed => egui::RichText::new(format!("{stage} ({changed} changed)")).color(CHANGED),
            };
            let open = (!filter.is_empty() || self.only_changed).then_some(true);
            egui::CollapsingHeader::new(title).id_salt(&stage).open(open).show(ui, |ui| {
                listed.into_iter().for_each(|i| knob_row(ui, &mut self.sheet, i));
            });
        }
        if ui.input(|input| input.pointer.any_released()) {
            self.sheet.release();
        }
    }

    fn header(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            let sheet = &mut self.sheet;
            if ui.add_enabled(sheet.can_undo(), egui::Button::new("Undo")).clicked() {
                sheet.undo();
            }
            if ui.add_enabled(sheet.can_redo(), egui::Button::new("Redo")).clicked() {
                sheet.redo();
            }
            ui.menu_button("Profile", |ui| {
                for profile in &self.profiles {
                    if ui.button(&profile.name).on_hover_text(&profile.doc).clicked() {
                        sheet.set_all(&profile.values);
                        ui.close();
                    }
                }
            });
            ui.checkbox(&mut self.only_changed, "changed");
            let search =
                egui::TextEdit::singleline(&mut self.filter).hint_text("search").desired_width(110.0);
            ui.add(search);
        });
    }
}

fn knob_row(ui: &mut egui::Ui, sheet: &mut KnobSheet, index: usize) {
    let (knob, value, is_changed) =
        (sheet.knobs()[index].clone(), sheet.value(index).to_owned(), sheet.is_changed(index));
    ui.horizontal(|ui| {
        let mut name = egui::RichText::new(knob.name());
        if is_changed {
            name = name.color(CHANGED);
        }
        let label = ui.label(name).on_hover_ui(|ui| tooltip(ui, &knob));
        let set = editor(ui, &knob, &value, label.id);
        if is_changed && ui.small_button("reset").on_hover_text(format!("back to {}", knob.default)).clicked()
        {
            sheet.reset(index);
        }
        if let Some((value, drags)) = set {
            sheet.set(index, value, drags);
        }
    });
}

fn tooltip(ui: &mut egui::Ui, knob: &Knob) {
    ui.set_max_width(420.0);
    ui.strong(&knob.key);
    ui.label(&knob.doc);
    ui.label(format!("{}; default {}", knob.takes, knob.default));
}

/// The widget of a value; the value that it is set to, and whether the pointer still drags it.
fn editor(ui: &mut egui::Ui, knob: &Knob, value: &str, label: egui::Id) -> Option<(String, bool)> {
    let mut set = None;
    if knob.optional {
        let mut is_there = value != NONE;
        if checkbox(ui, &mut is_there, &format!("{} is set", knob.name())) {
            set = Some((if is_there { present(knob) } else { NONE.into() }, false));
        }
        if !is_there {
            ui.weak(NONE);
            return set;
        }
    }
    match &knob.kind {
        KnobKind::Boolean => {
            let mut on = value == "true";
            if checkbox(ui, &mut on, knob.name()) {
                set = Some((on.to_string(), false));
            }
        }
        KnobKind::Integer([least, greatest]) => {
            let mut number = value.parse().unwrap_or(*least);
            let drag =
                egui::DragValue::new(&mut number).range(*least..=*greatest).fixed_decimals(0).speed(0.1);
            let response = ui.add(drag).labelled_by(label);
            if response.changed() {
                set = Some((format!("{number:.0}"), response.dragged()));
            }
        }
        KnobKind::Number([least, greatest]) => {
            let mut number: f64 = value.parse().unwrap_or(*least);
            let speed = if greatest - least < 1e3 {
                0.004 * (greatest - least)
            } else {
                0.02 * number.abs().max(0.01)
            };
            let drag =
                egui::DragValue::new(&mut number).range(*least..=*greatest).speed(speed).max_decimals(6);
            let response = ui.add(drag).labelled_by(label);
            if response.changed() {
                // As a float of the renderer, without digits that it does not have.
                set = Some(((number as f32).to_string(), response.dragged()));
            }
        }
        KnobKind::Choice(names) => {
            let list = egui::ComboBox::from_id_salt(&knob.key).selected_text(value).show_ui(ui, |ui| {
                for (name, doc) in names {
                    if ui.selectable_label(name == value, name).on_hover_text(doc).clicked() {
                        set = Some((name.clone(), false));
                    }
                }
            });
            list.response.labelled_by(label);
        }
    }
    set
}

/// A checkbox whose name stands elsewhere; whether it was clicked. egui gives one without text an empty label, whatever it is labelled by: tests
/// and screen readers need the name.
fn checkbox(ui: &mut egui::Ui, on: &mut bool, name: &str) -> bool {
    let response = ui.checkbox(on, "");
    let info = || egui::WidgetInfo::selected(egui::WidgetType::Checkbox, ui.is_enabled(), *on, name);
    response.widget_info(info);
    response.changed()
}

/// The first value of an optional knob that gets one.
fn present(knob: &Knob) -> String {
    if knob.default != NONE {
        return knob.default.clone();
    }
    match &knob.kind {
        KnobKind::Boolean => "false".into(),
        KnobKind::Integer([least, _]) | KnobKind::Number([least, _]) => (least.max(1.0) as f32).to_string(),
        KnobKind::Choice(names) => names.first().map(|(name, _)| name.clone()).unwrap_or_default(),
    }
}
