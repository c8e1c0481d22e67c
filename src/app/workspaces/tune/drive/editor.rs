//! The drive: waveform, its values, a table of points, a preview of two periods.

use eframe::egui::{Button, ComboBox, Ui};

use super::place::Place;
use super::{preview, table};
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::setup::Setup;
use crate::app::state::State;
use crate::app::widgets::parameter_slider::{ParameterSlider, Size};
use crate::app::widgets::text::small;
use crate::app::workspaces::tune::table_a1::case_picker;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The kinds of drive in the order of the list.
const KINDS: [&str; 8] = [
    "rest", "sine", "square", "triangle", "ramped", "chirp", "table", "recorded",
];

const HERTZ: (f64, f64) = (1e-6, 1e6);
const FREQUENCY: ParameterSpec = ParameterSpec {
    id: "frequency",
    symbol: "f",
    name: "drive frequency",
    unit: "Hz",
    default: 15.0,
    range: (1.0, 1000.0),
    limits: HERTZ,
    scale: Scale::Log,
    rank: Rank::Secondary,
    meaning: "periods per second of the drive voltage",
    equation: "",
};
const FROM: ParameterSpec = ParameterSpec {
    id: "from",
    symbol: "f from",
    name: "first frequency",
    range: (1.0, 10_000.0),
    meaning: "frequency at the start of the sweep",
    ..FREQUENCY
};
const TO: ParameterSpec = ParameterSpec {
    id: "to",
    symbol: "f to",
    name: "last frequency",
    meaning: "frequency at the end of the sweep",
    ..FROM
};
const SWEEP: ParameterSpec = ParameterSpec {
    id: "sweep",
    symbol: "sweep",
    name: "sweep time",
    unit: "s",
    range: (0.01, 100.0),
    limits: (1e-9, 1e6),
    meaning: "time from the first frequency to the last; then the voltage is held",
    ..FREQUENCY
};
const AMPLITUDE: ParameterSpec = ParameterSpec {
    id: "amplitude",
    symbol: "A",
    name: "drive amplitude",
    unit: "V",
    range: (0.0, 10.0),
    limits: (-1e4, 1e4),
    scale: Scale::Linear,
    meaning: "largest voltage; the branches of the piezo film are known to 8 V",
    ..FREQUENCY
};
const LAMBDA: ParameterSpec = ParameterSpec {
    id: "lambda",
    symbol: "λ",
    name: "ramp share",
    unit: "",
    range: (0.0, 0.5),
    limits: (0.0, 0.5),
    scale: Scale::Linear,
    meaning: "share of the period that each ramp takes; 0 is a square wave (fig. 6)",
    ..FREQUENCY
};

/// Draws the editor. Values that make no sense are shown where they are typed; the
/// drive stays what it was.
pub fn show(ui: &mut Ui, state: &mut State, place: Place) {
    if state.setup.preset.model.piezo.is_none() {
        ui.weak("This device has no drive.");
        return;
    }
    if place == Place::Panel && state.drive_editor_open {
        ui.weak("Shown in its window.");
        return;
    }
    ui.horizontal(|ui| {
        kind_picker(ui, &mut state.setup, place);
        case_picker::case_picker(ui, &mut state.setup, place.scope());
    });
    match state.setup.drive.clone() {
        DriveChoice::Waveform(Waveform::Table(table)) => {
            table::show(ui, &mut state.setup, &table, place);
            let button = ui.button("Load from a file...");
            if button.on_hover_text(Command::LoadDrive.text().1).clicked() {
                state.ask(Command::LoadDrive);
            }
        }
        DriveChoice::Waveform(waveform) => values(ui, &mut state.setup, waveform, place),
        DriveChoice::Recorded(_) => recorded(ui, &mut state.setup, place),
    }
    preview::show(ui, &state.setup, place);
    if place == Place::Panel {
        let button = ui.add(Button::new("Open in a window").small());
        if button.clicked() {
            state.ask(Command::DriveEditor);
        }
    }
}

/// Which of [`KINDS`] a drive is.
fn kind_of(drive: &DriveChoice) -> &'static str {
    match drive {
        DriveChoice::Recorded(_) => "recorded",
        DriveChoice::Waveform(waveform) => match waveform {
            Waveform::Rest => "rest",
            Waveform::Sine { .. } => "sine",
            Waveform::Square { .. } => "square",
            Waveform::Triangle { .. } => "triangle",
            Waveform::Ramped { .. } => "ramped",
            Waveform::Chirp { .. } => "chirp",
            Waveform::Table(_) => "table",
        },
    }
}

/// Frequency and amplitude of a drive, where it has them.
fn frequency_and_amplitude(drive: &DriveChoice) -> (Option<f64>, Option<f64>) {
    match drive {
        DriveChoice::Waveform(
            Waveform::Sine {
                frequency,
                amplitude,
            }
            | Waveform::Square {
                frequency,
                amplitude,
            }
            | Waveform::Triangle {
                frequency,
                amplitude,
            }
            | Waveform::Ramped {
                frequency,
                amplitude,
                ..
            }
            | Waveform::Chirp {
                from: frequency,
                amplitude,
                ..
            },
        ) => (Some(*frequency), Some(*amplitude)),
        DriveChoice::Waveform(Waveform::Table(table)) => (None, Some(table.amplitude())),
        _ => (None, None),
    }
}

/// The drive of the kind asked for, with as much kept of the present one as it has.
pub(crate) fn of_kind(setup: &Setup, kind: &str) -> Option<DriveChoice> {
    let usual = Waveform::parse(&setup.preset.drive, setup.preset.duration)
        .map(DriveChoice::Waveform)
        .unwrap_or(DriveChoice::Waveform(Waveform::Rest));
    let (own, fallback) = (
        frequency_and_amplitude(&setup.drive),
        frequency_and_amplitude(&usual),
    );
    let frequency = own.0.or(fallback.0).unwrap_or(15.0);
    let amplitude = own.1.or(fallback.1).unwrap_or(8.0);
    let waveform = match kind {
        "rest" => Waveform::Rest,
        "sine" => Waveform::Sine {
            frequency,
            amplitude,
        },
        "square" => Waveform::Square {
            frequency,
            amplitude,
        },
        "triangle" => Waveform::Triangle {
            frequency,
            amplitude,
        },
        "ramped" => Waveform::Ramped {
            frequency,
            amplitude,
            lambda: 0.1,
        },
        "chirp" => Waveform::Chirp {
            from: frequency,
            to: (10.0 * frequency).min(1e6),
            amplitude,
            duration: setup.duration,
        },
        "table" => {
            let quarter = 0.25 / frequency;
            let time = (0..5).map(|i| f64::from(i) * quarter).collect();
            let voltage = vec![0.0, amplitude, 0.0, -amplitude, 0.0];
            Waveform::Table(VoltageTable::new("edited", time, voltage, 0.0).ok()?.into())
        }
        _ => {
            let with_voltage = setup
                .overlays
                .iter()
                .find(|o| o.recording.voltage.is_some())?;
            return Some(DriveChoice::Recorded(with_voltage.id));
        }
    };
    Some(DriveChoice::Waveform(waveform))
}

fn kind_picker(ui: &mut Ui, setup: &mut Setup, place: Place) {
    let kind = kind_of(&setup.drive);
    let picker = ComboBox::from_id_salt((place.scope(), "kind"))
        .width(92.0)
        .selected_text(kind)
        .show_ui(ui, |ui| {
            for name in KINDS {
                let drive = of_kind(setup, name);
                let entry = ui.add_enabled(drive.is_some(), Button::selectable(name == kind, name));
                let entry = entry.on_disabled_hover_text("No recording with a voltage is loaded.");
                if entry.clicked()
                    && name != kind
                    && let Some(drive) = drive
                {
                    setup.drive = drive;
                }
            }
        });
    picker
        .response
        .on_hover_text("Waveform of the drive voltage");
}

/// Sliders for the values of a waveform.
fn values(ui: &mut Ui, setup: &mut Setup, mut waveform: Waveform, place: Place) {
    let before = waveform.clone();
    let usual = Waveform::parse(&setup.preset.drive, setup.preset.duration)
        .map(DriveChoice::Waveform)
        .unwrap_or(DriveChoice::Waveform(Waveform::Rest));
    let (usual_frequency, usual_amplitude) = frequency_and_amplitude(&usual);
    let mut edit = |spec: ParameterSpec, value: &mut f64, original: f64| {
        let slider = ParameterSlider {
            scope: place.scope(),
            id: spec.id,
            spec,
            value: *value,
            original,
            locked: None,
            size: Size::Small,
            problem: None,
        };
        if let Some(new) = slider.show(ui).value {
            *value = new;
        }
    };
    let (f0, a0) = (
        usual_frequency.unwrap_or(15.0),
        usual_amplitude.unwrap_or(8.0),
    );
    match &mut waveform {
        Waveform::Rest | Waveform::Table(_) => {}
        Waveform::Sine {
            frequency,
            amplitude,
        }
        | Waveform::Square {
            frequency,
            amplitude,
        }
        | Waveform::Triangle {
            frequency,
            amplitude,
        } => {
            edit(FREQUENCY, frequency, f0);
            edit(AMPLITUDE, amplitude, a0);
        }
        Waveform::Ramped {
            frequency,
            amplitude,
            lambda,
        } => {
            edit(FREQUENCY, frequency, f0);
            edit(AMPLITUDE, amplitude, a0);
            edit(LAMBDA, lambda, 0.1);
        }
        Waveform::Chirp {
            from,
            to,
            amplitude,
            duration,
        } => {
            edit(FROM, from, f0);
            edit(TO, to, 10.0 * f0);
            edit(AMPLITUDE, amplitude, a0);
            edit(SWEEP, duration, setup.duration);
        }
    }
    if matches!(waveform, Waveform::Rest) {
        ui.weak("No voltage since poling: no force.");
    }
    if waveform != before {
        match waveform.check() {
            Ok(()) => setup.drive = DriveChoice::Waveform(waveform),
            Err(error) => {
                let text = small(error.to_string());
                ui.label(text.color(crate::app::widgets::text::error_color(ui)));
            }
        }
    }
}

/// Choice among the recordings that have a voltage.
fn recorded(ui: &mut Ui, setup: &mut Setup, place: Place) {
    let DriveChoice::Recorded(chosen) = setup.drive else {
        return;
    };
    let name = |setup: &Setup| {
        let overlay = setup.overlays.iter().find(|o| o.id == chosen);
        overlay.map(|o| o.recording.name.clone())
    };
    let current = name(setup);
    let mut pick = None;
    ComboBox::from_id_salt((place.scope(), "recording"))
        .width(ui.available_width() - 16.0)
        .truncate()
        .selected_text(current.as_deref().unwrap_or("(removed)"))
        .show_ui(ui, |ui| {
            for overlay in setup
                .overlays
                .iter()
                .filter(|o| o.recording.voltage.is_some())
            {
                let entry = ui.selectable_label(overlay.id == chosen, &overlay.recording.name);
                if entry.clicked() {
                    pick = Some(overlay.id);
                }
            }
        })
        .response
        .on_hover_text("The recording whose voltage drives the simulation");
    if let Some(id) = pick {
        setup.drive = DriveChoice::Recorded(id);
    }
    if current.is_none() {
        let text = small("That recording was removed: choose another drive.");
        ui.label(text.color(crate::app::widgets::text::error_color(ui)));
    }
}
