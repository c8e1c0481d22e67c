//! The drive editor: kind of waveform, its values or a table of points, and a preview.

use eframe::egui::{Button, ComboBox, Label, Ui};

use super::place::Place;
use super::{preview, table};
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::state::State;
use crate::app::widgets::parameter_slider::{Extrapolation, ParameterSlider, Size};
use crate::app::widgets::text::small;
use crate::app::workspaces::tune::table_a1::case_picker;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::piezo::{MEASURED_FREQUENCY, MEASURED_VOLTAGE};

/// The kinds of drive in the order of the list.
const DRIVE_KINDS: [&str; 8] = [
    "rest", "sine", "square", "triangle", "ramped", "chirp", "table", "recorded",
];

/// Frequency and amplitude of a drive if the preset has none \[Hz\], \[V\].
const DEFAULT_FREQUENCY: f64 = 15.0;
const DEFAULT_AMPLITUDE: f64 = 8.0;
/// Ramp share of a new ramped square wave.
const DEFAULT_RAMP_SHARE: f64 = 0.1;
/// A new sweep ends at this multiple of its first frequency.
const SWEEP_RATIO: f64 = 10.0;
/// Frequencies that can be typed \[Hz\].
const FREQUENCY_LIMITS: (f64, f64) = (1e-6, 1e6);

const FREQUENCY_SPEC: ParameterSpec = ParameterSpec {
    id: "frequency",
    symbol: "f",
    name: "drive frequency",
    unit: "Hz",
    default: DEFAULT_FREQUENCY,
    range: (1.0, 1000.0),
    limits: FREQUENCY_LIMITS,
    scale: Scale::Log,
    rank: Rank::Secondary,
    meaning: "periods per second of the drive voltage",
    equation: "",
};
const FROM_SPEC: ParameterSpec = ParameterSpec {
    id: "from",
    symbol: "f from",
    name: "first frequency",
    range: (1.0, 10_000.0),
    meaning: "frequency at the start of the sweep",
    ..FREQUENCY_SPEC
};
const TO_SPEC: ParameterSpec = ParameterSpec {
    id: "to",
    symbol: "f to",
    name: "last frequency",
    meaning: "frequency at the end of the sweep",
    ..FROM_SPEC
};
const SWEEP_SPEC: ParameterSpec = ParameterSpec {
    id: "sweep",
    symbol: "sweep",
    name: "sweep time",
    unit: "s",
    range: (0.01, 100.0),
    limits: (1e-9, 1e6),
    meaning: "time from the first frequency to the last; then the voltage is held",
    ..FREQUENCY_SPEC
};
const AMPLITUDE_SPEC: ParameterSpec = ParameterSpec {
    id: "amplitude",
    symbol: "A",
    name: "drive amplitude",
    unit: "V",
    range: (0.0, 10.0),
    limits: (-1e4, 1e4),
    scale: Scale::Linear,
    meaning: "peak voltage; the branches of the piezo film are measured up to 8 V",
    ..FREQUENCY_SPEC
};
const LAMBDA_SPEC: ParameterSpec = ParameterSpec {
    id: "lambda",
    symbol: "λ",
    name: "ramp share",
    unit: "",
    range: (0.0, 0.5),
    limits: (0.0, 0.5),
    scale: Scale::Linear,
    meaning: "share of the period that each ramp takes; 0 is a square wave (fig. 6 of the paper)",
    ..FREQUENCY_SPEC
};

/// Draws the editor. Invalid values are shown where they are typed; the drive stays as it
/// was.
pub fn show(ui: &mut Ui, state: &mut State, place: Place) {
    if state.setup.preset.model.piezo.is_none() {
        ui.weak("This device has no drive.");
        return;
    }
    if place == Place::Panel && state.drive_editor_open {
        ui.weak("The drive editor is open beside the plots.");
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
    if matches!(
        state.setup.drive,
        DriveChoice::Waveform(Waveform::Periodic(_))
    ) {
        let button = ui.button("Draw it in Explore");
        let help = "Change this waveform by its handles in the Explore workspace";
        if button.on_hover_text(help).clicked() {
            state.ask(Command::DrawTuneDrive);
        }
    }
    preview::show(ui, &state.setup, place);
    if place == Place::Panel {
        let button = ui.add(Button::new("Open beside the plots").small());
        if button.clicked() {
            state.ask(Command::DriveEditor);
        }
    }
}

/// Which of [`DRIVE_KINDS`] a drive is.
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
            Waveform::Periodic(_) => "shaped",
        },
    }
}

/// The values of a waveform that have a slider, with their specifications. Tables and shaped
/// waveforms have none.
fn editable_values(waveform: &mut Waveform) -> Vec<(ParameterSpec, &mut f64)> {
    match waveform {
        Waveform::Rest | Waveform::Table(_) | Waveform::Periodic(_) => Vec::new(),
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
        } => vec![(FREQUENCY_SPEC, frequency), (AMPLITUDE_SPEC, amplitude)],
        Waveform::Ramped {
            frequency,
            amplitude,
            lambda,
        } => vec![
            (FREQUENCY_SPEC, frequency),
            (AMPLITUDE_SPEC, amplitude),
            (LAMBDA_SPEC, lambda),
        ],
        Waveform::Chirp {
            from,
            to,
            amplitude,
            duration,
        } => vec![
            (FROM_SPEC, from),
            (TO_SPEC, to),
            (AMPLITUDE_SPEC, amplitude),
            (SWEEP_SPEC, duration),
        ],
    }
}

/// The sliders of a drive.
pub(crate) fn slider_specs(drive: &DriveChoice) -> Vec<ParameterSpec> {
    match drive {
        DriveChoice::Recorded(_) => Vec::new(),
        DriveChoice::Waveform(waveform) => {
            let mut waveform = waveform.clone();
            let values = editable_values(&mut waveform);
            values.into_iter().map(|(spec, _)| spec).collect()
        }
    }
}

/// Whether a slider of any drive has this id.
pub(crate) fn has_slider(id: &str) -> bool {
    let all = [
        FREQUENCY_SPEC,
        AMPLITUDE_SPEC,
        LAMBDA_SPEC,
        FROM_SPEC,
        TO_SPEC,
        SWEEP_SPEC,
    ];
    all.iter().any(|spec| spec.id == id)
}

/// From which value on a drive is beyond what the gain curve of the piezo film was measured for.
fn extrapolation_of(id: &str) -> Option<Extrapolation> {
    if id == AMPLITUDE_SPEC.id {
        Some(Extrapolation {
            above: MEASURED_VOLTAGE,
            what: "The gain curve was measured",
        })
    } else if [FREQUENCY_SPEC.id, FROM_SPEC.id, TO_SPEC.id].contains(&id) {
        Some(Extrapolation {
            above: MEASURED_FREQUENCY,
            what: "The gain curve was measured",
        })
    } else {
        None
    }
}

/// Frequency \[Hz\] and amplitude \[V\] of a drive, if it has them. The frequency of a sweep is
/// the first one.
fn frequency_and_amplitude(drive: &DriveChoice) -> (Option<f64>, Option<f64>) {
    match drive {
        DriveChoice::Recorded(_) => (None, None),
        DriveChoice::Waveform(Waveform::Table(table)) => (None, Some(table.amplitude())),
        DriveChoice::Waveform(Waveform::Periodic(periodic)) => {
            let drive = periodic.drive();
            (Some(drive.frequency), Some(drive.cycle.amplitude()))
        }
        DriveChoice::Waveform(waveform) => {
            let mut waveform = waveform.clone();
            let values = editable_values(&mut waveform);
            let find = |ids: &[&str]| {
                let mut all = values.iter();
                all.find(|(spec, _)| ids.contains(&spec.id))
                    .map(|(_, value)| **value)
            };
            let frequency = find(&[FREQUENCY_SPEC.id, FROM_SPEC.id]);
            (frequency, find(&[AMPLITUDE_SPEC.id]))
        }
    }
}

/// Frequency \[Hz\] and amplitude \[V\] of the drive of the preset, or the defaults.
fn preset_frequency_and_amplitude(setup: &Setup) -> (f64, f64) {
    let drive = Waveform::parse(&setup.preset.drive, setup.preset.duration)
        .map(DriveChoice::Waveform)
        .unwrap_or(DriveChoice::Waveform(Waveform::Rest));
    let (frequency, amplitude) = frequency_and_amplitude(&drive);
    (
        frequency.unwrap_or(DEFAULT_FREQUENCY),
        amplitude.unwrap_or(DEFAULT_AMPLITUDE),
    )
}

/// A drive of another kind, with frequency and amplitude of the current one if it has them.
/// `None` for a recorded drive if no recording has a voltage.
pub(crate) fn of_kind(setup: &Setup, kind: &str) -> Option<DriveChoice> {
    let (frequency, amplitude) = frequency_and_amplitude(&setup.drive);
    let (preset_frequency, preset_amplitude) = preset_frequency_and_amplitude(setup);
    let frequency = frequency.unwrap_or(preset_frequency);
    let amplitude = amplitude.unwrap_or(preset_amplitude);
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
            lambda: DEFAULT_RAMP_SHARE,
        },
        "chirp" => Waveform::Chirp {
            from: frequency,
            to: (SWEEP_RATIO * frequency).min(FREQUENCY_LIMITS.1),
            amplitude,
            duration: setup.duration,
        },
        "table" => {
            let quarter = 0.25 / frequency;
            let time = (0..5).map(|i| f64::from(i) * quarter).collect();
            let voltage = vec![0.0, amplitude, 0.0, -amplitude, 0.0];
            Waveform::Table(VoltageTable::new("edited", time, voltage).ok()?.into())
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
            for name in DRIVE_KINDS {
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
    let (frequency, amplitude) = preset_frequency_and_amplitude(setup);
    let default_of = |id: &str| match id {
        id if id == AMPLITUDE_SPEC.id => amplitude,
        id if id == LAMBDA_SPEC.id => DEFAULT_RAMP_SHARE,
        id if id == TO_SPEC.id => SWEEP_RATIO * frequency,
        id if id == SWEEP_SPEC.id => setup.duration,
        _ => frequency,
    };
    for (spec, value) in editable_values(&mut waveform) {
        let slider = ParameterSlider {
            scope: place.scope(),
            id: spec.id,
            spec,
            value: *value,
            original: default_of(spec.id),
            locked: None,
            size: Size::Small,
            problem: None,
            extrapolation: extrapolation_of(spec.id),
        };
        if let Some(new) = slider.show(ui).value {
            *value = new;
        }
    }
    if matches!(waveform, Waveform::Rest) {
        ui.weak("No voltage since poling, hence no force.");
    }
    if let Waveform::Periodic(periodic) = &waveform {
        let text = periodic.drive().to_string();
        ui.add(Label::new(small(&text)).truncate())
            .on_hover_text(text);
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

/// The choice among the recordings that have a voltage.
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
