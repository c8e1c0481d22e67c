//! How a recording is to be read: which column is what, units, offset, scale, sign.

use std::path::PathBuf;

use eframe::egui::{
    Align2, ComboBox, DragValue, Grid, Key, RichText, ScrollArea, TextEdit, Ui, Window,
};
use egui_extras::{Column, TableBuilder};

use super::Answer;
use crate::app::theme;
use crate::model::unit::{format_quantity, parse_quantity, unit_factor};
use crate::recording::csv::{ColumnChoice, Decimal, Delimiter, ImportSettings, Preview};

/// Units offered for each quantity.
const TIME_UNITS: [&str; 3] = ["s", "ms", "us"];
const VOLTAGE_UNITS: [&str; 2] = ["V", "mV"];
const LENGTH_UNITS: [&str; 5] = ["m", "cm", "mm", "um", "nm"];

/// The open dialog.
#[derive(Debug)]
pub struct ImportDialog {
    path: PathBuf,
    preview: Preview,
    settings: ImportSettings,
    offset: String,
    offset_error: Option<String>,
}

impl ImportDialog {
    /// A dialog that starts with `known` settings, else with what was guessed.
    pub fn new(path: PathBuf, preview: Preview, known: Option<ImportSettings>) -> Self {
        let settings = known.unwrap_or_else(|| preview.settings.clone());
        Self {
            offset: format_quantity(settings.time_offset, "s", 9),
            offset_error: None,
            settings,
            path,
            preview,
        }
    }

    /// Why the import cannot start yet.
    fn missing(&self) -> Option<&'static str> {
        if self.settings.time.is_none() {
            Some("Choose the column of the time.")
        } else if self.settings.proof_mass.is_none() {
            Some("Choose the column of the proof mass.")
        } else if self.offset_error.is_some() {
            Some("Mend the time offset.")
        } else {
            None
        }
    }

    /// Draws it; returns whether it stays open, and the answer.
    pub fn show(&mut self, ui: &mut Ui) -> (bool, Option<Answer>) {
        let mut open = !ui.input(|input| input.key_pressed(Key::Escape));
        let mut answer = None;
        Window::new("Import a recording")
            .collapsible(false)
            .default_width(760.0)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ui, |ui| {
                ui.strong(&self.preview.name);
                let color = theme::error(ui.visuals().dark_mode);
                if let Some(problem) = self.preview.problem() {
                    ui.colored_label(color, problem.to_string());
                }
                for line in &self.preview.ambiguities {
                    ui.colored_label(color, line);
                }
                for warning in &self.preview.warnings {
                    ui.label(&warning.message);
                }
                ui.separator();
                self.columns(ui);
                ui.separator();
                self.text(ui);
                ui.separator();
                self.table(ui);
                ui.separator();
                let missing = self.missing();
                ui.horizontal(|ui| {
                    let button =
                        ui.add_enabled(missing.is_none(), eframe::egui::Button::new("Import"));
                    if button.clicked() {
                        answer = Some(Answer::Import(self.path.clone(), self.settings.clone()));
                    }
                    if ui.button("Cancel").clicked() {
                        open = false;
                    }
                    if let Some(missing) = missing {
                        ui.label(RichText::new(missing).color(color));
                    }
                });
            });
        (open && answer.is_none(), answer)
    }

    fn column_name(&self, index: usize) -> String {
        match self.preview.header.get(index) {
            Some(name) if !name.trim().is_empty() => name.clone(),
            _ => format!("column {}", index + 1),
        }
    }

    fn columns(&mut self, ui: &mut Ui) {
        let names: Vec<String> = (0..self.preview.columns)
            .map(|i| self.column_name(i))
            .collect();
        let settings = &mut self.settings;
        Grid::new("import columns").num_columns(5).show(ui, |ui| {
            for title in [
                "quantity",
                "column",
                "unit",
                "scale (negative turns over)",
                "offset",
            ] {
                ui.weak(title);
            }
            ui.end_row();
            chooser(ui, "time", &names, &mut settings.time, &TIME_UNITS);
            ui.label("");
            let field = ui.add(TextEdit::singleline(&mut self.offset).desired_width(90.0));
            let field = field.on_hover_text("added to the times, e.g. -1 s");
            name_field(&field, "time offset");
            if field.changed() {
                match parse_quantity(&self.offset, "s") {
                    Ok(offset) => {
                        settings.time_offset = offset;
                        self.offset_error = None;
                    }
                    Err(error) => self.offset_error = Some(error.to_string()),
                }
            }
            ui.end_row();
            chooser(
                ui,
                "proof mass",
                &names,
                &mut settings.proof_mass,
                &LENGTH_UNITS,
            );
            factor(ui, "proof mass scale", &mut settings.xp_scale);
            micrometres(ui, "proof mass offset", &mut settings.xp_offset);
            ui.end_row();
            chooser(
                ui,
                "cantilever",
                &names,
                &mut settings.cantilever,
                &LENGTH_UNITS,
            );
            factor(ui, "cantilever scale", &mut settings.xc_scale);
            micrometres(ui, "cantilever offset", &mut settings.xc_offset);
            ui.end_row();
            chooser(ui, "voltage", &names, &mut settings.voltage, &VOLTAGE_UNITS);
            factor(ui, "voltage scale", &mut settings.voltage_scale);
            ui.end_row();
        });
        if let Some(error) = &self.offset_error {
            ui.colored_label(theme::error(ui.visuals().dark_mode), error);
        }
    }

    fn text(&mut self, ui: &mut Ui) {
        let settings = &mut self.settings;
        ui.horizontal_wrapped(|ui| {
            ui.label("cells separated by");
            for (delimiter, name) in Delimiter::ALL
                .into_iter()
                .zip(["comma", "semicolon", "tab"])
            {
                ui.radio_value(&mut settings.delimiter, delimiter, name);
            }
            ui.separator();
            ui.label("decimal");
            ui.radio_value(&mut settings.decimal, Decimal::Point, "point");
            ui.radio_value(&mut settings.decimal, Decimal::Comma, "comma");
            ui.separator();
            let label = ui.label("lines before the numbers").id;
            ui.add(DragValue::new(&mut settings.skip_lines).range(0..=100_000))
                .labelled_by(label);
        });
    }

    fn table(&self, ui: &mut Ui) {
        ScrollArea::horizontal().show(ui, |ui| {
            TableBuilder::new(ui)
                .striped(true)
                .max_scroll_height(170.0)
                .columns(Column::auto().at_least(70.0), self.preview.columns)
                .header(18.0, |mut header| {
                    for i in 0..self.preview.columns {
                        header.col(|ui| {
                            ui.strong(self.column_name(i));
                        });
                    }
                })
                .body(|mut body| {
                    for row in &self.preview.rows {
                        body.row(16.0, |mut cells| {
                            for i in 0..self.preview.columns {
                                cells.col(|ui| {
                                    ui.monospace(row.get(i).map_or("", String::as_str));
                                });
                            }
                        });
                    }
                });
        });
    }
}

fn name_field(response: &eframe::egui::Response, name: &str) {
    response.widget_info(|| {
        eframe::egui::WidgetInfo::labeled(eframe::egui::Role::TextInput, true, name)
    });
}

fn factor(ui: &mut Ui, name: &str, value: &mut f64) {
    let field = ui.add(DragValue::new(value).speed(0.01));
    field.widget_info(|| {
        eframe::egui::WidgetInfo::labeled(eframe::egui::Role::SpinButton, true, name)
    });
}

fn micrometres(ui: &mut Ui, name: &str, value: &mut f64) {
    let mut shown = *value * 1e6;
    let field = ui.add(DragValue::new(&mut shown).speed(0.1).suffix(" µm"));
    field.widget_info(|| {
        eframe::egui::WidgetInfo::labeled(eframe::egui::Role::SpinButton, true, name)
    });
    if field.changed() {
        *value = shown * 1e-6;
    }
}

/// Comboboxes for column and unit of a quantity.
fn chooser(
    ui: &mut Ui,
    quantity: &str,
    names: &[String],
    choice: &mut Option<ColumnChoice>,
    units: &[&str],
) {
    ui.label(quantity);
    let selected = choice
        .as_ref()
        .and_then(|c| names.get(c.index).cloned())
        .unwrap_or_else(|| "none".to_owned());
    ComboBox::from_id_salt((quantity, "column"))
        .selected_text(selected)
        .width(170.0)
        .show_ui(ui, |ui| {
            if ui.selectable_label(choice.is_none(), "none").clicked() {
                *choice = None;
            }
            for (index, name) in names.iter().enumerate() {
                let is = choice.as_ref().is_some_and(|c| c.index == index);
                if ui.selectable_label(is, name).clicked() {
                    let unit = choice
                        .as_ref()
                        .map_or_else(|| units[0].to_owned(), |c| c.unit.clone());
                    *choice = Some(ColumnChoice { index, unit });
                }
            }
        })
        .response
        .on_hover_text(format!("column of the {quantity}"));
    let mut unit = choice.as_ref().map_or("", |c| c.unit.as_str()).to_owned();
    ui.add_enabled_ui(choice.is_some(), |ui| {
        ComboBox::from_id_salt((quantity, "unit"))
            .selected_text(unit.clone())
            .width(60.0)
            .show_ui(ui, |ui| {
                for name in units {
                    debug_assert!(unit_factor(name, units[0]).is_some() || units[0] == "m");
                    ui.selectable_value(&mut unit, (*name).to_owned(), *name);
                }
            });
    });
    if let Some(choice) = choice {
        choice.unit = unit;
    }
}
