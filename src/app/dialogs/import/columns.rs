//! The fields of the import dialog, each with a name for screen readers.

use eframe::egui::{ComboBox, DragValue, Response, Role, TextEdit, Ui, WidgetInfo};

use crate::model::unit::format_quantity;
use crate::recording::csv::{ColumnChoice, DriftRemoval, Quantity, SampleClock};

/// Names of the columns.
pub type Names = Vec<String>;

/// Names a field.
pub fn name(response: &Response, role: Role, name: &str) {
    response.widget_info(|| WidgetInfo::labeled(role, response.enabled(), name));
}

/// Names a combobox, together with its choice.
fn name_choice(response: &Response, name: &str, chosen: &str) {
    response.widget_info(|| {
        let mut info = WidgetInfo::labeled(Role::ComboBox, response.enabled(), name);
        info.current_text_value = Some(chosen.to_owned());
        info
    });
}

/// A combobox for one of a few named values; returns its button.
pub fn pick<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    choices: &[(T, &'static str)],
) -> Response {
    let chosen = choices
        .iter()
        .find(|(choice, _)| choice == value)
        .map_or("", |(_, text)| text);
    let response = ComboBox::from_id_salt(name)
        .selected_text(chosen)
        .width(90.0)
        .show_ui(ui, |ui| {
            for (choice, text) in choices {
                ui.selectable_value(value, *choice, *text);
            }
        })
        .response;
    name_choice(&response, name, chosen);
    response
}

/// Number of lines before the data.
pub fn lines_before(ui: &mut Ui, lines: &mut usize) {
    let label = ui.label("lines before the data").id;
    ui.add(DragValue::new(lines).range(0..=100_000))
        .labelled_by(label);
}

/// The sampling interval where there is no column of times.
pub fn interval(ui: &mut Ui, clock: &mut Option<SampleClock>) {
    ui.horizontal(|ui| {
        ui.label("sampling interval");
        let mut micros = clock.map_or(0.0, |clock| 1e6 * clock.interval);
        let field = DragValue::new(&mut micros)
            .range(0.0..=1e12)
            .speed(0.1)
            .max_decimals(9)
            .suffix(" \u{b5}s");
        let field = ui.add(field);
        name(&field, Role::SpinButton, "sampling interval");
        if field.changed() {
            let start = clock.map_or(0.0, |clock| clock.start);
            *clock = (micros > 0.0).then_some(SampleClock {
                start,
                interval: 1e-6 * micros,
            });
        }
        if let Some(clock) = clock {
            ui.weak(format!(
                "{} samples a second",
                format_quantity(1.0 / clock.interval, "", 6)
            ));
        }
    });
}

/// What is taken out of a displacement that is integrated.
pub fn drift(ui: &mut Ui, drift: &mut DriftRemoval) {
    ui.horizontal_wrapped(|ui| {
        ui.label("drift of the integral");
        let labels = DriftRemoval::ALL.map(|one| (one, one.label()));
        // A corner that was typed is one of the high-pass.
        let mut kind = match *drift {
            DriftRemoval::HighPass { .. } => DriftRemoval::HighPass { corner: None },
            other => other,
        };
        let before = kind;
        pick(ui, "drift", &mut kind, &labels);
        if kind != before {
            *drift = kind;
        }
        if let DriftRemoval::HighPass { corner } = drift {
            let mut hertz = corner.unwrap_or(0.0);
            let field = DragValue::new(&mut hertz)
                .range(0.0..=1e9)
                .speed(0.05)
                .max_decimals(6)
                .suffix(" Hz");
            let field = ui
                .add(field)
                .on_hover_text("0: four periods of the corner fit into the recording");
            name(&field, Role::SpinButton, "drift corner");
            if field.changed() {
                *corner = (hertz > 0.0).then_some(hertz);
            }
        }
        ui.weak(kind.help());
    });
}

/// Scale and sign of a quantity, in two cells.
pub fn scale(ui: &mut Ui, quantity: &str, value: &mut f64) {
    let mut inverted = value.is_sign_negative();
    let mut size = value.abs();
    let field = ui.add(DragValue::new(&mut size).speed(0.01));
    name(&field, Role::SpinButton, &format!("{quantity} scale"));
    let field = field.on_hover_text("values are multiplied by this");
    if field.changed() && size.is_finite() {
        // A typed minus changes the present sign.
        inverted ^= size < 0.0;
        *value = size.abs() * if inverted { -1.0 } else { 1.0 };
    }
    let mut shown = inverted;
    let sign = ui
        .checkbox(&mut shown, "inverted")
        .on_hover_text("Change the sign: up becomes down");
    name(&sign, Role::CheckBox, &format!("{quantity} inverted"));
    if sign.changed() {
        *value = -*value;
    }
}

/// An offset in micrometres.
pub fn micrometres(ui: &mut Ui, title: &str, value: &mut f64) {
    let mut shown = *value * 1e6;
    let field = ui.add(DragValue::new(&mut shown).speed(0.1).suffix(" µm"));
    name(&field, Role::SpinButton, title);
    if field.changed() && shown.is_finite() {
        *value = shown * 1e-6;
    }
}

/// Comboboxes for column and unit of a quantity, in three cells with its name.
pub fn chooser(
    ui: &mut Ui,
    quantity: &str,
    names: &Names,
    choice: &mut Option<ColumnChoice>,
    units: &[&'static str],
) {
    ui.label(quantity);
    let selected = match choice {
        None => "none".to_owned(),
        Some(choice) => names
            .get(choice.index)
            .cloned()
            .unwrap_or_else(|| format!("column {} (missing)", choice.index.saturating_add(1))),
    };
    let response = ComboBox::from_id_salt((quantity, "column"))
        .selected_text(&selected)
        .width(170.0)
        .show_ui(ui, |ui| {
            if ui.selectable_label(choice.is_none(), "none").clicked() {
                *choice = None;
            }
            for (index, name) in names.iter().enumerate() {
                let is = choice.as_ref().is_some_and(|c| c.index == index);
                if ui.selectable_label(is, name).clicked() {
                    let unit = match choice {
                        Some(choice) => choice.unit.clone(),
                        None => unit_of(name, units),
                    };
                    let kind = Quantity::of_unit(&unit);
                    *choice = Some(ColumnChoice {
                        kind,
                        ..ColumnChoice::new(index, unit)
                    });
                }
            }
        })
        .response;
    name_choice(&response, &format!("{quantity} column"), &selected);
    let mut unit = choice.as_ref().map_or("", |c| c.unit.as_str()).to_owned();
    ui.add_enabled_ui(choice.is_some(), |ui| {
        let response = ComboBox::from_id_salt((quantity, "unit"))
            .selected_text(&unit)
            .width(60.0)
            .show_ui(ui, |ui| {
                for name in units {
                    ui.selectable_value(&mut unit, (*name).to_owned(), *name);
                }
            })
            .response;
        name_choice(&response, &format!("{quantity} unit"), &unit);
    });
    if let Some(choice) = choice
        && choice.unit != unit
    {
        choice.kind = Quantity::of_unit(&unit);
        choice.scale = None;
        choice.unit = unit;
    }
}

/// What one unit of a column stands for, where a displacement is given as a voltage or in pixels.
pub fn sensitivity(ui: &mut Ui, quantity: &str, choice: &mut Option<ColumnChoice>) {
    let Some(choice) = choice.as_mut().filter(|c| c.is_in_foreign_unit()) else {
        return;
    };
    let mut text = choice.scale.clone().unwrap_or_default();
    ui.horizontal(|ui| {
        ui.label(format!(
            "{quantity}: 1 {} of the instrument is",
            choice.unit
        ));
        let field = ui.add(
            TextEdit::singleline(&mut text)
                .hint_text(format!("0.5um/{}", choice.unit))
                .desired_width(90.0),
        );
        name(&field, Role::TextInput, &format!("{quantity} sensitivity"));
        if field.changed() {
            choice.scale = (!text.trim().is_empty()).then(|| text.trim().to_owned());
        }
    });
}

/// The unit in brackets after a column's name if it is one of `units`, else the first.
fn unit_of(name: &str, units: &[&'static str]) -> String {
    let written = name
        .split(['[', '('])
        .nth(1)
        .map(|rest| rest.trim_end_matches([']', ')']).trim());
    let known = units.iter().find(|unit| written == Some(**unit));
    known.or(units.first()).copied().unwrap_or("").to_owned()
}

#[cfg(test)]
mod tests {
    use super::super::columns::*;

    #[test]
    fn a_unit_in_the_name_is_taken_if_it_fits() {
        let units = ["m", "um"];
        assert_eq!(unit_of("x [um]", &units), "um");
        assert_eq!(unit_of("x (um)", &units), "um");
        assert_eq!(unit_of("x [V]", &units), "m");
        assert_eq!(unit_of("x", &units), "m");
    }
}
