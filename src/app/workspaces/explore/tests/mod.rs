//! Tests of the workspace through its accessibility tree, without a GPU.

mod panels;

use std::time::Duration;

use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::app::files::built_in;
use crate::app::setup::explore::ExplorePanel;
use crate::app::setup::view::View;
use crate::app::state::State;
use crate::model::preset::Preset;

/// Roles that take input.
const INPUTS: [Role; 7] = [
    Role::Button,
    Role::CheckBox,
    Role::ComboBox,
    Role::Slider,
    Role::SpinButton,
    Role::TextInput,
    Role::RadioButton,
];

/// The paper's device with few points, so that nothing takes long.
fn state(panel: ExplorePanel) -> State {
    let mut state = State::new(built_in::from_preset(Preset::default()), View::default());
    state.view.explore_panel = panel;
    let explore = &mut state.setup.explore;
    explore.map.points = 6;
    explore.orbit.points = 6;
    explore.basins.points = 4;
    explore.robustness.points = 3;
    explore.robustness.members = 4;
    explore.robustness.population = 6;
    explore.robustness.generations = 1;
    state
}

/// The workspace at the smallest supported size, less menus and status bar.
fn harness(state: State) -> Harness<'static, State> {
    let mut harness = Harness::builder()
        .with_size([1280.0, 660.0])
        .with_step_dt(1.0 / 60.0)
        .build_ui_state(super::show, state);
    harness.run_steps(3);
    harness
}

/// Draws until `is_done`.
fn wait(harness: &mut Harness<'_, State>, is_done: impl Fn(&Harness<'_, State>) -> bool) {
    for _ in 0..6000 {
        harness.run_steps(1);
        if is_done(harness) {
            harness.run_steps(2);
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("it does not end");
}

/// Whether some text on screen contains `part`.
fn says(harness: &Harness<'_, State>, part: &str) -> bool {
    harness.query_all_by_label_contains(part).next().is_some()
}

fn press(harness: &mut Harness<'_, State>, button: &str) {
    // Whether it is scrolled into view or not.
    harness.get_by_label(button).click_accesskit();
    harness.run_steps(3);
}

/// Inputs without a name, and those that reach out of the window.
fn faults(harness: &Harness<'_, State>) -> Vec<String> {
    let window = eframe::egui::Rect::from_min_size(
        eframe::egui::Pos2::ZERO,
        eframe::egui::vec2(1280.0, 660.0),
    );
    let inputs = INPUTS
        .into_iter()
        .flat_map(|role| harness.query_all_by_role(role));
    inputs
        .filter_map(|node| {
            let name = node.accesskit_node().label().unwrap_or_default();
            let rect = node.rect();
            let is_cut = rect.left() < window.left() - 0.5 || rect.right() > window.right() + 0.5;
            (name.trim().is_empty() || is_cut).then(|| format!("\"{name}\" at {rect:?}"))
        })
        .collect()
}
