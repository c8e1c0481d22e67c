//! The paper's Table A.1 beside the simulation: the only published measurements of the
//! device.

use std::sync::OnceLock;

use eframe::egui::{Grid, RichText, Ui};

use super::figures::{Figures, ROWS, figures, latest};
use super::small;
use crate::app::setup::{DriveChoice, Setup};
use crate::app::state::State;
use crate::model::drive::Waveform;
use crate::model::unit::format_number;

/// Facts of Table A.1; peaks in um, contacts in ms.
const TABLE: &str = include_str!("../../../../assets/table_a1.csv");
/// Periods that the window should span, so that the motion repeats.
const PERIODS: f64 = 4.0;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Drive frequency [Hz].
    pub frequency: f64,
    /// Drive amplitude [V].
    pub amplitude: f64,
    /// Square or sine.
    pub square: bool,
    /// The paper's simulation.
    pub simulation: Figures,
    /// The experiment.
    pub experiment: Figures,
}

impl Case {
    /// The drive of the experiment.
    pub fn waveform(&self) -> Waveform {
        let (frequency, amplitude) = (self.frequency, self.amplitude);
        if self.square {
            Waveform::Square {
                frequency,
                amplitude,
            }
        } else {
            Waveform::Sine {
                frequency,
                amplitude,
            }
        }
    }

    /// `15 Hz, 8 V, square`.
    pub fn name(&self) -> String {
        let signal = if self.square { "square" } else { "sine" };
        format!("{} Hz, {} V, {signal}", self.frequency, self.amplitude)
    }
}

/// The 16 cases in the order of the table.
pub fn cases() -> &'static [Case] {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(|| TABLE.lines().skip(1).filter_map(case).collect())
}

fn case(line: &str) -> Option<Case> {
    let mut cells = line.trim().split(',');
    let number = |cells: &mut std::str::Split<'_, char>| cells.next()?.parse::<f64>().ok();
    let (frequency, amplitude) = (number(&mut cells)?, number(&mut cells)?);
    let square = cells.next()? == "square";
    let mut pair = || Some((number(&mut cells)?, number(&mut cells)?));
    let (bounces, peak, contact) = (pair()?, pair()?, pair()?);
    let of = |bounces, peak_um: f64, contact_ms: f64| Figures {
        bounces: Some(bounces),
        peak: Some(1e-6 * peak_um),
        contact: Some(1e-3 * contact_ms),
    };
    Some(Case {
        frequency,
        amplitude,
        square,
        simulation: of(bounces.0, peak.0, contact.0),
        experiment: of(bounces.1, peak.1, contact.1),
    })
}

/// The case that is simulated at present, if it is one.
pub fn current(setup: &Setup) -> Option<&'static Case> {
    let model = &setup.preset.model;
    if !(model.name.starts_with("paper") && model.has_ground && model.piezo.is_some()) {
        return None;
    }
    let DriveChoice::Waveform(waveform) = &setup.drive else {
        return None;
    };
    cases().iter().find(|case| case.waveform() == *waveform)
}

/// Sets the drive to a case, and the span to as many periods as its features need.
pub fn choose(setup: &mut Setup, case: &Case) {
    setup.drive = DriveChoice::Waveform(case.waveform());
    setup.duration = setup.duration.max(PERIODS / case.frequency);
}

/// A menu of the 16 cases.
pub fn case_picker(ui: &mut Ui, setup: &mut Setup, scope: &str) {
    let now = current(setup);
    ui.push_id((scope, "cases"), |ui| {
        let menu = ui.menu_button("Table A.1 case...", |ui| {
            for case in cases() {
                if ui
                    .selectable_label(now == Some(case), case.name())
                    .clicked()
                {
                    choose(setup, case);
                    ui.close();
                }
            }
        });
        menu.response
            .on_hover_text("Set the drive to one of the 16 published experiments");
    });
}

/// The case's figures beside the simulated ones; nothing if the drive is no case.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(case) = current(&state.setup) else {
        ui.weak("The drive is none of the paper's 16 experiments.");
        case_picker(ui, &mut state.setup, "reference");
        return;
    };
    ui.label(small(format!("{} (Ryou and Oldham 2012)", case.name())));
    let own = state
        .snapshot
        .as_ref()
        .and_then(|s| latest(ui, None, &s.features));
    let own = figures(own.as_deref());
    Grid::new("table a1")
        .num_columns(4)
        .striped(true)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            for title in ["", "now", "paper's sim.", "experiment"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for row in ROWS {
                ui.label(row.title()).on_hover_text(row.help());
                let columns = [&own, &case.simulation, &case.experiment];
                for (i, column) in columns.into_iter().enumerate() {
                    let value = row.value(column);
                    let text = value.map_or("-".to_owned(), |v| format_number(v, 3));
                    let label = ui.label(RichText::new(text).monospace());
                    if let (0, Some(v), Some(e)) = (i, value, row.value(&case.experiment))
                        && e != 0.0
                    {
                        label.on_hover_text(format!(
                            "{:+.0} % of the experiment",
                            100.0 * (v - e) / e
                        ));
                    }
                }
                ui.end_row();
            }
        });
    case_picker(ui, &mut state.setup, "reference");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_cases_are_read_and_found_again() {
        assert_eq!(cases().len(), 16);
        let mut setup = super::super::tests::state().setup;
        for case in cases() {
            choose(&mut setup, case);
            assert_eq!(current(&setup), Some(case));
            assert!(setup.duration * case.frequency >= PERIODS);
        }
        assert_eq!(cases()[2].experiment.peak, Some(210.0 * 1e-6));
        setup.preset = crate::model::preset::Preset::embedded("oscillator").unwrap();
        assert_eq!(current(&setup), None);
    }
}
