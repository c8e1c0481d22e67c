//! The table of the kept curves and the list among the readouts, without worker threads.

use egui_kittest::kittest::Queryable;

use super::support::{full, keep};
use super::{harness, says};
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::state::State;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;

/// Two kept curves, the table open.
fn state() -> State {
    let mut state = full();
    keep(&mut state, "worse", 5.2e-6);
    state.kept_open = true;
    state
}

#[test]
fn a_row_shows_misfits_features_and_what_differs() {
    let harness = harness(state());
    // 2.6 um and 5.2 um over 20 nm, next to 1.25 um of the present run.
    // The total and one for each of the two recordings; those of the present run are also in the
    // line above the plots.
    for (misfit, expected) in [("130", 3), ("260", 3), ("62.5", 5)] {
        let cells = harness.query_all_by_label(misfit).count();
        assert_eq!(cells, expected, "{misfit}");
    }
    for part in ["bounces", "contact [ms]", "misfit", "differs from now"] {
        assert!(says(&harness, part), "{part}");
    }
    let contacts = harness.query_all_by_label("31.4").count();
    assert_eq!(contacts, 3, "of the present run and of both curves");
    // The first was kept before Cs and alpha were changed, the second after.
    assert!(says(&harness, "Cs 1.747e-21 N m^2 s"));
    assert!(says(&harness, "\u{3b1} 0.378"));
    assert!(says(&harness, "nothing"));
}

#[test]
fn another_drive_and_many_parameters_are_among_the_differences() {
    let mut state = state();
    state.setup.drive = DriveChoice::Waveform(Waveform::Rest);
    let parameters = &mut state.setup.preset.model.parameters;
    parameters.set(ParameterId::Dp, 50e-6);
    let harness = harness(state);
    assert!(says(&harness, "drive square:15Hz:8V"));
    assert!(says(&harness, "and 1 more"));
}

#[test]
fn a_curve_that_is_hidden_is_not_compared_with_and_its_row_stays() {
    let mut harness = harness(state());
    assert!(says(&harness, "Show kept: worse"));
    harness.get_by_label("draw worse").click();
    harness.run_steps(3);
    assert!(!harness.state().setup.kept[1].visible);
    assert!(!says(&harness, "Show kept: worse"));
    assert_eq!(harness.query_all_by_label("260").count(), 3);
}

#[test]
fn names_are_distinct_and_escape_keeps_the_old_one() {
    let mut harness = harness(state());
    harness.get_by_label("name of worse").click();
    harness.run_steps(3);
    harness.key_press(eframe::egui::Key::End);
    harness.run_steps(1);
    harness.get_by_label("name of worse").type_text(" and more");
    harness.run_steps(2);
    harness.key_press(eframe::egui::Key::Enter);
    harness.run_steps(30);
    assert_eq!(harness.state().setup.kept[1].name, "worse and more");
    harness.get_by_label("name of worse and more").click();
    harness.run_steps(3);
    let field = harness.get_by_label("name of worse and more");
    field.type_text(" still");
    harness.run_steps(2);
    harness.key_press(eframe::egui::Key::Escape);
    harness.run_steps(30);
    assert_eq!(harness.state().setup.kept[1].name, "worse and more");
    assert!(harness.query_by_label("name of worse and more").is_some());
}

#[test]
fn parameters_are_restored_and_the_drive_and_the_locks_stay() {
    let mut state = state();
    state.setup.drive = DriveChoice::Waveform(Waveform::Rest);
    let mut harness = harness(state);
    let before = harness.state().setup.kept[0].origin.preset.clone();
    assert_ne!(harness.state().setup.preset, before);
    harness.get_by_label("restore kept 1").scroll_to_me();
    harness.run_steps(20);
    harness.get_by_label("restore kept 1").click();
    harness.run_steps(3);
    let setup = &harness.state().setup;
    assert_eq!(setup.preset, before);
    assert_eq!(setup.drive, DriveChoice::Waveform(Waveform::Rest));
    assert!(setup.locked.contains("Ca"));
}

#[test]
fn the_list_among_the_readouts_leads_to_the_table() {
    let mut state = full();
    state.kept_open = false;
    let mut harness = harness(state);
    let button = harness.get_by_label("Table of kept curves");
    button.scroll_to_me();
    harness.run_steps(60);
    assert!(harness.query_by_label("show kept 1").is_some());
    harness.get_by_label("Table of kept curves").click();
    harness.run_steps(3);
    assert_eq!(harness.state().commands, [Command::KeptCurves]);
}
