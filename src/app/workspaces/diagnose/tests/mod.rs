//! Tests of the workspace through its accessibility tree, without a GPU.

mod answers;
mod support;
mod trials;

use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::app::state::State;

/// The workspace at the smallest supported size.
fn harness(state: State) -> Harness<'static, State> {
    harness_of(state, [1280.0, 690.0])
}

fn harness_of(state: State, size: [f32; 2]) -> Harness<'static, State> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_step_dt(1.0 / 60.0)
        .build_ui_state(super::show, state);
    harness.run_steps(4);
    harness
}

/// Whether some text on screen contains `part`.
fn says(harness: &Harness<'_, State>, part: &str) -> bool {
    harness.query_all_by_label_contains(part).next().is_some()
}

fn press(harness: &mut Harness<'_, State>, button: &str) {
    harness.get_by_role_and_label(Role::Button, button).click();
    harness.run_steps(4);
}
