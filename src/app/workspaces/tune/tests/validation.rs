//! The window with all cases of Table A.1.

use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::harness;
use super::support::state;
use crate::app::setup::DriveChoice;
use crate::app::state::State;
use crate::model::drive::Waveform;

#[test]
fn all_cases_of_the_table_are_shown_sorted_and_chosen() {
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
