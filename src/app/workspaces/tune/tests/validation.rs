//! The window with all cases of Table A.1.

use std::sync::Arc;

use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::harness;
use super::support::state;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::state::State;
use crate::app::workspaces::tune::table_a1::calibrate::{TableFitState, key};
use crate::fit::table_a1::calibrate::fit_table;
use crate::model::drive::Waveform;

#[test]
fn cases_of_the_table_can_be_sorted_and_chosen() {
    let mut state = state();
    state.validation_open = true;
    let mut harness = harness(state);
    for _ in 0..500 {
        harness.run_steps(2);
        if harness.query_by_label("100 Hz, 8 V, sine").is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let top = |harness: &Harness<'_, State>, case: &str| harness.get_by_label(case).rect().top();
    let (first, worst) = ("5 Hz, 6 V, square", "50 Hz, 8 V, square");
    assert!(top(&harness, first) < top(&harness, worst));
    // The paper's peak is 42 % above the experiment there: the largest of all errors.
    harness
        .get_by_role_and_label(Role::Button, "peak [\u{b5}m]")
        .click();
    harness.run_steps(3);
    assert!(top(&harness, worst) < top(&harness, first));
    harness.get_by_label("50 Hz, 8 V, sine").click();
    harness.run_steps(3);
    let drive = Waveform::parse("sine:50Hz:8V", 1.0).unwrap();
    let setup = &harness.state().setup;
    assert_eq!(setup.drive, DriveChoice::Waveform(drive));
}

/// Draws until a label appears.
fn until(harness: &mut Harness<'_, State>, label: &str) {
    for _ in 0..2000 {
        harness.run_steps(2);
        if harness.query_by_label(label).is_some() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("{label} never came");
}

#[test]
fn cancelling_a_fit_to_the_experiments_changes_nothing() {
    let mut state = state();
    state.validation_open = true;
    let before = state.setup.preset.model.clone();
    let mut harness = harness(state);
    until(&mut harness, "Fit to the experiments");
    harness.get_by_label("Fit to the experiments").click();
    until(&mut harness, "Cancel");
    harness.get_by_label("Cancel").click();
    until(&mut harness, "Cancelled: this is the best so far.");
    assert_eq!(harness.state().setup.preset.model, before);
    harness.get_by_label("Discard").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("Apply").is_none());
}

#[test]
fn a_fit_to_the_experiments_is_shown_and_applied_on_request() {
    let mut state = state();
    state.validation_open = true;
    let base = state.setup.preset.model.clone();
    let found = fit_table(&base, 1, |_| true);
    let mut harness = harness(state);
    let fit = TableFitState {
        base: Some(Arc::new(base.clone())),
        result: Some(Ok(Arc::new(found.clone()))),
        ..TableFitState::default()
    };
    harness.ctx.data_mut(|data| data.insert_temp(key(), fit));
    until(&mut harness, "100 Hz, 8 V, sine fitted");
    for omitted in &found.left_out {
        harness.get_by_label(&format!(
            "{} Hz, fitted to the other frequencies",
            omitted.frequency
        ));
    }
    harness.get_by_label_contains("More than 30 % off in peak or contact");
    assert_eq!(harness.state().setup.preset.model, base);
    harness.get_by_label("Apply").click();
    harness.run_steps(3);
    assert_eq!(harness.state().setup.preset.model, found.model);
}
