//! The drive as a table of points, typed one by one or pasted as text.

use eframe::egui::{Button, CollapsingHeader, Id, ScrollArea, TextEdit, Ui};

use super::place::Place;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::widgets::callout;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::quantity_field::QuantityField;
use crate::app::widgets::text::small;
use crate::model::drive::{DriveError, VoltageTable, Waveform};
use crate::model::unit::parse_quantity;

/// Tables with more points are edited as text only.
const MAX_ROWS: usize = 100;
/// Tables with more points are too long to edit here.
const MAX_TEXT_LINES: usize = 20_000;

/// Draws the table of the drive. An invalid change is refused with the reason.
pub fn show(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable, place: Place) {
    let (time, voltage) = table.samples();
    ui.weak(format!("{} points, linear interpolation", time.len()));
    if time.len() <= MAX_ROWS {
        rows(ui, setup, table, place);
    }
    if time.len() <= MAX_TEXT_LINES {
        CollapsingHeader::new("As text (paste here)")
            .id_salt((place.scope(), "as text"))
            .show_unindented(ui, |ui| text(ui, setup, time, voltage, place));
    }
}

/// What is wrong, without the name of the table, which is in view.
fn reason(error: &DriveError) -> String {
    match error {
        DriveError::Table { reason, .. } => reason.clone(),
        error => error.to_string(),
    }
}

fn rebuilt(time: Vec<f64>, voltage: Vec<f64>) -> Result<DriveChoice, DriveError> {
    let table = VoltageTable::new("edited", time, voltage, 0.0)?;
    let waveform = Waveform::Table(table.into());
    waveform.check()?;
    Ok(DriveChoice::Waveform(waveform))
}

fn rows(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable, place: Place) {
    let (time, voltage) = table.samples();
    let with = |row: usize, column: usize, value: f64| {
        let (mut time, mut voltage) = (time.to_vec(), voltage.to_vec());
        if column == 0 {
            time[row] = value;
        } else {
            voltage[row] = value;
        }
        rebuilt(time, voltage)
    };
    let mut changed = None;
    let area = ScrollArea::vertical()
        .id_salt((place.scope(), "rows"))
        .max_height(170.0);
    area.show(ui, |ui| {
        for row in 0..time.len() {
            ui.horizontal(|ui| {
                let values = [(time[row], "s", "time"), (voltage[row], "V", "voltage")];
                for (column, (value, unit, name)) in values.into_iter().enumerate() {
                    let label = format!("{name} {}", row + 1);
                    let field = QuantityField {
                        id: Id::unique((place.scope(), "point", row, column)),
                        label: &label,
                        value,
                        unit,
                        width: 96.0,
                        enabled: true,
                    };
                    let output = field.show(ui, |v| with(row, column, v).err().map(|e| reason(&e)));
                    if let Some(value) = output.value {
                        changed = with(row, column, value).ok();
                    }
                    if let Some(error) = &output.error {
                        let field = output.response.rect;
                        callout::error(ui, (place.scope(), row, column), field, error);
                    }
                }
                if time.len() > 1
                    && icon_button(ui, Icon::Remove, &format!("remove point {}", row + 1))
                        .on_hover_text("Remove this point")
                        .clicked()
                {
                    let (mut time, mut voltage) = (time.to_vec(), voltage.to_vec());
                    time.remove(row);
                    voltage.remove(row);
                    changed = rebuilt(time, voltage).ok();
                }
            });
        }
    });
    if ui.button("Add point").clicked() {
        let (mut time, mut voltage) = (time.to_vec(), voltage.to_vec());
        let end = time.last().copied().unwrap_or(0.0);
        let step = time.len().checked_sub(2).map_or(1e-3, |i| end - time[i]);
        time.push(end + step);
        voltage.push(voltage.last().copied().unwrap_or(0.0));
        changed = rebuilt(time, voltage).ok();
    }
    if let Some(drive) = changed {
        setup.drive = drive;
    }
}

fn text(ui: &mut Ui, setup: &mut Setup, time: &[f64], voltage: &[f64], place: Place) {
    let key = Id::unique((place.scope(), "table text"));
    let present = write(time, voltage);
    // The typed text together with the table it was typed over. A new table discards the text.
    let kept: Option<(String, String)> = ui.data(|data| data.get_temp(key));
    let mut typed = match kept {
        Some((typed, over)) if over == present => typed,
        _ => present.clone(),
    };
    ui.weak("One line per point: time and voltage, in any unit.");
    let edit = TextEdit::multiline(&mut typed)
        .desired_rows(6)
        .desired_width(f32::INFINITY)
        .code_editor();
    let response = ui.add(edit);
    ui.ctx()
        .accesskit_node_builder(response.id, |node| node.set_label("voltage table as text"));
    let read = read(&typed);
    if let Err(reason) = &read {
        ui.label(small(reason).color(crate::app::widgets::text::error_color(ui)));
    }
    let usable = read.is_ok() && typed != present;
    let apply = ui.add_enabled(usable, Button::new("Use these points"));
    ui.data_mut(|data| data.insert_temp(key, (typed, present)));
    if apply.clicked()
        && let Ok(drive) = read
    {
        setup.drive = drive;
    }
}

fn write(time: &[f64], voltage: &[f64]) -> String {
    let lines = time.iter().zip(voltage).map(|(t, v)| format!("{t}, {v}\n"));
    lines.collect()
}

/// Reads lines of `time, voltage`, with or without units, separated by comma, semicolon
/// or tab. Empty lines, comments (`#`) and a header are skipped.
pub(crate) fn read(text: &str) -> Result<DriveChoice, String> {
    let (mut time, mut voltage) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let separator = [';', '\t', ','].into_iter().find(|c| line.contains(*c));
        let Some((t, v)) = separator.and_then(|c| line.split_once(c)) else {
            return Err(format!(
                "line {}: \"{line}\" is not a pair; write time and voltage, for example \"5 ms, 8 V\"",
                number + 1
            ));
        };
        let pair = parse_quantity(t, "s").and_then(|t| Ok((t, parse_quantity(v, "V")?)));
        match pair {
            Ok((t, v)) => {
                time.push(t);
                voltage.push(v);
            }
            Err(_) if time.is_empty() && !line.contains(|c: char| c.is_ascii_digit()) => {}
            Err(error) => return Err(format!("line {}: {error}", number + 1)),
        }
    }
    rebuilt(time, voltage).map_err(|error| reason(&error))
}

#[cfg(test)]
mod tests {
    use super::super::table::*;

    #[test]
    fn pasted_points_are_read_or_refused_with_a_line_number() {
        let drive = read("t [s], V [V]\n# made by hand\n0, 0\n5 ms, 8 V\n10ms;-8\n").unwrap();
        let DriveChoice::Waveform(Waveform::Table(table)) = drive else {
            panic!("no table");
        };
        assert_eq!(
            table.samples(),
            (&[0.0, 5e-3, 10e-3][..], &[0.0, 8.0, -8.0][..])
        );
        assert!(read("0, 0\n1, volts").unwrap_err().contains("line 2"));
        assert!(read("0, 0\n1").unwrap_err().contains("line 2"));
        assert!(
            read("0, 0\n0, 1")
                .unwrap_err()
                .contains("does not increase")
        );
        assert!(read("").is_err());
    }
}
