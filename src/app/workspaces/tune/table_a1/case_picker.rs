//! The experiments of Table A.1: a menu that sets the drive to one, and its published figures
//! next to the simulated ones.

use eframe::egui::{Grid, RichText, Ui};

use super::features::{FEATURE_ROWS, latest};
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::state::State;
use crate::app::widgets::text::small;
use crate::fit::table_a1::measurements::{Case, Figures, cases};
use crate::model::unit::format_number;

/// Periods to simulate, so that the motion becomes periodic.
const MIN_PERIODS: f64 = 4.0;

/// The case that the current drive belongs to, if any.
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

/// Sets the drive to a case. Extends the span to as many periods as its features need.
pub fn choose(setup: &mut Setup, case: &Case) {
    setup.drive = DriveChoice::Waveform(case.waveform());
    setup.duration = setup.duration.max(MIN_PERIODS / case.frequency);
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

/// The published figures of the case next to the simulated ones.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(case) = current(&state.setup) else {
        ui.weak("The drive is not one of the paper's 16 experiments.");
        buttons(ui, state);
        return;
    };
    ui.label(small(format!("{} (Ryou and Oldham 2012)", case.name())));
    let own = state
        .snapshot
        .as_ref()
        .and_then(|s| latest(ui, None, &s.features));
    let own = own.as_deref().map(Figures::of).unwrap_or_default();
    Grid::new("table a1")
        .num_columns(4)
        .striped(true)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            for title in ["", "now", "paper's sim.", "experiment"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for row in FEATURE_ROWS {
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
    buttons(ui, state);
}

fn buttons(ui: &mut Ui, state: &mut State) {
    ui.horizontal(|ui| {
        case_picker(ui, &mut state.setup, "reference");
        let all = ui.button("All 16...");
        if all
            .on_hover_text(
                Command::Validation
                    .with_keys("All cases at the current parameters, with statistics"),
            )
            .clicked()
        {
            state.ask(Command::Validation);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::super::case_picker::*;

    #[test]
    fn every_case_is_recognised_from_its_drive() {
        let mut setup = crate::app::workspaces::tune::tests::support::state().setup;
        for case in cases() {
            choose(&mut setup, case);
            assert_eq!(current(&setup), Some(case));
            assert!(setup.duration * case.frequency >= MIN_PERIODS);
        }
        setup.preset = crate::model::preset::Preset::embedded("oscillator").unwrap();
        assert_eq!(current(&setup), None);
    }
}
