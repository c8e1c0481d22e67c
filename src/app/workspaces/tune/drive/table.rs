//! The drive as a table of points, typed one by one or pasted as text.

use eframe::egui::{Button, Checkbox, CollapsingHeader, ComboBox, Id, ScrollArea, TextEdit, Ui};

use super::place::Place;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::widgets::callout;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::quantity_field::QuantityField;
use crate::app::widgets::text::small;
use crate::model::drive::{DriveError, DriveReading, VoltageTable, Waveform};
use crate::model::unit::{counted, parse_quantity};
use crate::recording::measured_drive::drive_of_samples;

/// Tables with more points are edited as text only.
const MAX_ROWS: usize = 100;
/// Tables with more points are too long to edit here.
const MAX_TEXT_LINES: usize = 20_000;

/// Draws the table of the drive. An invalid change is refused with the reason.
pub fn show(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable, place: Place) {
    let Some((time, _)) = table.points() else {
        measured(ui, setup, table);
        return;
    };
    ui.weak(format!("{} points, linear interpolation", time.len()));
    if time.len() <= MAX_ROWS {
        rows(ui, setup, table, place);
    }
    if time.len() <= MAX_TEXT_LINES {
        CollapsingHeader::new("As text (paste here)")
            .id_salt((place.scope(), "as text"))
            .show_unindented(ui, |ui| text(ui, setup, table, place));
    }
    repeat(ui, setup, table, place);
}

/// What was found in the samples of a file, and how else they can be read.
fn measured(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable) {
    if let Some(text) = table.text() {
        ui.label(text);
    }
    let Some(source) = table.source() else {
        return;
    };
    ui.weak(format!(
        "{} of {}",
        counted(source.time.len(), "sample"),
        table.name
    ));
    if let Some(reading) = reading_picker(ui, "drive reading", source.reading) {
        let (time, voltage) = (source.time.clone(), source.voltage.clone());
        if let Ok(waveform) = drive_of_samples(&table.name, time, voltage, reading) {
            setup.drive = DriveChoice::Waveform(waveform);
        }
    }
}

/// A list of the ways to read a measured voltage; what was chosen, if it is another.
pub fn reading_picker(ui: &mut Ui, name: &str, reading: DriveReading) -> Option<DriveReading> {
    let mut chosen = reading;
    let list = ComboBox::from_id_salt(name).selected_text(reading.label());
    let output = list.show_ui(ui, |ui| {
        for other in DriveReading::ALL {
            ui.selectable_value(&mut chosen, other, other.label());
        }
    });
    let id = output.response.id;
    ui.ctx()
        .accesskit_node_builder(id, |node| node.set_label(name));
    (chosen != reading).then_some(chosen)
}

/// Whether the points come again, and after how long.
fn repeat(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable, place: Place) {
    let Some((time, _)) = table.points() else {
        return;
    };
    let span = table.end() - time.first().copied().unwrap_or(0.0);
    ui.horizontal(|ui| {
        let mut repeats = table.period().is_some();
        let can = span > 0.0;
        if ui
            .add_enabled(can, Checkbox::new(&mut repeats, "repeat after"))
            .changed()
            && let Ok(drive) = with_period(table, repeats.then_some(span))
        {
            setup.drive = drive;
        }
        let field = QuantityField {
            id: Id::unique((place.scope(), "period")),
            label: "period of the table",
            value: table.period().unwrap_or(span),
            unit: "s",
            width: 96.0,
            enabled: repeats,
        };
        let refused = |v: f64| with_period(table, Some(v)).err().map(|e| reason(&e));
        let output = field.show(ui, refused);
        if let Some(value) = output.value
            && let Ok(drive) = with_period(table, Some(value))
        {
            setup.drive = drive;
        }
        if let Some(error) = &output.error {
            let place = (place.scope(), "period");
            callout::error(ui, place, output.response.rect, error);
        }
    });
}

fn with_period(table: &VoltageTable, period: Option<f64>) -> Result<DriveChoice, DriveError> {
    let (time, voltage) = table.points().unwrap_or_default();
    rebuilt(time.to_vec(), voltage.to_vec(), period)
}

/// What is wrong, without the name of the table, which is in view.
fn reason(error: &DriveError) -> String {
    match error {
        DriveError::Table { reason, .. } => reason.clone(),
        error => error.to_string(),
    }
}

/// The points as a drive. They repeat if `period` says so and they still fit into it.
fn rebuilt(
    time: Vec<f64>,
    voltage: Vec<f64>,
    period: Option<f64>,
) -> Result<DriveChoice, DriveError> {
    let mut table = VoltageTable::new("edited", time, voltage)?;
    if let Some(period) = period {
        table = table.repeating(period)?;
    }
    let waveform = Waveform::Table(table.into());
    waveform.check()?;
    Ok(DriveChoice::Waveform(waveform))
}

fn rows(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable, place: Place) {
    let (time, voltage) = table.points().unwrap_or_default();
    let period = table.period();
    let with = |row: usize, column: usize, value: f64| {
        let (mut time, mut voltage) = (time.to_vec(), voltage.to_vec());
        if column == 0 {
            time[row] = value;
        } else {
            voltage[row] = value;
        }
        rebuilt(time, voltage, period)
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
                    changed = rebuilt(time, voltage, period).ok();
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
        changed = rebuilt(time, voltage, period).ok();
    }
    if let Some(drive) = changed {
        setup.drive = drive;
    }
}

fn text(ui: &mut Ui, setup: &mut Setup, table: &VoltageTable, place: Place) {
    let (time, voltage) = table.points().unwrap_or_default();
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
        setup.drive = match &drive {
            // They go on repeating where they fit into the period.
            DriveChoice::Waveform(Waveform::Table(new)) => {
                with_period(new, table.period()).unwrap_or(drive)
            }
            _ => drive,
        };
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
    rebuilt(time, voltage, None).map_err(|error| reason(&error))
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
            table.points().unwrap(),
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
