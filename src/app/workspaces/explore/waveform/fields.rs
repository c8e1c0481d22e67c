//! The fields of the editor: the selected handle, the drive, grid and limits, files.

use eframe::egui::{Button, CollapsingHeader, ComboBox, TextEdit, Ui};

use super::super::fields::{Row, name, positive, refusal, remark, within};
use super::{canvas, form};
use crate::app::analysis::explore::drawing::Drawing;
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::widgets::text::heading;
use crate::explore::waveform::export::GeneratorFormat;
use crate::explore::waveform::{EditableWaveform, ExcessKind};
use crate::model::drive::{Burst, Handle, Interpolation, MAX_BURST_PERIODS};
use crate::model::unit::{counted, format_quantity};

/// Limits of typed numbers: frequencies \[Hz\], voltages \[V\], phases \[deg\].
const FREQUENCIES: (f64, f64) = (1e-6, 1e6);
const VOLTAGES: (f64, f64) = (-1e4, 1e4);
const PHASES: (f64, f64) = (-360_000.0, 360_000.0);
/// Bursts when they are switched on.
const FIRST_BURST: Burst = Burst { on: 3, of: 5 };

/// Draws the fields.
pub fn show(ui: &mut Ui, state: &mut State) {
    if state.setup.preset.model.piezo.is_none() {
        let device = &state.setup.preset.model.name;
        refusal(
            ui,
            &format!(
                "The device {device} has no drive, so a waveform moves nothing. Choose another one in File, Open preset."
            ),
        );
    }
    let drawn = &mut state.setup.explore.drawn;
    let drawing = &mut state.exploring.drawing;
    handle(ui, drawn, drawing);
    ui.separator();
    drive(ui, drawn);
    burst(ui, drawn);
    ui.separator();
    form::show(ui, drawn, drawing);
    ui.separator();
    limits(ui, drawn);
    ui.separator();
    files(ui, state);
}

/// Time and voltage of the selected handle.
fn handle(ui: &mut Ui, drawn: &mut EditableWaveform, drawing: &mut Drawing) {
    let count = drawn.handles().len();
    ui.horizontal(|ui| {
        heading(ui, &counted(count, "handle"));
        let mut step = |ui: &mut Ui, text: &str, label: &str, by: usize| {
            let button = ui.small_button(text).on_hover_text(label);
            button.widget_info(|| {
                eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Button, true, label)
            });
            if button.clicked() {
                let next = drawing.selected.map_or(0, |i| (i + by) % count);
                drawing.selected = Some(next);
            }
        };
        step(ui, "<", "Select the previous handle", count - 1);
        step(ui, ">", "Select the next handle", 1);
        let delete = ui.add_enabled(drawing.selected.is_some(), Button::new("Delete").small());
        if delete
            .on_hover_text("Take the selected handle away (Delete)")
            .clicked()
        {
            canvas::remove(drawn, drawing);
        }
    });
    let Some((i, old)) = drawing
        .selected
        .and_then(|i| Some((i, *drawn.handles().get(i)?)))
    else {
        remark(ui, "None is selected.");
        return;
    };
    let time = Row {
        label: "handle time",
        name: "Time",
        help: "When, as a share of the period",
        value: old.time,
        unit: "",
    };
    let voltage = Row {
        label: "handle voltage",
        name: "Voltage",
        help: "Voltage of the handle, without the offset",
        value: old.voltage,
        unit: "V",
    };
    let mut target = None;
    if let Some(time) = time.show(ui, |v| within(v, 0.0, 1.0, "the time")) {
        target = Some(Handle { time, ..old });
    }
    let (low, high) = VOLTAGES;
    if let Some(voltage) = voltage.show(ui, |v| within(v, low, high, "the voltage")) {
        target = Some(Handle { voltage, ..old });
    }
    if let Some(target) = target {
        // A typed number stands as it was typed.
        let grid = std::mem::take(&mut drawn.grid);
        let moved = drawn.move_to(i, target);
        drawn.grid = grid;
        drawing.refusal = moved.err().map(|error| error.to_string());
    }
}

/// Lines, frequency, offset and phase.
fn drive(ui: &mut Ui, drawn: &mut EditableWaveform) {
    ui.horizontal(|ui| {
        name(ui, "Lines", "What leads from handle to handle");
        let mut kind = drawn.interpolation();
        let choices = [
            (Interpolation::Linear, "straight", "Straight lines"),
            (
                Interpolation::Smooth,
                "smooth",
                "A smooth curve that never goes beyond two neighbouring handles",
            ),
        ];
        for (choice, text, help) in choices {
            ui.selectable_value(&mut kind, choice, text)
                .on_hover_text(help);
        }
        if kind != drawn.interpolation()
            && let Err(error) = drawn.set_interpolation(kind)
        {
            log::warn!("handles that were valid are refused: {error}");
        }
    });
    let rows = [
        (
            "drawn frequency",
            "Frequency",
            "Periods per second",
            drawn.frequency,
            "Hz",
        ),
        (
            "drawn offset",
            "Offset",
            "Added to all handles",
            drawn.offset,
            "V",
        ),
        (
            "drawn phase",
            "Phase",
            "How far the drive is ahead at the start; the steady response is only moved in time",
            drawn.phase,
            "deg",
        ),
    ];
    let limits = [FREQUENCIES, VOLTAGES, PHASES];
    for (k, ((label, name, help, value, unit), (low, high))) in
        rows.into_iter().zip(limits).enumerate()
    {
        let row = Row {
            label,
            name,
            help,
            value,
            unit,
        };
        let what = format!("the {}", name.to_lowercase());
        if let Some(new) = row.show(ui, |v| within(v, low, high, &what)) {
            match k {
                0 => drawn.frequency = new,
                1 => drawn.offset = new,
                _ => drawn.phase = new,
            }
        }
    }
}

/// Bursts: some periods on, then a pause.
fn burst(ui: &mut Ui, drawn: &mut EditableWaveform) {
    let mut has_bursts = drawn.burst.is_some();
    let help = "Some periods on, then a pause at the offset";
    if ui
        .checkbox(&mut has_bursts, "Bursts")
        .on_hover_text(help)
        .changed()
    {
        drawn.burst = has_bursts.then_some(FIRST_BURST);
    }
    let Some(burst) = &mut drawn.burst else {
        return;
    };
    let most = f64::from(MAX_BURST_PERIODS);
    let on = Row {
        label: "periods on",
        name: "Periods on",
        help: "Periods of the waveform in each burst",
        value: f64::from(burst.on),
        unit: "",
    };
    let of = f64::from(burst.of);
    if let Some(value) = on.show(ui, |v| within(v, 1.0, of, "periods on")) {
        burst.on = value.round() as u32;
    }
    let all = Row {
        label: "periods of a burst",
        name: "of",
        help: "Periods from the start of one burst to that of the next",
        value: of,
        unit: "",
    };
    let least = f64::from(burst.on);
    if let Some(value) = all.show(ui, |v| within(v, least, most, "periods of a burst")) {
        burst.of = value.round() as u32;
    }
}

/// Grid and limits, and what exceeds them.
fn limits(ui: &mut Ui, drawn: &mut EditableWaveform) {
    type Row<'a> = (&'a str, &'a str, &'a str, &'a mut Option<f64>, &'a str, f64);
    let rows: [Row<'_>; 4] = [
        (
            "grid of time",
            "Time grid",
            "Handles come to rest at multiples of this share of the period",
            &mut drawn.grid.time,
            "",
            0.01,
        ),
        (
            "grid of voltage",
            "Voltage grid",
            "Handles come to rest at multiples of this voltage",
            &mut drawn.grid.voltage,
            "V",
            0.1,
        ),
        (
            "limit of voltage",
            "Largest voltage",
            "What the amplifier gives or the film stands; what exceeds it is drawn red",
            &mut drawn.limits.voltage,
            "V",
            8.0,
        ),
        (
            "limit of slew",
            "Largest slew",
            "How fast the amplifier changes its voltage; a step exceeds any limit",
            &mut drawn.limits.slew,
            "V/s",
            1e5,
        ),
    ];
    for (label, text, help, value, unit, usual) in rows {
        optional(ui, (label, text, help), value, unit, usual);
    }
    match drawn.excesses() {
        Ok(found) => {
            for kind in [ExcessKind::Voltage, ExcessKind::Slew] {
                let (what, unit) = match kind {
                    ExcessKind::Voltage => ("voltage", "V"),
                    ExcessKind::Slew => ("slew", "V/s"),
                };
                let own = found.iter().filter(|e| e.kind == kind);
                let (places, most) = own.fold((0, 0.0f64), |(n, m), e| (n + 1, m.max(e.value)));
                if places > 0 {
                    let most = if most.is_finite() {
                        format_quantity(most, unit, 3)
                    } else {
                        "a step".to_owned()
                    };
                    let places = counted(places, "place");
                    refusal(ui, &format!("The {what} is exceeded at {places}: {most}."));
                }
            }
        }
        Err(error) => refusal(ui, &error.to_string()),
    }
}

/// A number that can be switched off.
fn optional(
    ui: &mut Ui,
    (label, text, help): (&str, &str, &str),
    value: &mut Option<f64>,
    unit: &str,
    usual: f64,
) {
    ui.horizontal(|ui| {
        let mut is_on = value.is_some();
        let size = eframe::egui::vec2(super::super::fields::NAME_WIDTH, 18.0);
        ui.allocate_ui(size, |ui| {
            ui.set_min_width(size.x);
            let switch = ui.checkbox(&mut is_on, text);
            if switch.on_hover_text(help).changed() {
                *value = is_on.then_some(usual);
            }
        });
        if let Some(now) = *value {
            let row = Row {
                label,
                name: text,
                help,
                value: now,
                unit,
            };
            if let Some(new) = row.field(ui, |v| positive(v, "it")) {
                *value = Some(new);
            }
        }
    });
}

/// The drive of Tune, own files, and files of function generators.
fn files(ui: &mut Ui, state: &mut State) {
    ui.horizontal(|ui| {
        let id = ui.label("Name").id;
        let field = TextEdit::singleline(&mut state.setup.explore.drawn.name).desired_width(150.0);
        ui.add(field)
            .labelled_by(id)
            .on_hover_text("What the waveform is called in its file");
    });
    ui.horizontal_wrapped(|ui| {
        let has_drive = state.setup.preset.model.piezo.is_some();
        ui.add_enabled_ui(has_drive, |ui| button(ui, state, Command::UseDrawnDrive));
        button(ui, state, Command::DrawTuneDrive);
    });
    ui.horizontal_wrapped(|ui| {
        for command in [Command::LoadWaveform, Command::SaveWaveform] {
            button(ui, state, command);
        }
    });
    CollapsingHeader::new("For a function generator")
        .default_open(true)
        .show(ui, |ui| generator(ui, state));
}

fn button(ui: &mut Ui, state: &mut State, command: Command) {
    let (text, help) = command.text();
    if ui.button(text).on_hover_text(help).clicked() {
        state.ask(command);
    }
}

fn generator(ui: &mut Ui, state: &mut State) {
    let drawing = &mut state.exploring.drawing;
    let formats = [
        GeneratorFormat::Csv { has_header: true },
        GeneratorFormat::Csv { has_header: false },
        GeneratorFormat::Siglent,
        GeneratorFormat::Keysight,
    ];
    let picker = ComboBox::from_id_salt("generator format")
        .width(205.0)
        .selected_text(drawing.format.label())
        .show_ui(ui, |ui| {
            for format in formats {
                ui.selectable_value(&mut drawing.format, format, format.label());
            }
        });
    picker
        .response
        .on_hover_text("Who is to read the file of one period");
    let (fewest, most) = drawing.format.samples();
    drawing.samples = drawing.samples.clamp(fewest, most);
    let row = Row {
        label: "samples of a period",
        name: "Samples",
        help: "Number of voltages in one period",
        value: drawing.samples as f64,
        unit: "",
    };
    let (low, high) = (fewest as f64, most as f64);
    if let Some(value) = row.show(ui, |v| within(v, low, high, "samples")) {
        drawing.samples = value.round() as usize;
    }
    button(ui, state, Command::ExportWaveform);
}
