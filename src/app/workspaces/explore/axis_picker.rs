//! The choice of an axis: which number, from where to where, linear or logarithmic.

use eframe::egui::{ComboBox, Ui};

use super::fields::{Row, name};
use crate::app::setup::explore::AxisChoice;
use crate::explore::map::Axis;
use crate::model::Model;
use crate::model::drive::Waveform;

/// An axis to be chosen.
pub struct AxisPicker<'a> {
    /// What it is for: `horizontal`.
    pub title: &'a str,
    /// Tells the pickers of panels apart.
    pub scope: &'a str,
    /// Device and drive whose numbers are offered.
    pub of: (&'a Model, &'a Waveform),
}

impl AxisPicker<'_> {
    /// Draws it and changes the choice.
    pub fn show(&self, ui: &mut Ui, choice: &mut AxisChoice) {
        let now = Axis::offered(&choice.id, self.of, 2).ok();
        let shown = now.as_ref().map_or_else(
            || format!("{} (not there)", choice.id),
            |axis| axis.name.clone(),
        );
        let mut picked = None;
        ui.horizontal(|ui| {
            let help = "Which number of the drive, the device or its effects varies";
            name(ui, self.title, help);
            let picker = ComboBox::from_id_salt((self.scope, self.title, "axis"))
                .width(138.0)
                .truncate()
                .selected_text(shown)
                .show_ui(ui, |ui| {
                    for id in Axis::ids(self.of.0, self.of.1) {
                        let Ok(axis) = Axis::offered(&id, self.of, 2) else {
                            continue;
                        };
                        let text = format!("{} ({id})", axis.name);
                        if ui.selectable_label(choice.id == id, text).clicked() {
                            picked = Some(axis);
                        }
                    }
                });
            picker.response.on_hover_text(help);
        });
        if let Some(axis) = picked
            && axis.id != choice.id
        {
            let is_logarithmic = axis.is_logarithmic && axis.from > 0.0;
            *choice = AxisChoice::new(&axis.id, (axis.from, axis.to), is_logarithmic);
        }
        let unit = now.map(|axis| axis.unit).unwrap_or_default();
        self.ends(ui, choice, &unit);
    }

    fn ends(&self, ui: &mut Ui, choice: &mut AxisChoice, unit: &str) {
        let check = |value: f64| (!value.is_finite()).then(|| "give a finite number".to_owned());
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let ends = [
                ("from", "First value of the axis", &mut choice.from),
                ("to", "Last value of the axis", &mut choice.to),
            ];
            for (text, help, value) in ends {
                ui.label(text);
                let label = format!("{}, {}: {text}", self.scope, self.title);
                let row = Row {
                    label: &label,
                    name: text,
                    help,
                    value: *value,
                    unit,
                };
                if let Some(new) = row.narrow_field(ui, check) {
                    *value = new;
                }
            }
            let log = ui.checkbox(&mut choice.is_logarithmic, "log");
            log.on_hover_text("Equal ratios instead of equal differences");
        });
    }
}
